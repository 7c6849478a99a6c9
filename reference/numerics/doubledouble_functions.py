"""Quotient, square root, sine, cosine and angle of numbers of 106 bits, compiled; the operations are in `doubledouble`.

Relative errors are some 2**-102; errors of sine and cosine are absolute, for arguments below 2**30.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
from gnomon.reference.numerics.doubledouble import add, fma, multiply, quick_two_sum, two_product, two_sum
from gnomon.reference.numerics.precision import exact, working
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
GRID = 32
"""Sines are tabulated at multiples of 1/32."""
LAST_FACTORIAL = 28


def parts(value: Any, count: int = 2) -> list[float]:
    """A number as an unevaluated sum of doubles."""
    rest, doubles = Fraction(exact(value)), []
    for _ in range(count):
        doubles.append(float(rest))
        rest -= Fraction(doubles[-1])
    return doubles


with working(60) as _mp:
    HALF_PI = np.array(parts(_mp.pi / 2, 3))
    TURN = np.array(parts(2 * _mp.pi))
    SINES: Floats = np.array([parts(_mp.sin(_mp.mpf(k) / GRID)) for k in range(27)])
    COSINES: Floats = np.array([parts(_mp.cos(_mp.mpf(k) / GRID)) for k in range(27)])
    """Of k/32, up to pi/4."""
    INVERSE: Floats = np.array([parts(1 / _mp.factorial(k)) for k in range(LAST_FACTORIAL)])
    """1/k!."""


def filled(
    formula: Callable[..., None], dimension: int, parameters: Floats, starts: Floats, times: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """The states (n, k, dimension) of many motions by a compiled formula, and which of the motions are known (n,)."""
    states = np.empty((len(starts), len(times), dimension))
    known = np.empty(len(starts), dtype=np.bool_)
    formula(parameters, starts, times, states, known)
    return states, known


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def divide(a: float, a_low: float, b: float, b_low: float) -> tuple[float, float]:
    q = a / b
    p, p_low = multiply(b, b_low, q, 0.0)
    r, r_low = add(a, a_low, -p, -p_low)
    s, s_low = quick_two_sum(q, (r + r_low) / b)
    return s, s_low


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def root(a: float, a_low: float) -> tuple[float, float]:
    """The square root; 0 for 0."""
    if a == 0.0:
        return 0.0, 0.0
    s = math.sqrt(a)
    p, p_low = two_product(s, s)
    r, r_low = quick_two_sum(s, ((a - p) - p_low + a_low) / (2 * s))
    return r, r_low


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def sine_cosine(x: float, x_low: float) -> tuple[float, float, float, float]:
    """sin and cos, high and low part each."""
    quarter = np.rint(x / HALF_PI[0])
    p, p_low = two_product(quarter, HALF_PI[0])
    r, r_low = add(x, x_low, -p, -p_low)
    p, p_low = two_product(quarter, HALF_PI[1])
    r, r_low = add(r, r_low, -p, -p_low)
    r, r_low = add(r, r_low, -quarter * HALF_PI[2], 0.0)
    k = int(np.rint(abs(r) * GRID))
    sign = -1.0 if r < 0 else 1.0
    d, d_low = add(sign * r, sign * r_low, -k / GRID, 0.0)
    q, q_low = multiply(d, d_low, d, d_low)
    s, s_low = INVERSE[13, 0], INVERSE[13, 1]
    c, c_low = INVERSE[14, 0], INVERSE[14, 1]
    for j in range(11, 0, -2):
        s, s_low = multiply(s, s_low, -q, -q_low)
        s, s_low = add(s, s_low, INVERSE[j, 0], INVERSE[j, 1])
    for j in range(12, -1, -2):
        c, c_low = multiply(c, c_low, -q, -q_low)
        c, c_low = add(c, c_low, INVERSE[j, 0], INVERSE[j, 1])
    s, s_low = multiply(s, s_low, d, d_low)
    S, S_low, C, C_low = SINES[k, 0], SINES[k, 1], COSINES[k, 0], COSINES[k, 1]
    a, a_low = multiply(S, S_low, c, c_low)
    b, b_low = multiply(C, C_low, s, s_low)
    sine, sine_low = add(a, a_low, b, b_low)
    a, a_low = multiply(C, C_low, c, c_low)
    b, b_low = multiply(S, S_low, s, s_low)
    cosine, cosine_low = add(a, a_low, -b, -b_low)
    sine, sine_low = sign * sine, sign * sine_low
    turned = int(quarter) & 3
    if turned == 1:
        return cosine, cosine_low, -sine, -sine_low
    if turned == 2:
        return -sine, -sine_low, -cosine, -cosine_low
    if turned == 3:
        return -cosine, -cosine_low, sine, sine_low
    return sine, sine_low, cosine, cosine_low


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def angle(y: float, y_low: float, x: float, x_low: float) -> tuple[float, float]:
    """The angle of (x, y), from -pi to pi: the angle of the high parts, corrected once."""
    rough = math.atan2(y, x)
    s, s_low, c, c_low = sine_cosine(rough, 0.0)
    a, a_low = multiply(y, y_low, c, c_low)
    b, b_low = multiply(x, x_low, s, s_low)
    a, a_low = add(a, a_low, -b, -b_low)
    b = fma(x, c, y * s)
    high, low = two_sum(rough, a / b)
    return high, low
