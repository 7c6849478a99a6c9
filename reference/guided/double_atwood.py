"""A double Atwood machine: a mass against a pulley that can move, over which two masses hang."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.guided.uniform import Uniform


@dataclass(frozen=True)
class DoubleAtwood(Uniform):
    """The distance by which the movable pulley has descended, and the distance by which m2 has descended below it."""

    g: Fraction
    m1: Fraction
    m2: Fraction
    m3: Fraction

    @property
    def _resistance(self) -> Fraction:
        return self.m1 * (self.m2 + self.m3) + 4 * self.m2 * self.m3

    @property
    def rates(self) -> tuple[Fraction, Fraction]:
        """Accelerations of the movable pulley, and of m2 relative to it (m/s^2)."""
        pulley = 4 * self.m2 * self.m3 - self.m1 * (self.m2 + self.m3)
        relative = 2 * self.m1 * (self.m2 - self.m3)
        return self.g * pulley / self._resistance, self.g * relative / self._resistance

    @property
    def tensions(self) -> tuple[Fraction, Fraction]:
        """Tensions of the string of m1 and of the string of m2 and m3 (N): the massless pulley halves the first."""
        lower = 4 * self.g * self.m1 * self.m2 * self.m3 / self._resistance
        return 2 * lower, lower

    def _accelerations(self, mp: Any) -> Sequence[Any]:
        return [mp.mpf(rate) for rate in self.rates]
