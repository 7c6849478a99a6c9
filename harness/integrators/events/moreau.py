"""Moreau's time stepping: contact and friction as laws for velocities over a step, without locating events."""

from collections.abc import Callable
from typing import Any

from gnomon.cases.core.forms import Form, Friction, Impact, Values
from gnomon.harness.contract.integrator import Integrator, Problem, Steps
from gnomon.harness.integrators.base.fixed_step import FixedStep, Table
from gnomon.harness.integrators.base.stepping import Step, StepData, evaluate
from gnomon.harness.kernels.equations import Kernel, check_values


def impact_step(s: StepData, t: Any, h: Any) -> bool:
    """One step with impacts: half a drift; the impact law for the velocities, if the gap is now closed; half a drift.

    `call` computes the free derivatives of the state, the gap, the normal and the coefficient of restitution.
    """
    y, x, slope, increment = s.y, s.x, s.slope, s.increment
    half = y.size // 2
    for i in range(half):
        x[i] = y[i] + h / 2 * y[half + i]
        x[half + i] = y[half + i]
    evaluate(s, t + h / 2)
    gap, restitution = slope[2 * half], slope[3 * half + 1]
    before, free = 0.0, 0.0
    for i in range(half):
        increment[half + i] = h * slope[half + i]
        before += slope[2 * half + 1 + i] * y[half + i]
        free += slope[2 * half + 1 + i] * (y[half + i] + increment[half + i])
    if gap <= 0.0:
        push = max(0.0, -(free + restitution * before))
        for i in range(half):
            increment[half + i] += push * slope[2 * half + 1 + i]
    for i in range(half):
        increment[i] = h * (y[half + i] + increment[half + i] / 2)
    return True


def friction_step(s: StepData, t: Any, h: Any) -> bool:
    """One step with friction: half a drift; friction stops the motion, or slows it if it cannot; half a drift.

    `call` computes the derivatives of the state without friction, and the bounds of friction in sliding and in
    sticking.
    """
    y, x, slope, increment = s.y, s.x, s.slope, s.increment
    x[0] = y[0] + h / 2 * y[1]
    x[1] = y[1]
    evaluate(s, t + h / 2)
    free = y[1] + h * slope[1]
    bound = slope[3] if y[1] == 0.0 else slope[2]
    if abs(free) <= h * bound:
        increment[1] = -y[1]
    else:
        brake = h * slope[2]
        increment[1] = h * slope[1] + (-brake if free > 0.0 else brake)
    increment[0] = h * (y[1] + increment[1] / 2)
    return True


class Moreau(FixedStep):
    """Moreau's midpoint scheme with Newton's impact law or Coulomb's friction law. Order 1.

    Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988; Jean, Comput. Methods Appl. Mech. Eng.
    177, 1999. A step may contain any number of impacts; times of events are not located. The static bound of friction
    holds for sticking.
    """

    name, order = "Moreau", 1
    accepts = (Impact, Friction)
    policy = "time stepping"
    sweep = Steps(halvings=12)
    step = impact_step

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        return [[mp.mpf(1)]]

    def step_for(self, form: Form) -> Step:
        return impact_step if isinstance(form, Impact) else friction_step

    def equations(self, form: Form) -> Callable[..., Any]:
        if isinstance(form, Impact):
            free, gap, normal, restitution = form.free, form.gap, form.normal, form.restitution

            def contact(t: Any, y: Values, p: Values) -> Values:
                q = y[: len(y) // 2]
                return *free(t, y, p), *gap(t, q, p), *normal(t, q, p), *restitution(p)

            return contact
        assert isinstance(form, Friction)
        sliding, bounds = form.sliding, form.bounds

        def friction(t: Any, y: Values, p: Values) -> Values:
            return *sliding(t, y, (*p, 0.0)), *bounds(t, y, p)

        return friction

    def widths(self, form: Form, dimension: int) -> tuple[int, int]:
        return dimension, dimension + (dimension // 2 + 2 if isinstance(form, Impact) else 2)

    def kernel(self, problem: Problem) -> Kernel:
        form, n, known = problem.form, problem.dimension, len(problem.parameters)
        if isinstance(form, Impact):
            check_values(form.free, (n, known), n)
            check_values(form.gap, (n // 2, known), 1)
            check_values(form.normal, (n // 2, known), n // 2)
            check_values(form.restitution, (known,), 1)
        else:
            assert isinstance(form, Friction)
            check_values(form.sliding, (n, known + 1), n)
            check_values(form.bounds, (n, known), 2)
        return super().kernel(problem)


INTEGRATORS: tuple[type[Integrator], ...] = (Moreau,)
