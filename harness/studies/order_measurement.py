"""Measures the convergence order of one method on one case by running it.

Up to order 8, binary64 has an asymptotic range. For higher orders the same step function runs in 60-digit arithmetic,
with coefficients of as many digits; the binary64 table is these coefficients, rounded.
"""

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import Form
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.problem import accepted_form, initial_state, problem_of
from gnomon.harness.integrators.base.fixed_step import DIGITS, FixedStep
from gnomon.harness.results.convergence_order import fit_order
from gnomon.reference.numerics.precision import working


def measure_order(integrator: Integrator, case: Case, most_steps: int = 300_000) -> tuple[float, int] | None:
    """The order of a fixed-step integrator on a case, in binary64, and the number of points it was fitted to.

    The step is refined by halves and thirds (1, 2, 3, 4, 6, 8, ... steps for a sampling interval) until the error
    reaches round-off, or `most_steps` is passed. Round-off is estimated as the case's conditioning, multiplied by the
    square root of the number of steps if they are summed without compensation.
    """
    case = case.rounded()
    problem = problem_of(case, integrator.accepts)
    exact, start = case.sample(case.times), initial_state(case)[None]
    attainable = float(np.max(case.conditioning(case.times)))
    steps, errors, floors = [], [], []
    for count in _counts(most_steps // len(case.times)):
        h = problem.interval / count
        states = integrator.prepare(problem, h)(start.copy()).states[0]
        steps.append(h)
        errors.append(float(np.max(case.metric.distance(states, exact, case.times))))
        summed = 1 if integrator.compensated else count * len(case.times)
        floors.append(attainable * math.sqrt(summed))
        if errors[-1] < floors[-1]:
            break
    return fit_order(steps, errors, floors)


def _counts(most: int) -> list[int]:
    powers = [2**k for k in range(most.bit_length())]
    return sorted(n for n in {*powers, *(3 * k for k in powers)} if n <= most)


def measure_order_exactly(
    method: FixedStep, case: Case, counts: Sequence[int], digits: int = DIGITS
) -> tuple[float, int] | None:
    """The order of a method in `digits`-digit arithmetic, from errors at the end of the span; steps of span / count."""
    form = accepted_form(case, method.accepts)
    assert form is not None

    def end(count: int) -> Sequence[Any]:
        numbers = case.parameter_values(), case.initial_state
        return solve_exactly(method, form, *numbers, case.span, count, digits)  # type: ignore[arg-type]

    return fit_order_exactly(end, case, counts, digits)


def fit_order_exactly(
    end: Callable[[int], Sequence[Any]], case: Case, counts: Sequence[int], digits: int = DIGITS
) -> tuple[float, int] | None:
    """The order fitted to the states `end(count)` that a method reaches at the end of the span after `count` steps."""
    with working(digits) as mp:
        exact = case.exact(case.span, digits - 10)
        sizes = [max(abs(x), mp.mpf(1)) for x in exact]
        errors = [
            float(max(abs(a - b) / s for a, b, s in zip(end(count), exact, sizes, strict=True))) for count in counts
        ]
    return fit_order([float(case.span) / count for count in counts], errors, 10.0 ** (10 - digits))


def solve_exactly(
    method: FixedStep,
    form: Form,
    parameters: Sequence[Fraction],
    initial: Sequence[Fraction],
    span: Fraction,
    count: int,
    digits: int = DIGITS,
) -> tuple[Any, ...]:
    """The state after `count` equal steps over the span, by the method's own step function on mpmath numbers."""
    with working(digits) as mp:

        def number(x: Fraction) -> Any:
            return mp.mpf(x.numerator) / x.denominator

        p = [number(x) for x in parameters]
        y = np.array([number(x) for x in initial], dtype=object)
        h = number(span) / count
        arithmetic = mpmath_arithmetic(mp)
        step, f = rebind(method.step_for(form), arithmetic), rebind(method.equations(form), arithmetic)
        rows = method.table_for(mp, form, p, mp.eps, h)
        table = _zeros(mp, (len(rows), max(map(len, rows))))
        for row, values in zip(table, rows, strict=True):
            row[: len(values)] = values
        inputs, outputs = method.widths(form, len(y))
        x, slope = _zeros(mp, (inputs,)), _zeros(mp, (outputs,))
        store, increment = _zeros(mp, (method.rows(form), len(y))), _zeros(mp, (len(y),))
        for k in range(count):
            if not step(f, k * h, h, y, p, table, x, slope, store, increment):
                raise ArithmeticError(f"step {k} of {method.name} could not be made")
            y = y + increment
        return tuple(y)


def _zeros(mp: Any, shape: tuple[int, ...]) -> Any:
    return np.full(shape, mp.mpf(0), dtype=object)
