"""Compares formulas for many motions with the exact motion of each."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
from gnomon.reference.numerics.precision import exact

Floats = np.ndarray[Any, np.dtype[np.float64]]


def worst_ulps(
    states: Callable[..., Any], motion: Callable[..., Any], parameters: Floats, starts: Floats, times: Floats
) -> tuple[float, Floats]:
    """The largest error in units in the last place, and which motions are known. An error below 2**-58 of the size of the
    state counts as none: a value next to zero is not known to its last place."""
    found, known = states(parameters, starts, times)
    worst = 0.0
    for i in np.flatnonzero(known):
        one = motion(*map(Fraction, parameters[i].tolist()), *map(Fraction, starts[i].tolist()))
        for t, row in zip(times.tolist(), found[i].tolist(), strict=True):
            size = max(1.0, *map(abs, row))
            for value, right in zip(row, one.state(t, 40), strict=True):
                error = float(abs(exact(right) - Fraction(value)))
                if error > 2.0**-58 * size:
                    worst = max(worst, error / float(np.spacing(abs(value))))
    return worst, known
