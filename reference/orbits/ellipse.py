"""A million states on one ellipse in about a second: Kepler's equation in double-double, at any eccentricity.

The eccentric anomaly is found in doubles (Mikkola's start, Celest. Mech. 40, 1987; then Halley) and corrected once in
double-double. 1 - e is a separate constant, so that a close pericentre and a fall from rest lose no digits. Every value
has an error bound; where this leaves the nearest double uncertain, the value is computed in high precision.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache
from typing import Any

import mpmath
import numpy as np
from gnomon.reference.numerics.doubledouble import add, multiply, two_product, two_sum
from gnomon.reference.numerics.doubledouble_functions import divide
from gnomon.reference.numerics.precision import exact, working
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
GRID = 32
"""Sines are tabulated at multiples of 1/32."""
UNIT = 2.0**-98
"""Bound of the relative error of a few operations, each with 2**-104."""


def sample(motion: Any, times: Floats) -> Floats:
    """The nearest doubles to the states of a bound Kepler motion, shape (len(times), 4)."""
    times = np.ascontiguousarray(times, dtype=np.float64)
    values = np.empty((len(times), 4))
    proved = np.empty(len(times), dtype=np.bool_)
    _evaluate(times, _constants(motion), _sines(), _factorials(), values, proved)
    doubtful = np.flatnonzero(~proved)
    if len(doubtful):
        values[doubtful] = motion.sample_each(times[doubtful])
    return values


def _constants(motion: Any) -> Floats:
    """Rows of three doubles each: T, time of pericentre, n, 1 - e, e, then a P and b Q by component."""
    with working(80) as mp:
        r0, alpha, s0, _root = motion._elements(mp)
        e = motion._eccentricity(mp)
        period = motion._period(mp)
        before = mp.atan2(s0 * mp.sqrt(alpha), 1 - alpha * r0)
        pericentre = (s0 * mp.sqrt(alpha) - before) * period / (2 * mp.pi)
        along, across = motion._eccentricity_parts(mp)
        x, y = mp.mpf(motion.x) / r0, mp.mpf(motion.y) / r0
        px, py = (along * x + across * y, along * y - across * x) if e else (x, y)
        size = mp.hypot(px, py)
        px, py = px / size / alpha, py / size / alpha
        # b / a = sqrt(1 - e^2) = |h| sqrt(alpha / mu); the sign of h turns Q.
        ratio = mp.mpf(motion.angular_momentum) * mp.sqrt(alpha / mp.mpf(motion.mu))
        small = alpha * motion._pericentre(mp)
        numbers = [period, pericentre, 2 * mp.pi / period, small, e, px, py, -py * ratio, px * ratio]
        return np.array([_parts(number) for number in numbers])


def _parts(value: Any) -> list[float]:
    rest, parts = exact(value), []
    for _ in range(3):
        parts.append(float(rest))
        rest -= Fraction(parts[-1])
    return parts


@cache
def _sines() -> Floats:
    """sin and cos of k/32, high and low part, k = 0..51."""
    rows = []
    with mpmath.workdps(50):
        for k in range(math.ceil(math.pi / 2 * GRID) + 1):
            x = mpmath.mpf(k) / GRID
            rows.append([*_parts(mpmath.sin(x))[:2], *_parts(mpmath.cos(x))[:2]])
    return np.array(rows)


@cache
def _factorials() -> Floats:
    """1/k!, high and low part."""
    with mpmath.workdps(50):
        return np.array([_parts(1 / mpmath.factorial(k))[:2] for k in range(17)])


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _half_sines(h: float, sines: Floats, inverse: Floats) -> tuple[float, float, float, float]:
    """sin and cos of the double h, |h| <= pi/2, as double-doubles."""
    k = int(abs(h) * GRID + 0.5)
    sign = -1.0 if h < 0 else 1.0
    d = abs(h) - k / GRID  # exact: both are multiples of the last bit of h, and close
    q, q_low = two_product(d, d)
    s, s_low = inverse[15, 0], inverse[15, 1]
    c, c_low = inverse[16, 0], inverse[16, 1]
    for j in range(13, 0, -2):
        s, s_low = multiply(s, s_low, -q, -q_low)
        s, s_low = add(s, s_low, inverse[j, 0], inverse[j, 1])
    for j in range(14, -1, -2):
        c, c_low = multiply(c, c_low, -q, -q_low)
        c, c_low = add(c, c_low, inverse[j, 0], inverse[j, 1])
    s, s_low = multiply(s, s_low, d, 0.0)
    if k == 0:
        return sign * s, sign * s_low, c, c_low
    S, S_low, C, C_low = sines[k, 0], sines[k, 1], sines[k, 2], sines[k, 3]
    a, a_low = multiply(S, S_low, c, c_low)
    b, b_low = multiply(C, C_low, s, s_low)
    sine, sine_low = add(a, a_low, b, b_low)
    a, a_low = multiply(C, C_low, c, c_low)
    b, b_low = multiply(S, S_low, s, s_low)
    cosine, cosine_low = add(a, a_low, -b, -b_low)
    return sign * sine, sign * sine_low, cosine, cosine_low


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _anomaly(M: float, small: float, e: float) -> float:
    """E with E - e sin E = M in doubles, with a relative error of some ulps for small M too; |M| <= pi."""
    if M == 0.0:
        return 0.0
    alpha, beta = small / (4 * e + 0.5), abs(M) / (8 * e + 1)
    z = np.cbrt(beta + math.sqrt(beta * beta + alpha * alpha * alpha))
    s = z - alpha / z
    s -= 0.078 * s**5 / (1 + e)
    E = abs(M) + e * (3 * s - 4 * s**3)
    for _ in range(12):
        sine = math.sin(E)
        if E < 1.0:  # E - sin E without cancellation
            q, tail = E * E, 1.0
            for factor in (342, 272, 210, 156, 110, 72, 42, 20):
                tail = 1 - tail * q / factor
            value = small * E + e * tail * q * E / 6 - abs(M)
        else:
            value = E - e * sine - abs(M)
        half = math.sin(E / 2)
        slope = small + 2 * e * half * half
        step = value / (slope - 0.5 * value * e * sine / slope)
        E -= step
        if abs(step) < 1e-14 * E:
            break
    return float(E) if M > 0 else -float(E)


@njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _evaluate(times: Floats, constants: Floats, sines: Floats, inverse: Floats, values: Floats, proved: Any) -> None:
    period, centre = constants[0], constants[1]
    n, n_low, small, small_low, e, e_low = (
        constants[2, 0], constants[2, 1], constants[3, 0], constants[3, 1], constants[4, 0], constants[4, 1],
    )  # fmt: skip
    for i in range(len(times)):
        t = times[i]
        k = np.rint((t - centre[0]) / period[0])
        # t - k T - (time of pericentre): the leading parts cancel exactly, the rest follows in size.
        p, p_low = two_product(k, period[0])
        tau, tau_low = two_sum(t, -p)
        tau, tau_low = add(tau, tau_low, -centre[0], 0.0)
        tau, tau_low = add(tau, tau_low, -p_low, 0.0)
        p, p_low = two_product(k, period[1])
        tau, tau_low = add(tau, tau_low, -p, -p_low)
        tau, tau_low = add(tau, tau_low, -centre[1], -centre[2])
        tau, tau_low = add(tau, tau_low, -k * period[2], 0.0)
        M, M_low = multiply(tau, tau_low, n, n_low)
        E = _anomaly(M, small, e)
        S, S_low, C, C_low = _half_sines(E / 2, sines, inverse)
        # The residual E - e sin E - M in double-double, sin E = 2 S C.
        f, f_low = multiply(S, S_low, C, C_low)
        f, f_low = multiply(2 * f, 2 * f_low, e, e_low)
        f, f_low = add(E, 0.0, -f, -f_low)
        f, f_low = add(f, f_low, -M, -M_low)
        slope = small + 2 * e * S * S
        bend = e * S * C
        half = -0.5 * f / (slope - f * bend / slope)
        # The correction is a double, good to some ulps of itself and to its cube.
        off_E = UNIT * (abs(E) + abs(M) + abs(n * t) * 2.0**-50) / slope
        off_E += 2 * abs(half) * (2.0**-48 + 8 * half * half / slope)
        # Turned by half = (correction of E)/2: S + half C - half^2 S / 2.
        p, p_low = two_product(half, C)
        q = half * C_low - 0.5 * half * half * S
        s, s_low = add(S, S_low, p, p_low + q)
        p, p_low = two_product(-half, S)
        q = -half * S_low - 0.5 * half * half * C
        c, c_low = add(C, C_low, p, p_low + q)
        ss, ss_low = multiply(s, s_low, s, s_low)
        sine, sine_low = multiply(2 * s, 2 * s_low, c, c_low)
        cosine, cosine_low = add(1.0, 0.0, -2 * ss, -2 * ss_low)
        X, X_low = add(small, small_low, -2 * ss, -2 * ss_low)
        r, r_low = multiply(2 * ss, 2 * ss_low, e, e_low)
        r, r_low = add(r, r_low, small, small_low)
        rate, rate_low = divide(n, n_low, r, r_low)
        good = True
        for d in range(2):
            a, a_low, b, b_low = constants[5 + d, 0], constants[5 + d, 1], constants[7 + d, 0], constants[7 + d, 1]
            u, u_low = multiply(a, a_low, X, X_low)
            v, v_low = multiply(b, b_low, sine, sine_low)
            x, x_low = add(u, u_low, v, v_low)
            slide = abs(a * sine) + abs(b * cosine)
            off = UNIT * (abs(u) + abs(v)) + slide * off_E
            good &= x + (x_low + off) == x + (x_low - off) or (x == 0.0 and off == 0.0)
            values[i, d] = x + x_low
            u, u_low = multiply(a, a_low, -sine, -sine_low)
            v, v_low = multiply(b, b_low, cosine, cosine_low)
            w, w_low = add(u, u_low, v, v_low)
            off = UNIT * (abs(u) + abs(v)) + (abs(a * cosine) + abs(b * sine)) * off_E
            off = rate * (off + (abs(u) + abs(v)) * (UNIT + abs(e * sine) * off_E / r))
            w, w_low = multiply(w, w_low, rate, rate_low)
            good &= w + (w_low + off) == w + (w_low - off) or (w == 0.0 and off == 0.0)
            values[i, 2 + d] = w + w_low
        proved[i] = good and math.isfinite(values[i, 0] + values[i, 2])
