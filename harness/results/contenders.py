"""The cells of a results file: who is fastest at an error, and which comparisons further launches may decide.

A cell is a problem at one error, in one division. Runs and pages both use this module, which needs no pandas. Only default
variants in the case's own formulation count, because their times are precise.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import itemgetter
from typing import Any, NamedTuple

from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.results.equal_error import find_reached, has_waited, without_waits
from gnomon.harness.results.schema import TIMING_SPAN
from gnomon.harness.results.summary import tidy
from gnomon.harness.results.time_ratios import (
    NEAR,
    OPEN,
    SLOWER,
    Compared,
    Launch,
    Scatter,
    Timed,
    compare,
    scatter_of,
    states,
)

OURS = "gnomon"
ANSWERED, UNDECIDED, ALONE = "answered", "open", "alone"
"""Kinds of cells: a cell is open if a pair within NEAR of the fastest is open, and alone if it has one row."""
THIRD, YOURS, OWN = "third", "yours", "own"
"""Divisions: third-party libraries, integrators that the run was given, and gnomon's own methods."""
MOST_LAUNCHES = 8
"""Largest number of launches of an open pair: the interval is then half as wide as after two launches."""

Row = Mapping[str, Any]
Names = tuple[str, str, str]
"""Case, variant and integrator id."""


class Time(NamedTuple):
    """The time of a series at an error: see `equal_error.Reached`."""

    case: str
    variant: str
    library: str
    integrator_id: str
    target: float
    seconds: float
    times: dict[Launch, float]
    settings: tuple[float, ...]

    @property
    def timed(self) -> Timed:
        """The times for `time_ratios`."""
        return Timed(self.integrator_id, self.times)


def division(library: str) -> str:
    """The division in which integrators of a library are ranked."""
    return OWN if library == OURS else THIRD if library in LIBRARIES else YOURS


def cell(rows: Sequence[Compared], states_: Sequence[str]) -> str:
    """The kind of a cell from its rows and their states."""
    if len(rows) == 1:
        return ALONE
    near = any(of == OPEN and row.ratio < NEAR for row, of in zip(rows, states_, strict=True))
    return UNDECIDED if near else ANSWERED


def judge(cells: Sequence[Sequence[Timed]], scatter: Scatter) -> list[tuple[list[Compared], list[str], str]]:
    """For each cell its rows against the fastest, their states and its kind, at one false discovery rate for all."""
    rows = [compare(timed, scatter) for timed in cells]
    return [(of, each, cell(of, each)) for of, each in zip(rows, states(rows), strict=True)]


def times(rows: Iterable[Row]) -> tuple[list[Time], dict[str, Scatter]]:
    """The time at equal error of each series, from rows of `reading.rows`, and the scatter of launches by division."""
    series: dict[tuple[str, str, str, str], list[dict[str, Any]]] = {}
    every = list[dict[str, Any]]()
    for row in tidy(rows):
        # Times over several spans are on no page: they give the time of one more period.
        if row["status"] in SCORED and (row["seconds_median"] or 0.0) > 0 and TIMING_SPAN not in row["variant"]:
            every.append(row)
            if row["formulation"] == "" and row["variant"] == "":
                key = (row["case"], row["variant"], row["library"], row["integrator_id"])
                series.setdefault(key, []).append(row)
    return [
        Time(*key, reached.target, reached.seconds, reached.times, reached.settings)
        for key, own in sorted(series.items())
        for reached in find_reached(_usable(own))
    ], scatters(list_launched(every))


def scatters(series: Sequence[Timed]) -> dict[str, Scatter]:
    """The scatter by division. The scatter of third parties is only from their own launches: other methods do not change it."""
    every = scatter_of(series)
    third = scatter_of([timed for timed in series if division(timed.kind[0]) == THIRD])
    return {THIRD: third, YOURS: every, OWN: every}


_series = itemgetter("case", "variant", "formulation", "integrator_id", "machine")


def list_launched(rows: Iterable[Row]) -> list[Timed]:
    """The times of each series that was launched several times, at its setting with the most launches, the middle of several."""
    series: dict[tuple[Any, ...], dict[Any, dict[Launch, tuple[float, bool]]]] = {}
    for row in rows:
        seconds = row["seconds_median"]
        if row["status"] in SCORED and seconds is not None and seconds > 0:
            at = series.setdefault(_series(row), {}).setdefault(row["setting"], {})
            at[row.get("run", 1), row["launch"]] = seconds, has_waited(row)
    launched = []
    for key, every in sorted(series.items(), key=lambda item: str(item[0])):
        settings = {setting: without_waits(at) for setting, at in every.items()}
        most = max(map(len, settings.values()))
        often = sorted((setting for setting, at in settings.items() if len(at) == most), key=lambda s: s or 0.0)
        if most > 1:
            launched.append(Timed(str(key[-2]), settings[often[len(often) // 2]]))
    return launched


def find_undecided(times: Sequence[Time], scatter: Mapping[str, Scatter]) -> dict[Names, set[float]]:
    """The series that further launches may separate, with the settings from which the times of their open cells are computed.

    In an open cell these are the fastest series and all series within NEAR of it that are not slower, so that their numbers
    of launches stay equal. A cell is left open after MOST_LAUNCHES. Each division has its own false discovery rate, as on a
    page.
    """
    wanted: dict[Names, set[float]] = {}
    for _, rows, compared, each, of in _judge_cells(times, scatter):
        near = [
            time for time, row, state in zip(rows, compared, each, strict=True) if row.ratio < NEAR and state != SLOWER
        ]
        if of == UNDECIDED and min(len(time.times) for time in near) < MOST_LAUNCHES:
            for time in near:
                wanted.setdefault((time.case, time.variant, time.integrator_id), set()).update(time.settings)
    return wanted


def open_cells(times: Sequence[Time], scatter: Mapping[str, Scatter]) -> dict[str, tuple[int, int]]:
    """By division the numbers of open cells and of cells with a pair."""
    kinds: dict[str, list[str]] = {THIRD: [], YOURS: [], OWN: []}
    for name, *_, of in _judge_cells(times, scatter):
        kinds[name].append(of)
    return {name: (each.count(UNDECIDED), len(each) - each.count(ALONE)) for name, each in kinds.items()}


def _judge_cells(
    times: Sequence[Time], scatter: Mapping[str, Scatter]
) -> Iterator[tuple[str, list[Time], list[Compared], list[str], str]]:
    """The cells of each division: its name, the times, their rows and states, the kind of the cell."""
    for name in (THIRD, YOURS, OWN):
        cells: dict[tuple[str, str, float], list[Time]] = {}
        for time in times:
            if division(time.library) == name:
                cells.setdefault((time.case, time.variant, time.target), []).append(time)
        judged = judge([[time.timed for time in rows] for rows in cells.values()], scatter[name])
        for rows, (compared, each, of) in zip(cells.values(), judged, strict=True):
            yield name, rows, compared, each, of


def _usable(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The timed rows of a series as `find_reached` reads them, loosest first."""
    usable = []
    for row in sorted(rows, key=lambda row: -(row["setting"] or 0.0)):
        error = math.inf if row["status"] == Status.DIVERGED else row["error_max"]
        null = row["null_seconds"]
        known = {"error_max": math.nan if error is None else error, "null_seconds": math.nan if null is None else null}
        usable.append(row | known)
    return usable
