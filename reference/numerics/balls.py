"""Ball arithmetic at a precision that is raised until the balls prove the requested digits.

Cancellation, near-resonance and stiffness then cost only time: formulas of exact motions need no guard digits.
Balls: Johansson, Arb: efficient arbitrary-precision midpoint-radius interval arithmetic, IEEE Trans. Comput. 66 (2017).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

import flint

SMALL = 130
"""A component this many bits below the largest one needs no digits of its own: it may be an exact zero."""
ZERO_BITS = 2**12
"""A ball around zero narrower than 2**-4096 counts as zero, whatever the unit."""
MOST_BITS = 2**17
"""More than any motion needs within the domain of its case."""


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """The precision of balls inside the `with` block, restored after it."""
    before = flint.ctx.prec
    flint.ctx.prec = bits
    try:
        yield
    finally:
        flint.ctx.prec = before


def ball(value: Fraction | int) -> Any:
    """An exact rational as a ball at the current precision.

    Parameters
    ----------
    value : Fraction or int
        The number.

    Returns
    -------
    flint.arb
        A ball that contains the number.

    Examples
    --------
    >>> ball(Fraction(1, 3)).contains(flint.fmpq(1, 3))
    True
    """
    return flint.arb(flint.fmpq(value.numerator, value.denominator))


def refined(mp: Any, compute: Callable[[], Sequence[Any]]) -> list[Any]:
    """The midpoints of `compute()` as numbers of `mp`, proved to the precision that `mp` has.

    `compute` is called at increasing precision until each ball is narrower than the last bit of its component, or than
    2**-130 times the last bit of the largest component. Raises ArithmeticError where 2**17 bits are not enough.
    """
    wanted = mp.prec + 4
    bits = wanted + 30
    while bits <= MOST_BITS:
        with precision(bits):
            values = list(compute())
            if all(x.is_finite() for x in values) and _sharp(values, wanted):
                return [mp.mpf(dyadic(x)) for x in values]
        bits += bits // 2
    raise ArithmeticError(f"{MOST_BITS} bits do not determine the digits of {values}")


def sign(compute: Callable[[], Any]) -> int:
    """The sign of `compute()`, at the precision that decides it; 0 only where the ball is exactly zero.

    Raises ArithmeticError where 2**13 bits do not decide: test first, in rational numbers, whether it can be zero.
    """
    bits = 64
    while bits <= 2**13:
        with precision(bits):
            value = compute()
            if value > 0:
                return 1
            if value < 0:
                return -1
            if value.is_zero():
                return 0
        bits *= 2
    raise ArithmeticError(f"{value} cannot be distinguished from zero")


def floor_of(compute: Callable[[], Any]) -> int:
    """The floor of `compute()`, at the precision that decides it; ArithmeticError where it may be an integer itself."""
    bits = 64
    while bits <= 2**13:
        with precision(bits):
            whole = compute().floor().unique_fmpz()
        if whole is not None:
            return int(whole)
        bits *= 2
    raise ArithmeticError("a number cannot be distinguished from an integer")


def nearest_integer(x: Any) -> int:
    """The integer nearest to the midpoint of a ball; 0 if it is not finite."""
    with precision(max(64, flint.ctx.prec)):
        whole = (x.mid() + flint.arb(0.5)).floor().unique_fmpz() if x.is_finite() else 0
    return int(whole) if whole is not None else 0


def as_ball(value: Any) -> Any:
    """The exact value of an mpf as a ball without radius."""
    sign, mantissa, exponent, _bits = value._mpf_
    return flint.arb((-int(mantissa) if sign else int(mantissa), int(exponent)))


def dyadic(x: Any) -> tuple[int, int]:
    """Mantissa and exponent (of 2) of the midpoint of a ball, which an mpf takes exactly."""
    mantissa, exponent = x.mid().man_exp()
    return int(mantissa), int(exponent)


def _sharp(values: Sequence[Any], wanted: int) -> bool:
    largest = max((abs(x.mid()) for x in values), default=flint.arb(0))
    floor = (largest * flint.arb(2) ** -(wanted + SMALL)).max(flint.arb(2) ** -ZERO_BITS)
    return all(x.rel_accuracy_bits() >= wanted or x.rad() <= floor for x in values)
