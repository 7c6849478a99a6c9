"""Simpler models of the heavy top: steady slow precession, and small nutation about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.linear import LinearMotion, Row
from gnomon.reference.numerics.motion import BallMotion


@dataclass(frozen=True)
class FastTop(BallMotion):
    """State (theta, theta', phi, psi): theta is constant, phi' = W/a, psi' = a/I3 - (W/a) cos(theta)."""

    I3: Fraction
    W: Fraction
    a: Fraction
    start: tuple[Fraction, ...]

    def _balls(self, t: Fraction) -> Sequence[Any]:
        theta, _omega, phi, psi = self.start
        slow, time = ball(self.W / self.a), ball(t)
        spin = ball(self.a / self.I3) - slow * ball(theta).cos()
        return [ball(theta), 0 * time, ball(phi) + slow * time, ball(psi) + spin * time]


@dataclass(frozen=True)
class SmallNutation(LinearMotion):
    """State (theta, theta', phi, psi): Lagrange's equations linearised in theta about the angle `tilt`."""

    I1: Fraction
    I3: Fraction
    W: Fraction
    a: Fraction
    b: Fraction
    tilt: Fraction
    start: tuple[Fraction, ...]

    dimension = 4

    def rates(self) -> tuple[Any, ...]:
        """theta'', phi' and psi' at the tilt, each followed by its derivative with respect to theta."""
        s, u = ball(self.tilt).sin_cos()
        moment, a, b, weight = (ball(x) for x in (self.I1, self.a, self.b, self.W))
        turn = (b - a * u) / (moment * s * s)
        slope = (a - 2 * moment * turn * u) / (moment * s)
        pull = (turn * (moment * turn * u - a) + weight) * s / moment
        steeper = (
            (turn * (moment * turn * u - a) + weight) * u
            + slope * (2 * moment * turn * u - a) * s
            - moment * turn * turn * s * s
        ) / moment
        return pull, steeper, turn, slope, a / ball(self.I3) - turn * u, turn * s - slope * u

    def nutation_rate(self, digits: int = 15) -> Any | None:
        """Angular frequency of the small nutation (rad/s); None where the tilt is unstable."""
        square = -self.rates()[1]
        return self._derived(digits, lambda: (-self.rates()[1]).sqrt()) if square > 0 else None

    def _system(self) -> tuple[Sequence[Row], Row]:
        """With 1 as fifth component for the constant terms of the expansion about the tilt."""
        pull, steeper, turn, slope, spin, other = self.rates()
        tilt = ball(self.tilt)
        rows: list[Row] = [
            [0, 1, 0, 0, 0],
            [steeper, 0, 0, 0, pull - steeper * tilt],
            [slope, 0, 0, 0, turn - slope * tilt],
            [other, 0, 0, 0, spin - other * tilt],
            [0, 0, 0, 0, 0],
        ]
        return rows, [*self.start, 1]
