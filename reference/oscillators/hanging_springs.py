"""A mass that hangs on two springs in series: m x'' = m g - k x with 1/k = 1/k1 + 1/k2."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.linear import LinearMotion, Row


@dataclass(frozen=True)
class HangingSprings(LinearMotion):
    """State (x, x'), x downward from where both springs are unstretched."""

    mass: Fraction
    k1: Fraction
    k2: Fraction
    g: Fraction
    x0: Fraction
    v0: Fraction

    dimension = 2

    def _system(self) -> tuple[Sequence[Row], Row]:
        rows = ((0, 1, 0), (-self.in_series / self.mass, 0, self.g), (0, 0, 0))
        return rows, (self.x0, self.v0, 1)

    @property
    def in_series(self) -> Fraction:
        """Stiffness of the springs in series."""
        return self.k1 * self.k2 / (self.k1 + self.k2)

    def stiffness(self, digits: int = 15) -> Any:
        return self._quantity(digits, lambda mp: mp.mpf(self.in_series))

    def side_by_side(self, digits: int = 15) -> Any:
        """Stiffness of the springs in parallel."""
        return self._quantity(digits, lambda mp: mp.mpf(self.k1 + self.k2))

    def sag(self, digits: int = 15) -> Any:
        """Static deflection m g/k."""
        return self._quantity(digits, lambda mp: mp.mpf(self.mass * self.g / self.in_series))

    def period(self, digits: int = 15) -> Any:
        return self._quantity(digits, lambda mp: 2 * mp.pi * mp.sqrt(mp.mpf(self.mass / self.in_series)))
