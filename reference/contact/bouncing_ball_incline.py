"""A ball that bounces down a smooth incline: a bouncing ball normal to it, uniform acceleration along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.contact.bouncing_ball import BouncingBall
from gnomon.reference.numerics.motion import Motion, decades
from gnomon.reference.numerics.precision import Number, exact, publish, working


@dataclass(frozen=True)
class BouncingIncline(Motion):
    """State (x, y, x', y'), x down the incline, y normal to it. Impacts and their limit do not change x'."""

    ball: BouncingBall
    along: Fraction
    x0: Fraction
    vx0: Fraction

    def place(self, t: Number, digits: int) -> tuple[Any, Any]:
        """x and x' at t."""
        time = exact(t)
        with working(digits + 10 + decades(time)) as mp:
            return publish(self._place(mp, time), digits)  # type: ignore[return-value]

    def _place(self, mp: Any, t: Fraction) -> tuple[Any, Any]:
        return mp.mpf(self.x0 + t * (self.vx0 + self.along * t / 2)), mp.mpf(self.vx0 + self.along * t)

    def _guard(self, t: Fraction) -> float:
        return self.ball._guard(t)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        y, vy = self.ball._state(mp, t)
        x, vx = self._place(mp, t)
        return x, y, vx, vy
