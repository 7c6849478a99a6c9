"""Whether a run got worse than a base: for CI."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

SERIES = ["case", "variant", "formulation", "integrator_id"]
ERROR_FACTOR = 2.0
"""A series is worse where the median ratio of errors at equal settings is above this: the last bits of libm and FMA
move single errors of adaptive methods by more, their median hardly."""
SINGLE_FACTOR = 30.0
"""One setting alone is worse above this ratio: switching off FMA was seen to move one error from .0016 to .046."""
CALLS_FACTOR = 1.1
"""Right-hand sides are exact on one machine and vary by .3 % between builds."""
ORDER_LOSS = 0.3
RANK = {"ok": 0, "inaccurate": 1, "diverged": 2}


@dataclass
class Verdict:
    """Lines that say what got worse, and notes that need nobody's attention."""

    compared: int = 0
    regressions: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def compare(base: Any, run: Any) -> Verdict:
    """Compare two frames of `gnomon.harness.load`, series by series, at the settings that both have.

    Raises ValueError where they have no series in common.
    """
    verdict = Verdict()
    before, after = (dict(list(frame[frame["launch"] == 1].groupby(SERIES))) for frame in (base, run))
    for name in before:
        if name in after:
            verdict.compared += 1
            _series(" ".join(name), before[name], after[name], verdict)
    if not verdict.compared:
        raise ValueError("the two runs have no case and integrator in common; run the same cases")
    missing = len(set(before) - set(after))
    if missing:
        verdict.notes.append(f"{missing} series of the base were not run")
    return verdict


def _series(name: str, before: Any, after: Any, verdict: Verdict) -> None:
    both = before.merge(after, on="setting", suffixes=("", "_after"))
    for row in both.itertuples():
        if _worse(row.status, row.status_after):
            verdict.regressions.append(
                f"{name} at {row.setting:g}: {row.status} became {row.status_after} {row.reason_after}"
            )
    sound = both[(both["status"] == "ok") & (both["status_after"] == "ok")]
    attainable = np.maximum(10 * sound["conditioning"], 10 * sound["floor"])
    ratios = np.maximum(sound["error_max_after"], attainable) / np.maximum(sound["error_max"], attainable)
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
    seconds = (sound["seconds_median_after"] / sound["seconds_median"]).dropna()
    if len(seconds) and np.median(seconds) > 1.5:
        verdict.notes.append(f"{name}: {np.median(seconds):.2g} times the time of the base (advisory)")


def _worse(before: str, after: str) -> bool:
    """Whether a status got worse; what the clock decides (timeout, skipped) is no regression."""
    if after in ("timeout", "skipped") or before in ("timeout", "skipped"):
        return False
    return RANK.get(after, 3) > RANK.get(before, 3)


def _order(settings: Any, errors: Any, attainable: Any) -> float:
    """The slope of error over step where the error is well above what is attainable; nan for fewer than 4 points."""
    use = (errors > 30 * attainable) & (errors < 1e-2)
    if use.sum() < 4:
        return math.nan
    return float(np.polyfit(np.log(settings[use].astype(float)), np.log(errors[use].astype(float)), 1)[0])
