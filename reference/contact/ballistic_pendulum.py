"""The ballistic pendulum (Beatty, Dynamics, 7.2): a bullet that a block swallows, and the swing that follows.

The angular momentum about the pivot is kept through the impact: omega = m u/((m + M) L), a rational number; from there
on the motion is that of the pendulum of reference/pendulums/pendulum_simple.py, in exact numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.pendulums.pendulum_simple import Pendulum


@dataclass(frozen=True)
class BallisticPendulum(Motion):
    """State (x, theta, u, omega): the bullet x < 0 from the hanging block, which it follows from x = 0 on; u > 0."""

    g: Fraction
    length: Fraction
    m: Fraction
    M: Fraction
    x: Fraction
    u: Fraction

    @cached_property
    def impact_time(self) -> Fraction:
        return -self.x / self.u

    @cached_property
    def rate(self) -> Fraction:
        """omega after the impact."""
        return self.m * self.u / ((self.m + self.M) * self.length)

    @cached_property
    def swing(self) -> Pendulum:
        """The motion after the impact, with its own time."""
        return Pendulum(self.g, self.length, Fraction(0), self.rate)

    @cached_property
    def energy_lost(self) -> Fraction:
        """In the impact: M/(m + M) of the bullet's energy."""
        return self.M / (self.m + self.M) * self.m * self.u**2 / 2

    def _guard(self, t: Fraction) -> float:
        return self.swing._guard(max(t - self.impact_time, Fraction(0)))

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        if t < self.impact_time:
            return mp.mpf(self.x + self.u * t), mp.zero, mp.mpf(self.u), mp.zero
        theta, omega = self.swing._state(mp, t - self.impact_time)
        return mp.zero, theta, mp.zero, omega
