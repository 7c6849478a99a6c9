"""Gauss-Legendre methods: implicit Runge-Kutta of order 2s with s stages, solved by fixed-point or Newton iteration."""

from collections.abc import Sequence
from functools import cache
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder, Form, SecondOrder
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Steps
from gnomon.harness.integrators.base import tableau
from gnomon.harness.integrators.base.fixed_step import DIGITS, FixedStep, Loop, Table, keep_table, round_table
from gnomon.harness.integrators.base.tableau import ButcherTableau
from gnomon.harness.integrators.gauss.gauss_steps import gauss_step, newton_numbers, newton_step
from gnomon.harness.kernels.straight_line import derivatives_if_traced
from gnomon.reference.numerics.precision import nearest_double, working
from numpy.typing import NDArray

STEPS_BACK = {1: 4, 2: 2, 3: 2}
"""The number of last steps whose slopes are extrapolated, by the number of stages. It is 1 for more stages, as
polynomials of higher degree magnify round-off."""

SHORT = 42
"""Significant bits of the leading part of a coefficient. The rest is up to 2^10 times larger than after 53 bits."""


class Gauss(FixedStep):
    """The Gauss-Legendre method of `stages` stages, order 2s (Kuntzmann 1961, Butcher, Math. Comp. 18, 1964).

    Starting values by extrapolation of the last steps' slopes, and the iteration to round-off, follow Hairer, Lubich,
    Wanner VIII.6. Second-order equations are solved in Nyström form. Sums are compensated (Hairer, McLachlan,
    Razakarivony, BIT 48, 2008).

    If the fixed-point iteration does not converge in a step, the motion is stiff or the steps are long. The trajectory
    is then integrated again from its start, by Newton's iteration with the exact Jacobian (differentiated from the
    equations, IV.8 of Hairer and Wanner, Solving Ordinary Differential Equations II, 1996). Both iterations solve the
    same equations to round-off. Evaluations of the Jacobian are not counted as right-hand sides.
    """

    accepts = (FirstOrder, SecondOrder)
    conserves = ("symplectic", "reversible", "momentum")
    compensated = True
    step = gauss_step
    stages: ClassVar[int]

    def rows(self, form: Form) -> int:
        return 1 + (1 + STEPS_BACK.get(self.stages, 1)) * self.stages

    def table(self, mp: Any, form: Form, parameters: Any, roundoff: Any) -> Table:
        """The table of `gauss_step`: coefficients that conserve quadratic invariants exactly.

        A step is symplectic if m_ij + m_ji = 1 with m_ij = a_ij / b_j, or, for q'' = f, if m_ij - m_ji = c_i - c_j with
        m_ij = (a^2)_ij / b_j. Coefficients that are multiples of a power of two satisfy this condition, the sum of b
        and the symmetry of the nodes without rounding (Antoñana, Makazaga, Murua, Numer. Algorithms 76, 2017).
        """
        stages, second = self.stages, isinstance(form, SecondOrder)
        s, middle, zero = range(stages), stages // 2, mp.mpf(0)
        rows, b = stage_rows(mp, stages, second, mp.prec)
        exact = [row[0] for row in rows]
        points = [node - back for back in range(STEPS_BACK.get(stages, 1)) for node in exact]
        guesses = [
            [zero, *(value * b[j] / b[k % stages] for k, value in enumerate(row))]
            for j, row in enumerate(lagrange(mp, points, [1 + node for node in exact]))
        ]

        def multiple(value: Any, bits: int) -> Any:
            return value if roundoff <= mp.eps else mp.nint(mp.ldexp(value, bits)) / mp.mpf(2) ** bits

        low = [multiple(node, 53) for node in exact[:middle]]
        c = [*low, *[mp.mpf(1) / 2] * (stages % 2), *(1 - node for node in reversed(low))]
        m = [[multiple(rows[i][1 + j] / b[j], 52) for j in s] for i in s]
        for i in s:
            for j in range(i):
                m[j][i] = m[i][j] - (c[i] - c[j]) if second else 1 - m[i][j]
        low = [multiple(weight, 53) for weight in b[: (stages - 1) // 2]]
        rest = 1 - 2 * mp.fsum(low)
        b = [*low, *([rest] if stages % 2 else [rest / 2] * 2), *reversed(low)]
        last = [[roundoff, *b], *([[zero, *(1 - node for node in c)]] if second else [])]
        return [*([c[i], *m[i]] for i in s), *guesses, *last]

    def loop(self, problem: Problem, h: float, substeps: int) -> Loop:
        fixed_point = super().loop(problem, h, substeps)

        def run(initial: Floats, out: Floats, stop: NDArray[np.int64]) -> int:
            taken = fixed_point(initial, out, stop)
            newton = self.by_newton(problem, h, substeps) if stop[0] else None
            if newton is None:
                return taken
            stop[:] = 0
            for i in np.flatnonzero(np.isnan(out[:, -1]).any(axis=1)):
                own = np.zeros_like(stop)
                out[i] = np.nan
                taken += newton(initial[i : i + 1], out[i : i + 1], own)
                if own[0] and not stop[0]:
                    stop[:] = own[0], i, own[2]
            return taken

        return run

    def by_newton(self, problem: Problem, h: float, substeps: int) -> Loop | None:
        """The loop that takes these steps by Newton's iteration; None if the equations cannot be differentiated."""
        form, dimension = problem.form, problem.dimension
        assert isinstance(form, FirstOrder | SecondOrder)
        width, _ = self.widths(form, dimension)
        kernel = derivatives_if_traced(FirstOrder(self.equations(form)), width, len(problem.parameters), True)
        if kernel is None:
            return None
        rows = -(-newton_numbers(self.stages, width) // dimension)
        table = newton_table(self.stages, isinstance(form, SecondOrder))
        shape = (width, width * (1 + width)), rows
        return self.advancing(problem, h, substeps, newton_step, kernel.counted().address, table, shape)

    def binary64(self, form: Form, parameters: Sequence[float], h: float) -> Floats:
        name = f"Gauss {self.stages} {isinstance(form, SecondOrder)}"
        return keep_table(name, (__name__, tableau.__name__), lambda: super(Gauss, self).binary64(form, parameters, h))

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        return cls.tableau(mp).rows(mp)

    @classmethod
    def tableau(cls, mp: Any) -> ButcherTableau:
        """Collocation at the zeros of the Legendre polynomial shifted to [0, 1]."""
        return collocation(mp, nodes(mp, cls.stages), 2 * cls.stages)


@cache
def newton_table(stages: int, second_order: bool) -> Floats:
    def build() -> Floats:
        with working(DIGITS) as mp:
            return round_table(newton_rows(mp, stages, second_order, mp.mpf(2) ** -52))

    return keep_table(f"Gauss by Newton {stages} {second_order}", (__name__, tableau.__name__), build)


def newton_rows(mp: Any, stages: int, second_order: bool, roundoff: Any) -> Table:
    """The table of `newton_step`.

    For y' = f the state changes by b^T A^-1 z. For q'' = f the position changes by b^T A^-1 z and the velocity by
    b^T A^-2 (z - c h v) / h. Here b^T A^-2 c = b^T A^-1 1 is 2 for an odd number of stages and 0 for an even one.
    """
    rows, b = stage_rows(mp, stages, second_order, mp.prec)
    inverse = mp.matrix([row[1:] for row in stage_rows(mp, stages, False, mp.prec)[0]]) ** -1
    change = mp.matrix([b]) * inverse
    last = [[roundoff, *change], [mp.mpf(-2 * (stages % 2)), *(change * inverse)]]
    return [*rows, *with_rounding_residuals(mp, rows, last, second_order, roundoff)]


def with_rounding_residuals(mp: Any, rows: Table, last: Table, second_order: bool, roundoff: Any) -> Table:
    """The `last` rows of a table, each split in two (see `halves`), then one row with a residual for each of `rows`.

    The residual is the sum of the rounding residuals of the coefficients or, for second-order equations, the rounding
    residual of the node.
    """
    halved = [half for row in last for half in halves(mp, row, roundoff)]
    return [*halved, [mp.fsum(rounding_residuals(mp, row[:1] if second_order else row[1:], roundoff)) for row in rows]]


def halves(mp: Any, row: Sequence[Any], roundoff: Any) -> tuple[list[Any], list[Any]]:
    """Split a row of numbers into parts of SHORT bits and rests, which are 0 if the step runs in the context's digits.

    Sums begin with the rests. After 53 bits a rest would be a fraction of the last bit. A product with a simple number,
    such as 1/4 or 5/18, rounds such a fraction in the same way in every step: it is lost, and the energy drifts as t.
    """
    if roundoff <= mp.eps:
        return list(row), [mp.mpf(0)] * len(row)
    with mp.workprec(SHORT):
        high = [+value for value in row]
    return high, [value - short for value, short in zip(row, high, strict=True)]


def rounding_residuals(mp: Any, row: Sequence[Any], roundoff: Any) -> list[Any]:
    """The numbers minus their rounding to binary64; 0 if the step runs in the context's digits."""
    return [mp.mpf(0) if roundoff <= mp.eps else value - mp.mpf(nearest_double(value)) for value in row]


@cache
def stage_rows(mp: Any, stages: int, second_order: bool, precision: int) -> tuple[Table, list[Any]]:
    """Rows (c_j, a_j1 ...) and the weights b. For second-order equations the matrix is squared."""
    *rows, (_, *b) = collocation(mp, nodes(mp, stages), 2 * stages).rows(mp)
    if second_order:
        s = range(1, stages + 1)
        rows = [[c, *(mp.fsum(a[m - 1] * rows[m - 1][k] for m in s) for k in s)] for c, *a in rows]
    return rows, b


def collocation(mp: Any, c: Sequence[Any], order: int) -> ButcherTableau:
    """The implicit method that integrates the polynomial through the slopes at the nodes `c`, to each node and to 1."""
    *a, b = (dict(enumerate(integrals(mp, c, upper))) for upper in (*c, mp.mpf(1)))
    return ButcherTableau((order,), tuple(a), b, tuple(c))


def nodes(mp: Any, stages: int) -> list[Any]:
    """The zeros of the shifted Legendre polynomial, by Newton's method from estimates similar to Chebyshev nodes."""
    zeros = []
    for j in range(1, stages + 1):
        x = -mp.cos(mp.pi * (4 * j - 1) / (4 * stages + 2))
        for _ in range(12):
            previous, value = mp.mpf(1), x
            for n in range(1, stages):
                previous, value = value, ((2 * n + 1) * x * value - n * previous) / (n + 1)
            x -= value * (x * x - 1) / (stages * (x * value - previous))
        zeros.append((1 + x) / 2)
    return zeros


def basis(mp: Any, c: Sequence[Any]) -> list[list[Any]]:
    """Coefficients, lowest first, of the polynomials that are 1 at one node and 0 at the other nodes."""
    polynomials = []
    for j, node in enumerate(c):
        polynomial = [mp.mpf(1)]
        for other in [*c[:j], *c[j + 1 :]]:
            shifted = [mp.mpf(0), *polynomial]
            polynomial = [(s - other * q) / (node - other) for s, q in zip(shifted, [*polynomial, 0], strict=True)]
        polynomials.append(polynomial)
    return polynomials


def integrals(mp: Any, c: Sequence[Any], upper: Any) -> list[Any]:
    """Integrals of the basis polynomials from 0 to `upper`."""
    return [mp.fsum(q * upper ** (k + 1) / (k + 1) for k, q in enumerate(p)) for p in basis(mp, c)]


def lagrange(mp: Any, c: list[Any], points: list[Any]) -> list[list[Any]]:
    """Values of the basis polynomials at each of `points`."""
    polynomials = basis(mp, c)
    return [[mp.fsum(q * x**k for k, q in enumerate(p)) for p in polynomials] for x in points]


class ImplicitMidpoint(Gauss):
    """The implicit midpoint rule: the Gauss method of one stage. Order 2."""

    name, order, stages = "Implicit midpoint", 2, 1
    primary = False


class Gauss2(Gauss):
    """The Gauss method of two stages (Hammer and Hollingsworth, 1955). Order 4."""

    name, order, stages = "Gauss 2-stage", 4, 2


class Gauss3(Gauss):
    """The Gauss method of three stages. Order 6."""

    name, order, stages = "Gauss 3-stage", 6, 3
    primary = False


class Gauss4(Gauss):
    """The Gauss method of four stages. Order 8."""

    name, order, stages = "Gauss 4-stage", 8, 4
    sweep = Steps(coarsest=1.0, halvings=8)


class Gauss5(Gauss):
    """The Gauss method of five stages. Order 10."""

    name, order, stages = "Gauss 5-stage", 10, 5
    primary = False
    sweep = Steps(coarsest=1.0, halvings=7)


class Gauss6(Gauss):
    """The Gauss method of six stages. Order 12."""

    name, order, stages = "Gauss 6-stage", 12, 6
    primary = False
    sweep = Steps(coarsest=1.0, halvings=7)


class Gauss7(Gauss):
    """The Gauss method of seven stages. Order 14."""

    name, order, stages = "Gauss 7-stage", 14, 7
    primary = False
    sweep = Steps(coarsest=1.0, halvings=7)


class Gauss8(Gauss):
    """The Gauss method of eight stages. Order 16."""

    name, order, stages = "Gauss 8-stage", 16, 8
    primary = False
    sweep = Steps(coarsest=2.0, halvings=7)


INTEGRATORS: tuple[type[Integrator], ...] = (
    ImplicitMidpoint, Gauss2, Gauss3, Gauss4, Gauss5, Gauss6, Gauss7, Gauss8,
)  # fmt: skip
