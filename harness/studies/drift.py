"""How errors and invariants grow over time: as a power with its interval. From the sampled states that a run stored."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from gnomon.cases.core.case import Case
from gnomon.harness.contract.status import Status
from gnomon.harness.results import store
from gnomon.harness.results.analysis import SERIES
from gnomon.harness.results.convergence_order import mean_slope
from gnomon.harness.scoring.reference_solution import CaseSpec, reference_solutions
from gnomon.harness.scoring.score import Scorer
from gnomon.harness.studies.growth import by_octaves, named, possible
from numpy.typing import NDArray

Floats = NDArray[np.float64]

ROUND_OFF = 1e-13
"""Below this, some hundred units of round-off, growth has no law worth naming."""

CLEAR = 1e-5
"""The error near which growth is looked at."""

OCTAVES = 4
"""Of time, back from the end: the first of them has 4 of the 64 samples."""

CLEARLY_LESS = 4.0
"""Of two sums of squares with about seven independent values each, by which 97 % of chance is excluded (F test)."""


@dataclass(frozen=True)
class Growth:
    """How a size grows over time: its power of time with a 95 % interval, nan where no power was fitted.

    `law`: a name of `growth.LAWS`, or what lies between or beyond, where the interval excludes all others; "diverged",
    "round-off" and "exponential" have no power; empty where the interval holds several laws.
    """

    law: str
    power: float = math.nan
    low: float = math.nan
    high: float = math.nan


def growth(times: Floats, sizes: Floats) -> Growth:
    """How a size grows over the last OCTAVES octaves of time, by one series of samples.

    The power is the mean slope of the logarithms of the root mean squares, from one octave to the next, and its interval
    comes from the spread of these slopes. Samples of one series are not independent, so that the residuals of a line
    would give too narrow an interval: of a random walk it holds the power in 73 to 90 of 100, this one in 97.
    """
    if not np.all(np.isfinite(sizes)):
        return Growth("diverged")
    if np.max(np.abs(sizes)) < ROUND_OFF:
        return Growth("round-off")
    if _exponential(times, sizes):
        return Growth("exponential")
    centres, logs = by_octaves(times, np.abs(sizes)[None], OCTAVES)
    if len(centres) < OCTAVES or not np.all(np.isfinite(logs)):
        return Growth("")
    power, margin = mean_slope(list(zip(centres.tolist(), logs[:, 0].tolist(), strict=True)))
    low, high = power - margin, power + margin
    return Growth(named(low, high) if len(possible(low, high)) <= 1 else "", power, low, high)


def _exponential(times: Floats, sizes: Floats) -> bool:
    """Whether the largest value so far grew a hundredfold over the last three quarters of the time, and an exponential
    leaves a quarter of the squares that a power leaves: both have two numbers."""
    envelope = np.maximum.accumulate(np.abs(sizes))
    late = (times >= times[-1] / 4) & (envelope > 0)
    if np.count_nonzero(late) < 8:
        return False
    t, logs = times[late], np.log(envelope[late])
    rate, residual = _slope(t, logs)
    return rate * (t[-1] - t[0]) > math.log(100) and CLEARLY_LESS * residual < _slope(np.log(t), logs)[1]


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
    wanted = frame[(frame["status"] == Status.OK) & chosen & (frame["error_max"] > 0) & frame["case"].isin(list(known))]
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
    exact = reference_solutions([CaseSpec.of(case) for case, _ in cases], lambda: None)
    for case, group in cases:
        reference = exact[CaseSpec.of(case)]
        if isinstance(reference, str):
            continue  # its exact motion fails here, and so there is nothing to hold the states against
        scorer = Scorer(case, None, reference)
        for trial in group.itertuples():
            states = sampled.get(trial.measurement)
            if states is None or states.shape != scorer.reference.exact.shape:
                continue
            sizes = {"error": scorer.metric.distance(states, scorer.reference.exact)} | scorer.drift(states)
            key = [getattr(trial, column) for column in SERIES]
            rows += [
                (*key, trial.setting, quantity, *astuple(growth(reference.times, s)), float(np.max(s)))
                for quantity, s in sizes.items()
            ]
    return pd.DataFrame(rows, columns=[*SERIES, "setting", "quantity", "law", "power", "low", "high", "size"])
