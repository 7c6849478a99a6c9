"""Measures the convergence order of every in-house method, for the published table: in binary64 up to order 8, in more
digits above.

A method that chooses its own steps is measured at fixed steps, with the formula that propagates its solution.

`python -m gnomon.harness.studies.orders --to reports/local/orders.json` is part of `make bench`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from gnomon.cases.core.case import Case
from gnomon.cases.core.registry import get
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
on where in a step an event falls. Over fifty of them, four to a halving, the uncertainty of the slope is
ln 5 / (sqrt 50 * 2.6) = 0.09."""


@dataclass(frozen=True)
class Subject:
    """An in-house integrator by its name, and the problem on which its order is measured.

    `counts`: numbers of steps over the span, in `digits` digits; empty for binary64. `most_steps`: limit in binary64.
    `scattered`: whether the slope is fitted over the steps of SCATTERED.
    """

    integrator: str
    case: str = "pendulum_simple"
    variant: str | None = None
    span: str | None = None
    counts: tuple[int, ...] = ()
    digits: int = DIGITS
    most_steps: int = 300_000
    scattered: bool = False


def each(*names: str, **more: Any) -> list[Subject]:
    return [Subject(name, **more) for name in names]


def counts(coarsest: int) -> tuple[int, ...]:
    """Numbers of steps over the span, refined by halves and thirds."""
    return tuple(coarsest * n // 12 for n in (12, 16, 24, 32))


ORBIT: dict[str, Any] = {"case": "kepler_orbit", "span": "0.5"}
"""A short part of an orbit: at steps of hundredths of its time scale the leading term of the error dominates."""

SUBJECTS = [
    # The span is short, but longer for a high order, whose errors must be well above round-off.
    *each("Explicit Euler", "Explicit midpoint", "Heun", "RK3", "RK4", span="3"),
    *each("Symplectic Euler", "Störmer-Verlet", "Position Verlet", span="3"),
    *each("Forest-Ruth 4", "McLachlan-Atela 4", "Suzuki 4", "Blanes-Moan 4", span="3"),
    *each("Yoshida 6", "Kahan-Li 6", "Blanes-Moan 6", span="8"),
    *each("Yoshida 8", "Kahan-Li 8", span="16"),
    *each("Implicit midpoint", "Gauss 2-stage", span="3"),
    *each("Gauss 3-stage", span="8"),
    *each("Gauss 4-stage", span="16"),
    *each("Gauss 5-stage", "Gauss 6-stage", "Gauss 7-stage", "Gauss 8-stage", span="0.25", counts=counts(8)),
    *each("Gauss 8-stage SIMD", span="0.25", counts=counts(12)),
    *each("Bogacki-Shampine 3(2)", "Verner 6(5)", "RKN 6(4)", **ORBIT, counts=counts(96)),
    # Their leading error coefficients are small, so it dominates at shorter steps only.
    *each("Dormand-Prince 5(4)", "Tsitouras 5(4)", **ORBIT, counts=counts(192)),
    # The error term of order 8 is so small that the next one exceeds it until steps are far too short for binary64.
    *each("DOP853", "DOP853 [events]", span="3", counts=counts(768)),
    *each("Verner 9(8)", "RKN 12(10)", **ORBIT, counts=counts(48)),
    *each("Gragg-Bulirsch-Stoer", **ORBIT, counts=counts(60), digits=80),
    *each("Taylor", case="kepler_orbit", span="1/32", counts=counts(24), digits=80),
    *each("Radau IIA 5", span="16"),
    *each("Störmer 8", case="kepler_orbit", span="1", counts=counts(384)),
    *each("Störmer 12", case="kepler_orbit", span="1", counts=counts(1152)),
    *each("Boris", "Volume-preserving 4", "Volume-preserving 6", case="charge_in_E_and_B", variant="oblique"),
    *each("Higuera-Cary", case="relativistic_charge", variant="oblique"),
    *each("RATTLE", "RATTLE Suzuki 4", "RATTLE Kahan-Li 6", case="holonomic_constraint_dae", most_steps=20_000),
    *each("Exponential Runge-Kutta 4", case="forced_oscillator"),
    *each("RKMK 4", "Axis splitting 2", "Axis splitting 6", case="euler_top"),
    *each("Explicit Euler [events]", "RK4 [events]", case="pendulum_quadratic_damping"),
    *each("Moreau [time stepping]", case="coulomb_friction_oscillator", scattered=True),
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
