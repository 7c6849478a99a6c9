"""Measures convergence orders: of one method on one case by running it, and of every in-house method, for the published table.

Up to order 8, binary64 has an asymptotic range. For higher orders the same step function runs in 60-digit arithmetic,
with coefficients of as many digits; the binary64 table is these coefficients, rounded. A method that chooses its own steps
is measured at fixed steps, with the formula that propagates its solution. The order is fitted by
`results.convergence_order`, as the orders of a run are.

`python -m gnomon.harness.studies.orders --out reports/local/orders.json` is part of `make bench`.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import FirstOrder, Form, SecondOrder
from gnomon.cases.core.registry import get
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.problem import find_accepted_form
from gnomon.harness.integrators.base.fixed_step import DIGITS, FixedStep
from gnomon.harness.integrators.base.stepping import StepData
from gnomon.harness.integrators.runge_kutta.embedded import Embedded
from gnomon.harness.integrators.runge_kutta.nystrom import Nystrom
from gnomon.harness.integrators.taylor.taylor import Taylor
from gnomon.harness.measuring.reference_solution import ReferenceSolution
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.measuring.solved import solve_within
from gnomon.harness.registry import lookup
from gnomon.harness.results.convergence_order import fit_order
from gnomon.harness.results.study_file import publish
from gnomon.harness.studies.fixed_step_formulas import at_fixed_steps, taylor_steps
from gnomon.reference.numerics.precision import working

WITHIN = 0.1
"""Tolerance between measured and declared order: at the finest steps the next term of the error changes the slope by
less."""

BINARY64 = 16
"""Digits of a row that is measured in binary64."""

SCATTERED = tuple(sorted({round(2 ** (k / 4)) for k in range(8, 60)}))
"""Numbers of steps in a sampling interval for a method whose error is C h within a factor of about five, which depends
on the place of an event in its step. Over fifty of them, four to a halving, the uncertainty of the slope is ln 5 /
(sqrt 50 * 2.6) = 0.09."""


@dataclass(frozen=True)
class Subject:
    """An in-house integrator by its name, and the problem on which its order is measured.

    `coarsest`: the smallest number of steps over the span, in `digits` digits; 0 for binary64. `most_steps`: limit in
    binary64. `scattered`: whether the slope is fitted over the steps of SCATTERED.
    """

    integrator: str
    case: str = "pendulum_simple"
    variant: str | None = None
    span: str | None = None
    coarsest: int = 0
    digits: int = DIGITS
    most_steps: int = 300_000
    scattered: bool = False

    @property
    def counts(self) -> tuple[int, ...]:
        """Numbers of steps over the span, refined by halves and thirds; empty for binary64."""
        return tuple(self.coarsest * n // 12 for n in (12, 16, 24, 32) if self.coarsest)


def subjects_of(methods: Iterable[Integrator]) -> list[Subject]:
    """The subjects of methods: as orders.toml lists them, or by the defaults of this file; none for a method without either."""
    table = read_declared("studies", "orders.toml")
    listed = {name: Subject(name, **row) for row in table["subjects"] for name in row.pop("integrators")}
    subjects = (listed.get(method.id.removeprefix("gnomon:")) or _find_default(method, table) for method in methods)
    return [subject for subject in subjects if subject is not None]


def _find_default(method: Integrator, table: Mapping[str, Any]) -> Subject | None:
    if not {FirstOrder, SecondOrder} & {*method.accepts} or method.order is None:
        return None
    if isinstance(method, Embedded | Nystrom):
        return Subject(method.name, **table["pairs"])
    spans = [span for order, span in table["spans"].items() if method.order <= int(order)]
    return Subject(method.name, span=spans[0]) if isinstance(method, FixedStep) and spans else None


SUBJECTS = subjects_of(lookup.in_house())


def measure_row(subject: Subject) -> dict[str, Any]:
    """A row of the published table. Raises RuntimeError if fewer than four steps are in the asymptotic range."""
    integrator = lookup.own()[f"gnomon:{subject.integrator}"]
    twin = at_fixed_steps(integrator)
    case = get(subject.case, subject.variant, span=subject.span)
    fit = order_of(subject, twin, case)
    if fit is None:
        raise RuntimeError(f"no range of steps shows the order of {subject.integrator} on {subject.case}")
    return {
        "integrator": subject.integrator,
        "case": subject.case + (f"/{subject.variant}" if subject.variant else ""),
        "span": float(case.span),
        "digits": subject.digits if subject.counts else BINARY64,
        "at_fixed_steps": twin is not integrator or isinstance(integrator, Taylor),
        "points": fit[1],
        "order": fit[0],
        "declared": integrator.order,
        "keeps": list(integrator.conserves),
    }


def order_of(subject: Subject, twin: Integrator, case: Case) -> tuple[float, int] | None:
    if subject.scattered:
        return fit_scattered_order(twin, case)
    if not subject.counts:
        return measure_order(twin, case, subject.most_steps)
    if isinstance(twin, Taylor):
        with working(subject.digits) as mp:
            return fit_order_exactly(
                lambda count: taylor_steps(mp, case, twin.order, count), case, subject.counts, subject.digits
            )
    assert isinstance(twin, FixedStep)
    return measure_order_exactly(twin, case, subject.counts, subject.digits)


def fit_scattered_order(integrator: Integrator, case: Case) -> tuple[float, int]:
    """The slope over fifty step sizes, for a method whose errors scatter from one step size to the next."""
    _, interval, error = _on_case(integrator, case)
    errors = [error(interval / count) for count in SCATTERED]
    return -float(np.polyfit(np.log(SCATTERED), np.log(errors), 1)[0]), len(SCATTERED)


def measure_order(integrator: Integrator, case: Case, most_steps: int = 300_000) -> tuple[float, int] | None:
    """The order of a fixed-step integrator on a case, in binary64, and the number of points it was fitted to.

    The step is refined by halves and thirds (1, 2, 3, 4, 6, 8, ... steps for a sampling interval) until the error
    reaches round-off, or `most_steps` is passed. Round-off is estimated as the case's conditioning, multiplied by the
    square root of the number of steps if they are summed without compensation.
    """
    reference, interval, error = _on_case(integrator, case)
    samples, attainable = len(reference.times), float(np.max(reference.conditioning))
    steps, errors, floors = [], [], []
    for count in _counts(most_steps // samples):
        steps.append(interval / count)
        errors.append(error(steps[-1]))
        floors.append(attainable * math.sqrt(1 if integrator.compensated else count * samples))
        if errors[-1] < floors[-1]:
            break
    return fit_order(steps, errors, floors)


def _on_case(integrator: Integrator, case: Case) -> tuple[ReferenceSolution, float, Callable[[float], float]]:
    """The reference solution, the sampling interval, and the largest error as a function of the step size."""
    scorer = Scorer.of(case.rounded())
    problem, start = scorer.problem(find_accepted_form(case, integrator.accepts)), scorer.reference.start[None]

    def error(step: float) -> float:
        return scorer.largest_error(solve_within(integrator, problem, step, start).states[0])

    return scorer.reference, problem.interval, error


def _counts(most: int) -> list[int]:
    powers = [2**k for k in range(most.bit_length())]
    return sorted(n for n in {*powers, *(3 * k for k in powers)} if n <= most)


def measure_order_exactly(
    method: FixedStep, case: Case, counts: Sequence[int], digits: int = DIGITS
) -> tuple[float, int] | None:
    """The order over steps of span / count, in `digits`-digit arithmetic, from the error at the end of the span."""
    form = find_accepted_form(case, method.accepts)
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
        (inputs, outputs), stored = method.shape(form, len(y), len(p))
        x, slope = _zeros(mp, (inputs,)), _zeros(mp, (outputs,))
        store, increment = _zeros(mp, (stored, len(y))), _zeros(mp, (len(y),))
        s = StepData(f, y, p, table, x, slope, store, increment)
        for k in range(count):
            if not step(s, k * h, h):
                raise ArithmeticError(f"step {k} of {method.name} could not be made")
            y += increment
        return tuple(y)


def _zeros(mp: Any, shape: tuple[int, ...]) -> Any:
    return np.full(shape, mp.mpf(0), dtype=object)


def main() -> None:
    publish(__doc__, measure_row, SUBJECTS)


if __name__ == "__main__":
    main()
