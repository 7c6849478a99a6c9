"""A spring-driven pin with friction proportional to the deceleration of its torpedo.

x'' = (k/m) (d0 - x) - mu a while it moves: harmonic about xe = d0 - mu m a/k, x = xe - R cos psi, v = w R sin psi.
Rational numbers decide whether it starts to move, and whether it reaches the gap before it stops.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, sign
from gnomon.reference.numerics.motion import BallMotion


@dataclass(frozen=True)
class FiringPin(BallMotion):
    """State (x, v), x0 <= gap, v0 >= 0. The primer at `gap` stops the pin; a pin that stops before it stays."""

    mass: Fraction
    stiffness: Fraction
    d0: Fraction
    mu: Fraction
    a: Fraction
    gap: Fraction
    x0: Fraction
    v0: Fraction

    @property
    def centre(self) -> Fraction:
        """xe."""
        return self.d0 - self.mu * self.mass * self.a / self.stiffness

    @property
    def moves(self) -> bool:
        """Whether the pin leaves its start: it is not at the gap, and has a speed or a spring force above friction."""
        return self.x0 < self.gap and (self.v0 > 0 or self.centre > self.x0)

    @property
    def fires(self) -> bool:
        """Whether it reaches the gap, possibly at zero speed."""
        reach = self.gap - self.centre
        return self.x0 == self.gap or (self.moves and (reach <= 0 or reach**2 <= self._square))

    @property
    def _square(self) -> Fraction:
        """R^2."""
        return (self.x0 - self.centre) ** 2 + self.v0**2 * self.mass / self.stiffness

    def end_time(self, digits: int = 15) -> Any:
        """Time at which a moving pin strikes or stops (s)."""
        return self._derived(digits, self._end)

    def end_position(self, digits: int = 15) -> Any:
        return self._derived(digits, self._place)

    def strike_speed(self, digits: int = 15) -> Any:
        """Speed at the gap, w sqrt(R^2 - (gap - xe)^2), if it fires."""
        square = (self._square - (self.gap - self.centre) ** 2) * self.stiffness / self.mass
        return self._derived(digits, lambda: ball(square).sqrt())

    def fastest(self, digits: int = 15) -> Any:
        """The largest speed: at the centre if the pin passes it, else at the start or the strike."""
        if not self.moves:
            return self._derived(digits, lambda: flint.arb(0))
        if self.x0 >= self.centre:
            return self._derived(digits, lambda: ball(self.v0))
        if self.fires and self.gap < self.centre:
            return self.strike_speed(digits)
        return self._derived(digits, lambda: self._rate() * ball(self._square).sqrt())

    def holding_deceleration(self, digits: int = 15) -> Any:
        """The deceleration at which friction holds the pin, k d0/(mu m); mu > 0."""
        return self._derived(digits, lambda: ball(self.stiffness * self.d0 / (self.mu * self.mass)))

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if not self.moves:
            return ball(self.x0), flint.arb(0) if self.x0 != self.gap or t > 0 else ball(self.v0)
        # w t is algebraic for a rational t, the angles of the end are not.
        if sign(lambda: self._end() - ball(t)) < 0:
            return self._place(), flint.arb(0)
        rate = self._rate()
        sine, cosine = (rate * ball(t)).sin_cos()
        distance, v = ball(self.x0 - self.centre), ball(self.v0)
        return ball(self.centre) + distance * cosine + v / rate * sine, v * cosine - rate * distance * sine

    def _rate(self) -> Any:
        return ball(self.stiffness / self.mass).sqrt()

    def _end(self) -> Any:
        rate, reach = self._rate(), self.gap - self.centre
        begin = flint.arb.atan2(ball(self.v0), rate * ball(self.centre - self.x0))
        if not self.fires or (reach > 0 and reach**2 == self._square):
            return (flint.arb.pi() - begin) / rate
        return (flint.arb.atan2(ball(self._square - reach**2).sqrt(), ball(-reach)) - begin) / rate

    def _place(self) -> Any:
        return ball(self.gap) if self.fires else ball(self.centre) + ball(self._square).sqrt()
