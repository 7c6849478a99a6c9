"""An Atwood machine whose pulley has a moment of inertia."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.guided.uniform import Uniform


@dataclass(frozen=True)
class Atwood(Uniform):
    """x, by which m1 has descended: x'' = g (m1 - m2)/(m1 + m2 + I/R^2)."""

    g: Fraction
    m1: Fraction
    m2: Fraction
    inertia: Fraction
    radius: Fraction

    @property
    def rate(self) -> Fraction:
        return self.g * (self.m1 - self.m2) / (self.m1 + self.m2 + self.inertia / self.radius**2)

    def tensions(self, digits: int = 15) -> tuple[Any, Any]:
        """Tensions of the rope on the sides of m1 and m2 (N)."""
        first, second = self.m1 * (self.g - self.rate), self.m2 * (self.g + self.rate)
        return self._quantity(digits, lambda mp: mp.mpf(first)), self._quantity(digits, lambda mp: mp.mpf(second))

    def _accelerations(self, mp: Any) -> Sequence[Any]:
        return (mp.mpf(self.rate),)
