"""The regression check: whether a run is worse than a base run, for continuous integration.

Every setting that the base measured is compared, or counted as not compared. A setting that is not compared does not
pass.
"""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from operator import itemgetter
from statistics import median
from typing import Any

from gnomon.harness.contract.status import CANNOT_RUN, SCORED, STOPPED, Status, is_certain_timeout
from gnomon.harness.results.contenders import list_launched
from gnomon.harness.results.convergence_order import FEWEST, LARGEST_ERROR, fit_slope
from gnomon.harness.results.equal_error import geometric_mean
from gnomon.harness.results.time_ratios import (
    EQUAL_WITHIN,
    SLOWER,
    Compared,
    Scatter,
    Timed,
    discoveries,
    scatter_of,
    state,
)
from gnomon.harness.results.time_ratios import compare as compare_times

SERIES = ["case", "variant", "formulation", "integrator_id"]
_name = itemgetter(*SERIES)
TEXTS = ["setting_kind", "numbers", "status", "reason", "machine"]
NUMBERS = [
    "setting", "span", "limit_seconds", "repeats", "turned_starts", "error_max", "floor", "conditioning", "rhs_calls",
    "seconds_median",
]  # fmt: skip
FILLED = {"turned_starts": 0.0, "repeats": 1.0}
"""The numbers that null stands for in these columns; in others null is an unknown number."""
ERROR_FACTOR = 2.0
"""A series is worse if the median ratio of errors at equal settings is above this. Differences of libm and FMA in the
last bits change single errors of adaptive methods by more, but hardly the median."""
SINGLE_FACTOR = 30.0
"""A single setting is worse above this ratio of errors: switching off FMA changed one error from .0016 to .046."""
CALLS_FACTOR = 1.1
"""A series is worse above this ratio of right-hand sides: counts are exact on one machine, and vary by .3 % between
builds."""
ORDER_LOSS = 0.3
NEAR_LIMIT = 1 / 3
"""A setting that took more than this share of the time limit in the base may pass the limit on a slower machine."""
RANK = {status: rank for rank, status in enumerate(SCORED)}
ANSWERED = (*SCORED, Status.REFUSED, Status.CRASHED, Status.OUT_OF_MEMORY)
"""The statuses that the integrator determines; the others depend on the clock, the machine or the plan."""

Row = Mapping[str, Any]
"""SERIES, `launch`, TEXTS and NUMBERS of a measurement; null is None or nan."""


@dataclass
class Verdict:
    """The result of a regression check: regressions, the amount that was compared, and notes for information."""

    compared: int = 0
    """Number of series with at least one setting compared."""
    settings: int = 0
    regressions: list[str] = field(default_factory=list)
    not_compared: Counter[str] = field(default_factory=Counter)
    """Number of settings of the base that were not compared, by reason."""
    allowed: int = 0
    """Number of these settings that may be missing in the run."""
    notes: list[str] = field(default_factory=list)

    @property
    def failed(self) -> bool:
        """Whether anything is worse, or a setting is not compared that must not be missing."""
        return bool(self.regressions) or self.not_compared.total() > self.allowed

    def summary(self) -> list[str]:
        """The numbers of settings that were not compared, by reason, and that were compared: one or two lines."""
        reasons_ = f"{self.not_compared.total()} settings of the base not compared: {reasons(self.not_compared)}"
        counts = f"{self.compared} series compared at {self.settings} settings, {len(self.regressions)} regressions"
        return [reasons_, counts] if self.not_compared else [counts]


def compare(base: Sequence[Row], run: Sequence[Row], allow_missing: bool = False) -> Verdict:
    """Compare the measurements of two runs (`reading.rows`), series by series, at the settings that both have.

    If the run lacks a series, this is a regression unless `allow_missing`, which also accepts settings without a result in the
    run. A series without a comparable setting is a regression. Raises ValueError if no setting of any
    series can be compared.
    """
    verdict = Verdict()
    before, after = _series(base), _series(run)
    lacked = _find_lacked(before) & _find_lacked(after)
    before = {name: rows for name, rows in before.items() if any(row["status"] in ANSWERED for row in rows)}
    if not before:
        raise ValueError("nothing ran in the base, so there is nothing to compare with; give another base")
    if not before.keys() & after.keys():
        raise ValueError("the two runs have no case and integrator in common; run the same cases")
    incomparable: list[str] = []
    for name, rows in before.items():
        if name in after:
            _compare(" ".join(name), rows, after[name], verdict, incomparable)
    if not verdict.compared and not verdict.regressions:
        raise ValueError(f"no setting of the two runs can be compared: {reasons(verdict.not_compared)}")
    verdict.regressions += incomparable
    missing = [name for name in before if name not in after]
    if missing:
        lacking = sum(row["status"] in ANSWERED for name in missing for row in before[name])
        verdict.not_compared["their series is not in the run"] += lacking
        verdict.allowed += lacking
        line = f"{len(missing)} series of the base are not in the run, the first: {' '.join(missing[0])}"
        (verdict.notes if allow_missing else verdict.regressions).append(line)
    verdict.compared += len({name for name, _ in lacked})  # trials that can run on neither machine are equal
    verdict.settings += len(lacked)
    verdict.allowed *= allow_missing
    return verdict


@dataclass(frozen=True)
class Change:
    """A number of a series in the base and in the run, at one setting, and the median over settings of their ratio."""

    base: float
    run: float
    ratio: float


@dataclass(frozen=True)
class TimeChange(Change):
    """A change of a time: its ratio lies between `low` and `high` with 95 % confidence; nan without times on one machine.

    `state` is one of `time_ratios.states`: "slower" of the run or, with a ratio below 1, of the base.
    """

    low: float = math.nan
    high: float = math.nan
    state: str = ""


@dataclass(frozen=True)
class SeriesChange:
    """The changes of a series over the settings that are ok in both runs.

    `setting` is the finest of them, at which numbers are given, and `settings` their number. Without any, numbers are nan
    and `why` has the most frequent status of each run.
    """

    name: tuple[str, ...]
    setting: float
    settings: int
    error: Change
    calls: Change
    seconds: TimeChange
    why: str = ""


def changes(base: Sequence[Row], run: Sequence[Row]) -> list[SeriesChange]:
    """The changes of the series of two runs (`reading.rows`), in the base's order, without series that could run in neither.

    Ratios of times are from settings that one machine timed in both runs, with the scatter between launches of both files.
    One false discovery rate holds for all ratios.
    """
    before, after = _series(base), _series(run)
    # Launches of two files share no effect, though they have equal numbers.
    scatter = scatter_of(
        series._replace(times={(sign * number, n): x for (number, n), x in series.times.items()})
        for sign, side in ((1, base), (-1, run))
        for series in list_launched(side)
    )
    compared, judged = list[SeriesChange](), list[Compared | None]()
    for name in dict.fromkeys([*before, *after]):
        rows = before.get(name, ()), after.get(name, ())
        if any(row["status"] not in CANNOT_RUN for side in rows for row in side):
            pairs = _pair_solved(*rows)
            compared.append(_change(name, pairs, *rows))
            timed = [pair for pair in pairs if pair[0]["machine"] == pair[1]["machine"]]
            judged.append(_compare_times(name[-1], timed, scatter))
    held = iter(discoveries([row.p for row in judged if row is not None]))
    return [
        change if row is None else replace(change, seconds=_with_time(change.seconds, row, bool(next(held))))
        for change, row in zip(compared, judged, strict=True)
    ]


def slower(compared: Sequence[SeriesChange]) -> list[str]:
    """A line for each series that is slower than the base by more than EQUAL_WITHIN: advice, because machines differ."""
    return [
        f"{' '.join(change.name)}: {change.seconds.ratio:.2g} ({change.seconds.low:.2g} – {change.seconds.high:.2g})"
        " times the time of the base (advisory)"
        for change in compared
        if change.seconds.state == SLOWER and change.seconds.ratio > EQUAL_WITHIN
    ]


def _pair_solved(before: Sequence[Row], after: Sequence[Row]) -> list[tuple[Row, Row]]:
    """The settings that are ok in both runs and comparable."""
    pairs = _pair_rows([row for row in before if row["status"] == Status.OK], after)
    return [
        (row, later)
        for row, later in pairs
        if later is not None and later["status"] == Status.OK and _incomparable(row, later) is None
    ]


def _compare_times(integrator_id: str, pairs: Sequence[tuple[Row, Row]], scatter: Scatter) -> Compared | None:
    """The times of the run against the base over settings that both timed; None without any.

    A launch counts with the geometric mean of its times if it timed all of the settings.
    """
    sides = []
    for number in (0, 1):
        launches: dict[int, list[float]] = {}
        for pair in pairs:
            for launch, seconds in pair[number]["times"].items():
                launches.setdefault(launch, []).append(seconds)
        whole = {(number, n): geometric_mean(at) for n, at in launches.items() if len(at) == len(pairs)}
        sides.append(Timed(integrator_id, whole) if whole else None)
    if None in sides:
        return None
    return compare_times([side for side in sides if side is not None], scatter, 0, 1)[1]


def _with_time(change: TimeChange, row: Compared, claimed: bool) -> TimeChange:
    return replace(change, ratio=row.ratio, low=row.low, high=row.high, state=state(row, claimed))


def _change(
    name: tuple[str, ...], both: Sequence[tuple[Row, Row]], before: Sequence[Row], after: Sequence[Row]
) -> SeriesChange:
    finest = min(both, key=lambda pair: pair[0]["setting"], default=None)

    def numbers(column: str) -> tuple[float, float]:
        return (math.nan, math.nan) if finest is None else (finest[0][column], finest[1][column])

    def change(column: str) -> Change:
        ratios = [_ratio(new[column], old[column]) for old, new in both]
        ratios = [ratio for ratio in ratios if not math.isnan(ratio)]
        return Change(*numbers(column), median(ratios) if ratios else math.nan)

    return SeriesChange(
        name, math.nan if finest is None else finest[0]["setting"], len(both),
        change("error_max"), change("rhs_calls"), TimeChange(*numbers("seconds"), math.nan),
        "" if both else f"base: {_most(before)}; run: {_most(after)}",
    )  # fmt: skip


def _most(rows: Sequence[Row]) -> str:
    """The most frequent status of a series in words."""
    counts = Counter(str(row["status"]) for row in rows).most_common(1)
    return counts[0][0].replace("_", " ") if counts else "no such series"


def _find_lacked(series: Mapping[tuple[str, ...], Sequence[Row]]) -> set[tuple[tuple[str, ...], float | None]]:
    """Series and setting of the trials that cannot run."""
    return {(name, _setting(row)) for name, rows in series.items() for row in rows if row["status"] in CANNOT_RUN}


def _series(rows: Iterable[Row]) -> dict[tuple[str, ...], list[dict[str, Any]]]:
    """The first launches by series, with TEXTS and NUMBERS; null numbers are nan.

    `times` are the times of all launches on the machine of the row, and `seconds` is their geometric mean.
    """
    by_series: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    times: dict[Any, dict[int, float]] = {}
    for row in rows:
        name, read = _name(row), _read(row)
        if row["launch"] == 1:
            by_series.setdefault(name, []).append(read)
        if not math.isnan(read["seconds_median"]):
            times.setdefault((name, read["setting"], read["machine"]), {})[row["launch"]] = read["seconds_median"]
    for name, of in by_series.items():
        for row in of:
            row["times"] = times.get((name, row["setting"], row["machine"]), {})
            row["seconds"] = geometric_mean(row["times"].values()) if row["times"] else math.nan
    return by_series


def _read(row: Row) -> dict[str, Any]:
    values: dict[str, Any] = {name: row[name] for name in (*TEXTS, *NUMBERS)}
    for name in NUMBERS:
        if values[name] is None or values[name] != values[name]:
            values[name] = FILLED.get(name, math.nan)
    return values


def reasons(counted: Counter[str]) -> str:
    """Counts by reason as text, the most frequent first."""
    return ", ".join(f"{count} because {reason}" for reason, count in counted.most_common())


def _compare(name: str, before: Sequence[Row], after: Sequence[Row], verdict: Verdict, incomparable: list[str]) -> None:
    hangs = any(is_certain_timeout(row["status"], row["reason"], row["repeats"]) for row in after)
    both: list[tuple[Row, Row]] = []
    left_out: Counter[str] = Counter()
    for row, later in _pair_rows([row for row in before if row["status"] in ANSWERED], after):
        lacking = _lacking(row, later, hangs)
        reason = lacking or (_incomparable(row, later) if later else None)
        if reason is not None:
            left_out[reason] += 1
            verdict.allowed += lacking is not None
        elif later is not None:
            both.append((row, later))
    verdict.not_compared += left_out
    verdict.compared += bool(both)
    verdict.settings += len(both)
    _statuses(name, both, verdict)
    if _has_ok(before) and not _has_ok(after):
        counts = ", ".join(f"{n} {status}" for status, n in Counter(row["status"] for row in after).most_common())
        verdict.regressions.append(f"{name}: ok in the base, no setting is ok any more ({counts})")
    elif not both:
        incomparable.append(f"{name}: no setting can be compared ({reasons(left_out)})")
    _numbers(name, [pair for pair in both if all(row["status"] == Status.OK for row in pair)], verdict)


def _has_ok(rows: Sequence[Row]) -> bool:
    return any(row["status"] == Status.OK for row in rows)


def _pair_rows(before: Sequence[Row], after: Sequence[Row]) -> list[tuple[Row, Row | None]]:
    """Each row of the base with the run's row at its setting: of several, from the base's machine, or the first."""
    at: dict[Any, Row] = {}
    for row in reversed(after):
        at[_setting(row)] = at[_setting(row), row["machine"]] = row
    return [(row, at.get((_setting(row), row["machine"]), at.get(_setting(row)))) for row in before]


def _setting(row: Row) -> float | None:
    return None if math.isnan(row["setting"]) else float(row["setting"])


def _lacking(before: Row, after: Row | None, hangs: bool) -> str | None:
    """Why the run has no result at a setting of the base; None if it has one, or if it hangs and should have one."""
    if after is None:
        return "the run has no such setting"
    status = after["status"]
    if status == Status.INTERRUPTED:
        return "the trial was interrupted in the run"
    if status not in STOPPED:
        return None
    if after["limit_seconds"] < before["limit_seconds"]:
        return f"the trial is {status} under a lower limit than the base had"
    near = before["seconds_median"] > NEAR_LIMIT * after["limit_seconds"]
    lasting = before["status"] == Status.OK and after["limit_seconds"] >= before["limit_seconds"] and hangs and not near
    return None if lasting else f"the trial is {status} in the run"


def _incomparable(before: Row, after: Row) -> str | None:
    """Why two results at one setting cannot be compared; None if they can."""
    statuses = before["status"], after["status"]
    if any(before[name] != after[name] for name in ("numbers", "span")):
        return "the numbers of the case are others in the run"
    if all(status in SCORED for status in statuses) and before["turned_starts"] != after["turned_starts"]:
        return "errors are medians over turned starts in one of the two alone"
    if statuses != (Status.OK, Status.OK):
        return None
    if not all(math.isfinite(row[name]) for row in (before, after) for name in ("error_max", "floor", "conditioning")):
        return "an error, a floor or a conditioning is missing or not finite in one of the two"
    if math.isnan(before["rhs_calls"]) != math.isnan(after["rhs_calls"]):
        return "right-hand sides are counted in one of the two alone"
    return None


def _statuses(name: str, both: Sequence[tuple[Row, Row]], verdict: Verdict) -> None:
    """A line for each kind of worse status, with the first setting and reason."""
    worse: dict[tuple[str, str], list[Row]] = {}
    for before, after in both:
        if RANK.get(after["status"], 3) > RANK.get(before["status"], 3):
            worse.setdefault((before["status"], after["status"]), []).append(after)
    for (was, became), rows in worse.items():
        more = f" and {len(rows) - 1} more" if len(rows) > 1 else ""
        line = f"{name} at {rows[0]['setting']:g}{more}: {was} became {became} {rows[0]['reason'] or ''}"
        verdict.regressions.append(line.rstrip())


def _numbers(name: str, sound: Sequence[tuple[Row, Row]], verdict: Verdict) -> None:
    """Compare errors, right-hand sides and order at the settings that are ok in both runs.

    The smaller one of the two attainable errors counts, so that a bound that is too large hides no error.
    """
    if not sound:
        return
    settings = [before["setting"] for before, _ in sound]
    attainable = [10 * min(max(row["conditioning"], row["floor"]) for row in pair) for pair in sound]
    errors = [[pair[side]["error_max"] for pair in sound] for side in (0, 1)]
    ratios = [_ratio(max(b, least), max(a, least)) for a, b, least in zip(*errors, attainable, strict=True)]
    if median(ratios) > ERROR_FACTOR:
        verdict.regressions.append(f"{name}: errors are {median(ratios):.2g} times the errors of the base")
    for setting, ratio in zip(settings, ratios, strict=True):
        if ratio > SINGLE_FACTOR:
            verdict.regressions.append(f"{name} at {setting:g}: the error is {ratio:.2g} times the error of the base")
    counted = [(before["rhs_calls"], after["rhs_calls"]) for before, after in sound]
    calls = [_ratio(after, before) for before, after in counted if not math.isnan(before)]
    if calls and median(calls) > CALLS_FACTOR:
        verdict.regressions.append(f"{name}: {median(calls):.2f} times the right-hand sides of the base")
    if any(before["setting_kind"] == "step" for before, _ in sound):
        orders = [_order(settings, values, attainable) for values in errors]
        if orders[1] < orders[0] - ORDER_LOSS:
            verdict.regressions.append(f"{name}: order {orders[0]:.2f} became {orders[1]:.2f}")


def _ratio(after: float, before: float) -> float:
    """The quotient; 1 for two zeros."""
    if before == 0:
        return math.inf if after > 0 else 1.0
    return after / before


def _order(settings: Sequence[float], errors: Sequence[float], attainable: Sequence[float]) -> float:
    """The slope of log error over log step where errors are well above the attainable error; nan below 4 points.

    A missing order hides nothing: the errors themselves are compared at every setting.
    """
    rows = zip(settings, errors, attainable, strict=True)
    used = [(math.log(h), math.log(error)) for h, error, least in rows if 30 * least < error < LARGEST_ERROR]
    return fit_slope(used) if len(used) >= FEWEST else math.nan
