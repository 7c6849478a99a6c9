"""A bead on a smooth wire that rotates uniformly in a vertical plane: r'' = O^2 r - g sin(O t).

r = A e^(Ot) + B e^(-Ot) + (g/(2 O^2)) sin(Ot). The load is part of a linear system, with components sin and cos.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.linear import LinearMotion, Row


@dataclass(frozen=True)
class BeadOnTurningWire(LinearMotion):
    """State (r, r'); the wire is horizontal at t = 0 and rises."""

    O: Fraction  # noqa: E741 - the symbol of the equations
    g: Fraction
    r0: Fraction
    v0: Fraction

    dimension = 2

    def _system(self) -> tuple[Sequence[Row], Row]:
        rate = self.O
        rows = ((0, 1, 0, 0), (rate**2, 0, -self.g, 0), (0, 0, 0, rate), (0, 0, -rate, 0))
        return rows, (self.r0, self.v0, 0, 1)

    @property
    def growing(self) -> Fraction:
        """A, the coefficient of the growing part; zero on bounded motions."""
        return (self.r0 + (self.v0 - self.g / (2 * self.O)) / self.O) / 2

    @property
    def decaying(self) -> Fraction:
        """B, the coefficient of the decaying part."""
        return (self.r0 - (self.v0 - self.g / (2 * self.O)) / self.O) / 2

    def swing(self, digits: int = 15) -> Any:
        """g/(2 O^2), the amplitude of the bounded periodic motion."""
        return self._quantity(digits, lambda mp: mp.mpf(self.g / (2 * self.O**2)))
