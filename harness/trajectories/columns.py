"""The columns of a file as times and states of a case: which column is which coordinate, in which unit and convention.

A text such as `time=t,phi=theta:deg,w=omega:deg/s` names a column, the number that it is, and options after colons. A
column that has the name of a coordinate needs no text. Nothing else is guessed, and the mapping is part of the report.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.formulation import Formulation
from gnomon.cases.core.numbers import nearest
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.problem import names_of
from gnomon.harness.results.visible import shorten
from gnomon.harness.trajectories.attitudes import EULER, QUATERNIONS, Y_UP, matrices, rates_are_of_body
from gnomon.harness.trajectories.reading import Table
from gnomon.harness.trajectories.units import factor_to
from numpy.typing import NDArray

TIME = ("t", "time")
ATTITUDE, RATES = "attitude", "rates"
WORDS = ("negative", "wrapped", "first", "y-up", "y-up-space", "conjugate", "transposed", "body", "space", "matrix")
GREEK = {"θ": "theta", "φ": "phi", "ψ": "psi", "ω": "omega", "α": "alpha", "β": "beta", "γ": "gamma", "δ": "delta"}
SYNTAX = "write COLUMN=COORDINATE or COLUMN=COORDINATE:UNIT, as phi=theta:deg"


@dataclass
class Trajectory:
    """The times and states of a file, in the coordinates and units of a case.

    `times` (n,), `states` (n, dim), nan where `present` (dim,) is False; `half_units` (n, dim): half a unit of the last
    digit of each number, 0 for binary64; `half_time` the same of the times, in s. `lines`: the line or row of the file of
    each row, with `row_word` before it. `mapping`, `notes`: how the file was read, a line each.
    """

    source: str
    times: Floats
    states: Floats
    present: NDArray[np.bool_]
    half_units: Floats
    half_time: float
    lines: NDArray[np.int64]
    row_word: str
    mapping: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def row(self, place: int) -> str:
        return f"{self.row_word} {self.lines[place]}"


@dataclass(frozen=True)
class Entry:
    """One part of a mapping: columns of the file, the numbers that they are, and options."""

    columns: tuple[str, ...]
    targets: tuple[str, ...]
    options: tuple[str, ...]
    text: str
    is_stated: bool = True


@dataclass(frozen=True)
class Coordinates:
    """The names and units of a case's own state, or of a formulation of it."""

    names: tuple[str, ...]
    units: Mapping[str, str]
    formulation: Formulation | None = None


def read_columns(
    table: Table, case: Case, stated: Iterable[str] | Mapping[str, str] | None = None, is_partial: bool = False
) -> Trajectory:
    """The trajectory of a table, mapped as stated and, for the rest, by the names of the coordinates.

    Raises ValueError for a column, coordinate, unit or option that does not exist, and for a coordinate without column
    unless `is_partial`.
    """
    entries = [_entry(text, table) for text in split_columns(stated)]
    for name in _find_repeated([target for entry in entries for target in entry.targets]):
        raise ValueError(f"--columns: {name} is given twice; give it one column")
    chart = _chart(case, table, entries)
    entries += _by_name(table, chart, entries)
    mapper = _Mapper(table, case, chart)
    for entry in sorted(entries, key=lambda each: each.targets == (RATES,)):  # they may need the attitude
        mapper.apply(entry)
    return mapper.trajectory(is_partial)


def coordinate_sets(case: Case) -> list[Coordinates]:
    """The sets of coordinates that a file may hold: of the case itself, then of each formulation without another clock."""
    own = Coordinates(tuple(c.name for c in case.state), {c.name: c.unit for c in case.state})
    sets = [own]
    for each in case.formulations:
        if each.clock is None:
            units = _read_formulations().get(case.name, {}).get(each.name)
            units = units or dict.fromkeys(names_of(case, each).coordinates, "")
            sets.append(Coordinates(tuple(units), units, each))
    return sets


@lru_cache(maxsize=1)
def _read_formulations() -> dict[str, dict[str, dict[str, str]]]:
    return tomllib.loads(Path(__file__).with_name("formulations.toml").read_text(encoding="utf-8"))


def _find_repeated(names: Sequence[str]) -> list[str]:
    return [name for place, name in enumerate(names) if name in names[:place]]


def split_columns(stated: Iterable[str] | Mapping[str, str] | None) -> list[str]:
    """The parts between commas, but for commas within brackets, as in the column `R[1,1]`."""
    if stated is None:
        return []
    if isinstance(stated, Mapping):
        return [f"{column}={target}" for column, target in stated.items()]
    parts = [stated] if isinstance(stated, str) else list(stated)
    entries = [part.strip() for text in parts for part in re.split(r",(?![^\[(]*[\])])", text)]
    if not all(entries):
        raise ValueError(f"--columns {shorten(','.join(parts))!r}: an empty part between commas; {SYNTAX}")
    return entries


def _entry(text: str, table: Table) -> Entry:
    left, equals, right = text.rpartition("=")
    target, *options = (part.strip() for part in right.split(":"))
    if not equals or not left.strip() or not target:
        raise ValueError(f"--columns {shorten(text)!r}: {SYNTAX}")
    targets = ("t",) if target.lower() in TIME else tuple(part.strip() for part in target.split("+"))
    return Entry(_columns(left.strip(), table), targets, tuple(options), text)


def _columns(left: str, table: Table) -> tuple[str, ...]:
    """The columns of a name: a column, an array, #k for the k-th column, the last part of a dotted name, or a+b."""
    if left in table.columns:
        return (left,)
    if left in table.groups:
        return table.groups[left]
    names = list(table.columns)
    if re.fullmatch(r"#\d+", left):
        place = int(left[1:])
        if not 1 <= place <= len(names):
            raise ValueError(
                f"--columns {left}: the file has {len(names)} columns; give a number from 1 to {len(names)}"
            )
        return (names[place - 1],)
    short = [name for name in names if name.rpartition(".")[2] == left]
    if len(short) == 1:
        return (short[0],)
    if "+" in left:
        return tuple(name for part in left.split("+") for name in _columns(part.strip(), table))
    if short:
        raise ValueError(
            f"--columns {left}: several columns end so ({shorten(', '.join(short))}); write the whole name"
        )
    raise ValueError(f"--columns: no column is called {shorten(left)!r}; {_list_names([*names, *table.groups], left)}")


def _list_names(names: Sequence[str], wanted: str) -> str:
    if len(names) <= 30:
        return f"the file has {', '.join(names)}"
    return f"the file has {len(names)} columns: {nearest(wanted, names).removesuffix(': see gnomon list')}"


def _chart(case: Case, table: Table, entries: Sequence[Entry]) -> Coordinates:
    """The coordinates that the mapping names, or else those for which the file has all columns; the case's own first."""
    sets = coordinate_sets(case)
    named = {target for entry in entries for target in entry.targets} - {"t", ATTITUDE, RATES}
    fitting = [each for each in sets if named <= set(each.names)]
    if not fitting:
        wrong = sorted(named - set(sets[0].names))[0]
        others = "".join(
            f"; as {each.formulation.name}: {', '.join(each.names)}"
            for each in sets[1:]
            if each.formulation is not None
        )
        attitude = f", {ATTITUDE}, {RATES}" if _attitude(case) else ""
        raise ValueError(
            f"--columns: {case.name} has no coordinate {shorten(wrong)!r}; it has t, {', '.join(sets[0].names)}{attitude}{others}"
        )
    if any(entry.targets in ((ATTITUDE,), (RATES,)) for entry in entries):
        return sets[0]
    known = _names_in(table)
    covered = [each for each in fitting if set(each.names) <= named | set(known)]
    return covered[0] if covered else fitting[0]


def _names_in(table: Table) -> dict[str, str]:
    """The columns by the name of a coordinate that each can have; a name that two columns have is not there."""
    by_name: dict[str, str] = {}
    for column in table.columns:
        name = GREEK.get(column, column)
        if name not in by_name:
            by_name[name] = column
    lower: dict[str, list[str]] = {}
    for column in table.columns:
        lower.setdefault(column.lower(), []).append(column)
    return by_name | {name: columns[0] for name, columns in lower.items() if len(columns) == 1 and name not in by_name}


def _by_name(table: Table, chart: Coordinates, entries: Sequence[Entry]) -> list[Entry]:
    """An entry for the time and each coordinate that no text maps and whose name a column has that no text uses."""
    used = {column for entry in entries for column in entry.columns}
    mapped = {target for entry in entries for target in entry.targets}
    known = {name: column for name, column in _names_in(table).items() if column not in used}
    added = []
    if "t" not in mapped and "t" not in chart.names:
        times = [known[name] for name in TIME if name in known]
        added += [Entry((column,), ("t",), (), column, False) for column in times[:1]]
    elements = {name for name in chart.names if re.fullmatch(r"R[123][123]", name)}
    covered = mapped | (elements if ATTITUDE in mapped else set())
    names = () if RATES in mapped else [name for name in chart.names if name not in covered and name in known]
    return added + [Entry((known[name],), (name,), (), known[name], False) for name in names]


def _attitude(case: Case) -> list[int]:
    """The places of the nine numbers of an attitude; [] for a case without one."""
    places = [place for place, coordinate in enumerate(case.state) if coordinate.kind == "attitude"]
    return places if len(places) == 9 else []


def _rates(case: Case) -> list[int]:
    places = [place for place, coordinate in enumerate(case.state) if coordinate.kind == "angular velocity"]
    return places if len(places) == 3 else []


class _Mapper:
    """Fills times and states, one entry after the other."""

    def __init__(self, table: Table, case: Case, chart: Coordinates) -> None:
        self.table, self.case, self.chart = table, case, chart
        rows = table.rows()
        self.times: Floats | None = None
        self.half_time = 0.0
        self.values = np.full((rows, len(chart.names)), np.nan)
        self.halves = np.zeros((rows, len(chart.names)))
        self.present = np.zeros(len(chart.names), dtype=np.bool_)
        self.attitude: Floats | None = None
        self.mapping: list[str] = []

    def apply(self, entry: Entry) -> None:
        values = np.column_stack([self.table.columns[name] for name in entry.columns])
        halves = np.column_stack([self._half(name) for name in entry.columns])
        if entry.targets == ("t",):
            self._take_time(entry, values, halves)
        elif entry.targets == (ATTITUDE,):
            self._take_attitude(entry, values, halves)
        else:
            targets = self._targets(entry)
            if len(entry.columns) != len(targets):
                raise ValueError(
                    f"--columns {shorten(entry.text)}: {len(entry.columns)} columns for {len(targets)} numbers"
                    f" ({', '.join(targets)}); give as many"
                )
            self._take_vector(entry, targets, values, halves)

    def trajectory(self, is_partial: bool) -> Trajectory:
        table, names = self.table, self.chart.names
        if self.times is None:
            raise ValueError(
                f"{table.source}: no column is called t or time; give --columns COLUMN=t, {_list_names(list(table.columns), 't')}"
            )
        missing = [name for name, present in zip(names, self.present, strict=True) if not present]
        formulation = self.chart.formulation
        if len(missing) == len(names) or (missing and (not is_partial or formulation is not None)):
            way = f"--columns COLUMN={missing[0]}" + (
                ", or --partial to compare the others alone"
                if len(missing) < len(names) and formulation is None
                else ""
            )
            raise ValueError(
                f"{table.source}: no column for {shorten(', '.join(missing))} of {self.case.name}; give {way}"
                f"; {_list_names(list(table.columns), missing[0])}"
            )
        states, halves, present, notes = self.values, self.halves, self.present, list(table.notes)
        if formulation is not None:
            parameters = [float(value) for value in self.case.parameter_values()]
            with np.errstate(all="ignore"):
                states = np.asarray(formulation.decode(states, parameters), dtype=np.float64)
                moved = np.asarray(formulation.decode(self.values + halves, parameters), dtype=np.float64)
            halves, present = np.abs(moved - states), np.ones(states.shape[1], dtype=np.bool_)
            notes.append(f"coordinates of the formulation {formulation.name}, converted to the case's own")
        if missing:
            notes.append(f"not compared, without a column: {', '.join(missing)}")
        return Trajectory(
            table.source, self.times, states, present, np.where(np.isfinite(halves), halves, 0.0), self.half_time,
            np.array(table.lines, dtype=np.int64), table.row_word, self.mapping, notes,
        )  # fmt: skip

    def _half(self, name: str) -> Floats:
        half = self.table.resolution.get(name)
        return np.zeros(self.table.rows()) if half is None else half

    def _targets(self, entry: Entry) -> tuple[str, ...]:
        if entry.targets != (RATES,):
            return entry.targets
        places = _rates(self.case)
        if not places:
            raise ValueError(
                f"--columns {shorten(entry.text)}: {self.case.name} has no three rates; name its coordinates"
            )
        return tuple(self.chart.names[place] for place in places)

    def _unit(self, entry: Entry, unit: str, what: str, words: Sequence[str]) -> tuple[float, str]:
        """The factor to a unit, and how it is known. Raises ValueError for an option that is neither unit nor word."""
        units = [option for option in entry.options if option not in words]
        for option in units:
            if option in WORDS:
                raise ValueError(f"--columns {shorten(entry.text)}: {option} is not an option of {what}")
        if len(units) > 1:
            raise ValueError(f"--columns {shorten(entry.text)}: two units, {units[0]} and {units[1]}; give one")
        if units:
            return factor_to(units[0], unit or "1", f"--columns {shorten(entry.text)}"), units[0]
        stated = self.table.units.get(entry.columns[0])
        if stated:
            return factor_to(stated, unit or "1", f"the header's unit of {entry.columns[0]}"), f"{stated}, by the file"
        return 1.0, unit if unit in ("", "1") else f"{unit}, as no unit is stated"

    def _say(self, entry: Entry, what: str, unit: str) -> None:
        words = [
            option for option in entry.options if option in WORDS or option in QUATERNIONS or EULER.fullmatch(option)
        ]
        details = ", ".join([part for part in (unit, *words) if part and part != "1"])
        self.mapping.append(f"{' + '.join(entry.columns)} is {what}" + (f" ({details})" if details else ""))

    def _take_time(self, entry: Entry, values: Floats, halves: Floats) -> None:
        if values.shape[1] != 1:
            raise ValueError(f"--columns {shorten(entry.text)}: {values.shape[1]} columns; the time is one")
        factor, unit = self._unit(entry, "s", "the time", ("first",))
        times = values[:, 0] * factor
        if "first" in entry.options:
            times = times - times[0]
        self.times = times
        self._say(entry, "the time", unit)
        if np.any(halves):
            self.half_time = factor * _rounding_of_times(
                values[:, 0], halves[:, 0], self.table.decimals.get(entry.columns[0])
            )

    def _take_vector(self, entry: Entry, targets: tuple[str, ...], values: Floats, halves: Floats) -> None:
        units = {self.chart.units[name] for name in targets}
        if len(units) > 1:
            raise ValueError(
                f"--columns {shorten(entry.text)}: {', '.join(targets)} have several units; map them one by one"
            )
        words = ("negative", "wrapped", *(("y-up",) if len(targets) == 3 else ()))
        words += ("body", "space", "y-up-space") if entry.targets == (RATES,) else ()
        (own,) = units
        factor, unit = self._unit(entry, own, "these numbers" if len(targets) > 1 else targets[0], words)
        values, halves = values * factor, halves * abs(factor)
        if "negative" in entry.options:
            values = -values
        if "wrapped" in entry.options:
            finite = np.all(np.isfinite(values), axis=1)
            values[finite] = np.unwrap(values[finite], axis=0)
        if {"y-up", "y-up-space"} & set(entry.options):
            values = values @ Y_UP.T
        if entry.targets == (RATES,):
            values = self._in_own_axes(entry, values)
        places = [self.chart.names.index(name) for name in targets]
        self.values[:, places], self.halves[:, places], self.present[places] = values, halves, True
        self._say(entry, ", ".join(targets), unit)

    def _in_own_axes(self, entry: Entry, values: Floats) -> Floats:
        """Rates along the axes of the case, from rates along the body's or space's axes."""
        axes = {"body", "space"} & set(entry.options)
        if len(axes) != 1:
            raise ValueError(f"--columns {shorten(entry.text)}: rates along which axes? add :body or :space")
        own = rates_are_of_body(self.case, _rates(self.case), _attitude(self.case)) if _attitude(self.case) else None
        if own is None:
            raise ValueError(f"--columns {shorten(entry.text)}: {self.case.name} has no attitude; name its coordinates")
        if own == ("body" in axes):
            return values
        if self.attitude is None:
            raise ValueError(f"--columns {shorten(entry.text)}: to turn the rates, map the attitude too")
        return np.asarray(np.einsum("nji,nj->ni" if own else "nij,nj->ni", self.attitude, values))

    def _take_attitude(self, entry: Entry, values: Floats, halves: Floats) -> None:
        places = _attitude(self.case)
        if not places:
            raise ValueError(
                f"--columns {shorten(entry.text)}: {self.case.name} has no attitude; it has {', '.join(self.chart.names)}"
            )
        kinds = [o for o in entry.options if o in QUATERNIONS or o == "matrix" or EULER.fullmatch(o)]
        if len(kinds) != 1:
            raise ValueError(
                f"--columns {shorten(entry.text)}: how is the attitude written? add one of :wxyz, :xyzw, :matrix, or a sequence"
                " of Euler angles as :ZYX (about the body's axes) or :zyx (about space's)"
            )
        (kind,) = kinds
        width = 4 if kind in QUATERNIONS else 9 if kind == "matrix" else 3
        if values.shape[1] != width:
            raise ValueError(
                f"--columns {shorten(entry.text)}: {values.shape[1]} columns, {kind} has {width}; give as many"
            )
        is_euler = width == 3
        words = (kind, "y-up", "y-up-space", "conjugate", "transposed")
        factor, unit = self._unit(entry, "rad" if is_euler else "1", "an attitude", words)
        rotations = matrices(values * factor if is_euler else values, kind)
        if {"conjugate", "transposed"} & set(entry.options):
            rotations = np.swapaxes(rotations, 1, 2)
        if {"y-up", "y-up-space"} & set(entry.options):
            rotations = Y_UP @ rotations
            rotations = rotations @ Y_UP.T if "y-up" in entry.options else rotations
        self.attitude = rotations
        self.values[:, places] = rotations.reshape(-1, 9)
        self.halves[:, places] = np.max(halves * (abs(factor) if is_euler else 2.0), axis=1, keepdims=True)
        self.present[places] = True
        self._say(entry, "the attitude", unit if is_euler else "")


def _rounding_of_times(values: Floats, halves: Floats, decimals: int | None) -> float:
    """Half a unit of the last digit of the times, in their unit; 0 if equal steps with these digits have no rest.

    0.05, 0.1, 0.15 are exact; 0.033, 0.067, 0.1 are not, nor are times without equal steps.
    """
    finite = values[np.isfinite(values)]
    if len(finite) < 3 or decimals is None:
        return float(np.max(halves, initial=0.0))
    steps = np.diff(finite)
    if decimals >= 0:
        steps = np.round(steps * 10.0**decimals)
        is_even = len(np.unique(steps)) == 1
    else:
        is_even = bool(np.ptp(steps) <= 4 * np.max(np.spacing(np.abs(finite))))
    return 0.0 if is_even else float(np.max(halves[np.isfinite(values)]))


def states_of(case: Case, times: Any, states: Any) -> Trajectory:
    """The trajectory of arrays in the case's own coordinates and units: times (n,), states (n, dim).

    Raises ValueError for other shapes, and for arrays that are not numbers.
    """
    names = [coordinate.name for coordinate in case.state]
    try:
        moments, values = np.array(times, dtype=np.float64), np.array(states, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError("times and states: give arrays of numbers") from None
    if moments.ndim != 1 or values.shape != (len(moments), len(names)):
        raise ValueError(
            f"times has the shape {moments.shape}, states {values.shape}; give (n,) and (n, {len(names)}), with the columns"
            f" {', '.join(names)}"
        )
    halves = np.zeros_like(values)
    if isinstance(states, np.ndarray) and states.dtype.kind == "f" and states.dtype.itemsize < 8:
        halves = np.where(np.isfinite(values), np.abs(np.spacing(states)).astype(np.float64) / 2, 0.0)
    return Trajectory(
        "the given states", moments, values, np.ones(len(names), dtype=np.bool_), halves, 0.0,
        np.arange(1, len(moments) + 1), "row",
    )  # fmt: skip
