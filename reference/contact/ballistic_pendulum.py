"""The ballistic pendulum: a bullet stops in a hanging block, which then swings.

The impact conserves the angular momentum about the pivot: omega = m u/((m + M) L), a rational number; after it the
block moves as in reference/pendulums/pendulum_simple.py, from exact numbers.
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
    """State (x, theta, u, omega), x < 0 and u > 0 of the bullet relative to the hanging block: 0 after the impact."""

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
        """The motion after the impact, timed from it."""
        return Pendulum(self.g, self.length, Fraction(0), self.rate)

    @property
    def rise(self) -> Fraction:
        """The height that the block reaches (m)."""
        return min((self.rate * self.length) ** 2 / (2 * self.g), 2 * self.length)

    @cached_property
    def energy_lost(self) -> Fraction:
        """Energy lost in the impact: M/(m + M) of the bullet's energy."""
        return self.M / (self.m + self.M) * self.m * self.u**2 / 2

    def _guard(self, t: Fraction) -> float:
        return self.swing._guard(max(t - self.impact_time, Fraction(0)))

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        if t < self.impact_time:
            return mp.mpf(self.x + self.u * t), mp.zero, mp.mpf(self.u), mp.zero
        theta, omega = self.swing._state(mp, t - self.impact_time)
        return mp.zero, theta, mp.zero, omega
