"""Exact states of many harmonic oscillators at once, in double-double; formulas as in `harmonic_oscillator`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gnomon.reference.numerics.doubledouble import add, multiply
from gnomon.reference.numerics.doubledouble_functions import divide, filled, root, sine_cosine
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
MOST_PHASE = 2.0**30
"""The phase in rad above which a motion is not called known: its absolute error is then 2**-70."""


def states(parameters: Floats, starts: Floats, times: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """States (n, k, 2) of oscillators with m, k (n, 2) from x, v (n, 2) at the times (k,) after the start.

    Also which of them are known (n,).
    """
    return filled(_evaluate, 2, parameters, starts, times)


@njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _evaluate(parameters: Floats, starts: Floats, times: Floats, out: Floats, known: Any) -> None:
    for i in range(len(starts)):
        x, v = starts[i, 0], starts[i, 1]
        a, a_low = divide(parameters[i, 1], 0.0, parameters[i, 0], 0.0)
        w, w_low = root(a, a_low)
        reach, reach_low = divide(v, 0.0, w, w_low)
        fast, fast_low = multiply(w, w_low, x, 0.0)
        known[i] = w > 0.0
        for j in range(len(times)):
            a, a_low = multiply(w, w_low, times[j], 0.0)
            known[i] &= abs(a) < MOST_PHASE
            if not known[i]:
                out[i, j] = np.nan
                continue
            s, s_low, c, c_low = sine_cosine(a, a_low)
            a, a_low = multiply(c, c_low, x, 0.0)
            b, b_low = multiply(s, s_low, reach, reach_low)
            a, a_low = add(a, a_low, b, b_low)
            out[i, j, 0] = a + a_low
            a, a_low = multiply(c, c_low, v, 0.0)
            b, b_low = multiply(s, s_low, fast, fast_low)
            a, a_low = add(a, a_low, -b, -b_low)
            out[i, j, 1] = a + a_low
            known[i] &= math.isfinite(out[i, j, 0] + out[i, j, 1])
