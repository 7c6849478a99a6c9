"""Exact numbers in, correctly rounded numbers out.

Every input of a motion is taken as the exact rational number that it is: a float is its binary64 value, a
decimal string its decimal value. Work is done in a private mpmath context, so the caller's precision is never
touched, and each result is rounded once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

import mpmath
from mpmath.libmp import mpf_pos, round_nearest, to_float, to_rational

Number = int | float | str | Fraction | Any
"""What counts as an exact number; `Any` stands for mpmath's mpf, which has no static type."""

_context = mpmath.MPContext()


def exact(value: Number, name: str = "number") -> Fraction:
    """The exact rational value of a number.

    Raises ValueError, naming `name` and the value, for what is not a finite real number.
    """
    if isinstance(value, Fraction):
        return value
    if hasattr(value, "_mpf_"):
        if not mpmath.isfinite(value):
            raise ValueError(f"{name} = {value} is not finite; give a finite number")
        return Fraction(*to_rational(value._mpf_))
    try:
        if isinstance(value, str):
            return Fraction(value.strip())
        if not math.isfinite(value):
            raise ValueError(f"{name} = {value} is not finite; give a finite number")
        return Fraction(value if isinstance(value, int) else float(value))
    except (TypeError, ValueError, ZeroDivisionError) as error:
        if isinstance(error, ValueError) and "not finite" in str(error):
            raise
        raise ValueError(
            f"{name} = {value!r} is not a number; give an int, a float, a Fraction, an mpf or a decimal string"
        ) from None


@contextmanager
def working(digits: float) -> Iterator[Any]:
    """The private mpmath context, at `digits` decimal digits inside the `with` block.

    Blocks nest: the precision of the outer block is back when the inner one ends.
    """
    before = _context.prec
    _context.dps = math.ceil(digits)
    try:
        yield _context
    finally:
        _context.prec = before


def publish(values: Iterable[Any], digits: int) -> tuple[Any, ...]:
    """Round each value once to `digits` significant digits and hand it out as mpmath's own mpf."""
    bits = math.ceil(digits * math.log2(10)) + 1
    return tuple(mpmath.mp.make_mpf(mpf_pos(value._mpf_, bits, round_nearest)) for value in values)


def quantity(digits: int, formula: Callable[[Any], Any], guard: float = 10) -> Any:
    """A number: `formula(mp)` with guard digits, rounded once."""
    with working(digits + guard) as mp:
        return publish([formula(mp)], digits)[0]


def nearest_double(value: Any) -> float:
    """The double nearest to an mpf (mpmath's own float() truncates)."""
    return float(to_float(mpf_pos(value._mpf_, 53, round_nearest)))
