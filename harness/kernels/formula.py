"""Equations as one writes them: powers, one fraction a term, and no factor 1, double sign or needless parenthesis.

`equation_text` keeps every operation for programs; here its expressions become sums of terms, which `write` writes in
a notation: `plain` for a terminal, `gnomon.harness.kernels.latex` for print.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Protocol

from gnomon.harness.kernels.equation_text import EquationText

SHORT = 3
"""Most names and numbers of a value that is written where it is used; a longer value gets a name."""
SMALL = 16
"""The largest denominator of a number that is written as a fraction."""


@dataclass(frozen=True)
class Term:
    """A number times powers of bases: names, calls of functions, and sums in parentheses."""

    number: Fraction
    factors: tuple[tuple[Base, Exponent], ...] = ()


@dataclass(frozen=True)
class Call:
    """A function of one or two arguments."""

    function: str
    arguments: tuple[Sum, ...]


Sum = tuple[Term, ...]
Base = str | Call | Sum
Exponent = Fraction | Sum


class Notation(Protocol):
    """The writer of the parts of a formula."""

    def symbol(self, name: str) -> str: ...

    def number(self, value: Fraction) -> str: ...

    def power(self, base: Base, exponent: str) -> str: ...

    def root(self, under: Sum) -> str: ...

    def call(self, call: Call) -> str: ...

    def enclosed(self, inner: Sum) -> str: ...

    def quotient(self, above: Sequence[str], below: Sequence[str], alone: tuple[Sum | None, Sum | None]) -> str: ...

    def product(self, factors: Sequence[str]) -> str: ...


def formulas(text: EquationText) -> tuple[dict[str, Sum], list[Sum]]:
    """(values by name, derivatives) of equations, as sums; a short value has no name and is written where it is used."""
    known: dict[str, Sum] = {}
    named: dict[str, Sum] = {}
    lines = [line.split(" = ") for line in text.where]
    free = iter([name for name, _ in lines])
    for name, expression in lines:
        value = read(expression, known)
        if _size(value) > SHORT - (len(value) > 1):
            shown = next(free)
            named[shown], value = value, _name(shown)
        known[name] = value
    return named, [read(expression, known) for expression in text.derivatives]


def read(expression: str, known: Mapping[str, Sum]) -> Sum:
    """An expression of `EquationText` as a sum, with values in the place of `known` names."""
    return _read(ast.parse(expression, mode="eval").body, known)


def _read(node: ast.expr, known: Mapping[str, Sum]) -> Sum:
    match node:
        case ast.Constant(value):
            return (Term(Fraction(repr(value))),) if value else ()
        case ast.Name(name):
            return known.get(name, _name(name))
        case ast.UnaryOp(_, x):
            return negative(_read(x, known))
        case ast.BinOp(x, operation, y):
            left, right = _read(x, known), _read(y, known)
            if isinstance(operation, ast.Add | ast.Sub):
                return left + (right if isinstance(operation, ast.Add) else negative(right))
            return product(left, right if isinstance(operation, ast.Mult) else power(right, Fraction(-1)))
        case ast.Call(ast.Name("sqrt"), [x]):
            return power(_read(x, known), Fraction(1, 2))
        case ast.Call(ast.Name("pow"), [x, y]):
            exponent = _read(y, known)
            constant = exponent[0].number if exponent and not exponent[0].factors and len(exponent) == 1 else None
            return power(_read(x, known), exponent if constant is None else constant)
        case ast.Call(ast.Name("atan"), [ast.Constant(1)]):
            return product((Term(Fraction(1, 4)),), _name("pi"))
        case ast.Call(ast.Name(name), arguments):
            call = Call(name, tuple(_read(x, known) for x in arguments))
            return (Term(Fraction(1), ((call, Fraction(1)),)),)
    raise ValueError(f"{ast.unparse(node)} has no formula; equations have + - * /, powers and functions")


def _name(name: str) -> Sum:
    """A name as a sum: one term, the first power of the name."""
    return (Term(Fraction(1), ((name, Fraction(1)),)),)


def negative(value: Sum) -> Sum:
    return tuple(replace(term, number=-term.number) for term in value)


def product(left: Sum, right: Sum) -> Sum:
    """The product, in which equal bases have one power."""
    if not (left and right):
        return ()
    number = Fraction(1)
    powers: dict[Base, Exponent] = {}
    for value in (left, right):
        term = value[0] if len(value) == 1 else _in_parentheses(value)
        number *= term.number
        for base, exponent in term.factors:
            former = powers.get(base, Fraction(0))
            if isinstance(former, Fraction) and isinstance(exponent, Fraction):
                powers[base] = former + exponent
            else:
                powers[base] = (*_sum(former), *_sum(exponent))
    return (Term(number, tuple((base, exponent) for base, exponent in powers.items() if exponent != 0)),)


def _in_parentheses(value: Sum) -> Term:
    """A sum as a factor; a sum without a positive term gives its sign to the term."""
    if all(term.number < 0 for term in value):
        return Term(Fraction(-1), ((negative(value), Fraction(1)),))
    return Term(Fraction(1), ((value, Fraction(1)),))


def power(value: Sum, exponent: Exponent) -> Sum:
    """A power. A root of a power stays one, because the root of x^2 is not x."""
    if not value:
        return ()
    if len(value) == 1:
        ((term,)) = value
        if term.number == 1 and len(term.factors) == 1 and term.factors[0][1] == 1:
            return (Term(Fraction(1), ((term.factors[0][0], exponent),)),)
        if isinstance(exponent, Fraction) and exponent.denominator == 1:
            raised = [(base, each * exponent) for base, each in term.factors if isinstance(each, Fraction)]
            if len(raised) == len(term.factors):
                return (Term(term.number**exponent.numerator, tuple(raised)),)
    return (Term(Fraction(1), ((value, exponent),)),)


def _sum(exponent: Exponent) -> Sum:
    return ((Term(exponent),) if exponent else ()) if isinstance(exponent, Fraction) else exponent


def _size(value: Sum) -> int:
    """The number of names and numbers."""
    return sum((abs(term.number) != 1) + sum(map(_leaves, term.factors)) for term in value)


def _leaves(factor: tuple[Base, Exponent]) -> int:
    base, exponent = factor
    inner = 1 if isinstance(base, str) else sum(map(_size, base.arguments)) if isinstance(base, Call) else _size(base)
    return inner + (0 if isinstance(exponent, Fraction) else _size(exponent))


def write(value: Sum, notation: Notation) -> str:
    """A sum in a notation; a positive term comes first."""
    first = next((k for k, term in enumerate(value) if term.number > 0), 0)
    text = ""
    for term in (*value[first : first + 1], *value[:first], *value[first + 1 :]):
        sign = "-" if term.number < 0 else "+" if text else ""
        text += (f" {sign} " if text else sign) + _term(replace(term, number=abs(term.number)), notation)
    return text or "0"


def _term(term: Term, notation: Notation) -> str:
    """A term without its sign. Functions follow a fraction of names and sums, as in g/L sin(theta)."""
    kinds = {str: 0, tuple: 1, Call: 2}
    factors = sorted(term.factors, key=lambda factor: (kinds[type(factor[0])], factor[0] != "pi"))
    below = [(base, -each) for base, each in factors if isinstance(each, Fraction) and each < 0]
    above = [(base, each) for base, each in factors if not (isinstance(each, Fraction) and each < 0)]
    as_fraction = term.number.denominator <= SMALL
    top = term.number.numerator if as_fraction else term.number
    bottom = term.number.denominator if as_fraction else 1
    front = [factor for factor in above if not isinstance(factor[0], Call)]
    apart = bool(front or top != 1) and all(isinstance(base, str) for base, _ in below)
    inside = front if apart and (below or bottom != 1) else above
    behind = [_factor(*factor, notation) for factor in above if factor not in inside]
    numbers = [[notation.number(Fraction(n))] if n != 1 else [] for n in (top, bottom)]
    up = numbers[0] + [_factor(*factor, notation) for factor in inside]
    down = numbers[1] + [_factor(*factor, notation) for factor in below]
    if not down:
        return notation.product([*up, *behind]) or notation.number(Fraction(1))
    alone = _alone(numbers[0], inside), _alone(numbers[1], below)
    return notation.product([notation.quotient(up or [notation.number(Fraction(1))], down, alone), *behind])


def _alone(number: list[str], factors: Sequence[tuple[Base, Exponent]]) -> Sum | None:
    """The sum that is the only factor, which needs no parentheses above or below a line."""
    if len(factors) == 1 and not number and factors[0][1] == 1 and isinstance(factors[0][0], tuple):
        return factors[0][0]
    return None


def _factor(base: Base, exponent: Exponent, notation: Notation) -> str:
    if exponent == Fraction(1, 2):
        return notation.root(base if isinstance(base, tuple) else (Term(Fraction(1), ((base, Fraction(1)),)),))
    if exponent != 1:
        text = str(exponent) if isinstance(exponent, Fraction) else write(exponent, notation)
        return notation.power(base, text)
    if isinstance(base, str):
        return notation.symbol(base)
    return notation.call(base) if isinstance(base, Call) else notation.enclosed(base)


class Plain:
    """The notation of a terminal: theta' = omega, omega' = -g/L sin(theta)."""

    def symbol(self, name: str) -> str:
        return name

    def number(self, value: Fraction) -> str:
        return str(value) if value.denominator == 1 and abs(value) < 10**6 else repr(float(value))

    def power(self, base: Base, exponent: str) -> str:
        inner = self.symbol(base) if isinstance(base, str) else (
            self.call(base) if isinstance(base, Call) else self.enclosed(base)
        )  # fmt: skip
        return f"{inner}^{exponent if exponent.isalnum() else f'({exponent})'}"

    def root(self, under: Sum) -> str:
        return f"sqrt({write(under, self)})"

    def call(self, call: Call) -> str:
        return f"{call.function}({', '.join(write(x, self) for x in call.arguments)})"

    def enclosed(self, inner: Sum) -> str:
        return f"({write(inner, self)})"

    def quotient(self, above: Sequence[str], below: Sequence[str], alone: tuple[Sum | None, Sum | None]) -> str:
        down = self.product(below)
        return f"{self.product(above)}/{f'({down})' if len(below) > 1 else down}"

    def product(self, factors: Sequence[str]) -> str:
        return " ".join(factors)


def plain(text: EquationText, before: Sequence[str]) -> Iterator[str]:
    """Lines for a terminal: each expression after its text of `before`, as "y' =", then the values that have a name."""
    named, derivatives = formulas(text)
    notation = Plain()
    for words, value in zip(before, derivatives, strict=True):
        yield f"{words} {write(value, notation)}"
    for name, value in named.items():
        yield f"  with {name} = {write(value, notation)}"
