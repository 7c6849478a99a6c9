"""The base class of exact motions: exact inputs, guard digits against cancellation, results rounded once."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.balls import refined
from gnomon.reference.numerics.pointwise import Floats, Pointwise
from gnomon.reference.numerics.precision import publish, quantity, working

MANY = 512
"""Number of times from which a table is faster than single evaluations."""


class Motion(Pointwise):
    """An exact solution of an initial value problem that starts at t = 0.

    A subclass is a frozen dataclass whose fields are Fractions. It states

    1. `_state(mp, t)`: the state at the Fraction t, computed at the precision of the mpmath context `mp`; it converts
       every input with `mp.mpf(fraction)`;
    2. `_guard(t)`: the number of digits that this formula loses to cancellation at t;
    3. `_cycle(mp)`, if the motion repeats itself: sampling many times is then fast, however late they are.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Decay(Motion):
    ...     rate: Fraction
    ...     def _state(self, mp, t):
    ...         rate = mp.mpf(self.rate.numerator) / self.rate.denominator
    ...         return [mp.exp(-rate * t.numerator / t.denominator)]
    ...     def _guard(self, t):
    ...         return 2
    >>> float(Decay(Fraction(1, 2)).state(Fraction(2), 20)[0])
    0.36787944117144233
    """

    def sample(self, times: Floats, span: float | None = None, breaks: Sequence[Any] = ()) -> Floats:
        """Doubles within 0.51 ulp of the state at each time (float64, s), shape (len(times), dimension).

        Fewer than MANY times are evaluated one by one, more by a table, which is kept on disk. `span` (s) is the end
        of the table: the motion is not evaluated beyond it. `breaks` are times at which the motion is not smooth.
        """
        from gnomon.reference.numerics import table  # loads numba and compiles: only where many times are asked for

        return table.sample(self, times, span, breaks) if len(times) >= MANY else self.sample_each(times)

    def _quantity(self, digits: int, formula: Callable[[Any], Any], guard: float = 10) -> Any:
        """A derived number: `formula(mp)` with guard digits, rounded once."""
        return quantity(digits, formula, guard)

    def _rational(self, digits: int, value: Fraction) -> Any:
        """A derived number that is rational, rounded once."""
        return self._quantity(digits, lambda mp: mp.mpf(value))


class BallMotion(Motion):
    """A motion whose state is a formula in ball arithmetic, `_balls(t)`, at the current precision.

    The base class raises the precision until the balls prove the digits, so the formula needs no care about cancellation.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> from gnomon.reference.numerics.balls import ball
    >>> @dataclass(frozen=True)
    ... class Decay(BallMotion):
    ...     rate: Fraction
    ...     def _balls(self, t):
    ...         return [(-ball(self.rate * t)).exp()]
    >>> float(Decay(Fraction(1, 2)).state(Fraction(2), 20)[0])
    0.36787944117144233
    """

    @abstractmethod
    def _balls(self, t: Fraction) -> Sequence[Any]: ...

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        return refined(mp, lambda: self._balls(t))

    def _guard(self, t: Fraction) -> float:
        return 2  # the balls prove the digits; two more are for the rounding

    def _derived(self, digits: int, formula: Callable[[], Any]) -> Any:
        """A derived number: `formula()` in balls, rounded once to `digits`."""
        with working(digits + 2) as mp:
            return publish(refined(mp, lambda: [formula()]), digits)[0]


def decades(value: Fraction) -> float:
    """An upper bound of log10 of a nonnegative number, 0 below 1: digits that a term of its size can cancel."""
    if value <= 1:
        return 0.0
    return (value.numerator.bit_length() - value.denominator.bit_length() + 1) * 0.30103
