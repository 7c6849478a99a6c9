"""RATTLE and its compositions for motions under a holonomic constraint."""

from collections.abc import Callable
from typing import Any

from gnomon.cases.core.forms import Constrained, Form
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.constraints import constraints_of
from gnomon.harness.contract.integrator import Integrator, Problem, Unsupported
from gnomon.harness.integrators.base.fixed_step import Table
from gnomon.harness.integrators.base.stepping import StepData, evaluate, sum_of
from gnomon.harness.integrators.gauss.gauss_steps import MOST_ITERATIONS, SMALLEST, has_settled
from gnomon.harness.integrators.geometric.constrained_parts import explicit_parts, is_constant
from gnomon.harness.integrators.geometric.splitting import Composed, KahanLi6, Suzuki4
from gnomon.harness.kernels.equations import Kernel, check_values

COUNT = 0
"""The number of constraints, which is compiled in: loops of unknown length took a fifth of the time more. With 0 the step reads
it from the sizes of its arrays."""


def rattle_step(s: StepData, t: Any, h: Any) -> bool:
    """One step of symmetric RATTLE steps.

    Rows of `table`: lengths of the symmetric steps over h; the unit round-off. `call` computes at a position, for n
    coordinates and m constraints: the n accelerations M^-1 force without constraints; the m constraints; their rates g_t
    at a constant place; their gradients G by rows; M^-1 G^T by columns. The next step uses the values at the end of this
    step.

    `store` holds in its first row a flag and the values of the constraints at the start of the motion, which are
    conserved; in its second row the correction of the position and the rounding residual of the position: the exact
    position is `y` plus this residual; then m rows of M^-1 G^T at the start of a step, and m rows for `eliminate`.

    The gradient is computed at the position plus its residual. The return to the constraint leaves the residual out:
    otherwise the rounded constraint would determine it, equally at each return, and the momentum would drift as t. On a
    sphere this drift was 4e-4 units of round-off in each step, of either sign.
    """
    table, y, x, slope, store, increment = s.table, s.y, s.x, s.slope, s.store, s.increment
    n = x.size
    m = COUNT if COUNT > 0 else (slope.size - n) // (2 * n + 2)
    gradient = n + 2 * m
    pushed = gradient + m * n
    for i in range(2 * n):
        increment[i] = 0.0
    now = t
    if store[0, 0] == 0.0:
        for i in range(n):
            x[i] = y[i]
        evaluate(s, now)
        store[0, 0] = 1.0
        for k in range(m):
            store[0, 1 + k] = slope[n + k]
    for j in range(table.shape[1]):
        length = table[0, j] * h
        if length == 0.0:
            continue
        for k in range(m):
            for i in range(n):
                store[2 + k, i] = slope[pushed + k * n + i]
        for i in range(n):
            increment[n + i] += length / 2 * slope[i]
            increment[i] += length * (y[n + i] + increment[n + i])
        now += length
        if not move_onto_constraints(s, now, length):
            return False
        for i in range(n):
            x[i] = y[i] + (increment[i] + store[1, n + i])
        evaluate(s, now)
        for i in range(n):
            increment[n + i] += length / 2 * slope[i]
        for k in range(m):
            along = slope[n + m + k]
            for i in range(n):
                along += slope[gradient + k * n + i] * (y[n + i] + increment[n + i])
            store[2 + m + k, m] = along
            for c in range(m):
                product = 0.0
                for i in range(n):
                    product += slope[gradient + k * n + i] * slope[pushed + c * n + i]
                store[2 + m + k, c] = product
        eliminate(store, 2 + m, m)
        for k in range(m):
            share = store[2 + m + k, m]
            for i in range(n):
                increment[n + i] -= share * slope[pushed + k * n + i]
    for i in range(n):
        moved = x[i] - y[i]
        store[1, n + i] += increment[i] - moved
        increment[i] = moved
    return True


def move_onto_constraints(s: Any, now: Any, length: Any) -> bool:
    """Move the position along M^-1 G^T at the start until constraints have their values, and correct the velocity.

    Constraints are computed at the rounded position and extrapolated to the exact position with their gradients. The
    correction has a sum of its own: as part of the change of the position, its last terms would have biased rounding.

    A change that does not halve is round-off, as Newton's method squares changes: with two constraints changes of a
    thousandth of round-off shrank by a hundredth in each round, up to MOST_ITERATIONS.
    """
    y, x, slope, store, increment, roundoff = s.y, s.x, s.slope, s.store, s.increment, s.table[1, 0]
    n = x.size
    m = COUNT if COUNT > 0 else (slope.size - n) // (2 * n + 2)
    gradient = n + 2 * m
    for i in range(n):
        store[1, i] = 0.0
    least, stalled = 0.0, 0
    for iteration in range(MOST_ITERATIONS):
        for i in range(n):
            x[i] = y[i] + (increment[i] - store[1, i])
        evaluate(s, now)
        for k in range(m):
            beyond = 0.0
            for i in range(n):
                beyond += slope[gradient + k * n + i] * ((y[i] - x[i]) + (increment[i] - store[1, i]))
            store[2 + m + k, m] = slope[n + k] - store[0, 1 + k] + beyond
            for c in range(m):
                product = 0.0
                for i in range(n):
                    product += slope[gradient + k * n + i] * store[2 + c, i]
                store[2 + m + k, c] = product
        eliminate(store, 2 + m, m)
        largest, size, first = 0.0, SMALLEST, store[2 + m, m]
        for i in range(n):
            correction = first * store[2, i]
            for k in range(1, m):
                correction += store[2 + m + k, m] * store[2 + k, i]
            if not abs(correction) < 1e300:
                return False
            store[1, i] += correction
            largest = max(largest, abs(correction))
            size = max(size, abs(x[i]))
        change = largest / size
        stalled = stalled + 1 if 2 * change >= least else 0
        if has_settled(iteration, change, least, stalled, roundoff):
            for i in range(n):
                increment[i], lost = sum_of(increment[i], -store[1, i])
                store[1, n + i] += lost
                increment[n + i] -= store[1, i] / length
            return True
        least = change if iteration == 0 else min(least, change)
    return False


def eliminate(store: Any, first: Any, m: Any) -> None:
    """Solve the m equations of the rows from `first`: the solution replaces their right-hand sides, in column m.

    The matrix is G M^-1 G^T, its two gradients at most a step apart: it needs no exchange of rows.
    """
    for k in range(m):
        for c in range(k + 1, m + 1):
            store[first + k, c] /= store[first + k, k]
        for j in range(k + 1, m):
            for c in range(k + 1, m + 1):
                store[first + j, c] -= store[first + j, k] * store[first + k, c]
    for back in range(1, m):
        for c in range(m - back, m):
            store[first + m - 1 - back, m] -= store[first + m - 1 - back, c] * store[first + c, m]


class ConstrainedMethod(Composed):
    """A method for a constrained motion, whose step calls a function that computes force, constraint and gradient."""

    accepts = (Constrained,)
    conserves = ("symplectic", "reversible", "momentum", "constraint")
    compensated = True
    step = rattle_step

    def unsupported(self, form: Form | SceneForm) -> str | None:
        if isinstance(form, Constrained) and form.velocity_force is not None:
            return "its steps are explicit only for forces of place and time: this form has forces that depend on velocities"
        return None

    def equations(self, form: Form) -> Callable[..., Any]:
        assert isinstance(form, Constrained)
        return explicit_parts(form)

    def shape(self, form: Form, dimension: int, parameters: int) -> tuple[tuple[int, int], int]:
        assert isinstance(form, Constrained)
        n = dimension // 2
        m = constraints_of(form, n, parameters)
        return (n, n + m * (2 * n + 2)), 2 + 2 * m

    def constants(self, shape: tuple[tuple[int, int], int]) -> tuple[tuple[str, int], ...]:
        return (("COUNT", shape[1] // 2 - 1),)

    def kernel(self, problem: Problem) -> Kernel:
        form, n, known = problem.form, problem.dimension // 2, len(problem.parameters)
        assert isinstance(form, Constrained)
        m = constraints_of(form, n, known)
        wanted = {form.force: n, form.gradient: m * n, form.mass: n * n, form.constraint_rate: m}
        for function, count in wanted.items():
            if function is not None:
                check_values(function, (n, known), count)
        if form.mass is not None and not is_constant(form.mass, n, known):
            raise Unsupported("its steps are explicit only for a constant mass: this form has one of place or time")
        return super().kernel(problem)

    def table(self, mp: Any, form: Form, parameters: Any, roundoff: Any) -> Table:
        return [*self.coefficients(mp), [roundoff]]


class Rattle(ConstrainedMethod):
    """RATTLE (Andersen, J. Comput. Phys. 52, 1983; Leimkuhler and Skeel, J. Comput. Phys. 112, 1994). Order 2."""

    name, order = "RATTLE", 2


class Rattle4(ConstrainedMethod):
    """Five RATTLE steps in Suzuki's lengths (Reich, SIAM J. Numer. Anal. 33, 1996). Order 4."""

    name, order = "RATTLE Suzuki 4", 4
    primary = False
    composition = Suzuki4


class Rattle6(ConstrainedMethod):
    """Nine RATTLE steps in Kahan and Li's lengths (Reich, SIAM J. Numer. Anal. 33, 1996). Order 6."""

    name, order = "RATTLE Kahan-Li 6", 6
    composition = KahanLi6


INTEGRATORS: tuple[type[Integrator], ...] = (Rattle, Rattle4, Rattle6)
