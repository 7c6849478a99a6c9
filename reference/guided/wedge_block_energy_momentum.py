"""A block on a wedge that is free to slide, without friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.guided.uniform import Uniform


@dataclass(frozen=True)
class Wedge(Uniform):
    """X of the wedge and s of the block down its face, without friction."""

    g: Fraction
    m: Fraction
    M: Fraction
    alpha: Fraction

    def _accelerations(self, mp: Any) -> Sequence[Any]:
        g, m, M = mp.mpf(self.g), mp.mpf(self.m), mp.mpf(self.M)
        cosine, sine = mp.cos_sin(mp.mpf(self.alpha))
        common = g * sine / (M + m * sine**2)
        return -m * cosine * common, (M + m) * common

    def normal_force(self, digits: int = 15) -> Any:
        """Normal force between block and wedge (N): m M g cos(alpha)/(M + m sin^2(alpha))."""

        def formula(mp: Any) -> Any:
            cosine, sine = mp.cos_sin(mp.mpf(self.alpha))
            return mp.mpf(self.m * self.M * self.g) * cosine / (mp.mpf(self.M) + mp.mpf(self.m) * sine**2)

        return self._quantity(digits, formula)
