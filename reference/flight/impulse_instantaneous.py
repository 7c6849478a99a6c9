"""A mass under a short pulse of force.

The pulse is half a sine, F = (pi J/(2 T)) sin(pi s/T), 0 < s = t - t1 < T, of impulse J. T = 0 is its limit, the
instantaneous impulse v -> v + J/m at t1; with T > 0 the position lags behind that limit by J T/(2 m).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.motion import BallMotion


@dataclass(frozen=True)
class Pulse(BallMotion):
    """State (x, v)."""

    m: Fraction
    impulse: Fraction
    begin: Fraction
    length: Fraction
    x0: Fraction
    v0: Fraction

    @property
    def final_speed(self) -> Fraction:
        """The velocity after the pulse (m/s)."""
        return self.v0 + self.impulse / self.m

    def lag(self, digits: int = 15) -> Any:
        """Lag of the position behind the position after an instantaneous impulse, after the end of the pulse (m)."""
        return self._rational(digits, self.impulse * self.length / (2 * self.m))

    def before_the_impulse(self, digits: int = 15) -> tuple[Any, Any]:
        """The state at t1, without the impulse."""
        return self._rational(digits, self.x0 + self.v0 * self.begin), self._rational(digits, self.v0)

    def _balls(self, t: Fraction) -> Sequence[Any]:
        place, kick = self.x0 + self.v0 * t, self.impulse / self.m
        if t < self.begin:
            return ball(place), ball(self.v0)
        since = t - self.begin
        if since >= self.length:
            return ball(place + kick * (since - self.length / 2)), ball(self.v0 + kick)
        angle = flint.arb.pi() * ball(since / self.length)
        way = ball(since) - ball(self.length) * angle.sin() / flint.arb.pi()
        gained = (angle / 2).sin()
        return ball(place) + ball(kick / 2) * way, ball(self.v0) + ball(kick) * gained * gained
