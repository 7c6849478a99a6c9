"""The order of convergence that errors show: the slope of error against step size in the asymptotic range."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

Floats = NDArray[np.float64]

LARGEST_ERROR = 1e-2
"""Above this the error is no small quantity and its leading term does not rule it."""

ABOVE_FLOOR = 100.0
"""Round-off moves an error this far above it by 1 %, and the slope over four halvings by 0.005."""

FEWEST, MOST = 4, 6
"""Points that a slope is fitted to: the finest in the range, where the leading term rules most."""

LARGEST_ON_A_LINE, ABOVE_FLOOR_ON_A_LINE = 5e-2, 20.0
"""For `line`, whose points must agree: an error of 5e-2 that falls as those below it is asymptotic already, and round-off
moves one 20 times above it by 5 %, the slope over three halvings by 0.03."""

STRAIGHT = 0.02
"""A coarser point is taken in beyond the fewest while it moves the slope by less than this."""


def fit_order(
    steps: Sequence[float], errors: Sequence[float], floor: float | Sequence[float] = 0.0
) -> tuple[float, int] | None:
    """The slope of log error against log step and the number of points used; None with fewer than 4 in the range.

    The range: errors below 1e-2 and above 100 times `floor`, what round-off and conditioning leave (one for all steps
    or one for each). Points past the first one that falls under it are left out, whatever they do.
    """
    points = _fitted_points(steps, errors, floor)
    return None if points is None else (_slope(points), len(points))


def slopes(
    steps: Sequence[float], errors: Sequence[float], floor: float | Sequence[float] = 0.0
) -> tuple[float, float, float] | None:
    """The slope of `fit_order`, and the smallest and largest slope from one of its points to the next."""
    points = _fitted_points(steps, errors, floor)
    if points is None:
        return None
    pieces = [_slope(pair) for pair in itertools.pairwise(points)]
    return _slope(points), min(pieces), max(pieces)


def line(steps: Sequence[float], errors: Sequence[float], floor: float, within: float) -> tuple[float, float] | None:
    """The slope over the finest four successive steps whose slopes from one to the next agree within `within` with it,
    and the margin of `mean_slope`: settings that agree with each other may agree on what is not yet the order.

    Of errors below 5e-2 and above 20 times `floor`. None without four such steps.
    """
    points = [
        (math.log(step), math.log(error)) if ABOVE_FLOOR_ON_A_LINE * floor < error < LARGEST_ON_A_LINE else None
        for step, error in sorted(zip(steps, errors, strict=True))
    ]
    for first in range(len(points) - FEWEST + 1):
        taken = [point for point in points[first : first + FEWEST] if point is not None]
        if len(taken) == FEWEST:
            slope = _slope(taken)
            if all(abs(_slope(pair) - slope) <= within for pair in itertools.pairwise(taken)):
                return slope, mean_slope(taken)[1]
    return None


def mean_slope(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The mean slope from each point to the next, and half of its 95 % interval, from their spread (Student's t).

    Where the points scatter independently, or are the path of a random walk, neighbouring slopes are not correlated or
    against each other, and the interval is rather too wide. A line that bends has it wider by what it bends.
    """
    pieces = np.array([_slope(pair) for pair in itertools.pairwise(points)])
    half = stdtrit(len(pieces) - 1, 0.975) * np.std(pieces, ddof=1) / math.sqrt(len(pieces))
    return float(np.mean(pieces)), float(half)


def why_no_line(errors: Sequence[float], floor: float) -> str:
    """In words what `line` lacks, apart from points that agree."""
    least = ABOVE_FLOOR_ON_A_LINE * floor
    if all(error <= least for error in errors):
        return "round-off at every step size"
    count = sum(least < error < LARGEST_ON_A_LINE for error in errors)
    if count >= FEWEST:
        return ""
    ends = "between an error of 0.05 and round-off" if min(errors) <= least else "with an error below 0.05"
    return f"{count} {'setting' if count == 1 else 'settings'} {ends}, {FEWEST} are needed"


def _fitted_points(
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
    while count < min(MOST, len(usable)) and abs(_slope(usable[-count - 1 :]) - _slope(usable[-count:])) < STRAIGHT:
        count += 1
    return usable[-count:]


def _slope(points: Sequence[tuple[float, float]]) -> float:
    x, y = np.array(points).T
    return float(np.polyfit(x, y, 1)[0])
