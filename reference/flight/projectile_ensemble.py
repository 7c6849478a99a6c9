"""Exact states of many projectiles at once, in double-double; formulas as in `projectile_parabola`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gnomon.reference.numerics.doubledouble import add, multiply, two_product
from gnomon.reference.numerics.doubledouble_functions import filled
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def states(parameters: Floats, starts: Floats, times: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """States (n, k, 4) of projectiles with g (n, 1) from x, y, vx, vy (n, 4) at the times (k,) after the start.

    Also which of them are known (n,).
    """
    return filled(_evaluate, 4, parameters, starts, times)


@njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _evaluate(parameters: Floats, starts: Floats, times: Floats, out: Floats, known: Any) -> None:
    for i in range(len(starts)):
        g = parameters[i, 0]
        x, y, vx, vy = starts[i, 0], starts[i, 1], starts[i, 2], starts[i, 3]
        known[i] = True
        for j in range(len(times)):
            t = times[j]
            a, a_low = two_product(vx, t)
            a, a_low = add(a, a_low, x, 0.0)
            out[i, j, 0] = a + a_low
            fall, fall_low = two_product(g, t)
            a, a_low = add(vy, 0.0, -fall, -fall_low)
            out[i, j, 2], out[i, j, 3] = vx, a + a_low
            # y + t (vy - g t / 2)
            a, a_low = add(vy, 0.0, -fall / 2, -fall_low / 2)
            a, a_low = multiply(a, a_low, t, 0.0)
            a, a_low = add(a, a_low, y, 0.0)
            out[i, j, 1] = a + a_low
            known[i] &= math.isfinite(out[i, j, 0] + out[i, j, 1])
