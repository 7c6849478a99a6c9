"""Enclose elliptic motions in balls that contain the state, by formulas that the motions themselves do not use.

Jacobi's functions are quotients of theta functions, the initial state enters by addition theorems, and the angles of
precession and spin are rigorous quadratures of their rates. `gnomon certify` compares `Motion.state` with these balls.
Source of balls: Johansson, Numerical integration in arbitrary-precision ball arithmetic, ICMS 2018.
"""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import flint
from gnomon.harness.certification.enclosed_tops import Balls, hat, heavy_top, spherical_pendulum, top_attitude
from gnomon.reference.numerics.balls import MOST_BITS, ball, precision
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.theta import Jacobi, Values, accumulated, reals, turns
from gnomon.reference.numerics.vectors import cross
from gnomon.reference.pendulums.pendulum_simple import Pendulum
from gnomon.reference.rigid_bodies.euler_top import EulerTop
from gnomon.reference.rigid_bodies.lagrange_top import LagrangeTop, SphericalPendulum
from gnomon.reference.rigid_bodies.lagrange_top_attitude import TopAttitude

SPARE = 5
"""Digits of a quadrature beyond the digits required of the state."""


def enclosure(motion: Motion, t: Fraction, digits: int) -> tuple[tuple[Fraction, Fraction], ...] | None:
    """(midpoint, radius) of each component of the state at t, proved to `digits` digits of the largest component.

    None if this module has no enclosure for the motion, or for a special case of it.
    """
    enclose = ENCLOSED.get(type(motion))
    if enclose is None:
        return None
    bits = int(digits * 3.33) + 60
    while bits <= MOST_BITS:
        with precision(bits):
            state = enclose(motion, t, digits + SPARE)
            if state is None:
                return None
            size = max((abs(x.mid()) for x in state), default=flint.arb(0))
            if all(x.is_finite() and bool(x.rad() <= size * flint.arb(10) ** -digits) for x in state):
                return tuple((_exact(x.mid()), _exact(x.rad())) for x in state)
        bits *= 2
    raise ArithmeticError(f"{MOST_BITS} bits do not enclose {motion} at t = {float(t):g}")


def pendulum(motion: Pendulum, t: Fraction, digits: int) -> Balls:
    """(sin, cos)(theta/2) = (k sn, dn) and theta' = 2 w k cn; in rotation, with k > 1, by the reciprocal modulus."""
    theta0, omega0, time = ball(motion.theta0), ball(motion.omega0), ball(t)
    w = ball(motion.g / motion.length).sqrt()
    if motion.regime == motion.REST:
        return [theta0, omega0]
    rate = omega0 / (2 * w)
    if motion.regime == motion.SEPARATRIX:
        side = 1 if motion.omega0 > 0 else -1
        return [side * 4 * (w * time / 2).tanh().atan(), 2 * side * w * (w * time).sech()]
    base = 2 * flint.arb.pi() * turns(theta0 / (2 * flint.arb.pi()) + ball(Fraction(1, 2)))
    s, c = ((theta0 - base) / 2).sin_cos()
    square = s * s + rate * rate
    k, rest = square.sqrt(), c * c - rate * rate
    if motion.regime == motion.LIBRATION:
        functions = Jacobi(square, rest)
        here = reals(functions.shifted(Values(s / k, rate / k, c), w * time))
        return [base + 2 * flint.arb.atan2(k * here.sn, here.dn), 2 * w * k * here.cn]
    side = 1 if motion.omega0 > 0 else -1
    functions = Jacobi(1 / square, -rest / square)
    here = reals(functions.shifted(Values(s, c, side * rate / k), side * k * w * time))
    # theta differs from its mean growth by less than a turn, and half of theta is known up to whole turns.
    half = 2 * flint.arb.atan2(here.sn, here.cn)
    mean = theta0 - base + side * flint.arb.pi() * k * w * time / functions.quarter
    double = 4 * flint.arb.pi()
    return [base + half + double * turns((mean - half) / double + ball(Fraction(1, 2))), 2 * w * side * k * here.dn]


def euler_top(motion: EulerTop, t: Fraction, digits: int) -> Balls:
    """w by theta functions; R by quadrature of the rotation about L, or by exponentials of matrices."""
    rates, attitude = [ball(x) for x in motion.rates], flint.arb_mat(3, 3, [ball(x) for x in motion.attitude])
    time = ball(t)
    if motion.kind == "steady":
        turn = hat([x * time for x in rates]).exp()
    elif motion.kind == "symmetric":
        rates, turn = _symmetric(motion, time)
    else:
        rates, turn = _asymmetric(motion, time, digits)
    return [*rates, *(attitude * turn).entries()]


def _symmetric(motion: EulerTop, time: Any) -> tuple[Balls, Any]:
    """w rotates about the axis of symmetry and the body about L: two exponentials."""
    k = next(k for k in range(3) if motion.moments[k - 1] == motion.moments[k - 2])
    across, along = motion.moments[k - 1], motion.moments[k]
    spin = [ball((along - across) / across * motion.rates[k]) * time if i == k else flint.arb(0) for i in range(3)]
    about = [ball(i * w / across) * time for i, w in zip(motion.moments, motion.rates, strict=True)]
    turned = hat(spin).exp()
    start = flint.arb_mat(3, 1, [ball(x) for x in motion.rates])
    return (turned * start).entries(), hat(about).exp() * turned.transpose()


def _asymmetric(motion: EulerTop, time: Any, digits: int) -> tuple[Balls, Any]:
    """(A cn, B sn, C dn) about the axis nearest to L; the angle about L is the integral of its rate."""
    energy, square = motion.twice_energy, motion.momentum_squared
    order = sorted(range(3), key=lambda k: motion.moments[k])
    if square < energy * motion.moments[order[1]]:
        order.reverse()
    i1, i2, i3 = (motion.moments[k] for k in order)
    start = [ball(motion.rates[k]) for k in order]
    # An odd permutation of the axes is a mirror image: sn has the opposite sign.
    handed = 1 if tuple(order) in ((0, 1, 2), (1, 2, 0), (2, 0, 1)) else -1
    side = 1 if motion.rates[order[2]] > 0 else -1
    # On the separatrix cn has a constant sign; otherwise the sign is part of the phase.
    first = -1 if motion.kind == "separatrix" and start[0] < 0 else 1
    below, above = energy * i3 - square, square - energy * i1
    A, C = first * ball(below / (i1 * (i3 - i1))).sqrt(), side * ball(above / (i3 * (i3 - i1))).sqrt()
    B = ball(below / (i2 * (i3 - i2))).sqrt()
    p = side * first * handed * (1 if i3 > i1 else -1) * ball((i3 - i2) * above / (i1 * i2 * i3)).sqrt()
    m = (i2 - i1) * below / ((i3 - i2) * above)
    functions = Jacobi(ball(m), ball(1 - m), limit=motion.kind == "separatrix")
    begin = Values(start[1] / B, start[0] / A, start[2] / C)
    first_phase, momentum = functions.argument(begin), ball(square).sqrt()

    def about(s: Any) -> Any:
        sn, cn, _ = functions.at(first_phase + p * s)
        x, y = A * cn, B * sn
        return momentum * (ball(i1) * x * x + ball(i2) * y * y) / ((ball(i1) * x) ** 2 + (ball(i2) * y) ** 2)

    period = None if functions.limit else 2 * functions.quarter / abs(p)
    angle = accumulated(about, time, period, digits)
    sn, cn, dn = reals(functions.shifted(begin, p * time))
    here = A * cn, B * sn, C * dn
    own = [here[order.index(k)] for k in range(3)]
    before, after = (
        _frame([ball(i) * x for i, x in zip(motion.moments, w, strict=True)], order[2])
        for w in ([ball(x) for x in motion.rates], own)
    )
    s, c = angle.sin_cos()
    turn = flint.arb_mat(3, 3, [c, -s, 0, s, c, 0, 0, 0, 1])
    return own, before.transpose() * turn * after


def _frame(momentum: Balls, axis: int) -> Any:
    """A triad as rows: a unit vector perpendicular to L and to a body axis, the third one, the unit vector along L."""
    size = sum(x * x for x in momentum).sqrt()
    unit = [x / size for x in momentum]
    i, j = (axis + 1) % 3, (axis + 2) % 3
    across = (unit[i] * unit[i] + unit[j] * unit[j]).sqrt()
    node = [flint.arb(0)] * 3
    node[i], node[j] = unit[j] / across, -unit[i] / across
    return flint.arb_mat([node, list(cross(unit, node)), unit])


def _exact(x: Any) -> Fraction:
    mantissa, exponent = x.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


ENCLOSED: dict[type[Motion], Callable[[Any, Fraction, int], Balls | None]] = {
    Pendulum: pendulum,
    EulerTop: euler_top,
    LagrangeTop: heavy_top,
    TopAttitude: top_attitude,
    SphericalPendulum: spherical_pendulum,
}
