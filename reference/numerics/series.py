"""Truncated power series, extended by one coefficient at a time with the classical recurrences.

Equations evaluated once on a tape's variables leave a list of nodes; each further coefficient then costs one inner
product a node. Works over any numbers with the four operations and, as methods, sqrt, exp, log, sin, cos, asin ...
(python-flint's arb). Recurrences: Griewank and Walther, Evaluating Derivatives (2008), chapter 13.
"""

from __future__ import annotations

from collections.abc import Callable
from operator import mul
from typing import Any

Rule = Callable[[int], Any]
"""k -> coefficient k, from coefficients of the operands up to k and its own below k."""


class Tape:
    """The nodes of an expression in the sequence of their creation, and the zero of their number type."""

    def __init__(self, zero: Any) -> None:
        self.zero = zero
        self.nodes: list[Series] = []

    def node(self, rule: Rule) -> Series:
        series = Series(self, rule)
        self.nodes.append(series)
        return series

    def variable(self) -> Series:
        """A series whose coefficients the caller sets."""
        return Series(self, None)

    def extend(self, k: int) -> None:
        """Append coefficient k to every node; the variables must have theirs already."""
        for node in self.nodes:
            assert node.rule is not None
            node.c.append(node.rule(k))

    def clear(self) -> None:
        for node in self.nodes:
            node.c.clear()

    def inner(self, a: list[Any], b: list[Any], first: int, last: int, k: int) -> Any:
        """The sum of a[i] b[k-i] for i from `first` to `last`."""
        if last < first:
            return self.zero
        stop = k - last - 1
        return sum(map(mul, a[first : last + 1], b[k - first : stop if stop >= 0 else None : -1]), self.zero)

    def square(self, a: list[Any], first: int, last: int, k: int) -> Any:
        """The sum of a[i] a[k-i] for i from `first` to `last` = k - `first`: each product of two members once."""
        half = (k - 1) // 2
        twice = 2 * self.inner(a, a, first, half, k)
        return twice + a[k // 2] * a[k // 2] if k % 2 == 0 and first <= k // 2 <= last else twice

    def weighted(self, slopes: list[Any], b: list[Any], k: int) -> Any:
        """The sum of i a[i] b[k-i] for i from 1 to k, over k, with slopes[i] = i a[i]: the integral of a' b."""
        return self.inner(slopes, b, 1, k, k) / k


class Series:
    """One power series on a tape, with the arithmetic of equations."""

    def __init__(self, tape: Tape, rule: Rule | None) -> None:
        self.tape = tape
        self.rule = rule
        self.c: list[Any] = []

    def __add__(self, other: Any) -> Series:
        a = self.c
        if isinstance(other, Series):
            b = other.c
            return self.tape.node(lambda k: a[k] + b[k])
        return self.tape.node(lambda k: a[k] + other if k == 0 else a[k])

    __radd__ = __add__

    def __neg__(self) -> Series:
        return self * -1

    def __pos__(self) -> Series:
        return self

    def __sub__(self, other: Any) -> Series:
        if not isinstance(other, Series):
            return self.__add__(-other)
        a, b = self.c, other.c
        return self.tape.node(lambda k: a[k] - b[k])

    def __rsub__(self, other: Any) -> Series:
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> Series:
        a = self.c
        if isinstance(other, Series):
            b = other.c
            if b is a:
                return self.tape.node(lambda k: self.tape.square(a, 0, k, k))
            return self.tape.node(lambda k: self.tape.inner(a, b, 0, k, k))
        return self.tape.node(lambda k: a[k] * other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Series:
        if isinstance(other, Series):
            return other._divide(lambda k: self.c[k])
        a = self.c
        return self.tape.node(lambda k: a[k] / other)

    def __rtruediv__(self, other: Any) -> Series:
        return self._divide(lambda k: other if k == 0 else self.tape.zero)

    def _divide(self, numerator: Rule) -> Series:
        b = self.c
        quotient = self.tape.node(lambda k: (numerator(k) - self.tape.inner(b, quotient.c, 1, k, k)) / b[0])
        return quotient

    def __pow__(self, power: Any) -> Series:
        """A constant power; unless it is an integer >= 0 the base must not start at zero."""
        if isinstance(power, int) and power >= 0:
            result = self.tape.node(lambda k: self.tape.zero + (1 if k == 0 else 0)) if power == 0 else self
            for _ in range(power - 1):
                result = result * self
            return result
        if isinstance(power, int):
            return 1 / self**-power
        a = self.c

        def rule(k: int) -> Any:
            if k == 0:
                return a[0] ** power
            terms = ((power * i - (k - i)) * a[i] * result.c[k - i] for i in range(1, k + 1))
            return sum(terms, self.tape.zero) / (k * a[0])

        result = self.tape.node(rule)
        return result

    def sqrt(self) -> Series:
        a = self.c

        def rule(k: int) -> Any:
            if k == 0:
                return a[0].sqrt()
            return (a[k] - self.tape.square(root.c, 1, k - 1, k)) / (2 * root.c[0])

        root = self.tape.node(rule)
        return root

    def exp(self) -> Series:
        a, slopes = self.c, self._slopes()
        result = self.tape.node(lambda k: self.tape.weighted(slopes, result.c, k) if k else a[0].exp())
        return result

    def sin(self) -> Series:
        return self._circular()[0]

    def cos(self) -> Series:
        return self._circular()[1]

    def tan(self) -> Series:
        sine, cosine = self._circular()
        return sine / cosine

    def sinh(self) -> Series:
        return (self.exp() - (-self).exp()) / 2

    def cosh(self) -> Series:
        return (self.exp() + (-self).exp()) / 2

    def tanh(self) -> Series:
        return 1 - 2 / ((2 * self).exp() + 1)

    def _circular(self) -> tuple[Series, Series]:
        a, slopes = self.c, self._slopes()
        sine = self.tape.node(lambda k: self.tape.weighted(slopes, cosine.c, k) if k else a[0].sin())
        cosine = self.tape.node(lambda k: -self.tape.weighted(slopes, sine.c, k) if k else a[0].cos())
        return sine, cosine

    def log(self) -> Series:
        return self._integral(1 / self, "log")

    def atan(self) -> Series:
        return self._integral(1 / (1 + self * self), "atan")

    def asin(self) -> Series:
        return self._integral(1 / (1 - self * self).sqrt(), "asin")

    def acos(self) -> Series:
        return self._integral(-1 / (1 - self * self).sqrt(), "acos")

    def asinh(self) -> Series:
        return self._integral(1 / (1 + self * self).sqrt(), "asinh")

    def _integral(self, derivative: Series, name: str) -> Series:
        """A function: its first coefficient by its name, the others from its derivative."""
        a, slopes = self.c, self._slopes()
        return self.tape.node(lambda k: self.tape.weighted(slopes, derivative.c, k) if k else getattr(a[0], name)())

    def _slopes(self) -> list[Any]:
        """The coefficients k a[k], which grow with a."""
        a = self.c
        return self.tape.node(lambda k: a[k] * k).c
