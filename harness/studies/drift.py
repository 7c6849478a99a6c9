"""The growth of errors and drifts of invariants over time: a power with its interval, from the states of a run."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from gnomon.cases.core.case import Case
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solutions
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.results import store
from gnomon.harness.results.analysis import SERIES
from gnomon.harness.results.convergence_order import mean_slope
from gnomon.harness.studies.growth import by_octaves, name_law, possible

ROUND_OFF = 1e-13
"""Smaller growth, below some hundred units of round-off, is called round-off, and no power is fitted."""

CLEAR = 1e-5
"""Growth is fitted at the setting with an error nearest this: well above round-off, and small."""

OCTAVES = 4
"""Number of octaves of time for the fit, counted from the end: the earliest has 4 of the 64 samples."""

CLEARLY_LESS = 4.0
"""A ratio of two sums of squares, with about seven independent values each, which chance exceeds in 3 % (F test)."""


@dataclass(frozen=True)
class Growth:
    """The growth of a size over time: its power of time with a 95 % interval, nan if no power was fitted.

    `law`: a name of `growth.LAWS`, or "between ..." or "faster than ..." these, if the interval excludes all others;
    empty if the interval contains several laws. "diverged", "round-off" and "exponential" have no power.
    """

    law: str
    power: float = math.nan
    low: float = math.nan
    high: float = math.nan


def growth(times: Floats, sizes: Floats) -> Growth:
    """The growth of a size over the last OCTAVES octaves of time, from one series of samples.

    The power is the mean of the slopes between the logarithms of the root mean squares of neighbouring octaves; its
    interval comes from the spread of these slopes. Samples of one series are not independent. An interval from the
    residuals of a line would be too narrow: for random walks it contains the power in 73 to 90 of 100 cases, this
    interval in 97.
    """
    if not np.all(np.isfinite(sizes)):
        return Growth("diverged")
    if np.max(np.abs(sizes)) < ROUND_OFF:
        return Growth("round-off")
    if _is_exponential(times, sizes):
        return Growth("exponential")
    centres, logs = by_octaves(times, np.abs(sizes)[None], OCTAVES)
    if len(centres) < OCTAVES or not np.all(np.isfinite(logs)):
        return Growth("")
    power, margin = mean_slope(list(zip(centres.tolist(), logs[:, 0].tolist(), strict=True)))
    low, high = power - margin, power + margin
    return Growth(name_law(low, high) if len(possible(low, high)) <= 1 else "", power, low, high)


def _is_exponential(times: Floats, sizes: Floats) -> bool:
    """Whether the growth is exponential rather than a power.

    The largest value so far must have grown by a factor above 100 over the last three quarters of the time, and the
    residual sum of squares of an exponential must be below a quarter of the sum for a power. Both fits have two
    parameters.
    """
    envelope = np.maximum.accumulate(np.abs(sizes))
    late = (times >= times[-1] / 4) & (envelope > 0)
    if np.count_nonzero(late) < 8:
        return False
    t, logs = times[late], np.log(envelope[late])
    rate, residual = _line(t, logs)
    _, of_power = _line(np.log(t), logs)
    return bool(rate * (t[-1] - t[0]) > math.log(100) and CLEARLY_LESS * residual < of_power)


def _line(x: Floats, y: Floats) -> tuple[float, float]:
    """The slope of the line of least squares, and the sum of its squared residuals."""
    x, y = x - np.mean(x), y - np.mean(y)
    slope = float(x @ y) / float(x @ x)
    rest = y - slope * x
    return slope, float(rest @ rest)


def rebuild_case(kind: type[Case], variant: str, numbers: Mapping[str, str], span: float) -> Case:
    """The case of a stored trial, from the exact numbers of the trial.

    Raises ValueError if the case has parameters that it did not have when it ran.
    """
    wanted = [coordinate.name for coordinate in kind.state] + [parameter.name for parameter in kind.parameter_list]
    missing = [key for key in wanted if key not in numbers]
    if missing:
        raise ValueError(f"{kind.name} ran without {', '.join(missing)}, which it has now")
    return kind(
        variant=variant or None,
        initial_state=[numbers[coordinate.name] for coordinate in kind.state],
        span=span,
        **{parameter.name: numbers[parameter.name] for parameter in kind.parameter_list},
    )


class Sampled(NamedTuple):
    """A trial of a run with its sizes over time: the error, by the name "error", and the drift of each invariant."""

    trial: Any
    """The row of the store's frame, as `itertuples` gives it."""
    times: Floats
    sizes: dict[str, Floats]


def choose_samples(path: Path, frame: pd.DataFrame, known: Mapping[str, type[Case]]) -> Iterator[Sampled]:
    """Of each series the trial with an error nearest 1e-5: well above round-off, and small enough to follow its law.

    `frame` holds the store's rows of the file that are to be used. Cases that are not `known` by name are left out.
    """
    wanted = frame[(frame["status"] == Status.OK) & (frame["error_max"] > 0) & frame["case"].isin(list(known))]
    wanted = wanted.assign(away=np.abs(np.log10(wanted["error_max"] / CLEAR))).sort_values(["launch", "away"])
    wanted = wanted.groupby(SERIES, dropna=False).head(1)
    stored = store.states(path, wanted["measurement"].tolist())
    cases: list[tuple[Case, pd.DataFrame]] = []
    for (name, variant), group in wanted.groupby(["case", "variant"]):
        first = group.iloc[0]
        try:
            cases.append(
                (rebuild_case(known[name], variant, json.loads(first["numbers"]), float(first["span"])), group)
            )
        except ValueError:
            continue  # the case has other parameters now: its rows keep their errors, without laws
    exact = reference_solutions([CaseSpec.of(case) for case, _ in cases], lambda: None)
    for case, group in cases:
        reference = exact[CaseSpec.of(case)]
        if isinstance(reference, str):
            continue  # the exact motion cannot be computed here, so the states have no errors
        scorer = Scorer(case, None, reference)
        for trial in group[[*SERIES, "setting", "measurement"]].itertuples():
            states = stored.get(trial.measurement)
            if states is None or states.shape != scorer.reference.exact.shape:
                continue
            sizes = {"error": scorer.metric.distance(states, scorer.reference.exact)} | scorer.drift(states)
            yield Sampled(trial, reference.times, sizes)


def laws(path: Path, frame: pd.DataFrame, chosen: pd.Series[Any], known: Mapping[str, type[Case]]) -> pd.DataFrame:
    """Growth laws: a row for each series and quantity ("error" or an invariant), from `choose_samples` trials.

    `frame` holds the store's rows of the file; `chosen` marks the rows to use.
    """
    rows: list[tuple[Any, ...]] = []
    for trial, times, sizes in choose_samples(path, frame[chosen], known):
        key = [getattr(trial, column) for column in SERIES]
        rows += [
            (*key, trial.setting, quantity, *astuple(growth(times, size)), float(np.max(size)))
            for quantity, size in sizes.items()
        ]
    return pd.DataFrame(rows, columns=[*SERIES, "setting", "quantity", "law", "power", "low", "high", "size"])
