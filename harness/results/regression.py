"""The regression check: whether a run is worse than a base run, for continuous integration.

Every setting that the base measured and the run did not is a regression, or counted as not compared.
"""

import math
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from gnomon.harness.contract.status import CANNOT_RUN, SCORED, STOPPED, Status
from gnomon.harness.results.values import TRIES

SERIES = ["case", "variant", "formulation", "integrator_id"]
COLUMNS = [
    "setting", "setting_kind", "numbers", "span", "status", "reason", "limit_seconds", "repeats", "turned_starts",
    "error_max", "floor", "conditioning", "rhs_calls", "steps", "seconds_median", "machine",
]  # fmt: skip
ERROR_FACTOR = 2.0
"""A series is worse if the median ratio of errors at equal settings is above this. Differences of libm and FMA in the
last bits change single errors of adaptive methods by more, the median hardly."""
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
"""The statuses that the integrator determines; the clock, the machine or the plan determine the others."""


@dataclass
class Verdict:
    """What is worse in the run, how much was compared, and notes for information."""

    compared: int = 0
    """Number of series of which at least one setting was compared."""
    settings: int = 0
    regressions: list[str] = field(default_factory=list)
    not_compared: Counter[str] = field(default_factory=Counter)
    """Number of settings of the base that were not compared, by reason."""
    notes: list[str] = field(default_factory=list)


def compare(base: Any, run: Any, allow_missing: bool = False) -> Verdict:
    """Compare two frames of `gnomon.harness.load`, series by series, at the settings that both have.

    A series that the run lacks is a regression unless `allow_missing`. A series of which no setting can be compared is
    a regression. Raises ValueError if no setting of any series can be compared.
    """
    verdict = Verdict()
    before, after = (dict(list(_used(frame).groupby(SERIES))) for frame in (base, run))
    before = {name: rows for name, rows in before.items() if rows["status"].isin(ANSWERED).any()}
    if not before:
        raise ValueError("nothing ran in the base, so there is nothing to compare with; give another base")
    if not set(before) & set(after):
        raise ValueError("the two runs have no case and integrator in common; run the same cases")
    incomparable: list[str] = []
    for name in before:
        if name in after:
            _series(" ".join(name), before[name], after[name], verdict, incomparable)
    if not verdict.compared and not verdict.regressions:
        raise ValueError(f"no setting of the two runs can be compared: {reasons(verdict.not_compared)}")
    verdict.regressions += incomparable
    missing = [name for name in before if name not in after]
    if missing:
        lacking = sum(before[name]["status"].isin(ANSWERED).sum() for name in missing)
        verdict.not_compared["their series is not in the run"] += int(lacking)
        line = f"{len(missing)} series of the base are not in the run, the first: {' '.join(missing[0])}"
        (verdict.notes if allow_missing else verdict.regressions).append(line)
    _count_lacked(base, run, verdict)
    return verdict


def _count_lacked(base: Any, run: Any, verdict: Verdict) -> None:
    """Count as compared what neither of the two can run on its machine: these rows are equal."""
    place = [*SERIES, "setting"]
    before, after = (
        frame.loc[(frame["launch"] == 1) & frame["status"].isin(CANNOT_RUN), place]
        .astype({"setting": float})
        .drop_duplicates()
        for frame in (base, run)
    )
    both = before.merge(after, on=place)
    verdict.compared += both.groupby(SERIES).ngroups
    verdict.settings += len(both)


def _used(frame: Any) -> Any:
    """The rows and columns of a frame that are compared: its first launch, with numbers in place of nulls."""
    frame = frame.loc[frame["launch"] == 1].reindex(columns=[*SERIES, *COLUMNS])
    filled = {"turned_starts": 0.0, "repeats": 1.0, "limit_seconds": math.nan}
    return frame.assign(**{name: frame[name].astype(float).fillna(value) for name, value in filled.items()})


def reasons(counted: Counter[str]) -> str:
    """Counts by reason as text, the most frequent first."""
    return ", ".join(f"{count} because {reason}" for reason, count in counted.most_common())


def _series(name: str, before: Any, after: Any, verdict: Verdict, incomparable: list[str]) -> None:
    answered = before[before["status"].isin(ANSWERED)]
    pairs = answered.merge(after, on="setting", how="left", suffixes=("", "_after"))
    hangs = ((after["status"] == Status.TIMEOUT) & (after["repeats"] >= TRIES)).any()
    why_not = [_why_not(row, hangs) for row in pairs.itertuples()]
    left_out = Counter(reason for reason in why_not if reason is not None)
    verdict.not_compared += left_out
    both = pairs[[reason is None for reason in why_not]]
    if len(both):
        verdict.compared += 1
        verdict.settings += len(both)
    _statuses(name, both, verdict)
    if (before["status"] == Status.OK).any() and not (after["status"] == Status.OK).any():
        counts = ", ".join(f"{count} {status}" for status, count in after["status"].value_counts().items())
        verdict.regressions.append(f"{name}: ok in the base, no setting is ok any more ({counts})")
    elif both.empty:
        incomparable.append(f"{name}: no setting can be compared ({reasons(left_out)})")
    _numbers(name, both, verdict)


def _why_not(row: Any, hangs: bool) -> str | None:
    """Why a setting of the base cannot be compared with that of the run; None if it can."""
    status = row.status_after
    if not isinstance(status, str):
        return "the run has no such setting"
    if (row.numbers, row.span) != (row.numbers_after, row.span_after):
        return "the numbers of the case are others in the run"
    if status == Status.INTERRUPTED:
        return "the trial was interrupted in the run"
    if status in STOPPED:
        if row.limit_seconds_after < row.limit_seconds:
            return f"the trial is {status} under a lower limit than the base had"
        near = row.seconds_median > NEAR_LIMIT * row.limit_seconds_after
        lasting = row.status == Status.OK and row.limit_seconds_after >= row.limit_seconds and hangs and not near
        return None if lasting else f"the trial is {status} in the run"
    if row.status in SCORED and status in SCORED and row.turned_starts != row.turned_starts_after:
        return "errors are medians over turned starts in one of the two alone"
    return None


def _statuses(name: str, both: Any, verdict: Verdict) -> None:
    """A line for each kind of worse status, with the first setting and reason."""
    worse: dict[tuple[str, str], list[Any]] = {}
    for row in both.itertuples():
        if RANK.get(row.status_after, 3) > RANK.get(row.status, 3):
            worse.setdefault((row.status, row.status_after), []).append(row)
    for (was, became), rows in worse.items():
        more = f" and {len(rows) - 1} more" if len(rows) > 1 else ""
        line = f"{name} at {rows[0].setting:g}{more}: {was} became {became} {rows[0].reason_after or ''}"
        verdict.regressions.append(line.rstrip())


def _numbers(name: str, both: Any, verdict: Verdict) -> None:
    """Compare errors, right-hand sides, order and time at the settings that are ok in both runs."""
    sound = both[(both["status"] == Status.OK) & (both["status_after"] == Status.OK)]
    attainable = np.maximum(10 * sound["conditioning"], 10 * sound["floor"])
    errors = np.maximum(sound["error_max"], attainable)
    ratios = np.maximum(sound["error_max_after"], attainable) / errors
    if len(ratios) and np.median(ratios) > ERROR_FACTOR:
        verdict.regressions.append(f"{name}: errors are {np.median(ratios):.2g} times those of the base")
    for setting, ratio in zip(sound["setting"], ratios, strict=True):
        if ratio > SINGLE_FACTOR:
            verdict.regressions.append(f"{name} at {setting:g}: the error is {ratio:.2g} times that of the base")
    calls = (sound["rhs_calls_after"] / sound["rhs_calls"]).dropna()
    if len(calls) and np.median(calls) > CALLS_FACTOR:
        verdict.regressions.append(f"{name}: {np.median(calls):.2f} times the right-hand sides of the base")
    orders = [_order(sound["setting"], sound[column], attainable) for column in ("error_max", "error_max_after")]
    if (sound["setting_kind"] == "step").any() and orders[1] < orders[0] - ORDER_LOSS:
        verdict.regressions.append(f"{name}: order {orders[0]:.2f} became {orders[1]:.2f}")
    timed = sound[sound["machine"] == sound["machine_after"]]
    seconds = (timed["seconds_median_after"] / timed["seconds_median"]).dropna()
    if len(seconds) and np.median(seconds) > 1.5:
        verdict.notes.append(f"{name}: {np.median(seconds):.2g} times the time of the base (advisory)")


def _order(settings: Any, errors: Any, attainable: Any) -> float:
    """The slope of log error over log step where errors are well above the attainable one; nan below 4 points."""
    use = (errors > 30 * attainable) & (errors < 1e-2)
    if use.sum() < 4:
        return math.nan
    return float(np.polyfit(np.log(settings[use].astype(float)), np.log(errors[use].astype(float)), 1)[0])
