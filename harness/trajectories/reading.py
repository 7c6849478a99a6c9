"""Reads the columns of a file that somebody else wrote: text with separators, NPZ, MAT, HDF5, Parquet, JSON lines.

Nothing in a file is executed: pickled objects are refused, and links of HDF5 to other files are not followed. A file is
refused before it is read if it would take more than `MOST_BYTES` in memory.
"""

from __future__ import annotations

import csv
import json
import math
import re
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.harness.results.visible import shorten
from gnomon.harness.system import extras
from gnomon.harness.trajectories.units import is_unit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
MOST_BYTES = 1 << 28
"""Most bytes of a file, and of its arrays."""
MOST_TEXT = 1 << 26
"""Most bytes of a text, which takes twenty times as many while it is read."""
MOST_COLUMNS = 10_000
EXACT_DIGITS = 16
"""Numbers with so many significant digits are taken as binary64."""
COMMENTS = ("#", "%", "//", "!", '"#')
SEPARATORS = (";", "\t", "|", ",", " ")
"""In the sequence in which they are tried; the space stands for any white space."""
LINES_TRIED = 40
"""Lines from which the separator is found."""
_NUMBER = re.compile(
    r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|[+-]?(nan|inf|infinity)|[+-]?0x[\da-f.]+(p[+-]?\d+)?", re.I
)
_BRACKETS = re.compile(r"(.*?)[\s_]*[\[(]([^\[\]]*)[\])]\s*")


@dataclass
class Table:
    """The columns of a file.

    `columns`: by name, each (n,); a column of an array `r` is called `r[0]`, and `groups["r"]` has their names. `units`:
    units that the file states. `resolution`: half a unit of the last digit of each number, (n,), where the file has
    fewer digits than binary64. `lines`: the line, or the row from 1 on, of each row. `notes`: how the file was read.
    """

    source: str
    columns: dict[str, Floats] = field(default_factory=dict)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    resolution: dict[str, Floats] = field(default_factory=dict)
    decimals: dict[str, int] = field(default_factory=dict)
    lines: Sequence[int] = ()
    notes: list[str] = field(default_factory=list)
    row_word: str = "row"

    def rows(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def add(self, name: str, values: Any, unit: str | None = None) -> None:
        """Add an array: (n,) as one column, (n, ...) as a column for each number of a row. Raises ValueError for others."""
        array = np.asarray(values)
        if array.dtype.names is not None:
            for part in array.dtype.names:
                self.add(f"{name}.{part}" if name else part, array[part])
            return
        if array.dtype.kind not in "fiub" or array.ndim == 0:
            return
        half = _half_ulp(array)
        array = array.astype(np.float64)
        if array.ndim == 1:
            names = [name]
            flat, halves = array[:, np.newaxis], None if half is None else half[:, np.newaxis]
        else:
            names = [f"{name}[{','.join(map(str, place))}]" for place in np.ndindex(array.shape[1:])]
            flat, halves = array.reshape(len(array), -1), None if half is None else half.reshape(len(array), -1)
            self.groups[name] = tuple(names)
        if len(self.columns) + len(names) > MOST_COLUMNS:
            raise ValueError(f"{self.source}: more than {MOST_COLUMNS} columns; write those of the motion to a file")
        for place, each in enumerate(names):
            self.columns[each] = flat[:, place]
            if unit is not None:
                self.units[each] = unit
            if halves is not None:
                self.resolution[each] = halves[:, place]


def read_table(path: Path) -> Table:
    """The columns of a file, by its ending. Raises ValueError, which names file and place, for what cannot be read."""
    if not path.is_file():
        reason = "a folder, a pipe or a device" if path.exists() else "no such file"
        raise ValueError(f"{path}: {reason}; give a file with the columns of a motion")
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise ValueError(f"{path}: {size} bytes; give a file of at most {MOST_BYTES}, as with every tenth row")
    if not size:
        raise ValueError(f"{path}: an empty file; give a file with the columns of a motion")
    with path.open("rb") as file:
        head = file.read(8)
    kind = path.suffix.lower()
    if kind in REFUSED:
        raise ValueError(f"{path}: {REFUSED[kind]}")
    reader = READERS.get(kind) or next(
        (READERS[each] for start, each in STARTS.items() if head.startswith(start)), None
    )
    table = (reader or _read_text)(path)
    table.columns = {name: values for name, values in table.columns.items() if name}
    if not table.columns:
        raise ValueError(f"{path}: no columns of numbers; give a file with the times and coordinates of a motion")
    _keep_one_length(table)
    if not table.lines:
        table.lines = range(1, table.rows() + 1)
    return table


def _keep_one_length(table: Table) -> None:
    """Leave out arrays of another length than the commonest, as parameters; the times decide between equally common."""
    lengths = [len(values) for values in table.columns.values()]
    time = next((len(values) for name, values in table.columns.items() if name.lower() in ("t", "time")), 0)
    common = time or max(lengths, key=lambda length: (lengths.count(length), length))
    for name, names in list(table.groups.items()):  # (dim, n), as column-major programs write
        arrays = [table.columns[each] for each in names if each in table.columns]
        if len(arrays) == len(names) and len(arrays) == common != len(arrays[0]):
            for each in names:
                del table.columns[each]
                table.resolution.pop(each, None)
            del table.groups[name]
            table.add(name, np.array(arrays))  # a row of numbers for each time
            table.notes.append(f"{name}: transposed, as its columns are the rows")
    left_out = [name for name, values in table.columns.items() if len(values) != common]
    for name in left_out:
        del table.columns[name]
    gone = set(left_out)
    table.groups = {name: names for name, names in table.groups.items() if not gone & set(names)}
    if left_out:
        table.notes.append(f"left out, with another length than {common}: {shorten(', '.join(left_out))}")


def _half_ulp(array: Any) -> Floats | None:
    """Half an ulp of numbers with fewer digits than binary64; None for binary64 and integers."""
    if array.dtype.kind != "f" or array.dtype.itemsize >= 8:
        return None
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(np.spacing(array)).astype(np.float64) / 2)


# Text


def _read_text(path: Path) -> Table:
    _limit_text(path)
    text = _decode(path.read_bytes(), path)
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    if any("\0" in line for _, line in lines[:LINES_TRIED]):
        raise ValueError(f"{path}: not text, and of no known format; give one of {', '.join([*READERS, '.csv'])}")
    comments = [(number, line) for number, line in lines if line.lstrip().startswith(COMMENTS)]
    rest = [(number, line) for number, line in lines if not line.lstrip().startswith(COMMENTS)]
    separator, comma, first = _layout(rest, path)
    rows = [_cells(line, separator) for _, line in rest[first:]]
    width = max(set(map(len, rows)), key=list(map(len, rows)).count)
    for number, line in rest[:first]:
        if first and _is_number(_cells(line, separator)[0], comma):
            wrong = next((cell for cell in _cells(line, separator) if cell and not _is_number(cell, comma)), line)
            raise ValueError(
                f"{path}:{number}: {shorten(wrong)!r} is not a number; correct the line, or put # before it"
            )
    names, units = _header(rest[:first], comments, separator, width)
    if all(len(row) == width and not row[-1] for row in rows) and (not names or not names[-1] or len(names) < width):
        width, rows, names = width - 1, [row[:-1] for row in rows], names[: width - 1]
    if names and len(names) != width:
        number = rest[first][0]
        raise ValueError(
            f"{path}:{number}: {width} values, and {len(names)} names in the header ({shorten(', '.join(names))}); write one"
            " name for each column, and decimal commas with ; between the columns"
        )
    table = Table(str(path), lines=[number for number, _ in rest[first:]], row_word="line")
    names = names or [f"#{place}" for place in range(1, width + 1)]
    _ensure_rows(rows, table.lines, width, path)
    shapes: dict[str, list[tuple[int, int, int | None]]] = {}
    for place, name in enumerate(names):
        if name in table.columns:
            raise ValueError(f"{path}: two columns are called {shorten(name)!r}; give each its own name")
        texts = [row[place] for row in rows]
        table.columns[name] = _floats(texts, comma, name, table)
        shapes[name] = [shape for text in texts if (shape := _shape(text, comma)) is not None]
        if units.get(place):
            table.units[name] = units[place]
    is_exact = any(significant >= EXACT_DIGITS for each in shapes.values() for significant, _, _ in each)
    for name, written in shapes.items():
        _note_digits(table, name, written, is_exact)
    spoken = {" ": "white space", "\t": "tabs"}.get(separator, repr(separator))
    table.notes.append(f"columns between {spoken}" + (", decimal commas" if comma else ""))
    return table


def _limit_text(path: Path) -> None:
    size = path.stat().st_size
    if size > MOST_TEXT:
        raise ValueError(
            f"{path}: {size} bytes of text; give at most {MOST_TEXT}, as every tenth row, or NPZ or Parquet"
        )


def _decode(content: bytes, path: Path) -> str:
    for start, encoding in ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"", "utf-8-sig")):
        if content.startswith(start):
            try:
                return content.decode(encoding)
            except UnicodeDecodeError:
                continue
    return content.decode("latin-1")  # a degree sign of a spreadsheet; numbers are ASCII


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    if '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]
    return [cell.strip() for cell in line.split(separator)]


def _layout(lines: Sequence[tuple[int, str]], path: Path) -> tuple[str, bool, int]:
    """The separator, whether decimals have commas, and the place of the first line of numbers."""
    for separator in SEPARATORS:
        for comma in (False, True) if separator != "," else (False,):
            for first in range(min(len(lines), LINES_TRIED)):
                tried = [_cells(line, separator) for _, line in lines[first : first + LINES_TRIED]]
                if len(tried[0]) < 2 or not _are_numbers(tried[0], comma):
                    continue
                # A damaged line is named later; most lines must fit.
                fitting = sum(_are_numbers(row, comma) and len(row) == len(tried[0]) for row in tried)
                if 2 * fitting > len(tried):
                    return separator, comma, first
                break
    if not lines:
        raise ValueError(f"{path}: only comments; give a file with rows of numbers")
    number, line = lines[0]
    raise ValueError(
        f"{path}:{number}: no rows of two or more numbers follow {shorten(line.strip(), 60)!r}; give a time and coordinates in"
        " each row, with one of ; , | tab or space between them"
    )


def _are_numbers(cells: Sequence[str], comma: bool) -> bool:
    filled = [cell for cell in cells if cell]
    return bool(filled) and bool(cells[0]) and all(_is_number(cell, comma) for cell in filled)


def _is_number(text: str, comma: bool) -> bool:
    if comma:
        if "." in text:
            return False
        text = text.replace(",", ".", 1)
    return _NUMBER.fullmatch(text) is not None


def _number(text: str, comma: bool) -> float:
    if not text:
        return math.nan
    if not _is_number(text, comma):
        raise ValueError(text)
    plain = text.replace(",", ".", 1) if comma else text
    if "x" in plain.lower():
        return float.fromhex(plain)
    return float(plain.lower().replace("d", "e") if "d" in plain.lower() else plain)


def _floats(texts: Sequence[str], comma: bool, name: str, table: Table) -> Floats:
    numbers = np.empty(len(texts))
    for row, text in enumerate(texts):
        try:
            numbers[row] = _number(text, comma)
        except (ValueError, OverflowError):
            raise ValueError(
                f"{table.source}:{table.lines[row]}: {shorten(name)} = {shorten(text)!r} is not a number; correct the line, or put #"
                " before it"
            ) from None
    return numbers


def _ensure_rows(rows: Sequence[Sequence[str]], lines: Sequence[int], width: int, path: Path) -> None:
    for number, row in zip(lines, rows, strict=True):
        if len(row) != width:
            raise ValueError(f"{path}:{number}: {len(row)} values, other lines have {width}; correct the line")


def _header(
    above: Sequence[tuple[int, str]], comments: Sequence[tuple[int, str]], separator: str, width: int
) -> tuple[list[str], dict[int, str]]:
    """The names of the columns, [] without any, and units by place: from lines above the numbers, else from a comment."""
    heads = [_cells(line, separator) for _, line in above]
    heads = [cells for cells in heads if len(cells) > 1]
    if not heads:
        for _, line in reversed(comments):
            bare = line.strip().strip('"').lstrip("#%/! ")
            for cells in (_cells(bare, separator), bare.replace(",", " ").split()):
                if len(cells) == width and not any(_is_number(cell, False) for cell in cells):
                    heads = [cells]
                    break
            if heads:
                break
    if not heads:
        return [], {}
    units: dict[int, str] = {}
    names = heads[-1]
    if len(heads) > 1 and all(not cell.strip("[]()-") or is_unit(cell) for cell in heads[-1]):
        names = heads[-2]
        units = {place: cell.strip("[]() ") for place, cell in enumerate(heads[-1]) if cell.strip("[]()- ")}
    columns = []
    for place, name in enumerate(names):
        split = _BRACKETS.fullmatch(name)
        if split is not None and split[1] and is_unit(split[2]) and not split[2].isdigit():
            units.setdefault(place, split[2].strip())
            name = split[1]
        columns.append(name.strip())
    return columns, units


def _note_digits(table: Table, name: str, written: Sequence[tuple[int, int, int | None]], is_exact: bool) -> None:
    """Note half a unit of the last digit of each number, if the column has fewer digits than binary64.

    `is_exact`: whether some column has all digits: numbers with fewer, and not with equal decimals, then have no more.
    """
    if not written:
        return
    digits = max(significant for significant, _, _ in written)
    plain = [decimals for _, decimals, exponent in written if exponent is None]
    is_plain = len(plain) == len(written)
    table.decimals[name] = max(plain) if is_plain else -1
    is_fixed = is_plain and len(set(plain)) == 1
    if digits >= EXACT_DIGITS or (is_plain and max(plain) == 0) or (is_exact and not is_fixed):
        return
    values = np.abs(table.columns[name])
    if is_fixed:  # as by %.6f
        table.resolution[name] = np.full(len(values), 0.5 * 10.0 ** -plain[0])
    else:  # as by %.7g, which leaves out zeros at the end
        with np.errstate(divide="ignore", invalid="ignore"):
            decade = np.floor(np.log10(values))
        half = 0.5 * 10.0 ** (np.where(np.isfinite(decade), decade, -np.inf) + 1 - digits)
        table.resolution[name] = half


def _shape(text: str, comma: bool) -> tuple[int, int, int | None] | None:
    """(significant digits, decimals, exponent) of a written number; None for other texts."""
    plain = text.replace(",", ".", 1) if comma else text
    mantissa, _, exponent = plain.lower().replace("d", "e").partition("e")
    whole, _, decimals = mantissa.lstrip("+-").partition(".")
    if not (whole + decimals).isdigit():
        return (EXACT_DIGITS, 0, None) if "x" in mantissa else None
    significant = len((whole + decimals).lstrip("0"))
    return significant, len(decimals), int(exponent) if exponent else None


# Arrays


def _read_npz(path: Path) -> Table:
    table = Table(str(path))
    try:
        if path.suffix.lower() == ".npy":
            _add_array(table, "a", np.load(path, allow_pickle=False))
            return table
        with zipfile.ZipFile(path) as packed:
            size = sum(each.file_size for each in packed.infolist())
        if size > MOST_BYTES:
            raise _too_large(path, size)
        with np.load(path, allow_pickle=False) as arrays:
            for name in arrays.files:
                _add_array(table, name, arrays[name])
    except (OSError, zipfile.BadZipFile, EOFError, KeyError) as error:
        raise ValueError(
            f"{path}: not a whole file of NumPy ({shorten(str(error))}); write it with numpy.savez"
        ) from None
    except ValueError as error:
        if "allow_pickle" in str(error) or "Object arrays" in str(error):
            raise _refuse_pickle(path) from None
        raise
    return table


def _add_array(table: Table, name: str, array: Any) -> None:
    if array.dtype.hasobject:
        raise _refuse_pickle(Path(table.source))
    if array.dtype.names is not None:
        table.add("" if len(table.columns) == 0 else name, array)
    else:
        table.add(name, array)


def _refuse_pickle(path: Path) -> ValueError:
    return ValueError(
        f"{path}: it holds Python objects, which would be executed, and is not read; save plain arrays of numbers"
    )


def _too_large(path: Path, size: int) -> ValueError:
    return ValueError(f"{path}: its arrays take {size} bytes; give at most {MOST_BYTES}, as every tenth row")


def _read_mat(path: Path) -> Table:
    from scipy.io import loadmat, whosmat  # slow to load: only this format needs it

    try:
        size = sum(8 * math.prod(shape) for _, shape, _ in whosmat(path))
        if size > MOST_BYTES:
            raise _too_large(path, size)
        content = loadmat(path)
    except NotImplementedError:  # version 7.3, which is HDF5
        return _read_hdf5(path)
    except Exception as error:  # damaged files raise many kinds
        if str(error).startswith(str(path)):
            raise
        raise ValueError(f"{path}: not a whole file of MATLAB ({shorten(str(error))}); write it with save") from None
    if {"Aclass", "name", "dataInfo", "data_1", "data_2"} <= set(content):
        return _read_modelica(path, content)
    table = Table(str(path))
    for name, value in content.items():
        if not name.startswith("__"):
            _add_matlab(table, name, value)
    return table


def _add_matlab(table: Table, name: str, value: Any) -> None:
    """Add a matrix, or the fields of a structure; vectors are rows or columns in MATLAB."""
    if value.dtype.names is not None and value.size == 1:
        for part in value.dtype.names:
            _add_matlab(table, f"{name}.{part}", value[part].flat[0])
    elif value.dtype.kind in "fiub" and value.ndim >= 2:
        table.add(name, value.reshape(-1) if 1 in value.shape and value.ndim == 2 else value)


def _read_modelica(path: Path, content: Mapping[str, Any]) -> Table:
    """Results of Dymola and OpenModelica: names, and for each the matrix, the column and the sign of its numbers."""
    table = Table(str(path))
    is_transposed = "binTrans" in "".join(map(str, np.ravel(content["Aclass"])))
    letters = np.array([list(line) for line in content["name"]])
    names = ["".join(line).strip("\0 ") for line in (letters.T if is_transposed else letters)]
    places = content["dataInfo"].T if is_transposed else content["dataInfo"]
    for name, (matrix, column, *_) in zip(names, places.tolist(), strict=True):
        data = content["data_2"] if matrix in (0, 2) else None
        if data is not None and abs(column) > 0:
            values = data[abs(column) - 1] if is_transposed else data[:, abs(column) - 1]
            table.add(name.partition(" ")[0], values * (1 if column > 0 else -1))
    return table


def _read_hdf5(path: Path) -> Table:
    extras.require("files", f"{path.suffix} files of HDF5")
    import h5py  # of the extra `files`

    table, size = Table(str(path)), 0

    def visit(name: str, value: Any) -> None:
        nonlocal size
        if not isinstance(value, h5py.Dataset) or value.dtype.hasobject or not value.shape:
            return
        size += math.prod(value.shape) * max(value.dtype.itemsize, 8)
        if size > MOST_BYTES:
            raise _too_large(path, size)
        if value.external or value.is_virtual:
            raise ValueError(f"{path}: {name} lies in another file, which is not read; give one whole file")
        unit = value.attrs.get("units", value.attrs.get("unit"))
        array = value[()]
        if array.ndim == 2 and 1 in array.shape:
            array = array.reshape(-1)
        label = name.replace("/", ".")
        if array.dtype.names is not None:
            table.add("" if not table.columns else label, array)
        else:
            table.add(
                label, array, unit.decode() if isinstance(unit, bytes) else unit if isinstance(unit, str) else None
            )

    try:
        with h5py.File(path, "r") as file:
            file.visititems(visit)  # follows no link to another file
    except (OSError, RuntimeError, KeyError) as error:
        raise ValueError(f"{path}: not a whole file of HDF5 ({shorten(str(error))}); write it again") from None
    return table


def _read_parquet(path: Path) -> Table:
    extras.require("files", f"{path.suffix} files")
    import pyarrow  # of the extra `files`, like its module
    from pyarrow import parquet

    table = Table(str(path))
    try:
        file = parquet.ParquetFile(path)
        size = 8 * file.metadata.num_rows * file.metadata.num_columns
        if size > MOST_BYTES:
            raise _too_large(path, size)
        frame = file.read()
    except (OSError, pyarrow.ArrowException) as error:
        if str(error).startswith(str(path)):
            raise
        raise ValueError(f"{path}: not a whole file of Parquet ({shorten(str(error))}); write it again") from None
    for name, column in zip(frame.column_names, frame.columns, strict=True):
        kind = column.type
        if pyarrow.types.is_floating(kind) or pyarrow.types.is_integer(kind):
            table.add(name, column.to_numpy())
        elif pyarrow.types.is_list(kind) or pyarrow.types.is_fixed_size_list(kind):
            table.add(name, _stack(column.to_pylist(), name, path))
    return table


def _stack(rows: Sequence[Any], name: str, path: Path) -> Floats:
    try:
        return np.array(rows, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(
            f"{path}: {shorten(name)} has rows of different lengths, or with other values than numbers; write as many numbers in each"
        ) from None


# JSON


def _read_json(path: Path) -> Table:
    """Objects, one a line, or in a list; or one object of lists."""
    _limit_text(path)
    text = _decode(path.read_bytes(), path)
    lines: Sequence[int] = ()
    try:
        try:
            document = json.loads(text)
        except json.JSONDecodeError:
            numbered = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
            lines = [number for number, _ in numbered]
            document = [_json_line(path, number, line) for number, line in numbered]
    except RecursionError:
        raise ValueError(f"{path}: lists within lists without end; give an object of numbers in each line") from None
    table = Table(str(path), lines=lines, row_word="line" if lines else "row")
    if isinstance(document, dict) and all(not isinstance(value, list) for value in document.values()):
        document = [document]
    if isinstance(document, list):
        document = _transpose(document, path, lines)
    if not isinstance(document, dict):
        raise ValueError(
            f"{path}: {shorten(repr(document), 40)} is not an object; give an object of numbers in each line"
        )
    for name, values in document.items():
        if isinstance(values, list) and not any(isinstance(each, str | dict | bool) for each in values):
            table.add(name, _stack(values, name, path))
    return table


def _json_line(path: Path, number: int, line: str) -> Any:
    try:
        return json.loads(line)
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}:{number}: not JSON ({error.msg}); give an object of numbers in each line") from None


def _transpose(rows: list[Any], path: Path, lines: Sequence[int]) -> dict[str, list[Any]]:
    """The lists of the members of objects."""
    members: dict[str, list[Any]] = {}
    names = rows[0].keys() if rows and isinstance(rows[0], dict) else ()
    for place, row in enumerate(rows):
        where = f"{path}:{lines[place]}" if lines else f"{path}: row {place + 1}"
        if not isinstance(row, dict) or row.keys() != names:
            raise ValueError(
                f"{where}: {shorten(repr(row), 60)} has not the members of the first object; write all of them"
            )
        for name, value in row.items():
            members.setdefault(name, []).append(value)
    return members


READERS: Mapping[str, Callable[[Path], Table]] = {
    ".npz": _read_npz,
    ".npy": _read_npz,
    ".mat": _read_mat,
    ".h5": _read_hdf5,
    ".hdf5": _read_hdf5,
    ".parquet": _read_parquet,
    ".jsonl": _read_json,
    ".ndjson": _read_json,
    ".json": _read_json,
}
"""The reader of each ending; all other files are text with columns."""
STARTS = {
    b"PK\x03\x04": ".npz",
    b"\x89HDF\r\n\x1a\n": ".h5",
    b"PAR1": ".parquet",
    b"MATLAB 5": ".mat",
    b"\x93NUMPY": ".npy",
}
"""The first bytes of formats, for files with another ending."""
REFUSED = {
    **dict.fromkeys((".pkl", ".pickle", ".joblib", ".pt", ".dill"), "it holds Python objects, which would be executed, and"
    " is not read; save plain arrays, as with numpy.savez"),
    **dict.fromkeys((".xlsx", ".xls", ".ods"), "a spreadsheet is not read; save its sheet as CSV"),
    **dict.fromkeys((".gz", ".bz2", ".xz", ".zst", ".zip"), "a packed file is not read; unpack it"),
}  # fmt: skip


def read_frame(frame: Any) -> Table:
    """The columns of a mapping of names to arrays, or of a frame as of pandas, polars or pyarrow."""
    table = Table("the given columns")
    names: Iterable[Any] = frame.keys() if hasattr(frame, "keys") else getattr(frame, "column_names", ())
    for name in names:
        values = frame[name]
        array = values.to_numpy() if hasattr(values, "to_numpy") else values
        try:
            table.add(str(name), np.asarray(array))
        except (TypeError, ValueError) as error:
            raise ValueError(f"column {shorten(str(name))!r}: {error}; give numbers") from None
    if not table.columns:
        raise ValueError("no columns of numbers; give arrays by name, as {'t': times, 'theta': angles}")
    _keep_one_length(table)
    table.lines = range(1, table.rows() + 1)
    return table
