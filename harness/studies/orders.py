"""Measures the convergence order of every in-house method, for the published table: in binary64 up to order 8, in more
digits above.

A method that chooses its own steps is measured at fixed steps, with the formula that propagates its solution.

`python -m gnomon.harness.studies.orders --to reports/local/orders.json` is part of `make bench`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from gnomon.cases.core.case import Case
from gnomon.cases.core.registry import get
from gnomon.harness.contract.declared import declared
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.integrators.base.fixed_step import DIGITS, FixedStep
from gnomon.harness.integrators.taylor.taylor import Taylor
from gnomon.harness.registry import lookup
from gnomon.harness.results.measured_rows import publish
from gnomon.harness.studies.fixed_step_formulas import at_fixed_steps, taylor_steps
from gnomon.harness.studies.order_measurement import fit_order_exactly, measure_order, measure_order_exactly
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


SUBJECTS = [
    Subject(name, **row) for row in declared("studies", "orders.toml")["subjects"] for name in row.pop("integrators")
]


def measured(subject: Subject) -> dict[str, Any]:
    """A row of the published table. Raises RuntimeError if fewer than four steps are in the asymptotic range."""
    integrator = lookup.own()[f"gnomon:{subject.integrator}"]
    twin = at_fixed_steps(integrator)
    case = get(subject.case, subject.variant, span=subject.span)
    found = order_of(subject, twin, case)
    if found is None:
        raise RuntimeError(f"no range of steps shows the order of {subject.integrator} on {subject.case}")
    return {
        "integrator": subject.integrator,
        "case": subject.case + (f"/{subject.variant}" if subject.variant else ""),
        "span": float(case.span),
        "digits": subject.digits if subject.counts else BINARY64,
        "at_fixed_steps": twin is not integrator or isinstance(integrator, Taylor),
        "points": found[1],
        "order": found[0],
        "declared": integrator.order,
        "keeps": list(integrator.conserves),
    }


def order_of(subject: Subject, twin: Integrator, case: Case) -> tuple[float, int] | None:
    if subject.scattered:
        return scattered_order(twin, case)
    if not subject.counts:
        return measure_order(twin, case, subject.most_steps)
    if isinstance(twin, Taylor):
        with working(subject.digits) as mp:
            return fit_order_exactly(
                lambda count: taylor_steps(mp, case, twin.order, count), case, subject.counts, subject.digits
            )
    assert isinstance(twin, FixedStep)
    return measure_order_exactly(twin, case, subject.counts, subject.digits)


def scattered_order(integrator: Integrator, case: Case) -> tuple[float, int]:
    """The slope over fifty step sizes, for a method whose errors scatter from one step size to the next."""
    case = case.rounded()
    problem, exact, start = problem_of(case, integrator.accepts), case.sample(case.times), initial_state(case)[None]
    errors = []
    for count in SCATTERED:
        states = integrator.prepare(problem, problem.interval / count)(start.copy()).states[0]
        errors.append(float(np.max(case.metric.distance(states, exact, case.times))))
    return -float(np.polyfit(np.log(SCATTERED), np.log(errors), 1)[0]), len(SCATTERED)


def main() -> None:
    publish(__doc__, measured, SUBJECTS)


if __name__ == "__main__":
    main()
