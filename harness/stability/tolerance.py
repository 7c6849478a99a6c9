"""The panel of tolerances: slope, scatter and jumps of the error, effect of the start, and error over tolerance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from functools import cache, partial
from typing import Any

import numpy as np
from gnomon.cases.core.registry import get, names
from gnomon.harness.contract.integrator import Floats, Integrator, Steps, Tolerance
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.stability.panel import Column, Mark, panel
from gnomon.harness.stability.subjects import Budget, accepts, processor_seconds, subjects, trials_of
from gnomon.harness.studies.growth import interval_of_mean
from scipy.special import stdtrit

SUBJECTS = ("pendulum_simple", "kepler_orbit")
LOOSEST, TIGHTEST = 1e-5, 1e-7
FEWEST, MOST = 9, 121
"""Number of tolerances; the most are a factor of 1.04 apart."""
STARTS_FEWEST, STARTS_MOST = 8, 60
CASES_FEWEST = 2
ULPS = 8
TINY = 1e-10
"""Largest changes of a start, in ulp of each component and relative to the size of its group."""
BLOCKS = 8
"""Number of blocks for the interval of the slope, because errors at neighbouring tolerances are correlated."""
SHARE = 0.35
"""Share of the processor time for each of two problems; the rest is for the distribution over cases."""
DIGITS, STEP = 28, 2.0**-34
"""Digits, and relative distance of central differences: their error is 1e-20 of a size times a third derivative."""
STEADY, JUMPY, SENSITIVE = 0.1, 5.0, 2.0
"""Scatter in decades (a factor of 1.26) below which the error follows the tolerance; factors of the error above which a
jump, or the effect of a change of the start that is far below the error, is stated."""
PROPORTIONAL = 0.15


def _applies(integrator: Integrator) -> str | None:
    return "its setting is a step size" if isinstance(integrator.sweep, Steps) else None


def sentences(data: Mapping[str, Any]) -> list[str]:
    """Advice for the choice of an integrator, from the data of `tolerance`."""
    advice = []
    for name, row in data.get("problems", {}).items():
        if row.get("slope") is None:
            advice.append(f"Not for {name} at tolerances from {row['loosest']:g} to {row['tightest']:g}: {row['why']}.")
            continue
        slope = (
            f"error proportional to tolerance^{row['slope']:.2f} ({row['slope_low']:.2f} to {row['slope_high']:.2f})"
        )
        scatter, share = f"scatter {row['scatter_decades']:.2f} decades", row["round_off_share"]
        if share > 0.5:
            advice.append(f"Use it for errors at round-off on {name}: so at {share:.0%} of tolerances.")
        elif row["scatter_decades"] > STEADY:
            advice.append(f"Not for a tolerance that sets the error on {name}: {slope}, {scatter}.")
        elif row["slope_low"] > 1 + PROPORTIONAL or row["slope_high"] < 1 - PROPORTIONAL:
            advice.append(f"Not for an error that follows the tolerance in proportion on {name}: {slope}.")
        else:
            advice.append(f"Use its tolerance to set the error on {name}: {slope}, {scatter}.")
        if row["largest_jump"] > JUMPY:
            advice.append(f"Not for comparing runs at near tolerances on {name}: a factor of {row['neighbours']:.2f}"
                         f" changes the error {row['largest_jump']:.3g} times.")  # fmt: skip
        for key, text in (("ulps", f"{ULPS} ulp"), ("tiny", f"{TINY:g}")):
            if (row[key] or 0) > SENSITIVE:
                advice.append(f"Not for an error that repeats on {name}: changes of the start by {text} change it"
                             f" {row[key]:.3g} times.")  # fmt: skip
    over = data.get("over_tolerance") or {}
    if over.get("cases"):
        advice.append(f"Its error is {over['median']:.3g} times the tolerance {over['tolerance']:g} in the median of"
                     f" {over['cases']} cases, at most {over['worst']:.3g} times ({over['worst_case']}).")  # fmt: skip
    return advice


COLUMNS = (
    *(Column(name, f"error grows as tolerance to the power, {name}") for name in SUBJECTS),
    Column("jump", "largest jump of the error", True),
    Column("over", "error over tolerance, default cases", True),
)


def marks(data: Mapping[str, Any]) -> list[Mark]:
    """Slopes and jumps on the problems, and the spread of the error over the tolerance over all cases."""
    marks = []
    for name, row in data["problems"].items():
        if row["slope"] is None:
            marks.append(Mark(name if name in SUBJECTS else SUBJECTS[0], text=row["why"]))
            continue
        interval = f"{row['slope']:.2f} ({row['slope_low']:.2f} to {row['slope_high']:.2f})"
        text = f"{interval}, scatter {row['scatter_decades']:.2f} decades"
        if name in SUBJECTS:
            marks.append(Mark(name, row["slope"], row["slope_low"], row["slope_high"], text))
        jump = f"{name}: {row['largest_jump']:.3g} times for a change of {row['neighbours']:.2f} times"
        marks.append(Mark("jump", row["largest_jump"], text=jump))
    over = data["over_tolerance"]
    if over.get("cases"):
        text = (
            f"median {over['median']:.3g} of {over['cases']} cases, 10 to 90 %: {over['low']:.2g} to {over['high']:.2g}"
        )
        marks.append(Mark("over", over["median"], over["low"], over["high"], text))
    return marks


@panel("tolerance", "Error and tolerance", sentences, COLUMNS, marks, _applies)
def tolerance(integrator: Integrator, seconds: float) -> dict[str, Any]:
    """For each problem the slope and scatter of log error over log tolerance; over default cases error / tolerance."""
    budget = Budget(seconds)
    problems: dict[str, Any] = {}
    for trials in subjects(integrator, SUBJECTS):
        budget.extend(
            processor_seconds(partial(trials.whole, ends(trials)[0]))
        )  # compiles, which is not part of a solution's time
        if not problems or budget.left > -seconds:
            problems[trials.case.name] = proportionality(trials, SHARE * seconds)
    return {"problems": problems, "over_tolerance": over_tolerance(integrator, budget)}


def ends(trials: Trials) -> tuple[float, float]:
    """The loosest and the tightest tolerance of the panel that are within the sweep."""
    sweep = trials.integrator.sweep
    assert isinstance(sweep, Tolerance)
    return min(LOOSEST, sweep.loosest), max(TIGHTEST, sweep.tightest)


def proportionality(trials: Trials, seconds: float) -> dict[str, Any]:
    """Slope with its 95 % interval, scatter and jumps of the errors at tolerances from 1e-5 to 1e-7, within the sweep.

    `ulps`, `tiny`: the largest over the smallest error from changed starts at the middle tolerance.
    """
    loosest, tightest = ends(trials)
    budget = Budget(seconds)
    each = processor_seconds(lambda: trials.whole(tightest))
    count = budget.affords(1.5 * each, FEWEST, MOST)
    tolerances = np.geomspace(loosest, tightest, count)
    answers = [trials.whole(float(tolerance)) for tolerance in tolerances]
    errors = np.array([answer.error for answer in answers])
    row: dict[str, Any] = {"loosest": loosest, "tightest": tightest, "tolerances": count}
    usable = np.isfinite(errors) & (errors > 0)
    row["failed"] = int(np.count_nonzero(~np.isfinite(errors)))
    if np.count_nonzero(usable) < FEWEST:
        why = next((answer.why for answer in answers if not math.isfinite(answer.error)), "errors are 0")
        return row | {"slope": None, "why": why}
    row |= line(np.log10(tolerances[usable]), np.log10(errors[usable]))
    row["neighbours"] = float((loosest / tightest) ** (1 / (count - 1)))
    row["round_off_share"] = float(np.mean([answer.error <= answer.roundoff for answer in answers]))
    count = budget.affords(2 * each, 0, STARTS_MOST)
    if count < STARTS_FEWEST:
        return row | {"starts": 0, "ulps": None, "tiny": None}
    middle = math.sqrt(loosest * tightest)
    row |= {"starts": count, "ulps": _spread(trials, middle, count, 0.0), "tiny": _spread(trials, middle, count, TINY)}
    return row


def line(x: Floats, y: Floats) -> dict[str, float]:
    """Slope of y over x with its 95 % interval, standard deviation about the line, and largest jump.

    The jump is the largest factor by which 10^y changes from one x to the next beside the change of the line. The
    interval is a jackknife over blocks of neighbours, with Student's t.
    """
    slope, intercept = np.polyfit(x, y, 1)
    residuals = y - slope * x - intercept
    blocks = np.array_split(np.arange(len(x)), min(BLOCKS, len(x)))
    without = np.array([np.polyfit(np.delete(x, block), np.delete(y, block), 1)[0] for block in blocks])
    count = len(blocks)
    half = stdtrit(count - 1, 0.975) * math.sqrt((count - 1) / count * np.sum((without - without.mean()) ** 2))
    return {
        "slope": float(slope),
        "slope_low": float(slope - half),
        "slope_high": float(slope + half),
        "scatter_decades": float(np.std(residuals, ddof=2)),
        "largest_jump": float(10 ** np.max(np.abs(np.diff(residuals)))),
    }


def _spread(trials: Trials, tolerance: float, count: int, change: float) -> float | None:
    """The largest over the smallest error from `count` starts, moved by up to 8 ulp or by `change` of their sizes."""
    rng = np.random.default_rng(count)
    start, sizes = trials.start, trials.reference.sizes
    units = sizes * change / ULPS if change else np.spacing(np.abs(start)) * (start != 0)
    moved = start + units * rng.integers(-ULPS, ULPS, size=(count, len(start)), endpoint=True)
    slopes = sensitivity(trials.case.name)
    errors = []
    for initial, states in zip(moved, trials.solutions(trials.counting, tolerance, list(moved)), strict=True):
        exact = trials.reference.exact + slopes @ (initial - start)
        errors.append(float(np.max(trials.distance(states, exact))))
    least, most = min(errors), max(errors)
    return most / least if least > 0 and math.isfinite(most) else None


@cache
def sensitivity(name: str) -> Floats:
    """The derivative of the exact states by the initial state, at the samples of the default variant, (64, dim, dim).

    For a start that changes by 1e-10 it gives the exact motion to 1e-20 times the second derivative.
    """
    case = get(name).rounded()
    moments, columns = [Fraction(t) for t in case.times.tolist()], []
    for i, value in enumerate(case.initial_state):
        step = Fraction(STEP) * max(abs(value), Fraction(1))
        ends = []
        for sign in (1, -1):
            numbers = [x + sign * step * (k == i) for k, x in enumerate(case.initial_state)]
            neighbour = case.with_numbers(numbers, case.parameters)
            ends.append([neighbour.exact(t, DIGITS) for t in moments])
        above, below = ends
        pairs = zip(above, below, strict=True)
        columns.append([[float((a - b) / (2 * float(step))) for a, b in zip(*pair, strict=True)] for pair in pairs])
    return np.moveaxis(np.array(columns), 0, -1)


def over_tolerance(integrator: Integrator, budget: Budget, tolerance: float = 1e-6) -> dict[str, Any]:
    """Error over tolerance on default cases, in one random sequence for all methods, while time is left."""
    sweep = integrator.sweep
    assert isinstance(sweep, Tolerance)
    tolerance = min(max(tolerance, sweep.tightest), sweep.loosest)
    known = [name for name in names() if accepts(integrator, name)]
    ratios: dict[str, float] = {}
    for name in np.random.default_rng(0).permutation(known).tolist():
        if budget.left <= 0 and len(ratios) >= CASES_FEWEST:
            break
        ratios[name] = trials_of(integrator, name).whole(tolerance).error / tolerance
    data: dict[str, Any] = {"tolerance": tolerance, "tried": len(ratios), "of": len(known)}
    finite = {name: ratio for name, ratio in ratios.items() if math.isfinite(ratio)}
    data |= {"cases": len(finite), "failed": sorted(set(ratios) - set(finite))}
    if not finite:
        return data
    values = np.array(list(finite.values()))
    low, median, high = np.quantile(values, [0.1, 0.5, 0.9])
    worst = max(finite, key=lambda name: finite[name])
    data |= {"low": low, "median": median, "high": high, "worst": finite[worst], "worst_case": worst}
    if len(values) >= FEWEST:
        data["mean_low"], data["mean_high"] = (10**x for x in interval_of_mean(np.log10(np.maximum(values, 1e-16))))
    return data
