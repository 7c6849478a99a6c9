"""Conversion of inputs to exact rational numbers, and of results to correctly rounded ones.

An input stands for the rational number that it denotes: a float for its binary64 value, a decimal string for its
decimal value. Computations run in a private mpmath context, so that the caller's precision does not change, and each
result is rounded once.
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
"""The types of an exact number; `Any` stands for mpmath's mpf, which has no static type."""

LONGEST = 4000
"""Most characters of a number given as text."""
DECADES = 10_000
"""Largest power of ten of an input: as a fraction, 1e100000000 has 100 million digits."""
DECADES_OF_MPF = 10**7
"""The same for an mpf, which decaying motions make this small; as a power of two it converts quickly."""
SHOWN = 60
MOST_DIGITS = 2500
"""Most digits of a computation: the 1000 that a user may ask for, and those that a formula loses, at most 100 in the
catalogue. A state to so many takes some ten seconds, and to twice as many ten times as long."""

_context = mpmath.MPContext()


def exact(value: Number, name: str = "number") -> Fraction:
    """The exact rational value of a number.

    Raises ValueError, which names `name` and the value, for anything but a finite real number (booleans and arrays are
    refused), and for a number so large or so small that the conversion would take seconds.
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
    kinds = (
        "as 2.5, 1e-3 or 5/2" if isinstance(value, str) else "an int, a float, a Fraction, an mpf or a decimal string"
    )
    raise ValueError(f"{name} = {shortened(value)} is not a number; give {'one, ' * isinstance(value, str)}{kinds}")


class NotFiniteError(Exception):
    """An infinity or a NaN."""


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
            f"{name} = {shortened(value)} is too large or too small; give 0, or a number from "
            f"1e-{most} to 1e{most} in size"
        )


def shortened(value: Any) -> str:
    """A value as error messages show it: texts in quotes, long ones without their middle."""
    shown = repr(value) if not isinstance(value, int) or abs(value) < 10**40 else f"about 1e{int(_log10(value))}"
    return shown if len(shown) <= SHOWN else f"{shown[: SHOWN // 2]}...{shown[-SHOWN // 4 :]}"


def _log10(value: int) -> float:
    return (abs(value).bit_length() - 0.5) * math.log10(2)


@contextmanager
def working(digits: float) -> Iterator[Any]:
    """The private mpmath context, at `digits` decimal digits inside the `with` block.

    Blocks nest: the end of the inner block restores the precision of the outer one. Raises ArithmeticError for more than
    MOST_DIGITS: a formula whose terms grow exponentially and cancel may need any number of them.
    """
    if not digits <= MOST_DIGITS:
        raise ArithmeticError(f"it needs {digits:.4g} digits, and at most {MOST_DIGITS} are computed")
    before = _context.prec
    _context.dps = math.ceil(digits)
    try:
        yield _context
    finally:
        _context.prec = before


def publish(values: Iterable[Any], digits: int) -> tuple[Any, ...]:
    """Each value rounded once to `digits` significant digits, as an mpf of mpmath's global context."""
    bits = math.ceil(digits * math.log2(10)) + 1
    return tuple(mpmath.mp.make_mpf(mpf_pos(value._mpf_, bits, round_nearest)) for value in values)


def quantity(digits: int, formula: Callable[[Any], Any], guard: float = 10) -> Any:
    """`formula(mp)`, computed with guard digits and rounded once to `digits`."""
    with working(digits + guard) as mp:
        return publish([formula(mp)], digits)[0]


def nearest_double(value: Any) -> float:
    """The double nearest to an mpf (mpmath's own float() truncates)."""
    return float(to_float(mpf_pos(value._mpf_, 53, round_nearest)))
