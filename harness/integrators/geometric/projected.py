"""Explicit pairs for motions under constraints: each step ends with a projection onto the constraints and their tangents.

The pairs integrate the equations of index 1, whose solutions leave the constraints as errors add up. After each step the
position returns to the values of the constraints at the start, then the velocity to G q' + g_t = 0, both in the metric of
the mass matrix: the least kinetic energy of the correction (Eich, SIAM J. Numer. Anal. 30, 1993; Hairer, Lubich, Wanner,
Geometric Numerical Integration, IV.4). Corrections are as small as the error of a step, so the order stays.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from gnomon.cases.core.elimination import rows_of, solve_all
from gnomon.cases.core.forms import Constrained, Values
from gnomon.harness.contract.constraints import constraints_of, rest
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Tolerance
from gnomon.harness.integrators.base.step_control import AttemptData, end_slope
from gnomon.harness.integrators.base.step_control import first_step as first_step_alone
from gnomon.harness.integrators.base.stepping import evaluate
from gnomon.harness.integrators.gauss.gauss_steps import SMALLEST
from gnomon.harness.integrators.geometric.rattle import eliminate
from gnomon.harness.integrators.runge_kutta.dop853_table import DOP853
from gnomon.harness.integrators.runge_kutta.embedded import Embedded, propagate, state_within
from gnomon.harness.integrators.runge_kutta.explicit_pairs import DormandPrince5
from gnomon.harness.kernels.equations import Kernel, check_values, function_kernel

ENDS = 0
"""Set when a method is compiled, see `step_control`."""

MOST_RETURNS = 20
ENOUGH = 1e-9
"""Relative to the position: as Newton's method squares changes, the next one is below round-off."""


def first_step(s: AttemptData, k: Floats, tolerance: float, most: float, groups: Any) -> float:
    """The first step size; keeps the values of the constraints at the start in the last numbers of `slope`."""
    y, x, slope = s.y, s.x, s.slope
    h = first_step_alone(s, k, tolerance, most, groups)
    for i in range(x.size):
        x[i] = y[i]
    evaluate(s, 0.0)
    m = constraints_beside(slope, y)
    for j in range(m):
        slope[slope.size - m + j] = slope[y.size + j]
    return h


def constraints_beside(slope: Floats, y: Floats) -> int:
    """The number m of constraints: slopes, m constraints, their rates, G, M^-1 G^T, and m values of the start."""
    return (slope.size - y.size) // (y.size + 3)


def attempt(s: AttemptData, t: float, h: float) -> bool:
    """Compute a step and project its end; returns whether the projection converged."""
    propagate(s, t, h)
    m = constraints_beside(s.slope, s.y)
    rows = np.empty((m, m + 1))
    if not project(s, t + h, s.end, m, s.slope[s.slope.size - m :], rows):
        return False
    for i in range(s.y.size):
        s.change[i] += s.end[i] - (s.y[i] + s.change[i])
    if ENDS == 1:
        end_slope(s, t + h)
    return True


def between(s: AttemptData, t: float, h: float, ahead: float, out: Floats) -> None:
    """Write the state within a step into `out`: the interpolant, projected."""
    state_within(s, t, h, ahead, out)
    m = constraints_beside(s.slope, s.y)
    for i in range(s.y.size):
        s.spare[i] = out[i]
    rows = np.empty((m, m + 1))
    if project(s, t + ahead, s.spare, m, s.slope[s.slope.size - m :], rows):
        for i in range(s.y.size):
            out[i] = s.spare[i]


def project(s: Any, t: Any, state: Any, m: int, held: Any, rows: Any) -> bool:
    """Project a state onto m constraints, whose values are `held`, and onto their tangents.

    Along M^-1 G^T, computed at each place again. `rows` holds the linear equations. Returns False if Newton's method does
    not converge.
    """
    x, slope = s.x, s.slope
    n = state.size // 2
    gradient = 2 * n + 2 * m
    pushed = gradient + m * n
    near = False
    for _ in range(MOST_RETURNS):
        for i in range(2 * n):
            x[i] = state[i]
        evaluate(s, t)
        for j in range(m):
            rows[j, m] = slope[2 * n + j] - held[j]
            if near:
                rows[j, m] = slope[2 * n + m + j]
                for i in range(n):
                    rows[j, m] += slope[gradient + j * n + i] * state[n + i]
            for c in range(m):
                rows[j, c] = 0.0 * rows[j, m]
                for i in range(n):
                    rows[j, c] += slope[gradient + j * n + i] * slope[pushed + c * n + i]
        eliminate(rows, 0, m)
        moved = n if near else 0
        largest, size = 0.0, SMALLEST
        for i in range(n):
            correction = rows[0, m] * slope[pushed + i]
            for j in range(1, m):
                correction += rows[j, m] * slope[pushed + j * n + i]
            if not abs(correction) < 1e300:
                return False
            state[moved + i] -= correction
            largest = max(largest, abs(correction))
            size = max(size, abs(state[i]))
        if near:
            return True
        near = largest <= ENOUGH * size
    return False


def index_one_parts(form: Constrained) -> Callable[..., Any]:
    """(t, state, parameters) -> the slopes, constraints, their rates at a constant place, G, and M^-1 G^T by columns."""
    equations, constraint, gradient, mass = form.equations, form.constraint, form.gradient, form.mass
    rate = form.constraint_rate or rest(constraint)

    def of_unit_masses(t: Any, state: Values, p: Values) -> Values:
        q = state[: len(state) // 2]
        normals = gradient(t, q, p)
        return *equations(t, state, p), *constraint(t, q, p), *rate(t, q, p), *normals, *normals

    if mass is None:
        return of_unit_masses

    def of_masses(t: Any, state: Values, p: Values) -> Values:
        q = state[: len(state) // 2]
        normals = tuple(gradient(t, q, p))
        moved = solve_all(rows_of(mass(t, q, p), len(q)), rows_of(normals, len(q)), 1 + 0 * q[0])
        pushed = [x for row in moved for x in row]
        return *equations(t, state, p), *constraint(t, q, p), *rate(t, q, p), *normals, *pushed

    return of_masses


class Projected(Embedded):
    """An explicit pair on the equations of index 1, which projects steps and samples onto constraints and tangents."""

    accepts = (Constrained,)
    conserves = ("constraint",)

    def kernel(self, problem: Problem) -> Kernel:
        form, known = problem.form, len(problem.parameters)
        assert isinstance(form, Constrained)
        n, m = problem.dimension // 2, constraints_of(form, problem.dimension // 2, known)
        wanted = {form.force: n, form.gradient: m * n, form.mass: n * n, form.constraint_rate: m}
        for function, count in wanted.items():
            if function is not None:
                check_values(function, (n, known), count)
        outputs = 2 * n + 2 * m * (n + 1)
        return function_kernel(index_one_parts(form), 2 * n, known, outputs, problem.counted)

    def beside(self, problem: Problem) -> int:
        assert isinstance(problem.form, Constrained)
        m = constraints_of(problem.form, problem.dimension // 2, len(problem.parameters))
        return m * (problem.dimension + 3)


Projected.pieces = (first_step, attempt, *Embedded.pieces[2:5], between)


class ProjectedDormandPrince5(Projected):
    """Dormand and Prince's 5(4) pair with projection. Order 5."""

    name, order = "Projected Dormand-Prince 5(4)", 5
    primary = False
    sweep = Tolerance(1e-3, 1e-12)
    tableau = DormandPrince5.tableau


class ProjectedDop853(Projected):
    """Dormand and Prince's 8(5,3) pair with projection. Order 8."""

    name, order = "Projected DOP853", 8
    tableau = DOP853


INTEGRATORS: tuple[type[Integrator], ...] = (ProjectedDormandPrince5, ProjectedDop853)
