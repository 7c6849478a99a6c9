"""How errors and invariants grow over time: bounded, t, t^2, exponential. From the sampled states that a run stored."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from gnomon.cases.case import Case
from gnomon.harness import store
from gnomon.harness.analysis import SERIES
from gnomon.harness.judge import Judge
from gnomon.harness.truth import CaseSpec, truths
from numpy.typing import NDArray

Floats = NDArray[np.float64]

ROUND_OFF = 1e-13
"""Below this, some hundred units of round-off, growth has no law worth naming."""

CLEAR = 1e-5
"""The error near which growth is looked at."""


def law(times: Floats, sizes: Floats) -> str:
    """The law by which a size grows: round-off, bounded, sqrt t, t, t^2, faster than t^2, exponential.

    A power or an exponential is fitted to the running maximum over the last three quarters of the times, where a
    start-up no longer shows; the better of the two is named if the size grew by more than the rounding between laws.
    """
    if not np.all(np.isfinite(sizes)):
        return "diverged"
    envelope = np.maximum.accumulate(np.abs(sizes))
    if envelope[-1] < ROUND_OFF:
        return "round-off"
    late = (times >= times[-1] / 4) & (envelope > 0)
    if np.count_nonzero(late) < 8:
        return "bounded"
    t, logs = times[late], np.log(envelope[late])
    power, power_residual = _slope(np.log(t), logs)
    rate, rate_residual = _slope(t, logs)
    grown = rate * (t[-1] - t[0])
    if grown > math.log(100) and rate_residual < power_residual:
        return "exponential"
    bounds = ((0.25, "bounded"), (0.75, "sqrt t"), (1.5, "t"), (2.5, "t^2"))
    return next((name for bound, name in bounds if power < bound), "faster than t^2")


def _slope(x: Floats, y: Floats) -> tuple[float, float]:
    """Slope of the regression line and its residual sum of squares."""
    slope, intercept = np.polyfit(x, y, 1)
    return float(slope), float(np.sum((y - intercept - slope * x) ** 2))


def rebuilt(kind: type[Case], variant: str, numbers: Mapping[str, str], span: float) -> Case:
    """The case of a stored trial, from its own exact numbers.

    Raises ValueError where the case has other parameters than when it ran.
    """
    wanted = [coordinate.name for coordinate in kind.state] + [parameter.name for parameter in kind.parameter_list]
    missing = [key for key in wanted if key not in numbers]
    if missing:
        raise ValueError(f"{kind.name} ran without {', '.join(missing)}, which it has now")
    values = {key: Fraction(numbers[key]) for key in wanted}
    return kind(
        variant=variant or None,
        initial_state=[values[coordinate.name] for coordinate in kind.state],
        span=span,
        **{parameter.name: values[parameter.name] for parameter in kind.parameter_list},
    )


def laws(path: Path, frame: pd.DataFrame, chosen: pd.Series[Any], known: Mapping[str, type[Case]]) -> pd.DataFrame:
    """Drift laws: one row a series and quantity ("error" or an invariant), at the setting with an error nearest 1e-5.

    There growth stands clear above round-off, and is small enough to follow its law. `frame` holds the store's rows of
    that file; `chosen` marks the rows to look at. Cases that are not `known` by name have no laws.
    """
    wanted = frame[(frame["status"] == "ok") & chosen & (frame["error_max"] > 0) & frame["case"].isin(list(known))]
    wanted = wanted.assign(away=np.abs(np.log10(wanted["error_max"] / CLEAR))).sort_values(["launch", "away"])
    wanted = wanted.groupby(SERIES, dropna=False).head(1)
    sampled = store.states(path, wanted["measurement"].tolist())
    rows: list[tuple[Any, ...]] = []
    cases: list[tuple[Case, pd.DataFrame]] = []
    for (name, variant), group in wanted.groupby(["case", "variant"]):
        first = group.iloc[0]
        try:
            cases.append((rebuilt(known[name], variant, json.loads(first["numbers"]), float(first["span"])), group))
        except ValueError:
            continue  # the case has other parameters now: its rows keep their errors, without laws
    exact = truths([CaseSpec.of(case) for case, _ in cases], lambda: None)
    for case, group in cases:
        truth = exact[CaseSpec.of(case)]
        if isinstance(truth, str):
            continue  # its exact motion fails here, and so there is nothing to hold the states against
        judge = Judge(case, None, truth)
        for trial in group.itertuples():
            states = sampled.get(trial.measurement)
            if states is None or states.shape != judge.truth.exact.shape:
                continue
            sizes = {"error": judge.metric.distance(states, judge.truth.exact)} | judge.drift(states)
            key = [getattr(trial, column) for column in SERIES]
            rows += [
                (*key, trial.setting, quantity, law(truth.times, s), float(np.max(s))) for quantity, s in sizes.items()
            ]
    return pd.DataFrame(rows, columns=[*SERIES, "setting", "quantity", "law", "size"])
