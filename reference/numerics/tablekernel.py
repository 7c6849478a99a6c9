"""Evaluating a table of polynomials in double-double, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from gnomon.reference.numerics.doubledouble import add, fma, multiply, multiply_add, two_product, two_sum
from numba import njit
from numpy.typing import NDArray

SIGNATURE = (
    "void(float64[::1], float64[::1], float64[::1], float64[:,::1], float64[:,::1], float64[:,:,::1], float64[:,:,::1],"
    " float64[:,::1], float64[:,::1], float64[::1], float64[:,::1], float64[:,:,:,:,::1], float64[:,:,:,:,::1],"
    " int64[:,:,::1], float64[:,::1], boolean[::1])"
)
TINY = 1e-270
"""Below this, the low part of a double-double is subnormal."""
ROUNDING = 2.0**-80
"""In half cells: above the rounding error of a cell's end, below the distance of neighbouring doubles."""
DOUBT = 2.0**-7
"""In ulps: with an error below this, the value is within 0.51 ulp whichever way it was rounded."""


@njit(SIGNATURE, cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def evaluate(
    times: NDArray[Any],
    turns: NDArray[Any],
    edges: NDArray[Any],
    centres: NDArray[Any],
    inverses: NDArray[Any],
    high: NDArray[Any],
    low: NDArray[Any],
    errors: NDArray[Any],
    rates: NDArray[Any],
    period: NDArray[Any],
    shift: NDArray[Any],
    blocks: NDArray[Any],
    steps: NDArray[Any],
    groups: NDArray[Any],
    values: NDArray[Any],
    proved: NDArray[Any],
) -> None:
    """Fill `values` (len(times), dimension); `proved` is true where all values of a time are certainly within 0.51 ulp.

    `turns`: whole cycles before each time; the first block belongs to min(turns.min(), 0).
    `blocks` and `steps` (stages, count, size, size, 2): the power of stage k's matrix for n turns is
    blocks[k, n // count] steps[k, n % count], with `count` the number of the steps. `groups` (stages, groups, size): the
    components that each stage's matrix is multiplied with; -1 ends a group.
    """
    nodes, dimension = high.shape[1], high.shape[2]
    doubled = low.shape[1]
    stages, per_block, size = steps.shape[0], steps.shape[1], steps.shape[2]
    first = 0.0
    for n in turns:
        first = min(first, n)
    x, x_low, error = np.empty(dimension), np.empty(dimension), np.empty(dimension)
    y, y_low, y_error = np.empty(size), np.empty(size), np.empty(size)
    power = np.empty((size, size, 3))  # the last: the sum of magnitudes, because the product may cancel
    for i in range(len(times)):
        n = turns[i]
        proved[i] = False
        # t - n*period; the neglected part is below 2**-103 n*period.
        p, e = two_product(n, period[0])
        phase, below = two_sum(times[i], -p)
        phase, below = add(phase, below, -fma(n, period[1], e), -n * period[2])
        slip = abs(n) * period[0] * 2.0**-103
        cell = np.searchsorted(edges, phase, side="right") - 1
        if cell < 0:
            continue
        s, s_low = two_sum(phase, -centres[cell, 0])
        s, s_low = add(s, s_low, below, -centres[cell, 1])
        s, s_low = multiply(s, s_low, inverses[cell, 0], inverses[cell, 1])
        if abs(s) > 1.0 or (abs(s) == 1.0 and s * s_low > ROUNDING):
            continue  # in a gap between cells
        certain = True
        # The inner loop runs over components: the compiler turns it into vector instructions.
        for d in range(dimension):
            x[d], x_low[d] = 0.0, 0.0
            error[d] = errors[cell, d] + rates[cell, d] * slip
        for j in range(nodes - 1, doubled - 1, -1):
            for d in range(dimension):
                x[d] = fma(x[d], s, high[cell, j, d])
        for j in range(doubled - 1, -1, -1):
            for d in range(dimension):
                x[d], x_low[d] = multiply_add(x[d], x_low[d], s, s_low, high[cell, j, d], low[cell, j, d])
        for k in range(stages):
            index = int(n - first)
            block, step = index // per_block, index % per_block
            of_block, of_power = 0.0, 0.0
            for row in range(size):
                for column in range(size):
                    a, a_low, doubt = 0.0, 0.0, 0.0
                    for m in range(size):
                        f, f_low = blocks[k, block, row, m, 0], blocks[k, block, row, m, 1]
                        g, g_low = steps[k, step, m, column, 0], steps[k, step, m, column, 1]
                        of_block = max(of_block, abs(f))
                        a, a_low = multiply_add(f, f_low, g, g_low, a, a_low)
                        doubt += abs(f * g)
                    power[row, column, 0], power[row, column, 1], power[row, column, 2] = a, a_low, doubt
                    of_power = max(of_power, doubt)
            certain = certain and of_block > TINY and of_power > TINY
            for group in groups[k]:
                for row in range(size):
                    if group[row] < 0:
                        break
                    a, a_low, off = 0.0, 0.0, 0.0
                    for column in range(size):
                        d = group[column]
                        if d < 0:
                            break
                        f, f_low = power[row, column, 0], power[row, column, 1]
                        a, a_low = multiply_add(x[d], x_low[d], f, f_low, a, a_low)
                        off += error[d] * abs(f) + abs(x[d]) * power[row, column, 2] * 2.0**-97
                    y[row], y_low[row], y_error[row] = a, a_low, off
                for row in range(size):
                    d = group[row]
                    if d < 0:
                        break
                    x[d], x_low[d], error[d] = y[row], y_low[row], y_error[row]
        for d in range(dimension):
            a, a_low, off = x[d], x_low[d], error[d]
            if n != 0.0 and shift[d, 0] != 0.0:
                b, b_low = multiply(n, 0.0, shift[d, 0], shift[d, 1])
                a, a_low = add(a, a_low, b, b_low)
                off += abs(b) * 2.0**-98
            values[i, d] = a
            # An ulp is at least 2**-53 of its number.
            if (off < DOUBT * 2.0**-53 * abs(a) and abs(a) > TINY) or (off == 0.0 and a == 0.0):
                continue
            # The nearest double is uncertain within `off` of a midpoint; the closer neighbour of a power of two is the
            # one below.
            certain = certain and abs(a) > TINY and abs(a_low) + off < (abs(a) - np.nextafter(abs(a), 0.0)) / 2
        proved[i] = certain
