"""Linear motions, y' = A y with constant A, by the exponential of the matrix (Beatty, Dynamics, 6.6 to 6.18).

A constant load is a component that stays 1; a harmonic one is a pair cos(wt), sin(wt) that obeys its own linear
equations. So resonance, critical damping, coincident rates and vanishing fields are no special cases.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, ClassVar

import flint
from gnomon.reference.balls import BallMotion, ball

Row = Sequence[Any]


class LinearMotion(BallMotion):
    """A subclass states `_system()`; the state is the first `dimension` components of y."""

    dimension: ClassVar[int]

    @abstractmethod
    def _system(self) -> tuple[Sequence[Row], Row]:
        """A row by row, and y at t = 0: rationals or balls at the precision in force."""

    def _balls(self, t: Fraction) -> Sequence[Any]:
        rows, start = self._system()
        size = len(start)
        matrix = flint.arb_mat(size, size, [_entry(x) for row in rows for x in row])
        grown = (matrix * ball(t)).exp() * flint.arb_mat(size, 1, [_entry(x) for x in start])
        return [grown[i, 0] for i in range(self.dimension)]


def _entry(x: Any) -> Any:
    return ball(x) if isinstance(x, (int, Fraction)) else x
