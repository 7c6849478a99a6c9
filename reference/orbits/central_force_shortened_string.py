"""A mass on a smooth table, held by a string that is drawn through a hole at a given speed.

The force is central, so h = r^2 theta' is constant; with r = r0 - c t, theta = theta0 + h t/(r0 r): rational numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion


@dataclass(frozen=True)
class ShortenedString(Motion):
    """State (theta, omega); r0 > 0, before the mass reaches the hole at t = r0/c (c > 0)."""

    m: Fraction
    r0: Fraction
    rate: Fraction
    theta0: Fraction
    omega0: Fraction

    def radius(self, t: Fraction) -> Fraction:
        return self.r0 - self.rate * t

    def at(self, t: Fraction) -> tuple[Fraction, Fraction]:
        """The state, exactly."""
        share = self.r0 / self.radius(t)
        return self.theta0 + self.omega0 * t * share, self.omega0 * share**2

    def tension(self, t: Fraction) -> Fraction:
        """Tension of the string, m r theta'^2 (N)."""
        return self.m * self.radius(t) * self.at(t)[1] ** 2

    def work(self, t: Fraction) -> Fraction:
        """Work of the string until t (J): the transverse kinetic energy grows as 1/r^2, the radial one is constant."""
        return self.m * (self.r0 * self.omega0) ** 2 * ((self.r0 / self.radius(t)) ** 2 - 1) / 2

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        return [mp.mpf(value) for value in self.at(t)]
