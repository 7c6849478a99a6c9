"""Exact states of many Kepler orbits at once, on any conic, in double-double: some microseconds each.

Kepler's equation in universal variables is solved in doubles by Laguerre's method (Conway, Celestial Mechanics 39, 1986)
and corrected twice in double-double; the universal functions are Stumpff's series after quartering of their argument.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gnomon.reference.numerics.doubledouble import add, multiply, two_product
from gnomon.reference.numerics.doubledouble_functions import INVERSE, TURN, divide, filled, root
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
UNIT = 2.0**-92
"""Bound of the relative error of the terms of Kepler's equation: some hundred operations, and doublings of angles."""
CERTAIN = 2.0**-58
"""Largest relative error of distance and speed that the error of the anomaly may cause."""
SERIES_ARGUMENT, TERMS = 0.1, 12
"""Stumpff's series is summed below this argument: its term 12 is below 1e-35."""
ITERATIONS, QUARTERINGS = 60, 12


def states(parameters: Floats, starts: Floats, times: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """States (n, k, 4) of orbits with mu (n, 1) from x, y, vx, vy (n, 4) at the times (k,) after the start.

    Also which of them are known (n,): radial and nearly radial motions need the formulas of any precision.
    """
    return filled(_evaluate, 4, parameters, starts, times)


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _rough(alpha: float, chi: float) -> tuple[float, float, float, float]:
    """U0 to U3 in doubles."""
    z, quarterings = alpha * chi * chi, 0
    while abs(z) > SERIES_ARGUMENT:
        z, quarterings = z / 4, quarterings + 1
    c2 = c3 = 0.0
    for k in range(TERMS - 1, -1, -1):
        c2, c3 = INVERSE[2 * k + 2, 0] - z * c2, INVERSE[2 * k + 3, 0] - z * c3
    c0, c1 = 1 - z * c2, 1 - z * c3
    for _ in range(quarterings):
        c3, c2, c1, c0 = (c2 + c0 * c3) / 4, c1 * c1 / 2, c0 * c1, 2 * c0 * c0 - 1
    return c0, chi * c1, chi * chi * c2, chi * chi * chi * c3


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _universal(alpha: float, alpha_low: float, chi: float, chi_low: float, out: Floats) -> None:
    """U0 to U3, rows of two parts."""
    x, x_low = multiply(chi, chi_low, chi, chi_low)
    z, z_low = multiply(alpha, alpha_low, x, x_low)
    quarterings = 0
    while abs(z) > SERIES_ARGUMENT:
        z, z_low, quarterings = z / 4, z_low / 4, quarterings + 1
    c2 = c2_low = c3 = c3_low = 0.0
    for k in range(TERMS - 1, -1, -1):
        c2, c2_low = multiply(c2, c2_low, -z, -z_low)
        c2, c2_low = add(c2, c2_low, INVERSE[2 * k + 2, 0], INVERSE[2 * k + 2, 1])
        c3, c3_low = multiply(c3, c3_low, -z, -z_low)
        c3, c3_low = add(c3, c3_low, INVERSE[2 * k + 3, 0], INVERSE[2 * k + 3, 1])
    p, p_low = multiply(z, z_low, c2, c2_low)
    c0, c0_low = add(1.0, 0.0, -p, -p_low)
    p, p_low = multiply(z, z_low, c3, c3_low)
    c1, c1_low = add(1.0, 0.0, -p, -p_low)
    for _ in range(quarterings):
        p, p_low = multiply(c0, c0_low, c3, c3_low)
        p, p_low = add(p, p_low, c2, c2_low)
        c3, c3_low = p / 4, p_low / 4
        p, p_low = multiply(c1, c1_low, c1, c1_low)
        c2, c2_low = p / 2, p_low / 2
        c1, c1_low = multiply(c0, c0_low, c1, c1_low)
        p, p_low = multiply(c0, c0_low, c0, c0_low)
        c0, c0_low = add(2 * p, 2 * p_low, -1.0, 0.0)
    out[0, 0], out[0, 1] = c0, c0_low
    out[1, 0], out[1, 1] = multiply(c1, c1_low, chi, chi_low)
    out[2, 0], out[2, 1] = multiply(c2, c2_low, x, x_low)
    p, p_low = multiply(x, x_low, chi, chi_low)
    out[3, 0], out[3, 1] = multiply(c3, c3_low, p, p_low)


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _anomaly(r0: float, sigma: float, alpha: float, T: float) -> Any:
    """chi with r0 U1 + sigma U2 + U3 = T in doubles; nan where it is not found."""
    chi = T / r0
    if alpha > 0:
        chi = alpha * T
    elif alpha < 0 and -alpha * chi * chi > 1:
        half = math.sqrt(-1 / alpha)
        inside = -2 * alpha * abs(T) / (math.copysign(1.0, T) * sigma + half * (1 - r0 * alpha))
        if inside > 1.5:
            chi = math.copysign(half * math.log(inside), T)
    for _ in range(ITERATIONS):
        u0, u1, u2, u3 = _rough(alpha, chi)
        value = r0 * u1 + sigma * u2 + u3 - T
        slope = r0 * u0 + sigma * u1 + u2
        bend = sigma * u0 + (1 - alpha * r0) * u1
        step = 5 * value / (slope + math.sqrt(abs(16 * slope * slope - 20 * value * bend)))
        if not math.isfinite(step):
            return np.nan
        chi -= step
        if abs(step) <= 1e-12 * abs(chi) or value == 0.0:  # the rest is corrected in double-double
            return chi
    return np.nan


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _combined(a: Floats, p: Floats, b: Floats, q: Floats, c: Floats, out: Floats) -> None:
    """out = a p + b q + c."""
    x, x_low = multiply(a[0], a[1], p[0], p[1])
    y, y_low = multiply(b[0], b[1], q[0], q[1])
    x, x_low = add(x, x_low, y, y_low)
    out[0], out[1] = add(x, x_low, c[0], c[1])


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _turns(start: Floats) -> bool:
    """Whether the angular momentum is not zero, exactly."""
    a, a_low = two_product(start[0], start[3])
    b, b_low = two_product(start[1], start[2])
    h, h_low = add(a, a_low, -b, -b_low)
    return bool(h != 0.0 or h_low != 0.0)


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _elements(mu: float, start: Floats, out: Floats) -> None:
    """r0, sigma = r v / sqrt(mu), alpha = 2/r0 - v^2/mu, sqrt(mu), each in a row of two parts."""
    sums = np.zeros((3, 2))
    for row, (i, j) in enumerate(((0, 0), (2, 2), (0, 2))):
        a, a_low = two_product(start[i], start[j])
        b, b_low = two_product(start[i + 1], start[j + 1])
        sums[row, 0], sums[row, 1] = add(a, a_low, b, b_low)
    r0, r0_low = root(sums[0, 0], sums[0, 1])
    s, s_low = root(mu, 0.0)
    out[0, 0], out[0, 1] = r0, r0_low
    out[1, 0], out[1, 1] = divide(sums[2, 0], sums[2, 1], s, s_low)
    a, a_low = divide(2.0, 0.0, r0, r0_low)
    b, b_low = divide(sums[1, 0], sums[1, 1], mu, 0.0)
    out[2, 0], out[2, 1] = add(a, a_low, -b, -b_low)
    out[3, 0], out[3, 1] = s, s_low


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _reduced(elements: Floats, t: float, out: Floats) -> float:
    """sqrt(mu) t less whole periods of a bound orbit, which is the right side of Kepler's equation; also its error."""
    alpha, alpha_low = elements[2, 0], elements[2, 1]
    T, T_low = multiply(elements[3, 0], elements[3, 1], t, 0.0)
    error = UNIT * abs(T)
    if alpha > 0.0:
        a, a_low = root(alpha, alpha_low)
        a, a_low = multiply(a, a_low, alpha, alpha_low)
        period, period_low = divide(TURN[0], TURN[1], a, a_low)
        many = np.rint(T / period)
        if many != 0.0:
            p, p_low = multiply(period, period_low, many, 0.0)
            T, T_low = add(T, T_low, -p, -p_low)
            error *= 1.0 + 2.0 / (elements[0, 0] * alpha)  # alpha cancels next to the parabola
    out[0], out[1] = T, T_low
    return float(error)


@njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _evaluate(parameters: Floats, starts: Floats, times: Floats, out: Floats, known: Any) -> None:
    elements, U, T, value, r = (
        np.zeros((4, 2)), np.zeros((4, 2)), np.zeros(2), np.zeros(2), np.zeros(2),
    )  # fmt: skip
    for i in range(len(starts)):
        _elements(parameters[i, 0], starts[i], elements)
        r0, sigma, alpha, s = elements[0], elements[1], elements[2], elements[3]
        speed = math.hypot(starts[i, 2], starts[i, 3])
        known[i] = _turns(starts[i])  # a radial motion ends where it reaches the centre
        for j in range(len(times)):
            off = _reduced(elements, times[j], T)
            chi, chi_low = _anomaly(r0[0], sigma[0], alpha[0], T[0]), 0.0
            known[i] &= abs(alpha[0]) * chi * chi < SERIES_ARGUMENT * 4.0**QUARTERINGS
            if not known[i]:  # nan too
                out[i, j] = np.nan
                continue
            last = 0.0
            for _ in range(2):
                _universal(alpha[0], alpha[1], chi, chi_low, U)
                _combined(r0, U[1], sigma, U[2], U[3], value)
                value[0], value[1] = add(value[0], value[1], -T[0], -T[1])
                _combined(r0, U[0], sigma, U[1], U[2], r)
                last = -value[0] / r[0]
                chi, chi_low = add(chi, chi_low, last, 0.0)
            _universal(alpha[0], alpha[1], chi, chi_low, U)
            _combined(r0, U[0], sigma, U[1], U[2], r)
            terms = r0[0] * abs(U[1, 0]) + abs(sigma[0] * U[2, 0]) + abs(U[3, 0])
            off = (off + UNIT * terms) / r[0] + abs(last) * 2.0**-50
            bend = abs(sigma[0] * U[0, 0] + (1 - alpha[0] * r0[0]) * U[1, 0])
            size = r0[0] * abs(U[0, 0]) + abs(sigma[0] * U[1, 0]) + abs(U[2, 0])
            off = off * (bend / r[0] + 1 / math.sqrt(r[0]) + speed / s[0]) + UNIT * size / r[0]
            known[i] &= off < CERTAIN
            _place(elements, U, T, r, starts[i], out[i, j])


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _place(elements: Floats, U: Floats, T: Floats, r: Floats, start: Floats, out: Floats) -> None:
    """The state by Lagrange's coefficients f, g and their rates."""
    r0, s = elements[0], elements[3]
    a, a_low = divide(U[2, 0], U[2, 1], r0[0], r0[1])
    f, f_low = add(1.0, 0.0, -a, -a_low)
    a, a_low = add(T[0], T[1], -U[3, 0], -U[3, 1])
    g, g_low = divide(a, a_low, s[0], s[1])
    a, a_low = multiply(s[0], s[1], U[1, 0], U[1, 1])
    b, b_low = multiply(r0[0], r0[1], r[0], r[1])
    df, df_low = divide(-a, -a_low, b, b_low)
    a, a_low = divide(U[2, 0], U[2, 1], r[0], r[1])
    dg, dg_low = add(1.0, 0.0, -a, -a_low)
    for d in range(2):
        a, a_low = multiply(f, f_low, start[d], 0.0)
        b, b_low = multiply(g, g_low, start[2 + d], 0.0)
        a, a_low = add(a, a_low, b, b_low)
        out[d] = a + a_low
        a, a_low = multiply(df, df_low, start[d], 0.0)
        b, b_low = multiply(dg, dg_low, start[2 + d], 0.0)
        a, a_low = add(a, a_low, b, b_low)
        out[2 + d] = a + a_low
