"""Exact states of many simple pendulums at once, in double-double: some microseconds each.

Formulas as in `pendulum_simple`, with two differences. sn, cn, dn of w t come from the descending Landen
transformation (Bulirsch, Numerische Mathematik 7, 1965), without inverse functions. They are added to the functions of the
start, which are algebraic in the initial state, by the addition theorems (DLMF 22.8), whose denominator
1 - m s^2 s0^2 = c^2 + s^2 d0^2 does not cancel. So no incomplete integral is needed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gnomon.reference.numerics.doubledouble import add, multiply
from gnomon.reference.numerics.doubledouble_functions import TURN, angle, divide, root, sine_cosine
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
UNIT = 2.0**-94
"""Bound of the relative error of 1 - m times 1 - m, and of the elliptic argument: some hundred operations."""
CERTAIN = 2.0**-58
"""Largest absolute error of the amplitude. The states are then within 0.51 ulp, or 2**-58 of their size next to zeros."""
LEVELS = 20
"""Most steps of the arithmetic-geometric mean; 1 - m = 1e-30 takes 12."""


def states(parameters: Floats, starts: Floats, times: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """States (n, k, 2) of pendulums with g, L (n, 2) from theta, omega (n, 2) at the times (k,) after the start.

    Also which of them are known (n,): next to the separatrix and at rest a motion needs the formulas of any precision.
    """
    out = np.empty((len(starts), len(times), 2))
    known = np.empty(len(starts), dtype=np.bool_)
    _evaluate(parameters, starts, times, np.empty((LEVELS, 4)), out, known)
    return out, known


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _means(mc: float, mc_low: float, levels: Floats) -> tuple[int, float, float]:
    """The arithmetic-geometric mean from (1, sqrt(mc)): its steps, and its limit. `levels`: the pairs, two parts each."""
    a, a_low = 1.0, 0.0
    b, b_low = root(mc, mc_low)
    for n in range(len(levels)):
        levels[n, 0], levels[n, 1], levels[n, 2], levels[n, 3] = a, a_low, b, b_low
        c, c_low = add(a, a_low, b, b_low)
        if abs(a - b) <= 2.0**-54 * a:
            return n, c / 2, c_low / 2
        p, p_low = multiply(a, a_low, b, b_low)
        a, a_low = c / 2, c_low / 2
        b, b_low = root(p, p_low)
    return -1, a, a_low


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _jacobi(
    u: float, u_low: float, last: int, mean: float, mean_low: float, levels: Floats
) -> tuple[float, float, float, float, float, float]:
    """sn, cn, dn of u, two parts each."""
    x, x_low = multiply(u, u_low, mean, mean_low)
    s, s_low, c, c_low = sine_cosine(x, x_low)
    if s == 0.0:
        return 0.0, 0.0, c, c_low, 1.0, 0.0
    a, a_low = divide(c, c_low, s, s_low)
    c, c_low = multiply(mean, mean_low, a, a_low)
    d, d_low = 1.0, 0.0
    for n in range(last, -1, -1):
        b, b_low = levels[n, 0], levels[n, 1]
        a, a_low = multiply(a, a_low, c, c_low)
        c, c_low = multiply(c, c_low, d, d_low)
        e, e_low = add(levels[n, 2], levels[n, 3], a, a_low)
        f, f_low = add(b, b_low, a, a_low)
        d, d_low = divide(e, e_low, f, f_low)
        a, a_low = divide(c, c_low, b, b_low)
    e, e_low = multiply(c, c_low, c, c_low)
    e, e_low = add(e, e_low, 1.0, 0.0)
    e, e_low = root(e, e_low)
    sign = 1.0 if s > 0 else -1.0
    s, s_low = divide(sign, 0.0, e, e_low)
    c, c_low = multiply(c, c_low, s, s_low)
    return s, s_low, c, c_low, d, d_low


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _added(
    s: float, s_low: float, c: float, c_low: float, d: float, d_low: float, start: Floats, m: float, m_low: float
) -> tuple[float, float, float, float, float, float]:
    """sn, cn, dn of a sum from sn, cn, dn of one term and of the other (`start`), two parts each."""
    S, S_low, C, C_low, D, D_low = start[0], start[1], start[2], start[3], start[4], start[5]
    x, x_low = multiply(s, s_low, D, D_low)
    x, x_low = multiply(x, x_low, x, x_low)
    y, y_low = multiply(c, c_low, c, c_low)
    below, below_low = add(x, x_low, y, y_low)
    cc, cc_low = multiply(c, c_low, C, C_low)
    dd, dd_low = multiply(d, d_low, D, D_low)
    ss, ss_low = multiply(s, s_low, S, S_low)
    x, x_low = multiply(s, s_low, C, C_low)
    x, x_low = multiply(x, x_low, D, D_low)
    y, y_low = multiply(S, S_low, c, c_low)
    y, y_low = multiply(y, y_low, d, d_low)
    x, x_low = add(x, x_low, y, y_low)
    sn, sn_low = divide(x, x_low, below, below_low)
    x, x_low = multiply(ss, ss_low, dd, dd_low)
    x, x_low = add(cc, cc_low, -x, -x_low)
    cn, cn_low = divide(x, x_low, below, below_low)
    x, x_low = multiply(ss, ss_low, cc, cc_low)
    x, x_low = multiply(x, x_low, m, m_low)
    x, x_low = add(dd, dd_low, -x, -x_low)
    dn, dn_low = divide(x, x_low, below, below_low)
    return sn, sn_low, cn, cn_low, dn, dn_low


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _unwrapped(phase: float, phase_low: float, theta: float, sign: float, turns: float) -> float:
    """The angle of a turning pendulum. `phase`: the angle, up to turns; `theta`: where it started; `sign`: its direction;
    `turns`: the turns since, of which the fraction is a time and not an angle."""
    whole = math.floor(turns)
    advance = sign * (phase - theta)
    round_ = math.floor(advance / TURN[0])
    advance -= round_ * TURN[0]
    if advance > 6.0 and turns - whole < 0.25 and TURN[0] - advance < 1e-9:
        round_ += 1.0  # rounding has made it a little less than no advance
    if advance < 1e-9 and turns - whole > 0.75:
        round_ -= 1.0
    many = sign * (whole - round_)
    p, p_low = multiply(TURN[0], TURN[1], many, 0.0)
    high, low = add(phase, phase_low, p, p_low)
    return float(high + low)


@njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _evaluate(parameters: Floats, starts: Floats, times: Floats, levels: Floats, out: Floats, known: Any) -> None:
    start = np.empty(6)
    for i in range(len(starts)):
        theta, omega = starts[i, 0], starts[i, 1]
        x, x_low = divide(parameters[i, 0], 0.0, parameters[i, 1], 0.0)
        w, w_low = root(x, x_low)
        s, s_low, c, c_low = sine_cosine(theta / 2, 0.0)
        h, h_low = divide(omega, 0.0, 2 * w, 2 * w_low)
        x, x_low = multiply(h, h_low, h, h_low)
        y, y_low = multiply(s, s_low, s, s_low)
        m, m_low = add(x, x_low, y, y_low)
        y, y_low = multiply(c, c_low, c, c_low)
        mc, mc_low = add(y, y_low, -x, -x_low)
        k, k_low = root(m, m_low)
        turning = mc < 0.0
        sign = -1.0 if turning and omega < 0 else 1.0
        rate, rate_low = w, w_low
        if turning:  # modulus 1/k, argument k w t, and the amplitude is theta/2
            rate, rate_low = multiply(k, k_low, w, w_low)
            start[0], start[1], start[2], start[3] = s, s_low, c, c_low
            start[4], start[5] = divide(abs(h), sign * h_low, k, k_low)
            mc, mc_low = divide(-mc, -mc_low, m, m_low)
            m, m_low = divide(1.0, 0.0, m, m_low)
        else:  # the sine of the amplitude is sin(theta/2) / k
            half_turns = np.rint(theta / TURN[0])
            flip = -1.0 if half_turns % 2 != 0 else 1.0  # theta/2 is shifted by a half turn for each turn of theta
            start[0], start[1] = divide(flip * s, flip * s_low, k, k_low)
            start[2], start[3] = divide(h, h_low, k, k_low)
            start[4], start[5] = flip * c, flip * c_low
        last, mean, mean_low = _means(mc, mc_low, levels)
        longest = abs(rate) * np.max(np.abs(times)) if len(times) else 0.0
        known[i] = last >= 0 and m > 0.0 and UNIT * (1.0 + longest) < CERTAIN * mc
        for j in range(len(times)):
            u, u_low = multiply(rate, rate_low, sign * times[j], 0.0)
            s, s_low, c, c_low, d, d_low = _jacobi(u, u_low, last, mean, mean_low, levels)
            s, s_low, c, c_low, d, d_low = _added(s, s_low, c, c_low, d, d_low, start, m, m_low)
            if turning:
                x, x_low = angle(s, s_low, c, c_low)
                turns = abs(u) * mean / (TURN[0] / 2)
                out[i, j, 0] = _unwrapped(2 * x, 2 * x_low, theta, sign, turns)
                x, x_low = multiply(2 * rate, 2 * rate_low, d, d_low)
                out[i, j, 1] = sign * (x + x_low)
            else:
                s, s_low = multiply(s, s_low, k, k_low)
                x, x_low = angle(s, s_low, d, d_low)
                y, y_low = multiply(TURN[0], TURN[1], half_turns, 0.0)
                x, x_low = add(2 * x, 2 * x_low, y, y_low)
                out[i, j, 0] = x + x_low
                x, x_low = multiply(2 * rate, 2 * rate_low, c, c_low)
                x, x_low = multiply(x, x_low, k, k_low)
                out[i, j, 1] = x + x_low
            known[i] &= math.isfinite(out[i, j, 0] + out[i, j, 1])
