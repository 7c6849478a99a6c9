"""The heavy symmetric top in Euler angles, and the spherical pendulum, a top without spin.

Balls prove the digits, also next to the vertical and next to regular precession. The formula is chosen on exact
numbers: the cosine of a rational number other than zero is transcendental (Lindemann), so that a start at a rational
angle is never exactly a relative equilibrium, nor on the homoclinic motion of the sleeping top.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.rigid_bodies.nutation import Start, nutates, nutation


class Nutation(BallMotion):
    """A motion with the tilt angle of a top; a subclass states `_top()` and `_shift(plus, minus, period)`."""

    def _top(self) -> Start:
        raise NotImplementedError

    def _shift(self, plus: Any, minus: Any, period: Any) -> Sequence[Any]:
        """The change of the state over a period of the tilt, from the changes of the two integrals."""
        raise NotImplementedError

    def nutation_period(self, digits: int = 15) -> Any | None:
        """Period of theta and theta' (s); None where they are constant."""
        if not nutates(self._top()):
            return None
        return self._derived(digits, lambda: nutation_of(self, flint.ctx.prec).period())

    def precession_per_nutation(self, digits: int = 15) -> Any | None:
        """Change of the azimuth over a nutation period (rad); None where theta is constant."""
        if not nutates(self._top()):
            return None

        def gained() -> Any:
            plus, minus = nutation_of(self, flint.ctx.prec).advance()
            return (plus + minus) / 2

        return self._derived(digits, gained)

    def heights(self, digits: int = 15) -> tuple[Any, Any] | None:
        """The smallest and the largest cos(theta), theta from the upward vertical; None where it is constant."""
        if not nutates(self._top()):
            return None
        return (
            self._derived(digits, lambda: nutation_of(self, flint.ctx.prec).roots[0]),
            self._derived(digits, lambda: nutation_of(self, flint.ctx.prec).roots[1]),
        )

    def _cycle(self, mp: Any) -> Cycle | None:
        if not nutates(self._top()):
            return None

        def gained() -> Sequence[Any]:
            motion = nutation_of(self, flint.ctx.prec)
            period = motion.period()
            plus, minus = motion.advance()
            return [period, *self._shift(plus, minus, period)]

        period, *shift = refined(mp, gained)
        return Cycle(period, shift)


@lru_cache(maxsize=32)
def nutation_of(motion: Nutation, bits: int) -> Any:
    """A Steady, Homoclinic or Nutating, cached by precision; `bits` is the current one."""
    return nutation(motion._top())


@dataclass(frozen=True)
class LagrangeTop(Nutation):
    """State (theta, theta', phi, psi), 3-1-3 Euler angles, theta from the upward vertical.

    I1, I3 > 0, W = mgl > 0, a = p_psi, b = p_phi. 0 < theta < pi, unless b = a != 0: then theta may pass through zero,
    where it changes its sign, and stays within (-pi, pi).
    """

    I1: Fraction
    I3: Fraction
    W: Fraction
    a: Fraction
    b: Fraction
    theta: Fraction
    rate: Fraction
    phi: Fraction
    psi: Fraction

    def energy(self, digits: int = 15) -> Any:
        """H - a^2/(2 I3)."""
        return self._derived(digits, lambda: self._top().energy)

    def _top(self) -> Start:
        s, u = ball(self.theta).sin_cos()
        moment, a, b = ball(self.I1), ball(self.a), ball(self.b)
        across = a * (1 - u) / (1 + u) * a if self.a == self.b else ((b - a * u) / s) ** 2
        energy = moment * ball(self.rate) ** 2 / 2 + across / (2 * moment) + ball(self.W) * u
        upright = self.theta == 0
        return Start(
            moment,
            ball(self.W),
            a,
            b,
            energy,
            u,
            -s * ball(self.rate),
            up=self.a == self.b,
            still=self.rate == 0 and not upright,
            pole=int(upright),
            steady=upright and self.rate == 0,
        )

    def _balls(self, t: Fraction) -> Sequence[Any]:
        start = [ball(x) for x in (self.theta, self.rate, self.phi, self.psi)]
        if t == 0:
            return start
        tilt = nutation_of(self, flint.ctx.prec).at(ball(t))
        side = -1 if self.theta < 0 or (self.theta == 0 and self.rate < 0) else 1
        theta = side * 2 * flint.arb.atan2(tilt.s, tilt.c)
        drift = ball(self.a * (1 / self.I3 - 1 / self.I1)) * ball(t)
        turn = (tilt.plus + tilt.minus) / 2
        return [theta, side * tilt.rate, start[2] + turn, start[3] + drift + (tilt.plus - tilt.minus) / 2]

    def _shift(self, plus: Any, minus: Any, period: Any) -> Sequence[Any]:
        drift = ball(self.a * (1 / self.I3 - 1 / self.I1)) * period
        zero = flint.arb(0)
        return [zero, zero, (plus + minus) / 2, drift + (plus - minus) / 2]


@dataclass(frozen=True)
class SphericalPendulum(Nutation):
    """State (theta, theta', phi), theta from the downward vertical, 0 < theta < pi; h = sin^2(theta) phi' != 0."""

    g: Fraction
    L: Fraction
    h: Fraction
    theta: Fraction
    omega: Fraction
    phi: Fraction

    def _top(self) -> Start:
        s, c = ball(self.theta).sin_cos()
        weight, rate = ball(self.g / self.L), ball(self.omega)
        energy = rate * rate / 2 + (ball(self.h) / s) ** 2 / 2 - weight * c
        return Start(flint.arb(1), weight, flint.arb(0), ball(self.h), energy, -c, s * rate, still=self.omega == 0)

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if t == 0:
            return [ball(self.theta), ball(self.omega), ball(self.phi)]
        tilt = nutation_of(self, flint.ctx.prec).at(ball(t))
        theta = 2 * flint.arb.atan2(tilt.c, tilt.s)
        return [theta, -tilt.rate, ball(self.phi) + (tilt.plus + tilt.minus) / 2]

    def _shift(self, plus: Any, minus: Any, period: Any) -> Sequence[Any]:
        return [flint.arb(0), flint.arb(0), (plus + minus) / 2]
