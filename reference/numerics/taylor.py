"""Motions by Taylor series in high precision: a reference solution that shares no formula with the closed forms.

The coefficients follow from the equations alone, one degree at a time, over python-flint's balls; order and step are
from Jorba and Zou (Experimental Mathematics 14, 2005). Each step keeps only the midpoints of the balls: the result
is not an enclosure, and its digits are confirmed by a second run at another precision.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, dyadic, precision
from gnomon.reference.numerics.series import Series, Tape

Field = Callable[[Any, tuple[Any, ...]], tuple[Any, ...]]
"""(t, state) -> derivatives, over series of balls."""

MAX_STEPS = 100_000
WIDEST = 690
"""A step lasts exp(-690) to exp(690) s, 1e-300 to 1e300 s: as far as spans go."""


_OF_SERIES: dict[str, Callable[[Any], Any]] = {
    "sinh": lambda x: (x.exp() - (-x).exp()) / 2,
    "cosh": lambda x: (x.exp() + (-x).exp()) / 2,
    "tanh": lambda x: 1 - 2 / ((2 * x).exp() + 1),
    "asinh": lambda x: (x + (x * x + 1).sqrt()).log(),
}
"""Functions that flint has for balls only."""


def flint_arithmetic() -> dict[str, Callable[..., Any]]:
    """The functions of `math` on balls and on series over balls."""

    def method(name: str) -> Callable[[Any], Any]:
        def evaluate(x: Any) -> Any:
            if isinstance(x, flint.arb_series) and name in _OF_SERIES:
                return _OF_SERIES[name](x)
            return getattr(x if hasattr(x, name) else flint.arb(x), name)()

        return evaluate

    names = ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "sqrt", "exp", "log")
    functions: dict[str, Callable[..., Any]] = {name: method(name) for name in names}
    functions["hypot"] = lambda x, y: functions["sqrt"](x * x + y * y)
    return functions


def integrate(
    field: Field, state: Sequence[Fraction], times: Sequence[Fraction], digits: int
) -> list[tuple[Fraction, ...]]:
    """States at increasing `times` from `state` at t = 0, each step's truncation below 10**-digits of the state.

    Returned as exact dyadic fractions. Raises ArithmeticError where a series is not finite, or for too many steps.
    """
    order = math.ceil(digits * math.log(10) / 2) + 2
    with precision(math.ceil((digits + 10) * math.log2(10))):
        now = Fraction(0)
        here = [ball(x) for x in state]
        flow = _Flow(field, len(here))
        states = []
        steps = 0
        for time in times:
            while now < time:
                series = flow.series(now, here, order)
                step = min(_step(series, order), time - now)
                here = [_value(coefficients, step) for coefficients in series]
                now += step
                steps += 1
                if steps > MAX_STEPS:
                    raise ArithmeticError(f"more than {MAX_STEPS} Taylor steps, at t = {float(now):g}")
            states.append(tuple(_fraction(x) for x in here))
        return states


class _Flow:
    """Taylor coefficients of the solution through any state: y_{k+1} = f(y)_k / (k+1)."""

    def __init__(self, field: Field, dimension: int) -> None:
        self.tape = Tape(flint.arb(0))
        self.time = self.tape.variable()
        self.state = tuple(self.tape.variable() for _ in range(dimension))
        self.rates = field(self.time, self.state)

    def series(self, now: Fraction, here: list[Any], order: int) -> list[list[Any]]:
        """Coefficients up to `order` for each component, lowest first."""
        zero = self.tape.zero
        self.tape.clear()
        self.time.c[:] = [ball(now), flint.arb(1)] + [zero] * order
        for y, x in zip(self.state, here, strict=True):
            y.c[:] = [x]
        for k in range(order):
            self.tape.extend(k)
            for y, rate in zip(self.state, self.rates, strict=True):
                term = rate.c[k] if isinstance(rate, Series) else (flint.arb(rate) if k == 0 else zero)
                y.c.append(term.mid() / (k + 1))
        return [y.c for y in self.state]


def _step(series: list[list[Any]], order: int) -> Fraction:
    """The radius of convergence, estimated from the last two coefficients, over e^2; dyadic: sums of many stay short."""
    levels = (max(_magnitude(coefficients[k]) for coefficients in series) for k in range(order))
    size = next((level for level in levels if level != -math.inf), 0.0)  # a start at zero has the size of its rate
    logs = []
    for k in (order - 1, order):
        largest = max(_magnitude(coefficients[k]) for coefficients in series)
        if largest != -math.inf:
            logs.append((size - largest) / k)
    if not logs:
        return Fraction(2**60)  # a polynomial motion: any step is exact
    exponent = min(logs) - 2
    if not -WIDEST < exponent < WIDEST:
        raise ArithmeticError(f"a Taylor step would last about 1e{exponent / math.log(10):.0f} s")
    return Fraction(math.exp(exponent))


def _magnitude(x: Any) -> float:
    """Natural logarithm of |x|, -inf at zero; wide exponents do not overflow."""
    if not x.is_finite():
        raise ArithmeticError("a Taylor coefficient is not finite")
    mantissa, exponent = abs(x.mid()).man_exp()
    return -math.inf if mantissa == 0 else math.log(int(mantissa)) + int(exponent) * math.log(2)


def _value(coefficients: list[Any], step: Fraction) -> Any:
    """Horner's rule at `step`, midpoint only."""
    h = ball(step)
    total = coefficients[-1]
    for coefficient in reversed(coefficients[:-1]):
        total = total * h + coefficient
    return total.mid()


def _fraction(x: Any) -> Fraction:
    mantissa, exponent = dyadic(x)
    return mantissa * Fraction(2) ** exponent
