"""Enclose tops and the spherical pendulum in balls: tilt by theta functions, precession and spin by quadrature."""

from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.theta import Jacobi, Values, accumulated, reals
from gnomon.reference.rigid_bodies.lagrange_top import LagrangeTop, SphericalPendulum
from gnomon.reference.rigid_bodies.lagrange_top_attitude import TopAttitude

Balls = list[Any]


def heavy_top(motion: LagrangeTop, t: Fraction, digits: int) -> Balls | None:
    """theta by theta functions, precession and spin by quadrature.

    None for upright, hanging, steady and homoclinic motions.
    """
    top = motion._top()
    if _is_special(top):
        return None
    (theta, rate), tilt = _tilt(top, ball(t), digits)
    precession, spin = _enclose_turn(top, ball(motion.I3), tilt)
    return [theta, rate, ball(motion.phi) + precession, ball(motion.psi) + spin]


def top_attitude(motion: TopAttitude, t: Fraction, digits: int) -> Balls | None:
    """The angles of the heavy top, converted to rates in the body and a product of rotation matrices."""
    top = motion._top() if motion._square else None
    if top is None or _is_special(top):
        return None
    (theta, rate), tilt = _tilt(top, ball(t), digits)
    precession, spin = _enclose_turn(top, ball(motion.I3), tilt)
    x, y, _ = motion._vertical
    psi = flint.arb.atan2(ball(x), ball(y))
    before = _euler(flint.arb(0), flint.arb.atan2((1 - top.u * top.u).sqrt(), top.u), psi)
    turn = before.transpose() * _euler(precession, theta, psi + spin)
    sine, cosine = (psi + spin).sin_cos()
    across = (top.b - top.a * theta.cos()) / (top.moment * theta.sin())
    rates = [rate * cosine + across * sine, across * cosine - rate * sine, ball(motion.rates[2])]
    return [*rates, *(flint.arb_mat(3, 3, [ball(v) for v in motion.attitude]) * turn).entries()]


def _is_special(top: Any) -> bool:
    return bool(top.up or top.down or top.steady or top.homoclinic)


def _enclose_turn(top: Any, axial: Any, tilt: Callable[[Callable[[Any, Any], Any]], Any]) -> tuple[Any, Any]:
    """The angles of precession and spin since the start."""
    a, b, moment = top.a, top.b, top.moment
    return (
        tilt(lambda above, below: (b - a + a * above) / (moment * above * below)),
        tilt(lambda above, below: a / axial - (b - a + a * above) * (1 - above) / (moment * above * below)),
    )


def _euler(phi: Any, theta: Any, psi: Any) -> Any:
    """The rotation matrix Rz(phi) Rx(theta) Rz(psi)."""
    zero = flint.arb(0)
    axes = [[zero, zero, phi], [theta, zero, zero], [zero, zero, psi]]
    first, second, third = (hat(axis).exp() for axis in axes)
    return first * second * third


def spherical_pendulum(motion: SphericalPendulum, t: Fraction, digits: int) -> Balls:
    """Like the heavy top, upside down and without spin."""
    (theta, rate), tilt = _tilt(motion._top(), ball(t), digits)
    turn = tilt(lambda above, below: ball(motion.h) / (above * below))
    return [flint.arb.pi() - theta, -rate, ball(motion.phi) + turn]


def _tilt(top: Any, time: Any, digits: int) -> tuple[tuple[Any, Any], Callable[[Callable[[Any, Any], Any]], Any]]:
    """theta, from the upward vertical, and theta'; and the integral up to `time` of any function of (1 - u, 1 + u).

    u = cos(theta) satisfies u'^2 = 2 (E - W u)(1 - u^2)/I1 - (b - a u)^2/I1^2; flint isolates the roots. Next to a
    pole, 1 - u and 1 + u are computed from the squares of cn and sn: these stay away from zero even on balls much wider
    than 1 - u or 1 + u.
    """
    i, w, a, b, energy = top.moment, top.weight, top.a, top.b, top.energy
    cubic = flint.arb_poly(
        [2 * energy / i - (b / i) ** 2, 2 * a * b / i**2 - 2 * w / i, -2 * energy / i - (a / i) ** 2, 2 * w / i]
    )
    u1, u2, u3 = _real_roots(cubic)
    functions = Jacobi((u2 - u1) / (u3 - u1), (u3 - u2) / (u3 - u1))
    p = (w * (u3 - u1) / (2 * i)).sqrt()
    begin = _begin(top, functions, (u1, u2, u3))
    phase = functions.argument(begin)

    def turned(rate: Callable[[Any, Any], Any]) -> Any:
        def at(s: Any) -> Any:
            sn, cn, _ = functions.at(phase + p * s)
            return rate(1 - u2 + (u2 - u1) * cn * cn, 1 + u1 + (u2 - u1) * sn * sn)

        return accumulated(at, time, 2 * functions.quarter / p, digits)

    sn, cn, dn = reals(functions.shifted(begin, p * time))
    above, below = 1 - u2 + (u2 - u1) * cn * cn, 1 + u1 + (u2 - u1) * sn * sn
    theta = 2 * flint.arb.atan2(above.sqrt(), below.sqrt())
    return (theta, -2 * p * (u2 - u1) * sn * cn * dn / (above * below).sqrt()), turned


def _begin(top: Any, functions: Jacobi, roots: tuple[Any, Any, Any]) -> Values:
    """sn, cn, dn at the start, from u and the sign of u'."""
    u1, u2, u3 = roots
    if top.still and bool(top.u.overlaps(u1)) and not bool(top.u.overlaps(u2)):
        return Values(flint.arb(0), flint.arb(1), flint.arb(1))
    dn = ((u3 - top.u) / (u3 - u1)).sqrt()
    if top.still:
        return Values(flint.arb(1), flint.arb(0), dn)
    side = 1 if top.rate > 0 else -1
    return Values(((top.u - u1) / (u2 - u1)).sqrt(), side * ((u2 - top.u) / (u2 - u1)).sqrt(), dn)


def _real_roots(cubic: Any) -> tuple[Any, Any, Any]:
    """The three real roots, ascending; nan if more bits are needed to separate them."""
    try:
        roots = sorted((_newton(cubic, x.real) for x in cubic.complex_roots()), key=lambda x: float(x.mid()))
    except ValueError:
        roots = []
    if len(roots) == 3 and all(bool(x < y) for x, y in pairwise(roots)):
        return roots[0], roots[1], roots[2]
    return flint.arb.nan(), flint.arb.nan(), flint.arb.nan()


def _newton(f: Any, x: Any) -> Any:
    """The root in the ball `x`, by interval Newton steps until the radius no longer halves."""
    slope = f.derivative()
    while True:
        centre = x.mid()
        closer = centre - f(centre) / slope(x)
        if not closer.is_finite() or not bool(closer.rad() < x.rad() / 2):
            return x
        x = closer


def hat(v: Balls) -> Any:
    x, y, z = v
    return flint.arb_mat(3, 3, [0, -z, y, z, 0, -x, -y, x, 0])
