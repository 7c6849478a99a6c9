"""Fits the convergence order to errors: the slope of log error against log step size in the asymptotic range."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

LARGEST_ERROR = 1e-2
"""Above this an error is not small, and its leading term does not dominate."""

ABOVE_FLOOR = 100.0
"""Least ratio of an error to round-off, which changes it by 1 % then, and the slope over four halvings by 0.005."""

FEWEST, MOST = 4, 6
"""Minimum and maximum number of points of a fit: the finest in the range, where the leading term dominates most."""

LARGEST_ON_A_LINE, ABOVE_FLOOR_ON_A_LINE = 5e-2, 20.0
"""Wider bounds for `line`, whose points must agree: an error of 5e-2 on a line with smaller errors is asymptotic.
Round-off changes an error 20 times larger by 5 %, and the slope over three halvings by 0.03."""

STRAIGHT = 0.02
"""A coarser point is added to the smallest number of points while it changes the slope by less than this."""


def fit_order(
    steps: Sequence[float], errors: Sequence[float], floor: float | Sequence[float] = 0.0
) -> tuple[float, int] | None:
    """The slope of log error against log step and the number of points used; None with fewer than 4 in the range.

    The range: errors below 1e-2 and above 100 times `floor`, the error due to round-off and conditioning (one for all
    steps or one for each). All steps finer than the first one below the range are left out.
    """
    points = _choose_points(steps, errors, floor)
    return None if points is None else (fit_slope(points), len(points))


def slopes(
    steps: Sequence[float], errors: Sequence[float], floor: float | Sequence[float] = 0.0
) -> tuple[float, float, float] | None:
    """The slope of `fit_order`, and the smallest and largest slope from one of its points to the next."""
    points = _choose_points(steps, errors, floor)
    if points is None:
        return None
    pieces = [fit_slope(pair) for pair in itertools.pairwise(points)]
    return fit_slope(points), min(pieces), max(pieces)


def line(steps: Sequence[float], errors: Sequence[float], floor: float, within: float) -> tuple[float, float] | None:
    """The slope over the finest four successive steps on a line, and its margin from `mean_slope`.

    The steps are on a line if the slope between any two neighbours differs from their slope by at most `within`. Errors
    are below 5e-2 and above 20 times `floor`. None without four such steps. The order may differ from the slope by the
    margin.
    """
    points = [
        (math.log(step), math.log(error)) if ABOVE_FLOOR_ON_A_LINE * floor < error < LARGEST_ON_A_LINE else None
        for step, error in sorted(zip(steps, errors, strict=True))
    ]
    for first in range(len(points) - FEWEST + 1):
        window = [point for point in points[first : first + FEWEST] if point is not None]
        if len(window) == FEWEST:
            slope = fit_slope(window)
            if all(abs(fit_slope(pair) - slope) <= within for pair in itertools.pairwise(window)):
                return slope, mean_slope(window)[1]
    return None


def mean_slope(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The mean slope between neighbouring points, and half of its 95 % interval from the spread (Student's t).

    If the points scatter independently or follow a random walk, neighbouring slopes are uncorrelated or negatively
    correlated, and the interval is rather too wide. A line that bends has a wider interval.
    """
    return mean_and_half(np.array([fit_slope(pair) for pair in itertools.pairwise(points)]))


def mean_and_half(values: NDArray[np.float64]) -> tuple[float, float]:
    """The mean, and half of its 95 % interval (Student's t) if the values scatter independently."""
    half = stdtrit(len(values) - 1, 0.975) * np.std(values, ddof=1) / math.sqrt(len(values))
    return float(np.mean(values)), float(half)


def why_no_line(errors: Sequence[float], floor: float) -> str:
    """The reason why `line` has too few points, in words; empty if it has enough."""
    least = ABOVE_FLOOR_ON_A_LINE * floor
    if all(error <= least for error in errors):
        return "round-off at every step size"
    count = sum(least < error < LARGEST_ON_A_LINE for error in errors)
    if count >= FEWEST:
        return ""
    ends = "between an error of 0.05 and round-off" if min(errors) <= least else "with an error below 0.05"
    return f"{count} {'setting' if count == 1 else 'settings'} {ends}, {FEWEST} are needed"


def _choose_points(
    steps: Sequence[float], errors: Sequence[float], floor: float | Sequence[float]
) -> list[tuple[float, float]] | None:
    """The points (log step, log error) that a slope is fitted to, coarsest first; None with fewer than 4."""
    floors = np.broadcast_to(np.asarray(floor, dtype=np.float64), (len(steps),))
    usable: list[tuple[float, float]] = []
    for step, error, least in sorted(zip(steps, errors, floors.tolist(), strict=True), reverse=True):
        if math.isfinite(error) and error < ABOVE_FLOOR * least:
            break
        if not error < LARGEST_ERROR:
            usable = []
        elif error > 0:
            usable.append((math.log(step), math.log(error)))
    if len(usable) < FEWEST:
        return None
    count = FEWEST
    while (
        count < min(MOST, len(usable)) and abs(fit_slope(usable[-count - 1 :]) - fit_slope(usable[-count:])) < STRAIGHT
    ):
        count += 1
    return usable[-count:]


def fit_slope(points: Sequence[tuple[float, float]]) -> float:
    """The slope of the regression line through a few points: numpy's polynomials take 60 microseconds for two."""
    x, y = (sum(values) / len(points) for values in zip(*points, strict=True))
    return float(sum((a - x) * (b - y) for a, b in points) / sum((a - x) ** 2 for a, _ in points))
