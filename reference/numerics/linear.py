"""Linear motions, y' = A y with constant A, by the exponential of the matrix (Beatty, Dynamics, 6.6 to 6.18).

A constant load is a component that stays 1; a harmonic one is a pair cos(wt), sin(wt) that obeys its own linear
equations. So resonance, critical damping, coincident rates and vanishing fields are not special cases.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

import flint
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.motion import MANY, BallMotion
from gnomon.reference.numerics.pointwise import Cycle, Floats, Turn

Row = Sequence[Any]

FARTHEST = 2 ** (8 * 200)
"""(1e60)**8: for longer times, enough precision takes seconds."""


class LinearMotion(BallMotion):
    """A subclass states `_system()`; the state is the first `dimension` components of y."""

    dimension: ClassVar[int]

    @abstractmethod
    def _system(self) -> tuple[Sequence[Row], Row]:
        """A row by row, and y at t = 0: rationals or balls at the current precision."""

    def _balls(self, t: Fraction) -> Sequence[Any]:
        return self._whole(t)[: self.dimension]

    def _whole(self, t: Fraction) -> list[Any]:
        """All components of y."""
        rows, start = self._system()
        size = len(start)
        return list((_exponential(rows, t) * flint.arb_mat(size, 1, [_entry(x) for x in start])).entries())

    def _rate(self) -> float:
        """Largest angular frequency (rad/s), load included, of a motion without a cycle; 0 if it does not vibrate."""
        return 0.0

    def sample(self, times: Floats, span: float | None = None, breaks: Sequence[Any] = ()) -> Floats:
        rate = self._rate()
        period = 2 * math.pi / rate if rate else math.inf
        if not 0 < period < math.inf or len(times) < MANY:
            return super().sample(times, span, breaks)
        return Strobed(self, Fraction(period)).sample(times, span, breaks)[:, : self.dimension]


@dataclass(frozen=True)
class Strobed(BallMotion):
    """All components of a linear motion, with a cycle of any length T: y(t + T) = exp(A T) y(t)."""

    motion: LinearMotion
    period: Fraction

    def _balls(self, t: Fraction) -> Sequence[Any]:
        return self.motion._whole(t)

    def _cycle(self, mp: Any) -> Cycle:
        size = len(self.motion._system()[1])
        entries = refined(mp, lambda: list(_exponential(self.motion._system()[0], self.period).entries()))
        turn = Turn([entries[size * i : size * (i + 1)] for i in range(size)], [range(size)])
        return Cycle(mp.mpf(self.period), (mp.zero,) * size, [turn])


def _exponential(rows: Sequence[Row], t: Fraction) -> Any:
    """exp(A t)."""
    matrix = flint.arb_mat(len(rows), len(rows), [_entry(x) for row in rows for x in row])
    grown = matrix * ball(t)
    # entries of the eighth power scale as the eighth power of the rates, whatever the units
    if any(abs(x.mid()) > FARTHEST for x in ((grown * grown) ** 4).entries()):
        raise ArithmeticError(f"t = {float(t):g} s exceeds 1e60 times its shortest time scale; give a shorter span")
    return grown.exp()


def _entry(x: Any) -> Any:
    return ball(x) if isinstance(x, (int, Fraction)) else x
