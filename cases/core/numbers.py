"""The numbers of a case: their names, units and meaning, their ranges, and the rules that join several of them."""

import difflib
import fnmatch
import math
import re
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from gnomon.reference.numerics.precision import Number, exact

FEW = 20
"""The most valid names that an error message lists."""
LARGEST, SMALLEST = max(Fraction(10) ** 300, Fraction(1e300)), min(Fraction(1, 10**300), Fraction(1e-300))
"""Limits of the size of a number that is not 0, given as text or as a double: closer to the limits of binary64 a
square root or a quotient may overflow or underflow."""
TINY = Fraction(1, 10**3)
"""A number below this fraction of its typical range is unusual: the error about a missing exact motion names it."""


@dataclass(frozen=True)
class Range:
    """The allowed interval of one number, and the typical one.

    Parameters
    ----------
    low, high : float
        Ends of the allowed interval; infinite by default.
    low_open, high_open : bool
        Whether an end does not belong to it.
    typical : tuple[float, float]
        The interval from which tests and searches draw at random.

    Examples
    --------
    >>> print(Range(0.0, 1.0, high_open=True))
    [0, 1)
    """

    low: float = -math.inf
    high: float = math.inf
    low_open: bool = False
    high_open: bool = False
    typical: tuple[float, float] = (-10.0, 10.0)

    def admits(self, value: Fraction) -> bool:
        above = value > self.low if self.low_open else value >= self.low
        below = value < self.high if self.high_open else value <= self.high
        return above and below

    def __str__(self) -> str:
        left, right = (
            "(" if self.low_open or self.low == -math.inf else "[",
            ")" if self.high_open or self.high == math.inf else "]",
        )
        return f"{left}{self.low:g}, {self.high:g}{right}"


def typical(low: float, high: float) -> Range:
    """Any number; tests and searches draw from [low, high].

    Parameters
    ----------
    low, high : float
        The interval.

    Returns
    -------
    Range
        For the argument `range` of a `Coordinate` or `Parameter`.

    Examples
    --------
    >>> typical(-7, 7).admits(Fraction(100))
    True
    """
    return Range(typical=(float(low), float(high)))


def positive(low: float = 0.1, high: float = 10.0) -> Range:
    """A number above zero; tests and searches draw from [low, high].

    Parameters
    ----------
    low, high : float
        The interval.

    Returns
    -------
    Range
        For the argument `range` of a `Coordinate` or `Parameter`.

    Examples
    --------
    >>> print(positive())
    (0, inf)
    """
    return Range(low=0.0, low_open=True, typical=(float(low), float(high)))


def nonnegative(low: float = 0.0, high: float = 10.0) -> Range:
    """Zero or a number above it; tests and searches draw from [low, high].

    Parameters
    ----------
    low, high : float
        The interval.

    Returns
    -------
    Range
        For the argument `range` of a `Coordinate` or `Parameter`.

    Examples
    --------
    >>> print(nonnegative())
    [0, inf)
    """
    return Range(low=0.0, typical=(float(low), float(high)))


DURATION = Range(low=0.0, low_open=True)


class OutOfReachError(ValueError, ArithmeticError):
    """The numbers are inside the domain, but their exact motion cannot be computed."""


@dataclass(frozen=True)
class Rule:
    """A rule that joins several numbers.

    Parameters
    ----------
    statement : str
        The rule in words, which the error names where it does not hold.
    holds : Callable
        Takes parameters and initial values as Fractions by name; returns whether they keep the rule.
    explain : Callable, optional
        Takes the same; says how they break the rule, and which numbers near to them keep it.

    Examples
    --------
    >>> above = Rule("the start is above the ground, y > 0", lambda n: n["y"] > 0)
    """

    statement: str
    holds: Callable[[Mapping[str, Fraction]], bool]
    explain: Callable[[Mapping[str, Fraction]], str | None] | None = None


@dataclass(frozen=True)
class Domain:
    """Which numbers a case admits: a Range for each parameter and initial value by name, and joint rules."""

    ranges: Mapping[str, Range]
    rules: tuple[Rule, ...] = ()

    def check(self, case: str, numbers: Mapping[str, Fraction]) -> None:
        """Raise ValueError that names the first number outside its range, or the first rule that does not hold."""
        for name, value in numbers.items():
            allowed = self.ranges.get(name, Range())
            if not allowed.admits(value):
                raise ValueError(f"{case}: {name} = {show(value)} is outside {allowed}")
        for rule in self.rules:
            if not rule.holds(numbers):
                listed = ", ".join(f"{name} = {show(value)}" for name, value in numbers.items())
                reason = rule.explain(numbers) if rule.explain is not None else None
                raise ValueError(
                    f"{case}: {rule.statement} does not hold for {listed}{f': {reason}' if reason else ''}"
                )

    def admits(self, numbers: Mapping[str, Fraction]) -> bool:
        return all(self.ranges.get(name, Range()).admits(value) for name, value in numbers.items()) and all(
            rule.holds(numbers) for rule in self.rules
        )

    def unusual(self, numbers: Mapping[str, Fraction]) -> str:
        """The message that the exact motion is out of reach: it names the numbers outside their typical ranges, or all."""
        outside = []
        for name, value in numbers.items():
            low, high = self.ranges.get(name, Range()).typical
            tiny = 0 < abs(value) < TINY * Fraction(max(-low, high))
            if tiny or not low <= value <= high:
                outside.append(f"{name} = {show(value)} (usual: {low:g} to {high:g})")
        named = ", ".join(outside) or ", ".join(f"{name} = {show(value)}" for name, value in numbers.items())
        return f"the exact motion is out of reach for {named}"

    def draw(self, names: Iterable[str], unit: Callable[[], float]) -> dict[str, float]:
        """Random admissible numbers from `unit()`, which returns floats in [0, 1).

        Raises ValueError if 1000 attempts do not meet the joint rules.
        """
        names = tuple(names)
        for _ in range(1000):
            numbers = {}
            for name in names:
                low, high = self.ranges.get(name, Range()).typical
                numbers[name] = low + (high - low) * unit()
            if self.admits({name: Fraction(value) for name, value in numbers.items()}):
                return numbers
        raise ValueError(f"no admissible numbers for {', '.join(names)} in 1000 attempts; narrow the typical ranges")


def show(value: Fraction) -> str:
    """A number as text: exact if that is short, else to 17 digits."""
    if value and (abs(value) > sys.float_info.max or float(value) == 0):
        decades = (value.numerator.bit_length() - value.denominator.bit_length()) * math.log10(2)
        return f"{'-' if value < 0 else ''}1e{decades:.0f} (about)"
    if value.denominator == 1 and abs(value.numerator) < 10**15:
        return str(value.numerator)
    shortest = repr(float(value))
    return shortest if Fraction(shortest) == value else f"{float(value):.17g}"


def given(value: Number, name: str, allowed: Range) -> Fraction:
    """The exact value of what a caller gave for `name`.

    Raises ValueError, which states the allowed range, if it is not a number, or too small or large for computations in
    binary64. A Fraction or an mpf may be arbitrarily small: decayed states of exact motions are.
    """
    try:
        number = exact(value, name)
    except ValueError as error:
        raise ValueError(f"{error}; allowed: {allowed}") from None
    small = 0 < abs(number) < SMALLEST and not (isinstance(value, Fraction) or hasattr(value, "_mpf_"))
    if small or abs(number) > LARGEST:
        raise ValueError(
            f"{name} = {show(number)} is too {'small' if small else 'large'}: it must be in {allowed}, and 0 or of size "
            "1e-300 to 1e300"
        )
    return number


def matching(pattern: str, names: Iterable[str]) -> list[str]:
    """The names that a pattern with * and ? selects, in their order; letters of either case. Raises ValueError for none."""
    names = list(names)
    form = re.compile(fnmatch.translate(pattern.replace("[", "[[]")), re.IGNORECASE)
    matches = [name for name in names if form.match(name)]
    if not matches:
        raise ValueError(f"nothing matches {pattern!r}; {nearest(pattern.strip('*?'), names)}")
    return matches


def is_pattern(name: str) -> bool:
    """Whether a name has a wildcard."""
    return "*" in name or "?" in name


def nearest(name: str, valid: Iterable[str]) -> str:
    """The hint for an unknown name: the valid names most like it, or all valid names if none is like it."""
    valid = sorted(valid)
    close = difflib.get_close_matches(name, valid, n=3, cutoff=0.5)
    if close:
        return f"did you mean {' or '.join(close)}?"
    shown = ", ".join(valid[:FEW])
    return (
        f"valid names: {shown}"
        if len(valid) <= FEW
        else f"valid names: {shown} ... {len(valid)} in all: see gnomon list"
    )
