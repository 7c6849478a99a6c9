"""A load on a stiff rope under a crane on a soft mount, forced: the matrix exponential of the linear motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.linear import LinearMotion, Row


@dataclass(frozen=True)
class HoistedLoad(LinearMotion):
    """State (x1, x2, v1, v2); the force on the crane is F cos(w t), a pair cos, sin of the state."""

    M: Fraction
    m: Fraction
    K: Fraction
    k: Fraction
    F: Fraction
    w: Fraction
    x1: Fraction
    x2: Fraction
    v1: Fraction
    v2: Fraction

    dimension: ClassVar[int] = 4

    def _system(self) -> tuple[Sequence[Row], Row]:
        first, second, w = self.M, self.m, self.w
        rows = (
            (0, 0, 1, 0, 0, 0),
            (0, 0, 0, 1, 0, 0),
            (-(self.K + self.k) / first, self.k / first, 0, 0, self.F / first, 0),
            (self.k / second, -self.k / second, 0, 0, 0, 0),
            (0, 0, 0, 0, 0, -w),
            (0, 0, 0, 0, w, 0),
        )
        return rows, (self.x1, self.x2, self.v1, self.v2, 1, 0)

    def _rate(self) -> float:
        return max(float(self.fast_frequency()), float(self.w))

    def _squares(self) -> tuple[Any, Any]:
        """Squares of the frequencies: roots of M m s^2 - (M k + m (K + k)) s + K k, in balls."""
        half = ball(self.M * self.k + self.m * (self.K + self.k)) / 2
        product = ball(self.M * self.m)
        larger = (half + (half * half - product * ball(self.K * self.k)).sqrt()) / product
        return ball(self.K * self.k) / (product * larger), larger

    def slow_frequency(self, digits: int = 15) -> Any:
        """Frequency of the mode in which crane and load move together (rad/s)."""
        return self._derived(digits, lambda: self._squares()[0].sqrt())

    def fast_frequency(self, digits: int = 15) -> Any:
        """Frequency of the mode of the rope (rad/s)."""
        return self._derived(digits, lambda: self._squares()[1].sqrt())
