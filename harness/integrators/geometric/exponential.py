"""Exponential Runge-Kutta methods: the linear part of the equations, which may be stiff, is solved exactly."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import Form, SemiLinear
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solver
from gnomon.harness.integrators.base.fixed_step import DIGITS, FixedStep, Table, keep_table
from gnomon.harness.integrators.base.stepping import StepData, evaluate, product, sum_of
from gnomon.harness.integrators.gauss.gauss import halves
from gnomon.harness.kernels.equations import Kernel, check_values
from gnomon.reference.numerics.precision import working

Matrix = Any
"""A square numpy array of mpmath numbers."""
Phi = Callable[[int, Any], Matrix]
"""A function (k, c) -> phi_k(c h L)."""


def exponential_step(s: StepData, t: Any, h: Any) -> bool:
    """One step of an exponential Runge-Kutta method.

    Rows of `table`: c_1 ... c_s; for each stage and for the end the matrices exp(c h L) - 1 and h a_1 ... h a_s, each
    as one row; for the matrices of the end the rests beyond their leading bits. Without the rests the errors of the
    linear part and of a constant slope would grow as t.

    A constant slope adds equal numbers in every step, and their roundings may be equal too. So their residuals are
    carried to the sum with the state and, in the last row of `store`, to the next step.
    """
    table, y, x, slope, store, increment = s.table, s.y, s.x, s.slope, s.store, s.increment
    n = y.size
    stages = store.shape[0] - 1
    for j in range(stages + 1):
        first = 1 + j * (stages + 1)
        for i in range(n):
            if j == stages:
                total = combine(store[stages, i], table, first + stages + 1, i, y, store, j)
                slopes = 0.0
                for m in range(stages):
                    for k in range(n):
                        added, first_lost = product(table[first + 1 + m, i * n + k], store[m, k])
                        slopes, second_lost = sum_of(slopes, added)
                        total += first_lost + second_lost
                total = combine(total, table, first, i, y, store, 0)
                total, store[stages, i] = sum_of(total, slopes)
            else:
                total = combine(0.0, table, first, i, y, store, j)
            increment[i] = total
        if j < stages:
            for i in range(n):
                x[i] = y[i] + increment[i]
            evaluate(s, t + table[0, j] * h)
            for i in range(n):
                store[j, i] = slope[i]
    return True


def combine(total: Any, table: Any, first: Any, i: Any, y: Any, store: Any, count: Any) -> Any:
    """Add to `total` component i of the products of matrices with the state and with the first `count` slopes.

    The matrices are the rows of `table` from `first` on.
    """
    n = y.size
    for m in range(count):
        for k in range(n):
            total += table[first + 1 + m, i * n + k] * store[m, k]
    for k in range(n):
        total += table[first, i * n + k] * y[k]
    return total


class ExponentialRungeKutta(FixedStep):
    """An exponential Runge-Kutta method, given by its nodes and its coefficients: matrices of phi functions of h L.

    phi_0 = exp, phi_k(z) = (phi_{k-1}(z) - 1/(k-1)!)/z. The step calls the nonlinear rest of the equations.
    """

    accepts = (SemiLinear,)
    compensated = True
    may_stop_aside = False  # its coefficients hold for one step size
    step = exponential_step
    function = "rest"
    nodes: ClassVar[tuple[float, ...]]

    @classmethod
    @abstractmethod
    def tableau(cls, phi: Phi) -> list[list[Matrix]]:
        """The coefficients a_j1 ... a_j,j-1 of each stage j, then b_1 ... b_s."""

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        return [[mp.mpf(c) for c in cls.nodes]]

    def kernel(self, problem: Problem) -> Kernel:
        assert isinstance(problem.form, SemiLinear)
        n, known = problem.dimension, len(problem.parameters)
        check_values(problem.form.linear, (known,), n * n)
        return super().kernel(problem)

    def rows(self, form: Form) -> int:
        return len(self.nodes) + 1

    def prepare(self, problem: Problem, setting: float) -> Solver:
        if not problem.uniform:
            raise Refused("its coefficients hold for one step size; these samples need others in between")
        return super().prepare(problem, setting)

    def table_for(self, mp: Any, form: Form, parameters: Sequence[Any], roundoff: Any, h: Any) -> Table:
        assert isinstance(form, SemiLinear)
        entries = [mp.mpf(x) * h for x in form.linear(tuple(parameters))]
        n = round(len(entries) ** 0.5)
        known = {c: phi_functions(mp, c * np.array(entries).reshape(n, n)) for c in {*self.nodes, 1}}
        rows = [*self.tableau(lambda k, c: known[c][k])]
        table = self.coefficients(mp)
        flat = []
        for c, row in zip((*self.nodes, 1), rows, strict=True):
            less_one = known[c][0] - np.eye(n, dtype=int)
            blanks = [less_one * 0] * (len(self.nodes) - len(row))
            flat += [less_one, *(h * a for a in row), *blanks]
        flattened = [list(matrix.ravel()) for matrix in flat]
        end = [halves(mp, row, roundoff) for row in flattened[-len(self.nodes) - 1 :]]
        return [*table, *flattened[: -len(end)], *(high for high, _ in end), *(rest for _, rest in end)]


def phi_functions(mp: Any, z: Matrix, count: int = 4) -> list[Matrix]:
    """phi_0 ... phi_{count-1} of a matrix: Taylor series of z / 2^s, doubled s times (Skaflestad and Wright, 2009).

    Rows of very different size lose digits; working digits are added in proportion to the logarithm of the matrix's
    size.
    """
    size = max(mp.mpf(1), max(abs(x) for x in z.ravel()) * len(z))
    doublings = int(mp.ceil(mp.log(size, 2))) + 1
    with mp.workdps(mp.dps + 10 + int(3 * mp.log10(size))):
        scaled = z / mp.mpf(2) ** doublings
        unit = np.array([[mp.mpf(int(i == j)) for j in range(len(z))] for i in range(len(z))], dtype=object)
        term = unit / mp.factorial(count - 1)
        last, k = term, count
        while max(abs(x) for x in term.ravel()) > mp.eps:
            term = term.dot(scaled) / k
            last, k = last + term, k + 1
        values = [last]
        for k in range(count - 2, -1, -1):
            values.insert(0, scaled.dot(values[0]) + unit / mp.factorial(k))
        for _ in range(doublings):
            values = [_double(mp, values, k) for k in range(count)]
    return values


def _double(mp: Any, phi: list[Matrix], k: int) -> Matrix:
    total = phi[0].dot(phi[k])
    for j in range(1, k + 1):
        total = total + phi[j] / mp.factorial(k - j)
    return total / 2**k


class HochbruckOstermann4(ExponentialRungeKutta):
    """Hochbruck and Ostermann's method of five stages, also for stiff problems. Order 4.

    Hochbruck and Ostermann, SIAM J. Numer. Anal. 43, 2005.
    """

    name, order = "Exponential Runge-Kutta 4", 4
    nodes = (0, 0.5, 0.5, 1, 0.5)

    def binary64(self, form: Form, parameters: Sequence[float], h: float) -> Floats:
        assert isinstance(form, SemiLinear)
        with working(DIGITS) as mp:
            linear = form.linear(tuple(map(mp.mpf, parameters)))
        name = f"{self.name} {linear!r} {h!r}"
        return keep_table(
            name, (__name__, halves.__module__), lambda: super(HochbruckOstermann4, self).binary64(form, parameters, h)
        )

    @classmethod
    def tableau(cls, phi: Phi) -> list[list[Matrix]]:
        half = 0.5
        a52 = phi(2, half) / 2 - phi(3, 1) + phi(2, 1) / 4 - phi(3, half) / 2
        a54 = phi(2, half) / 4 - a52
        nothing = a52 * 0
        return [
            [],
            [phi(1, half) / 2],
            [phi(1, half) / 2 - phi(2, half), phi(2, half)],
            [phi(1, 1) - 2 * phi(2, 1), phi(2, 1), phi(2, 1)],
            [phi(1, half) / 2 - 2 * a52 - a54, a52, a52, a54],
            [
                phi(1, 1) - 3 * phi(2, 1) + 4 * phi(3, 1),
                nothing,
                nothing,
                4 * phi(3, 1) - phi(2, 1),
                4 * phi(2, 1) - 8 * phi(3, 1),
            ],
        ]


INTEGRATORS: tuple[type[Integrator], ...] = (HochbruckOstermann4,)
