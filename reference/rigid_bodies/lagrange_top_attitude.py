"""The heavy symmetric top as a rigid body: rates in the body and rotation matrix, without singular angles.

Only the third row of R(0), the vertical in the body, enters the motion; its length is a factor of the weight, so that
R(0) need not be orthogonal: R(t) = R(0) Q(t). Every special motion (regular precession, passage through the vertical or
the lowest point, asymptotic approach to the vertical) is recognised on exact numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.rigid_bodies.euler_top import EulerTop
from gnomon.reference.rigid_bodies.nutation import Start, TiltState, nutates, nutation

Quaternion = tuple[Any, Any, Any, Any]
"""(w, x, y, z)."""


@dataclass(frozen=True)
class TopAttitude(BallMotion):
    """State (w1, w2, w3, R11..R33), w in the body, R' = R hat(w):

    I1 w1' = (I1 - I3) w2 w3 + W R32, I1 w2' = (I3 - I1) w3 w1 - W R31, w3' = 0.
    """

    I1: Fraction
    I3: Fraction
    W: Fraction
    rates: tuple[Fraction, Fraction, Fraction]
    attitude: tuple[Fraction, ...]

    def nutation_period(self, digits: int = 15) -> Any | None:
        """Period of the tilt (s); None where it is constant or approaches the vertical asymptotically."""
        if self._square == 0 or not nutates(self._top()):
            return None
        return self._derived(digits, lambda: _nutation(self, flint.ctx.prec).period())

    def precession_per_nutation(self, digits: int = 15) -> Any | None:
        """Change of the azimuth over a nutation period (rad); None without such a period."""
        if self._square == 0 or not nutates(self._top()):
            return None

        def gained() -> Any:
            plus, minus = _nutation(self, flint.ctx.prec).advance()
            return (plus + minus) / 2

        return self._derived(digits, gained)

    @property
    def _vertical(self) -> tuple[Fraction, Fraction, Fraction]:
        x, y, z = self.attitude[6:]
        return x, y, z

    @property
    def _square(self) -> Fraction:
        return sum((x * x for x in self._vertical), Fraction(0))

    def _top(self) -> Start:
        (w1, w2, w3), (x, y, z) = self.rates, self._vertical
        spin, along = self.I3 * w3, self.I1 * (w1 * x + w2 * y) + self.I3 * w3 * z  # a; b times the vertical's length
        energy = self.I1 * (w1 * w1 + w2 * w2) / 2 + self.W * z
        rate = x * w2 - y * w1
        level = along**2 == spin**2 * self._square
        up, down = level and along * spin >= 0, level and along * spin <= 0
        on_pole = x == 0 and y == 0
        still = rate == 0 and not on_pole
        length = ball(self._square).sqrt()
        a = ball(spin)
        pole = 0 if not on_pole else 1 if z > 0 else -1
        return Start(
            ball(self.I1),
            ball(self.W) * length,
            a,
            a if up else -a if down else ball(along) / length,
            ball(energy),
            flint.arb(pole) if pole else ball(z) / length,
            ball(rate) / length,
            up=up,
            down=down,
            still=still,
            pole=pole,
            steady=(w1 == 0 and w2 == 0) if on_pole else still and self._bend == 0,
            homoclinic=up and pole <= 0 and energy > 0 and energy**2 == self.W**2 * self._square,
        )

    @property
    def _bend(self) -> Fraction:
        """The second derivative of R33."""
        (w1, w2, w3), (x, y, z) = self.rates, self._vertical
        excess = (self.I1 - self.I3) / self.I1 * w3
        w1_rate, w2_rate = excess * w2 + self.W / self.I1 * y, -excess * w1 - self.W / self.I1 * x
        x_rate, y_rate = y * w3 - z * w2, z * w1 - x * w3
        return x_rate * w2 + x * w2_rate - y_rate * w1 - y * w1_rate

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        if self._square == 0:
            free = EulerTop((self.I1, self.I1, self.I3), self.rates, self.attitude)
            return [mp.mpf(x) for x in free.state(t, mp.dps + 2)]
        return super()._state(mp, t)

    def _balls(self, t: Fraction) -> Sequence[Any]:
        start = [ball(x) for x in (*self.rates, *self.attitude)]
        if t == 0:
            return start
        motion = _nutation(self, flint.ctx.prec)
        top = motion.start
        spin = self._first_spin()
        tilt = motion.at(ball(t))
        drift = top.a * ball((1 / self.I3 - 1 / self.I1) * t)
        both, apart = spin + drift + tilt.plus, tilt.minus - spin - drift
        turn = matrix(
            product(conjugate(_quaternion(self._first_tilt(top), spin, -spin)), _quaternion(tilt, both, apart))
        )
        across = _across(top, tilt)
        sine, cosine = ((both - apart) / 2).sin_cos()
        rates = (tilt.rate * cosine + across * sine, across * cosine - tilt.rate * sine, start[2])
        rows = [start[3 + 3 * i : 6 + 3 * i] for i in range(3)]
        return [*rates, *(sum(row[k] * turn[k][j] for k in range(3)) for row in rows for j in range(3))]

    def _first_spin(self) -> Any:
        """psi at the start, where phi = 0."""
        (w1, w2, _), (x, y, _z) = self.rates, self._vertical
        if x != 0 or y != 0:
            return flint.arb.atan2(ball(x), ball(y))
        return flint.arb.atan2(ball(-w2), ball(w1)) if w1 or w2 else flint.arb(0)

    def _first_tilt(self, top: Start) -> TiltState:
        zero = flint.arb(0)
        if top.pole:
            return TiltState(flint.arb(int(top.pole > 0)), flint.arb(int(top.pole < 0)), zero, zero, zero)
        return TiltState(((1 + top.u) / 2).sqrt(), ((1 - top.u) / 2).sqrt(), zero, zero, zero)


@lru_cache(maxsize=32)
def _nutation(motion: TopAttitude, bits: int) -> Any:
    """A Steady, Homoclinic or Nutating, cached by precision; `bits` is the current one."""
    return nutation(motion._top())


def _across(top: Start, tilt: TiltState) -> Any:
    """phi' sin(theta)."""
    total = flint.arb(0)
    if not top.down:
        total += (top.b + top.a) * tilt.s / tilt.c
    if not top.up:
        total += (top.b - top.a) * tilt.c / tilt.s
    return total / (2 * top.moment)


def _quaternion(tilt: TiltState, both: Any, apart: Any) -> Quaternion:
    """Rz(phi) Rx(theta) Rz(psi), from phi + psi and phi - psi."""
    sine, cosine = (both / 2).sin_cos()
    other_sine, other_cosine = (apart / 2).sin_cos()
    return tilt.c * cosine, tilt.s * other_cosine, tilt.s * other_sine, tilt.c * sine


def conjugate(q: Quaternion) -> Quaternion:
    return q[0], -q[1], -q[2], -q[3]


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def matrix(q: Quaternion) -> list[list[Any]]:
    """The rotation matrix of a unit quaternion."""
    w, x, y, z = q
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
