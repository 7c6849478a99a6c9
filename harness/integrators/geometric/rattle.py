"""RATTLE and its compositions for motions under a holonomic constraint."""

from collections.abc import Callable
from typing import Any

from gnomon.cases.core.forms import Constrained, Form, Values
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Integrator, Problem
from gnomon.harness.integrators.base.fixed_step import Table
from gnomon.harness.integrators.base.stepping import call, sum_of
from gnomon.harness.integrators.gauss.gauss_steps import MOST_ITERATIONS, SMALLEST, settled
from gnomon.harness.integrators.geometric.splitting import Composed, KahanLi6, Suzuki4
from gnomon.harness.kernels.equations import Kernel, check_values


def rattle_step(
    f: Any, t: Any, h: Any, y: Any, p: Any, table: Any, x: Any, slope: Any, store: Any, increment: Any
) -> bool:
    """One step of symmetric RATTLE steps.

    Rows of `table`: lengths of the symmetric steps over h; the unit round-off. `call` computes force, constraint and
    gradient at a position; the next step uses the values at the end of this step. `store` holds a flag and the
    constraint's value at the start of the motion, which is conserved; the gradient at the start of a step; the
    correction of the position; the rounding residual of the position: the exact position is `y` plus this residual.

    The gradient is computed at the position plus its residual. The return to the constraint leaves the residual out:
    otherwise the rounded constraint would determine it, equally at each return, and the momentum would drift as t. On a
    sphere this drift was 4e-4 units of round-off in each step, of either sign.
    """
    n = x.size
    for i in range(2 * n):
        increment[i] = 0.0
    now = t
    if store[0, 0] == 0.0:
        for i in range(n):
            x[i] = y[i]
        call(f, now, x, p, slope)
        store[0, 0] = 1.0
        store[0, 1] = slope[n]
    for j in range(table.shape[1]):
        length = table[0, j] * h
        if length == 0.0:
            continue
        for i in range(n):
            store[1, i] = slope[n + 1 + i]
            increment[n + i] += length / 2 * slope[i]
            increment[i] += length * (y[n + i] + increment[n + i])
        now += length
        if not onto_constraint(f, now, length, y, p, table[1, 0], x, slope, store, increment):
            return False
        for i in range(n):
            x[i] = y[i] + (increment[i] + store[3, i])
        call(f, now, x, p, slope)
        along, square = 0.0, 0.0
        for i in range(n):
            increment[n + i] += length / 2 * slope[i]
            along += slope[n + 1 + i] * (y[n + i] + increment[n + i])
            square += slope[n + 1 + i] * slope[n + 1 + i]
        for i in range(n):
            increment[n + i] -= along / square * slope[n + 1 + i]
    for i in range(n):
        moved = x[i] - y[i]
        store[3, i] += increment[i] - moved
        increment[i] = moved
    return True


def onto_constraint(
    f: Any, now: Any, length: Any, y: Any, p: Any, roundoff: Any, x: Any, slope: Any, store: Any, increment: Any
) -> bool:
    """Move the position along the gradient at the start until the constraint has its value, and correct the velocity.

    The constraint is computed at the rounded position and extrapolated to the exact position with its gradient. The
    correction has a sum of its own: as part of the change of the position, its last terms would have biased rounding.
    """
    n = x.size
    for i in range(n):
        store[2, i] = 0.0
    least, stalled = 0.0, 0
    for iteration in range(MOST_ITERATIONS):
        for i in range(n):
            x[i] = y[i] + (increment[i] - store[2, i])
        call(f, now, x, p, slope)
        product, beyond = 0.0, 0.0
        for i in range(n):
            product += slope[n + 1 + i] * store[1, i]
            beyond += slope[n + 1 + i] * ((y[i] - x[i]) + (increment[i] - store[2, i]))
        share = (slope[n] - store[0, 1] + beyond) / product
        largest, size = 0.0, SMALLEST
        for i in range(n):
            correction = share * store[1, i]
            if not abs(correction) < 1e300:
                return False
            store[2, i] += correction
            largest = max(largest, abs(correction))
            size = max(size, abs(x[i]))
        change = largest / size
        stalled = stalled + 1 if change >= least else 0
        if settled(iteration, change, least, stalled, roundoff):
            for i in range(n):
                increment[i], lost = sum_of(increment[i], -store[2, i])
                store[3, i] += lost
                increment[n + i] -= store[2, i] / length
            return True
        least = change if iteration == 0 else min(least, change)
    return False


class ConstrainedMethod(Composed):
    """A method for a constrained motion, whose step calls a function that computes force, constraint and gradient."""

    accepts = (Constrained,)
    conserves = ("symplectic", "reversible", "momentum", "constraint")
    compensated = True
    step = rattle_step

    def unsupported(self, form: Form | SceneForm) -> str | None:
        if isinstance(form, Constrained) and (form.mass or form.velocity_force or form.constraint_rate):
            return "it takes unit masses, forces of place and time, and constraints without time"
        return None

    def equations(self, form: Form) -> Callable[..., Any]:
        assert isinstance(form, Constrained)
        force, constraint, gradient = form.force, form.constraint, form.gradient

        def all_parts(t: Any, q: Values, p: Values) -> Values:
            return *force(t, q, p), *constraint(t, q, p), *gradient(t, q, p)

        return all_parts

    def widths(self, form: Form, dimension: int) -> tuple[int, int]:
        return dimension // 2, dimension + 1

    def kernel(self, problem: Problem) -> Kernel:
        form, n = problem.form, problem.dimension // 2
        assert isinstance(form, Constrained)
        for function, count in ((form.force, n), (form.constraint, 1), (form.gradient, n)):
            check_values(function, (n, len(problem.parameters)), count)
        return super().kernel(problem)

    def rows(self, form: Form) -> int:
        return 4

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
