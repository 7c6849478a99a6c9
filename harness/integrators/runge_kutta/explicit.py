"""Explicit Runge-Kutta methods at a fixed step."""

from typing import Any, ClassVar

from gnomon.cases.core.forms import FirstOrder, Form
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.integrators.base.fixed_step import FixedStep, Table
from gnomon.harness.integrators.base.stepping import StepData, evaluate
from gnomon.harness.integrators.base.tableau import ButcherTableau


def runge_kutta_step(s: StepData, t: Any, h: Any) -> bool:
    """One explicit Runge-Kutta step. Rows of `table`: c_j, a_j1, a_j2, ... for each stage, then 1, b_1, b_2, ..."""
    table, y, store, increment = s.table, s.y, s.store, s.increment
    stages = table.shape[0] - 1
    for j in range(stages):
        stage(s, t, h, j, store)
    for i in range(y.size):
        total = 0.0
        for m in range(stages):
            total += table[stages, m + 1] * store[m, i]
        increment[i] = h * total
    return True


def stage(s: Any, t: Any, h: Any, j: int, k: Any) -> None:
    """Compute the slope of stage j into k[j], from the slopes of the stages before it."""
    table, y, x, slope = s.table, s.y, s.x, s.slope
    for i in range(y.size):
        total = 0.0
        for m in range(j):
            total += table[j, m + 1] * k[m, i]
        x[i] = y[i] + h * total
    evaluate(s, t + table[j, 0] * h)
    for i in range(y.size):
        k[j, i] = slope[i]


class RungeKutta(FixedStep):
    """An explicit Runge-Kutta method, given by its tableau."""

    accepts = (FirstOrder,)
    step = runge_kutta_step
    tableau: ClassVar[ButcherTableau]

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        return cls.tableau.rows(mp)

    def rows(self, form: Form) -> int:
        return len(self.tableau.a)


class ExplicitEuler(RungeKutta):
    """Euler's method (1768). Order 1."""

    name, order = "Explicit Euler", 1
    tableau = ButcherTableau(orders=(1,), a=({},), b={0: "1"})


class ExplicitMidpoint(RungeKutta):
    """The explicit midpoint method (Runge, Mathematische Annalen 46, 1895). Order 2."""

    name, order = "Explicit midpoint", 2
    primary = False
    tableau = ButcherTableau(orders=(2,), a=({}, {0: "1/2"}), b={1: "1"})


class Heun2(RungeKutta):
    """Heun's method, the explicit trapezoidal rule (Zeitschrift fuer Mathematik und Physik 45, 1900). Order 2."""

    name, order = "Heun", 2
    primary = False
    tableau = ButcherTableau(orders=(2,), a=({}, {0: "1"}), b={0: "1/2", 1: "1/2"})


class Kutta3(RungeKutta):
    """Kutta's method of three stages (Zeitschrift fuer Mathematik und Physik 46, 1901). Order 3."""

    name, order = "RK3", 3
    primary = False
    tableau = ButcherTableau(orders=(3,), a=({}, {0: "1/2"}, {0: "-1", 1: "2"}), b={0: "1/6", 1: "2/3", 2: "1/6"})


class RK4(RungeKutta):
    """The classical Runge-Kutta method (Kutta, Zeitschrift fuer Mathematik und Physik 46, 1901). Order 4."""

    name, order = "RK4", 4
    tableau = ButcherTableau(
        orders=(4,), a=({}, {0: "1/2"}, {1: "1/2"}, {2: "1"}), b={0: "1/6", 1: "1/3", 2: "1/3", 3: "1/6"}
    )


INTEGRATORS: tuple[type[Integrator], ...] = (ExplicitEuler, ExplicitMidpoint, Heun2, Kutta3, RK4)
