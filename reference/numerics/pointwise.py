"""Exact motions, evaluated at one time after another: exact inputs, guard digits, results rounded once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from gnomon.reference.numerics.precision import Number, exact, nearest_double, publish, working
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SAMPLE_DIGITS = 40


@dataclass(frozen=True)
class Turn:
    """A linear map: `matrix`, row by row, multiplies each group of components (given by their indices in the state)."""

    matrix: Sequence[Sequence[Any]]
    groups: Sequence[Sequence[int]]


@dataclass(frozen=True)
class Cycle:
    """state(t + period) = turned state(t) + shift for all t, with `turns` applied one after the other.

    Components in a turn have no shift. All numbers are mpmath's.
    """

    period: Any
    shift: Sequence[Any]
    turns: Sequence[Turn] = ()


class Pointwise(ABC):
    """The part of `Motion` that needs no table: tables are built from it."""

    def state(self, t: Number, digits: int = 15) -> tuple[Any, ...]:
        """State at time t, correct to `digits` significant digits relative to the size of the motion.

        Raises ArithmeticError where the formula gives no number.
        """
        time = exact(t, "t")
        with working(digits + self._guard(time)) as mp:
            state = self._state(mp, time)
            if not all(map(mp.isfinite, state)):
                raise ArithmeticError(f"no finite state at t = {float(time):g} s with {mp.dps} digits")
            return publish(state, digits)

    @abstractmethod
    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]: ...

    def _guard(self, t: Fraction) -> float:
        return 10

    def _cycle(self, mp: Any) -> Cycle | None:
        """How the motion repeats itself, at the precision of `mp`; None where it does not."""
        return None

    def sample_each(self, times: Floats) -> Floats:
        """The nearest doubles without a table: each state in high precision, then rounded."""
        return np.array([[nearest_double(x) for x in self.state(float(t), SAMPLE_DIGITS)] for t in times])
