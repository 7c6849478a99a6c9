"""Fixed-step twins of methods that choose their own steps: the method's formula at equal steps shows its order."""

from dataclasses import replace
from functools import singledispatch
from typing import Any

from gnomon.cases.core.arithmetic import mpmath_arithmetic
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import Constrained, FirstOrder, SecondOrder
from gnomon.harness.contract.constraints import constraints_of
from gnomon.harness.contract.integrator import Integrator, Problem, Solver
from gnomon.harness.contract.problem import find_accepted_form
from gnomon.harness.integrators.base.fixed_step import FixedStep, Table
from gnomon.harness.integrators.base.stepping import StepData, call, evaluate
from gnomon.harness.integrators.events.hybrid import Dop853Events
from gnomon.harness.integrators.gauss import radau
from gnomon.harness.integrators.gauss.gauss import Gauss8
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.geometric.projected import Projected, index_one_parts, project
from gnomon.harness.integrators.multistep_extrapolation.extrapolation import (
    COLUMNS,
    GraggBulirschStoer,
    extrapolate,
    midpoint,
)
from gnomon.harness.integrators.runge_kutta.dop853 import Dop853
from gnomon.harness.integrators.runge_kutta.embedded import Embedded
from gnomon.harness.integrators.runge_kutta.explicit import RungeKutta, runge_kutta_step
from gnomon.harness.integrators.runge_kutta.nystrom import Nystrom, nystrom_increment
from gnomon.harness.integrators.taylor.recurrences import STRIDE, Recurrences, coefficients


@singledispatch
def at_fixed_steps(method: Integrator) -> Integrator:
    """The formula that propagates a method's solution, at fixed steps; fixed-step methods are returned unchanged."""
    return method


def make_fixed(base: Any, **attributes: Any) -> FixedStep:
    """An instance of a new subclass of `base` with these attributes."""
    kind: type[FixedStep] = type("Fixed", (base,), attributes)
    return kind()


@at_fixed_steps.register
def _(method: Embedded) -> FixedStep:
    tableau = replace(method.tableau, errors=(), extra=(), dense=None)
    return make_fixed(RungeKutta, name=method.name, order=method.order, tableau=tableau)


def step_projected(s: StepData, t: Any, h: Any) -> bool:
    """A step of an explicit method with projection. Last in `store`: a flag, the start, the state, equations."""
    y, x, slope, store, increment = s.y, s.x, s.slope, s.store, s.increment
    stages, m = s.table.shape[0] - 1, (slope.size - y.size) // (y.size + 2)
    if store[stages, 0] == 0.0:
        for i in range(y.size):
            x[i] = y[i]
        evaluate(s, t)
        store[stages, 0] = 1.0
        for j in range(m):
            store[stages + 1, j] = slope[y.size + j]
    runge_kutta_step(s, t, h)
    for i in range(y.size):
        store[stages + 2, i] = y[i] + increment[i]
    if not project(s, t + h, store[stages + 2], m, store[stages + 1], store[stages + 3 :]):
        return False
    for i in range(y.size):
        increment[i] = store[stages + 2, i] - y[i]
    return True


@at_fixed_steps.register
def _(method: Projected) -> FixedStep:
    tableau = replace(method.tableau, errors=(), extra=(), dense=None)

    def shape(self: FixedStep, form: Constrained, dimension: int, parameters: int) -> tuple[tuple[int, int], int]:
        m = constraints_of(form, dimension // 2, parameters)
        return (dimension, dimension + m * (dimension + 2)), len(tableau.a) + 3 + m

    return make_fixed(
        RungeKutta,
        name=method.name,
        order=method.order,
        accepts=(Constrained,),
        tableau=tableau,
        step=step_projected,
        shape=shape,
        equations=lambda self, form: index_one_parts(form),
    )


def nystrom_step(s: StepData, t: Any, h: Any) -> bool:
    """One step of a Nyström method, of a fixed length."""
    x, slope = s.x, s.slope
    for i in range(x.size):
        x[i] = s.y[i]
    evaluate(s, t)
    for i in range(x.size):
        s.store[0, i] = slope[i]
    nystrom_increment(s, t, h, s.table.shape[0] - 2)
    return True


@at_fixed_steps.register
def _(method: Nystrom) -> FixedStep:
    tableau = method.tableau
    return make_fixed(
        FixedStep,
        name=method.name,
        order=method.order,
        accepts=(SecondOrder,),
        step=nystrom_step,
        coefficients=classmethod(lambda cls, mp: tableau.fixed_rows(mp)),
        rows=lambda self, form: len(tableau.a) + 1,
    )


def columns_step(s: StepData, t: Any, h: Any) -> bool:
    """An extrapolated step with as many columns as `table` has rows."""
    table, store = s.table, s.store
    count = table.shape[0]
    start, before, now = store[count : count + 1], store[count + 1], store[count + 2]
    call(s.f, t, s.y, s.p, s.slope)
    start[0] = s.slope
    for j in range(count):
        midpoint(s, t, h, 2 * (j + 1), start, before, now)
        extrapolate(j, table, now, store)
    s.increment[:] = store[count - 1]
    return True


def with_columns(count: int) -> FixedStep:
    """Extrapolation with `count` columns, of order 2 `count`."""

    def coefficients(cls: type, mp: Any) -> Table:
        return GraggBulirschStoer.rows(mp)[:count]

    return make_fixed(
        FixedStep,
        name=f"{count} columns",
        order=2 * count,
        accepts=(FirstOrder,),
        step=columns_step,
        coefficients=classmethod(coefficients),
        rows=lambda self, form: count + 3,
    )


@at_fixed_steps.register
def _(method: GraggBulirschStoer) -> FixedStep:
    return with_columns(COLUMNS)


@at_fixed_steps.register
def _(method: GaussFast) -> FixedStep:
    """The table of GaussFast is the rounded table of Gauss8, as the tests of GaussFast show."""
    return Gauss8()


class RadauSteps(Radau5):
    """Radau IIA at fixed steps. The step divides the sample interval, since its dense output has order 3. Order 5."""

    def prepare(self, problem: Problem, setting: float) -> Solver:
        return radau.prepare_solver(problem, 1e-14, setting)


@at_fixed_steps.register
def _(method: Radau5) -> Integrator:
    return RadauSteps()


@at_fixed_steps.register
def _(method: Dop853Events) -> Integrator:
    """Events shorten the steps of the method, so that the few errors well above round-off would not lie on a line."""
    return at_fixed_steps(Dop853())


def taylor_steps(mp: Any, case: Case, order: int, count: int) -> list[Any]:
    """The state at the end of the span after `count` equal Taylor steps of an order, in the digits of the context `mp`.

    The recurrences are from the compiled method.
    """
    form = find_accepted_form(case, (FirstOrder,))
    assert isinstance(form, FirstOrder)
    recurrences = Recurrences(form, len(case.state), len(case.parameter_list))
    parameters = [mp.mpf(x.numerator) / x.denominator for x in case.parameter_values()]
    state = [mp.mpf(x.numerator) / x.denominator for x in case.initial_state]
    h = mp.mpf(case.span.numerator) / case.span.denominator / count
    for k in range(count):
        w = [mp.mpf(0)] * recurrences.length
        coefficients(recurrences, mpmath_arithmetic(mp), k * h, [*state, order], parameters, w)
        state = [mp.fsum(w[STRIDE * i + j] * h**j for j in range(order + 1)) for i in range(len(state))]
    return state
