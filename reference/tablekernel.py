"""Evaluating a table of polynomials in double-double, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from gnomon.reference.doubledouble import add, fma, multiply, quick_two_sum, two_product, two_sum
from numba import njit
from numpy.typing import NDArray

SIGNATURE = (
    "void(float64[::1], float64[::1], float64[:,::1], float64[::1], float64[:,:,::1], float64[:,:,::1], int64,"
    " float64[:,::1], float64[:,::1], float64[::1], float64[:,::1], float64[:,::1], boolean[::1])"
)
TINY = 1e-270
"""Below this, the low part of a double-double is subnormal."""


@njit(SIGNATURE, cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def evaluate(
    times: NDArray[Any],
    turns: NDArray[Any],
    factors: NDArray[Any],
    edges: NDArray[Any],
    high: NDArray[Any],
    low: NDArray[Any],
    doubled: int,
    errors: NDArray[Any],
    rates: NDArray[Any],
    period: NDArray[Any],
    shift: NDArray[Any],
    values: NDArray[Any],
    sure: NDArray[Any],
) -> None:
    """Fill `values` (len(times), dimension); `sure` tells where every value is certainly the nearest double.

    `turns`: whole cycles before each time. `factors` (count, 2): powers of the cycle's factor, from that of the
    smallest of `turns` on; empty for a factor of 1.
    """
    cells, dimension, nodes = high.shape
    first = 0.0
    for n in turns:
        first = min(first, n)
    for i in range(len(times)):
        n = turns[i]
        # t - n*period; what is left out is below 2**-104 n*period.
        p, e = two_product(n, period[0])
        phase, below = two_sum(times[i], -p)
        phase, below = add(phase, below, -fma(n, period[1], e), -n * period[2])
        slip = abs(n) * period[0] * 2.0**-104
        if phase < edges[0] - slip or phase > edges[cells]:
            sure[i] = False
            continue
        cell = min(max(np.searchsorted(edges, phase, side="right") - 1, 0), cells - 1)
        half = (edges[cell + 1] - edges[cell]) / 2
        centre = edges[cell] + half
        s, s_low = two_sum(phase, -centre)
        s, s_low = quick_two_sum(s, s_low + below)
        s, s_low = s / half, s_low / half  # half is a power of two
        certain = True
        for d in range(dimension):
            tail = high[cell, d, nodes - 1]
            for j in range(nodes - 2, doubled - 1, -1):
                tail = fma(tail, s, high[cell, d, j])
            x, x_low = tail, 0.0
            for j in range(doubled - 1, -1, -1):
                x, x_low = multiply(x, x_low, s, s_low)
                x, x_low = add(x, x_low, high[cell, d, j], low[cell, d, j])
            error = errors[cell, d] + rates[cell, d] * slip
            if len(factors):
                f, f_low = factors[int(n - first), 0], factors[int(n - first), 1]
                x, x_low = multiply(x, x_low, f, f_low)
                error = error * abs(f) + abs(x) * 2.0**-98
                certain = certain and abs(f) > TINY
            if n != 0.0 and shift[d, 0] != 0.0:
                a, a_low = multiply(n, 0.0, shift[d, 0], shift[d, 1])
                x, x_low = add(x, x_low, a, a_low)
                error += abs(a) * 2.0**-98
            values[i, d] = x
            if error > 0.0 or x != 0.0:
                # The nearest double is in doubt within `error` of the midpoint to a neighbour; the nearer midpoint of a
                # power of two is the one below.
                gap = abs(x) - np.nextafter(abs(x), 0.0)
                certain = certain and abs(x) > TINY and abs(x_low) + error < gap / 2
        sure[i] = certain


@njit("float64[:,::1](float64[:,::1], float64[:,::1])", cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def products(blocks: NDArray[Any], steps: NDArray[Any]) -> NDArray[Any]:
    """The products of all `blocks` with all `steps`, double-doubles as rows, the index of steps running first."""
    found = np.empty((len(blocks) * len(steps), 2))
    for i in range(len(blocks)):
        for j in range(len(steps)):
            x, x_low = multiply(blocks[i, 0], blocks[i, 1], steps[j, 0], steps[j, 1])
            found[i * len(steps) + j, 0] = x
            found[i * len(steps) + j, 1] = x_low
    return found
