"""A mass on a spring with dry friction: half cycles about two centres, then rest.

With d = mu_k m g/k a half cycle towards +-x is harmonic about -+d, and |x| at its end is 2d smaller than at its start:
at turning point n it is R - (2n - 1) d, R the amplitude of the first half cycle. The mass stays where this is at most
mu_s m g/k, which the squares decide in rational numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, floor_of
from gnomon.reference.numerics.motion import BallMotion


@dataclass(frozen=True)
class CoulombOscillator(BallMotion):
    """State (x, v); m x'' = -k x - mu_k m g sign(v), at rest where |k x| <= mu_s m g. mu_k <= mu_s."""

    mass: Fraction
    stiffness: Fraction
    g: Fraction
    mu_k: Fraction
    mu_s: Fraction
    x0: Fraction
    v0: Fraction

    @property
    def offset(self) -> Fraction:
        """d, the distance of the two centres from the centre of the spring."""
        return self.mu_k * self.mass * self.g / self.stiffness

    @property
    def limit(self) -> Fraction:
        """The largest |x| at which the mass stays."""
        return self.mu_s * self.mass * self.g / self.stiffness

    @cached_property
    def side(self) -> int:
        """Sign of the velocity in the first half cycle; 0 if the mass stays from the start."""
        if self.v0:
            return 1 if self.v0 > 0 else -1
        if abs(self.x0) <= self.limit:
            return 0
        return -1 if self.x0 > 0 else 1

    @cached_property
    def turns(self) -> int | None:
        """Number of turning points, the final rest included; None if the mass never stays."""
        if self.side == 0:
            return 0
        if self.mu_k == 0:
            return 1 if self._square <= self.limit**2 else None
        low, turns = 0, 1
        while not self._stays(turns):
            low, turns = turns, 2 * turns
        while turns - low > 1:
            middle = (low + turns) // 2
            low, turns = (low, middle) if self._stays(middle) else (middle, turns)
        return turns

    def _stays(self, turn: int) -> bool:
        """Whether the mass stays at a turning point."""
        return self._square <= (self.limit + (2 * turn - 1) * self.offset) ** 2

    @cached_property
    def _square(self) -> Fraction:
        """R^2."""
        return (self.x0 + self.side * self.offset) ** 2 + self.v0**2 * self.mass / self.stiffness

    def turn_time(self, turn: int, digits: int = 15) -> Any:
        return self._derived(digits, lambda: self._turn_time(turn))

    def turn_position(self, turn: int, digits: int = 15) -> Any:
        return self._derived(digits, lambda: self._turn_position(turn))

    def dissipated(self, digits: int = 15) -> Any:
        """Energy dissipated until the mass stays (J)."""
        assert self.turns is not None
        start = (self.stiffness * self.x0**2 + self.mass * self.v0**2) / 2
        turns = self.turns
        return self._derived(digits, lambda: ball(start) - ball(self.stiffness) * self._turn_position(turns) ** 2 / 2)

    def energy_after(self, turn: int, digits: int = 15) -> Any:
        """Energy of the spring at turning point number `turn` (J)."""
        return self._derived(digits, lambda: ball(self.stiffness) * self._turn_position(turn) ** 2 / 2)

    def period(self, digits: int = 15) -> Any:
        """Duration of two half cycles, 2 pi sqrt(m/k), which friction does not change."""
        return self._derived(digits, lambda: 2 * flint.arb.pi() / self._rate())

    def fastest(self, digits: int = 15) -> Any:
        """The largest speed, at the first passage through a centre, unless the start is faster."""
        if self.side == 0:
            return self._derived(digits, lambda: flint.arb(0))
        ahead = self.side * self.x0 + self.offset < 0
        arcs = 0 if ahead else 1
        if self.turns is not None and arcs >= self.turns:
            return self._derived(digits, lambda: ball(abs(self.v0)))
        lost = 2 * arcs * self.offset
        return self._derived(digits, lambda: (self._rate() * (self._radius() - ball(lost))).max(ball(abs(self.v0))))

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if self.side == 0:
            return ball(self.x0), flint.arb(0)
        # Turning points are at no rational time: w t is algebraic, its tangent is not.
        past = floor_of(lambda: (self._rate() * ball(t) - self._angle()) / flint.arb.pi()) + 1 if t else 0
        past = max(0, past)
        if self.turns is not None and past >= self.turns:
            return self._turn_position(self.turns), flint.arb(0)
        sine, cosine = (self._rate() * ball(t) - self._angle()).sin_cos()
        radius = self.side * (self._radius() - 2 * past * ball(self.offset))
        centre = -self.side * (-1) ** past * ball(self.offset)
        return centre + radius * cosine, -radius * self._rate() * sine

    def _rate(self) -> Any:
        return ball(self.stiffness / self.mass).sqrt()

    def _radius(self) -> Any:
        return ball(self._square).sqrt()

    def _angle(self) -> Any:
        """w times the time of the first turning point."""
        if self.v0 == 0:
            return flint.arb.pi()
        across = ball(abs(self.v0)) / self._rate()
        return flint.arb.atan2(across, ball(self.side * self.x0 + self.offset))

    def _turn_time(self, turn: int) -> Any:
        return (self._angle() + (turn - 1) * flint.arb.pi()) / self._rate()

    def _turn_position(self, turn: int) -> Any:
        if turn == 0:
            return ball(self.x0)
        return self.side * (-1) ** (turn - 1) * (self._radius() - (2 * turn - 1) * ball(self.offset))
