"""The base class of exact motions: exact inputs, guard digits against cancellation, results rounded once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from gnomon.reference.numerics.precision import Number, exact, nearest_double, publish, quantity, working
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SAMPLE_DIGITS = 40
MANY = 512
"""Number of times from which a table is faster than single evaluations."""


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


class Motion(ABC):
    """An exact solution of an initial value problem that starts at t = 0.

    A subclass is a frozen dataclass whose fields are Fractions. It states

    1. `_state(mp, t)`: the state at the Fraction t, computed at the precision of the mpmath context `mp`; it converts
       every input with `mp.mpf(fraction)`;
    2. `_guard(t)`: the number of digits that this formula loses to cancellation at t;
    3. `_cycle(mp)`, if the motion repeats itself: sampling many times is then fast, however late they are.
    """

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

    def sample(self, times: Floats, span: float | None = None, breaks: Sequence[Any] = ()) -> Floats:
        """Doubles within 0.51 ulp of the state at each time (float64, s), shape (len(times), dimension).

        Fewer than MANY times are evaluated one by one, more by a table, which is kept on disk. `span` (s) is the end
        of the table: the motion is not evaluated beyond it. `breaks` are times at which the motion is not smooth.
        """
        from gnomon.reference.numerics import table  # compiles; not wanted before many times are asked for

        return table.sample(self, times, span, breaks) if len(times) >= MANY else self.sample_each(times)

    def sample_each(self, times: Floats) -> Floats:
        """The nearest doubles without a table: each state in high precision, then rounded."""
        return np.array([[nearest_double(x) for x in self.state(float(t), SAMPLE_DIGITS)] for t in times])

    def _quantity(self, digits: int, formula: Callable[[Any], Any], guard: float = 10) -> Any:
        """A derived number: `formula(mp)` with guard digits, rounded once."""
        return quantity(digits, formula, guard)

    def _rational(self, digits: int, value: Fraction) -> Any:
        """A derived number that is rational, rounded once."""
        return self._quantity(digits, lambda mp: mp.mpf(value))


def decades(value: Fraction) -> float:
    """An upper bound of log10 of a nonnegative number, 0 below 1: digits that a term of its size can cancel."""
    if value <= 1:
        return 0.0
    return (value.numerator.bit_length() - value.denominator.bit_length() + 1) * 0.30103
