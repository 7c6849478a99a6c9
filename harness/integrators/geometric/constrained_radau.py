"""Radau IIA with three stages for motions under constraints, in the formulations of index 3 and of index 2.

Hairer, Lubich, Roche, The Numerical Solution of Differential-Algebraic Systems by Runge-Kutta Methods, 1989: of the last
stage the positions have order 5 in both formulations, the velocities order 3 at index 3 and order 5 at index 2. The last
stage is the end of the step, so it satisfies the constraints themselves (index 3) or their rates (index 2); the other
one of the two drifts.
"""

from collections.abc import Callable
from typing import Any, ClassVar

from gnomon.cases.core.forms import Constrained, Form
from gnomon.harness.contract.constraints import constraints_of
from gnomon.harness.contract.integrator import Integrator, Problem
from gnomon.harness.integrators.base.fixed_step import FixedStep, Table
from gnomon.harness.integrators.base.stepping import StepData, evaluate
from gnomon.harness.integrators.gauss.gauss_steps import MOST_ITERATIONS, SMALLEST, has_settled
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.geometric.constrained_parts import explicit_parts
from gnomon.harness.kernels.equations import Kernel, check_values

INDEX = 3
"""The index of the formulation, which is compiled in."""
STAGES = 3
UNITS = 64
"""Units of round-off that count as settled: constraints of several bodies amplify it, as in Andrews' mechanism."""
FIRST, LEFT, ROWS = 1, 4, 7
"""Rows of `store`: of the first stage's slopes; of its multipliers; of the linear equations."""


def radau_step(s: StepData, t: Any, h: Any) -> bool:
    """One step, with slopes by fixed-point iteration and multipliers by Newton's method.

    Rows of `table`: for each stage c_j, a_j1, a_j2, a_j3; three rows of A^-1 A^-1 at index 3, of A^-1 at index 2; the
    unit round-off. `call` computes at a state, for n coordinates and m constraints: the n accelerations without
    constraints; the m constraints; their rates g_t at a constant place; G by rows; M^-1 G^T by columns.

    `store` holds a flag and the values of the constraints at the start of the motion; for each stage its slopes
    (velocities, accelerations) and its multipliers; m rows of G M^-1 G^T with three right-hand sides. Scaled by h^2 at
    index 3, by h at index 2, the residuals of the constraints give changes of the multipliers whose matrix does not
    depend on h: a Kronecker product of the matrix in `table` and (G M^-1 G^T)^-1 at the end of the step.
    """
    table, y, x, slope, store, increment = s.table, s.y, s.x, s.slope, s.store, s.increment
    n = y.size // 2
    m = (slope.size - n) // (2 * n + 2)
    gradient = n + 2 * m
    pushed = gradient + m * n
    if store[0, 0] == 0.0:
        begin(s, t, n, m)
    least, stalled = 0.0, 0
    for iteration in range(MOST_ITERATIONS):
        change = 0.0
        for j in range(STAGES):
            for i in range(2 * n):
                total = table[j, 1] * store[FIRST, i]
                for k in range(1, STAGES):
                    total += table[j, k + 1] * store[FIRST + k, i]
                x[i] = y[i] + h * total
            evaluate(s, t + table[j, 0] * h)
            for i in range(n):
                pulled = slope[i]
                for k in range(m):
                    pulled -= slope[pushed + k * n + i] * store[LEFT + j, k]
                change = max(change, measure_change(s, h, j, i, x[n + i]), measure_change(s, h, j, n + i, pulled))
                store[FIRST + j, i] = x[n + i]
                store[FIRST + j, n + i] = pulled
            for k in range(m):
                beyond = slope[n + k] - store[0, 1 + k]
                if INDEX == 2:
                    beyond = slope[n + m + k]
                    for i in range(n):
                        beyond += slope[gradient + k * n + i] * x[n + i]
                store[ROWS + k, m + j] = beyond
        if not change < 1e300:
            return False
        for k in range(m):
            for c in range(m):
                product = 0.0
                for i in range(n):
                    product += slope[gradient + k * n + i] * slope[pushed + c * n + i]
                store[ROWS + k, c] = product
        eliminate_stages(store, m)
        change = max(change, correct(s, h, n, m))
        if not change < 1e300:
            return False
        stalled = stalled + 1 if change >= least else 0
        if has_settled(iteration, change, least, stalled, table[2 * STAGES, 0]):
            for i in range(2 * n):
                total = table[STAGES - 1, 1] * store[FIRST, i]
                for k in range(1, STAGES):
                    total += table[STAGES - 1, k + 1] * store[FIRST + k, i]
                increment[i] = h * total
            return True
        least = change if iteration == 0 else min(least, change)
    return False


def begin(s: Any, t: Any, n: int, m: int) -> None:
    """Store the values of the constraints at the start, and its slopes without multipliers as first guesses of all stages."""
    y, x, slope, store = s.y, s.x, s.slope, s.store
    for i in range(2 * n):
        x[i] = y[i]
    evaluate(s, t)
    store[0, 0] = 1.0
    for k in range(m):
        store[0, 1 + k] = slope[n + k]
    for j in range(STAGES):
        for i in range(n):
            store[FIRST + j, i] = y[n + i]
            store[FIRST + j, n + i] = slope[i]


def measure_change(s: Any, h: Any, j: int, i: int, value: Any) -> Any:
    """The change of a slope over a step, relative to the largest position or velocity.

    At index 3 the change of a velocity is multiplied by h and compared with the positions, because the round-off of
    velocities is the round-off of positions over h.
    """
    y, store = s.y, s.store
    n = y.size // 2
    first, change = 0, abs(h * (value - store[FIRST + j, i]))
    if i >= n:
        if INDEX == 3:
            change = h * change
        else:
            first = n
    size = SMALLEST
    for k in range(first, first + n):
        size = max(size, abs(y[k]) + abs(h * store[FIRST + j, k]))
    return change / size


def eliminate_stages(store: Any, m: int) -> None:
    """Solve m equations with three right-hand sides, in the columns from m on. See `rattle.eliminate`."""
    for k in range(m):
        for c in range(k + 1, m + STAGES):
            store[ROWS + k, c] /= store[ROWS + k, k]
        for j in range(k + 1, m):
            for c in range(k + 1, m + STAGES):
                store[ROWS + j, c] -= store[ROWS + j, k] * store[ROWS + k, c]
    for back in range(1, m):
        row = m - 1 - back
        for j in range(STAGES):
            for c in range(m - back, m):
                store[ROWS + row, m + j] -= store[ROWS + row, c] * store[ROWS + c, m + j]


def correct(s: Any, h: Any, n: int, m: int) -> Any:
    """Correct multipliers and slopes of all stages; returns the largest change, as `measure_change` does.

    The three solutions of the linear equations, in columns m to m + 2 of the last m rows of `store`, are combined by the
    matrix in rows 3 to 5 of `table` to changes of the multipliers. M^-1 G^T, the last m n numbers of `slope`, turns these
    into changes of the accelerations.
    """
    table, slope, store = s.table, s.slope, s.store
    pushed = n + 2 * m + m * n
    scale = h * h if INDEX == 3 else h
    largest = 0.0
    for j in range(STAGES):
        for k in range(m):
            moved = 0.0
            for c in range(STAGES):
                moved += table[STAGES + j, c] * store[ROWS + k, m + c]
            store[LEFT + j, k] += moved / scale
            for i in range(n):
                share = moved / scale * slope[pushed + k * n + i]
                value = store[FIRST + j, n + i] - share
                largest = max(largest, measure_change(s, h, j, n + i, value))
                store[FIRST + j, n + i] = value
                for other in range(STAGES):
                    store[FIRST + other, i] -= h * table[other, j + 1] * share
    return largest


class ConstrainedRadau(FixedStep):
    """Three stages of Radau IIA at a fixed step on a constrained motion."""

    accepts = (Constrained,)
    step = radau_step
    index: ClassVar[int]

    def equations(self, form: Form) -> Callable[..., Any]:
        assert isinstance(form, Constrained)
        return explicit_parts(form, of_state=True)

    def shape(self, form: Form, dimension: int, parameters: int) -> tuple[tuple[int, int], int]:
        assert isinstance(form, Constrained)
        n = dimension // 2
        m = constraints_of(form, n, parameters)
        return (dimension, n + m * (2 * n + 2)), ROWS + m

    def constants(self, shape: tuple[tuple[int, int], int]) -> tuple[tuple[str, int], ...]:
        return (("INDEX", self.index),)

    def kernel(self, problem: Problem) -> Kernel:
        form, n, known = problem.form, problem.dimension // 2, len(problem.parameters)
        assert isinstance(form, Constrained)
        m = constraints_of(form, n, known)
        wanted = {form.force: n, form.gradient: m * n, form.mass: n * n, form.constraint_rate: m}
        for function, count in wanted.items():
            if function is not None:
                check_values(function, (n, known), count)
        if form.velocity_force is not None:
            check_values(form.velocity_force, (2 * n, known), n)
        return super().kernel(problem)

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        rows = [row[: STAGES + 1] for row in Radau5.tableau(mp).rows(mp)[:STAGES]]
        inverse = mp.matrix([row[1:] for row in rows]) ** -1
        return [*rows, *(inverse * inverse if cls.index == 3 else inverse).tolist()]

    def table(self, mp: Any, form: Form, parameters: Any, roundoff: Any) -> Table:
        return [*self.coefficients(mp), [UNITS * roundoff]]


class RadauIndex3(ConstrainedRadau):
    """The constraints themselves at each stage, multipliers scaled by h^2: 5 in position, 3 in velocity. Order 3.

    Velocities leave the constraints, so `conserves` has no "constraint".
    """

    name, order, index = "Radau IIA index 3", 3, 3


class RadauIndex2(ConstrainedRadau):
    """The rates of the constraints at each stage, multipliers scaled by h; the constraints drift. Order 5."""

    name, order, index = "Radau IIA index 2", 5, 2


INTEGRATORS: tuple[type[Integrator], ...] = (RadauIndex3, RadauIndex2)
