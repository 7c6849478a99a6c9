"""Comparisons that further launches may decide: on rows of a results file, without pandas, as `rankings` on a page.

A cell is a problem at one error. Only default variants in the case's own formulation count, of which times are precise.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from statistics import median
from typing import Any, NamedTuple

from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.results.equal_error import reached
from gnomon.harness.results.separation import discoveries, paired
from gnomon.harness.results.summary import tidy
from gnomon.harness.results.values import DELAYED

CONTENDER = 2.0
"""Largest ratio to the least time for a contender: single launches of one program may be as far apart."""
LARGEST_NULL = 0.1
"""The largest share of the null call in the time of a contender with which a cell is ranked."""
MOST_LAUNCHES = 10
"""Number of launches after which an undecided pair is a tie."""
OURS = "gnomon"
RANKED, ONE_LAUNCH, TOO_SHORT, ALONE = "ranked", "not separated", "too short to rank", "one integrator"
"""Kinds of cells. A ranked cell has several integrators, timed in several launches on a span that is long enough: one
launch cannot separate integrators."""

THIRD, YOURS, OWN = "third", "yours", "own"
"""Divisions: third-party libraries, integrators that the run was given, and gnomon's own methods."""

Row = Mapping[str, Any]


class Time(NamedTuple):
    """The time of a series at an error: see `equal_error.Reached`."""

    case: str
    variant: str
    library: str
    integrator_id: str
    target: float
    seconds: float
    launches: int
    times: dict[tuple[int, int], float]
    null_share: float


class Pair(NamedTuple):
    """An undecided comparison of the integrator with the least time of a cell and a contender."""

    case: str
    variant: str
    target: float
    first: str
    contender: str


def division(library: str) -> str:
    """The division in which integrators of a library are ranked."""
    return OWN if library == OURS else THIRD if library in LIBRARIES else YOURS


def kind(rows: Sequence[Row]) -> str:
    """The kind of a cell, from `ratio`, `times` and `null_share` of its integrators."""
    contenders = [row for row in rows if row["ratio"] < CONTENDER]
    if len(rows) == 1:
        return ALONE
    if not all(row["null_share"] <= LARGEST_NULL for row in contenders):
        return TOO_SHORT
    first, *others = sorted(rows, key=lambda row: row["ratio"])
    several = any(len(first["times"].keys() & row["times"].keys()) > 1 for row in others)
    return RANKED if several else ONE_LAUNCH


def p_values(rows: Sequence[Row]) -> list[float]:
    """The p value of each row's claim that the integrator with the least time is faster."""
    first = min(rows, key=lambda row: row["ratio"])["times"]
    chosen = max(sum(row["ratio"] < CONTENDER for row in rows) - 1, 1)
    found = []
    for row in rows:
        both = first.keys() & row["times"].keys()
        found.append(min(1.0, chosen * paired([math.log(row["times"][n] / first[n]) for n in both])))
    return found


def times(rows: Iterable[Row]) -> list[Time]:
    """The time at equal error of each series, from rows of `reading.rows`."""
    series: dict[tuple[str, str, str, str], list[dict[str, Any]]] = {}
    for row in tidy(rows):
        if row["formulation"] == row["variant"] == "":
            key = (row["case"], row["variant"], row["library"], row["integrator_id"])
            series.setdefault(key, []).append(row)
    found = []
    for key, own in sorted(series.items()):
        timed = _timed(own)
        for one in reached(timed) if timed else ():
            found.append(Time(*key, one.target, one.seconds, one.launches, one.times, one.null_share))
    return found


def undecided(found: Sequence[Time]) -> list[Pair]:
    """The pairs that further launches may separate, in each division, which has its own false discovery rate, as on a page.

    A contender counts up to MOST_LAUNCHES.
    """
    of: dict[str, list[Time]] = {THIRD: [], YOURS: [], OWN: []}
    for one in found:
        of[division(one.library)].append(one)
    return [pair for part in of.values() for pair in _undecided(part)]


def _undecided(found: Sequence[Time]) -> list[Pair]:
    cells: dict[tuple[str, str, float], list[dict[str, Any]]] = {}
    for one in found:
        cells.setdefault((one.case, one.variant, one.target), []).append(one._asdict())
    kinds, claims = {}, []
    for key, rows in cells.items():
        least = min(row["seconds"] for row in rows)
        for row in rows:
            row["ratio"], row["slower"] = row["seconds"] / least, False
        kinds[key] = kind(rows)
        if kinds[key] == RANKED:
            claims += [(p, row) for p, row in zip(p_values(rows), rows, strict=True) if row["ratio"] > 1]
    for holds, (_, row) in zip(discoveries([p for p, _ in claims]), claims, strict=True):
        row["slower"] = bool(holds)
    pairs = []
    for key, rows in sorted(cells.items()):
        first = min(rows, key=lambda row: row["ratio"])["integrator_id"]
        near = [row for row in rows if row["ratio"] < CONTENDER and not row["slower"]]
        names = [row["integrator_id"] for row in near if row["launches"] < MOST_LAUNCHES and kinds[key] != TOO_SHORT]
        pairs += [Pair(*key, first, name) for name in names if name != first]
    return pairs


def _timed(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The timed rows of a series as `reached` reads them, loosest first, with the null calls without their own work."""
    slope = _slope(rows)
    found = []
    for row in sorted(rows, key=lambda row: -(row["setting"] or 0.0)):
        if row["status"] not in SCORED or not (row["seconds_median"] or 0.0) > 0:
            continue
        error = math.inf if row["status"] == Status.DIVERGED else row["error_max"]
        null, work = row["null_seconds"], row["null_work"]
        if null is not None and slope is not None and work is not None:
            null = max(null - slope * work, 0.0)
        numbers = {
            "error_max": math.nan if error is None else error,
            "null_seconds": math.nan if null is None else null,
        }
        found.append({**row, **numbers})
    return found


def _slope(rows: Sequence[Row]) -> float | None:
    """Seconds for a right-hand side (or a step) in a series: see `analysis.null_calls`."""
    taken: dict[str, float] = {}
    for row in rows:
        work = row["steps"] if row["rhs_calls"] is None else row["rhs_calls"]
        if work is not None:
            taken[row["trial_key"]] = max(work, taken.get(row["trial_key"], 0))
    usable = []
    for row in rows:
        seconds, null, own = row["seconds_median"], row["null_seconds"], row["null_work"]
        work, delay = taken.get(row["trial_key"]), row["delay_seconds"]
        if None in (seconds, null, own, work) or row["status"] not in SCORED:
            continue
        assert work is not None
        if work >= 2 * own and work > own and not (delay or 0.0) > DELAYED * seconds:
            usable.append((work, (seconds - null) / (work - own)))
    most = max((work for work, _ in usable), default=None)
    return None if most is None else max(median(cost for work, cost in usable if work == most), 0.0)
