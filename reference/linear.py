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
from gnomon.reference.balls import BallMotion, ball, refined
from gnomon.reference.motion import Cycle, Turn

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

    def _strobed(self, mp: Any, period: Fraction) -> Cycle:
        """Without load any time is as good as a period: y(t + T) = exp(A T) y(t)."""
        size = self.dimension

        def grown() -> list[Any]:
            matrix = flint.arb_mat(size, size, [_entry(x) for row in self._system()[0] for x in row])
            return list((matrix * ball(period)).exp().entries())

        entries = refined(mp, grown)
        turn = Turn([entries[size * i : size * (i + 1)] for i in range(size)], [range(size)])
        return Cycle(mp.mpf(period), (mp.zero,) * size, [turn])


def _entry(x: Any) -> Any:
    return ball(x) if isinstance(x, (int, Fraction)) else x
