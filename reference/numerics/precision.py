"""Exact numbers in, correctly rounded numbers out.

Every input of a motion is taken as the exact rational number that it is: a float is its binary64 value, a
decimal string its decimal value. Work is done in a private mpmath context, so the caller's precision is never
touched, and each result is rounded once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from decimal import Decimal
from fractions import Fraction
from numbers import Integral, Real
from typing import Any

import mpmath
from mpmath.libmp import mpf_pos, round_nearest, to_float, to_rational

Number = int | float | str | Fraction | Any
"""What counts as an exact number; `Any` stands for mpmath's mpf, which has no static type."""

LONGEST = 4000
"""Characters of a number given as text: more are no number that anybody wrote."""
DECADES = 10_000
"""Powers of ten that a number may have: as a fraction, 1e100000000 has so many digits."""
DECADES_OF_MPF = 10**7
"""States of exact motions decay so far; a power of two has its digits at once."""
SHOWN = 60

_context = mpmath.MPContext()


def exact(value: Number, name: str = "number") -> Fraction:
    """The exact rational value of a number.

    Raises ValueError, naming `name` and the value, for what is not a finite real number (a boolean and an array are
    none), and for one so large or small that its digits alone would take seconds.
    """
    if isinstance(value, Fraction):
        return value
    try:
        if isinstance(value, str):
            return _of_text(value.strip(), name)
        if hasattr(value, "_mpf_"):
            if not mpmath.isfinite(value):
                raise NotFiniteError
            _, mantissa, exponent, _bits = value._mpf_
            _check_decades(exponent * math.log10(2) if mantissa else 0, value, name, DECADES_OF_MPF)
            return Fraction(*to_rational(value._mpf_))
        if isinstance(value, Integral) and not isinstance(value, bool):
            return Fraction(int(value))
        if isinstance(value, Decimal) and value.is_finite():
            _check_decades(value.adjusted(), value, name)
        if isinstance(value, Real | Decimal) and not isinstance(value, bool):
            return Fraction(*value.as_integer_ratio())  # type: ignore[union-attr]
    except (NotFiniteError, OverflowError):
        raise ValueError(f"{name} = {value} is not finite; give a finite number") from None
    except (ValueError, ZeroDivisionError) as error:
        if str(error).startswith(f"{name} = "):
            raise
        if isinstance(value, float | Decimal):
            raise ValueError(f"{name} = {value} is not finite; give a finite number") from None
    raise ValueError(
        f"{name} = {shortened(value)} is not a number; give an int, a float, a Fraction, an mpf or a decimal string"
    )


class NotFiniteError(Exception):
    """What is infinite or no number."""


def _of_text(text: str, name: str) -> Fraction:
    if text.lstrip("+-").lower() in ("nan", "inf", "infinity"):
        raise NotFiniteError
    if len(text) > LONGEST:
        raise ValueError(f"{name} = {shortened(text)} has {len(text)} characters; give at most {LONGEST}")
    _, mark, exponent = text.lower().replace("_", "").partition("e")  # Fraction takes 1e1_000
    if mark and exponent.lstrip("+-").isdigit():
        _check_decades(float(exponent), text, name)
    return Fraction(text)


def _check_decades(decades: float, value: Any, name: str, most: int = DECADES) -> None:
    if abs(decades) > most:
        raise ValueError(
            f"{name} = {shortened(value)} is beyond what is computed with; give 0, or a number from "
            f"1e-{most} to 1e{most} in size"
        )


def shortened(value: Any) -> str:
    """A value as an error message shows it: texts in quotes, the middle of a long one left out."""
    shown = repr(value) if not isinstance(value, int) or abs(value) < 10**40 else f"about 1e{int(_log10(value))}"
    return shown if len(shown) <= SHOWN else f"{shown[: SHOWN // 2]}...{shown[-SHOWN // 4 :]}"


def _log10(value: int) -> float:
    return (abs(value).bit_length() - 0.5) * math.log10(2)


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
