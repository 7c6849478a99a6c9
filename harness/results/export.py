"""Exports the measurements of a results file as a table for other programs."""

import csv
import gzip
import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from gnomon.harness.contract.declared import read_declared
from gnomon.harness.results.reading import columns, rows
from gnomon.harness.results.schema import MEASUREMENT_COLUMNS, TRIAL_COLUMNS
from gnomon.harness.system import extras
from gnomon.reference.storage import diskcache

_FORMULA = re.compile(r"[=+\-@\t\r\n\uff1d\uff0b\uff0d\uff20]")
"""The beginning of a formula in a spreadsheet."""
COMPRESSION = 9
"""Of Parquet: higher levels take ten times as long for a few per cent."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE | re.ASCII)


def export(path: str | Path, target: Path, form: str, raw: bool = False) -> None:
    """Write the rows of a results file as csv, json (a list of rows) or parquet, which needs the extra `report`.

    In a csv, an apostrophe is put before a text that a spreadsheet would compute as a formula, unless `raw`. Raises
    ValueError for another format, as `load` does, and for an extra that is lacking.
    """
    write = _WRITERS.get(form)
    if write is None:
        raise ValueError(f"format {form!r} is not one of {', '.join(_WRITERS)}")
    write(path, target, raw)


def _csv(path: str | Path, target: Path, raw: bool) -> None:
    """Write rows as csv, compressed if `target` ends with .gz."""
    values = columns(path)
    with diskcache.whole(target) as part:
        opened: Any = gzip.open if target.suffix == ".gz" else open
        with opened(part, "wt", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(values)
            for row in zip(*values.values(), strict=True):
                writer.writerow(row if raw else map(_no_formula, row))


def _json(path: str | Path, target: Path, raw: bool) -> None:
    """Write rows as a list of JSON objects; `raw` changes nothing."""
    with diskcache.whole(target) as part:
        part.write_text(json.dumps(rows(path), indent=1), encoding="utf-8")


def _parquet(path: str | Path, target: Path, raw: bool) -> None:
    """Write columns of the declared types, each with its unit and meaning in the schema; `raw` changes nothing."""
    extras.require("report", "a Parquet file")
    import pyarrow  # slow to load: only Parquet needs it
    from pyarrow import parquet

    types = {"TEXT": pyarrow.string(), "REAL": pyarrow.float64(), "INTEGER": pyarrow.int64()}
    units_and_meanings = read_declared("results", "columns.toml")
    values = columns(path)
    fields = []
    for name in values:
        unit, meaning = units_and_meanings[name]
        fields.append(pyarrow.field(name, types[kind_of(name)], metadata={"unit": unit, "meaning": meaning}))
    table = pyarrow.table(list(values.values()), schema=pyarrow.schema(fields))
    with diskcache.whole(target) as part:
        parquet.write_table(table, part, compression="zstd", compression_level=COMPRESSION)


def kind_of(name: str) -> str:
    """The kind of an exported column in SQL: TEXT, REAL or INTEGER."""
    return (
        (TRIAL_COLUMNS | MEASUREMENT_COLUMNS | {"work": "INTEGER", "more_seconds": "REAL"}).get(name, "TEXT").split()[0]
    )


_WRITERS: Mapping[str, Callable[[str | Path, Path, bool], None]] = {"csv": _csv, "json": _json, "parquet": _parquet}


def _no_formula(value: Any) -> Any:
    """The text with an apostrophe if a spreadsheet would compute it; a negative number is not a formula."""
    if not isinstance(value, str) or not _FORMULA.match(value) or _NUMBER.fullmatch(value):
        return value
    return f"'{value}"
