"""Gauss-Legendre methods: implicit Runge-Kutta of order 2s with s stages, solved by fixed-point iteration."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, ClassVar

from gnomon.cases.forms import FirstOrder, Form, SecondOrder
from gnomon.harness.integrator import Integrator, Steps
from gnomon.harness.integrators.fixed_step import FixedStep, Floats, Table, kept
from gnomon.harness.integrators.stepping import Step, call
from gnomon.reference.precision import nearest_double

MOST_ITERATIONS = 100


def gauss_step(
    f: Any, t: Any, h: Any, y: Any, p: Any, table: Any, x: Any, slope: Any, store: Any, increment: Any
) -> bool:
    """One step for y' = f(t, y). Rows of `table`: c_j, a_j1 ... a_js for each stage; 0 and the coefficients that carry
    the last step's slopes on, for each stage; the unit round-off, b_1 ... b_s; what its rounding has taken from them;
    what rounding has taken from the sums of a_j.

    `store` holds a flag, the slopes k_1 ... k_s and a copy of the last step's. The iteration ends when its next change
    would be far below round-off, or when round-off stops it from shrinking. Coefficients are rounded the same way in
    every step, and so is what is left of the iteration: either would make the energy drift as t (Hairer, McLachlan,
    Razakarivony, BIT 48, 2008).
    """
    stages = (table.shape[0] - 3) // 2
    weights = 2 * stages
    start_stages(f, t, y, p, table, x, slope, store, stages, y.size)
    before = 0.0
    for iteration in range(MOST_ITERATIONS):
        change = 0.0
        for j in range(stages):
            for i in range(y.size):
                total = table[weights + 2, j] * store[j + 1, i]
                for m in range(stages):
                    total += table[j, m + 1] * store[m + 1, i]
                x[i] = y[i] + h * total
            call(f, t + table[j, 0] * h, x, p, slope)
            for i in range(y.size):
                moved = abs(slope[i] - store[j + 1, i])
                if not moved <= MOST:
                    return False
                if moved > 0.0:
                    change = max(change, h * moved / (abs(y[i]) + h * abs(slope[i])))
                store[j + 1, i] = slope[i]
        if settled(iteration, change, before, table[weights, 0]):
            for i in range(y.size):
                total = 0.0
                for m in range(stages):
                    total += table[weights + 1, m + 1] * store[m + 1, i]
                for m in range(stages):
                    total += table[weights, m + 1] * store[m + 1, i]
                increment[i] = h * total
            return True
        before = change
    return False


def gauss_nystrom_step(
    f: Any, t: Any, h: Any, y: Any, p: Any, table: Any, x: Any, slope: Any, store: Any, increment: Any
) -> bool:
    """The same step for q'' = f(t, q), with half the unknowns: the rows of a hold the square of that matrix. After b
    come the weights b_j (1 - c_j), each with what rounding has taken from it, and what it has taken from c."""
    half = x.size
    stages = (table.shape[0] - 5) // 2
    weights = 2 * stages
    start_stages(f, t, y, p, table, x, slope, store, stages, half)
    before = 0.0
    for iteration in range(MOST_ITERATIONS):
        change = 0.0
        for j in range(stages):
            for i in range(half):
                total = 0.0
                for m in range(stages):
                    total += table[j, m + 1] * store[m + 1, i]
                velocity = y[half + i]
                x[i] = y[i] + h * (table[j, 0] * velocity + (table[weights + 4, j] * velocity + h * total))
            call(f, t + table[j, 0] * h, x, p, slope)
            for i in range(half):
                moved = abs(slope[i] - store[j + 1, i])
                if not moved <= MOST:
                    return False
                if moved > 0.0:
                    change = max(change, h * moved / (abs(y[half + i]) + h * abs(slope[i])))
                store[j + 1, i] = slope[i]
        if settled(iteration, change, before, table[weights, 0]):
            for i in range(half):
                total, weighted = 0.0, 0.0
                for m in range(stages):
                    total += table[weights + 1, m + 1] * store[m + 1, i]
                    weighted += table[weights + 3, m + 1] * store[m + 1, i]
                for m in range(stages):
                    total += table[weights, m + 1] * store[m + 1, i]
                    weighted += table[weights + 2, m + 1] * store[m + 1, i]
                increment[i] = h * y[half + i] + h * (h * weighted)
                increment[half + i] = h * total
            return True
        before = change
    return False


def start_stages(
    f: Any, t: Any, y: Any, p: Any, table: Any, x: Any, slope: Any, store: Any, stages: int, width: int
) -> None:
    """First guesses of the slopes: the last step's polynomial carried on; at the very first step the slope at t."""
    if store[0, 0] == 0.0:
        store[0, 0] = 1.0
        for i in range(width):
            x[i] = y[i]
        call(f, t, x, p, slope)
        for j in range(stages):
            for i in range(width):
                store[j + 1, i] = slope[i]
    else:
        for j in range(stages):
            for i in range(width):
                store[stages + j + 1, i] = store[j + 1, i]
        for j in range(stages):
            for i in range(width):
                total = 0.0
                for m in range(stages):
                    total += table[stages + j, m + 1] * store[stages + m + 1, i]
                store[j + 1, i] = total


def settled(iteration: int, change: Any, before: Any, roundoff: Any) -> bool:
    """Whether the stages are as good as the arithmetic: `change` is the last iteration's, relative to the state."""
    if change <= roundoff:
        return True
    if iteration == 0:
        return False
    if change >= before:
        return bool(change < NOISE * roundoff)
    return bool(change * change / before < FAR_BELOW * roundoff)


FAR_BELOW = 2.5e-4
"""What is left of the iteration has a sign that lasts: over 1e7 steps it must stay below the walk of their round-off."""

MOST = 1e300
"""A slope beyond this, or not a number, ends the iteration."""

NOISE = 1e6
"""Where changes stop shrinking below this many units of round-off, it is round-off that stops them (cancellation)."""


class Gauss(FixedStep):
    """The Gauss-Legendre method of `stages` stages, order 2s (Kuntzmann 1961, Butcher, Math. Comp. 18, 1964).

    Starting values from the last step's collocation polynomial and the iteration to round-off follow Hairer, Lubich,
    Wanner VIII.6. Second-order equations are solved in Nyström form. Sums are compensated (Hairer, McLachlan,
    Razakarivony, BIT 48, 2008).
    """

    accepts = (FirstOrder, SecondOrder)
    conserves = ("symplectic", "reversible", "momentum")
    compensated = True
    stages: ClassVar[int]

    def step_for(self, form: Form) -> Step:
        return gauss_nystrom_step if isinstance(form, SecondOrder) else gauss_step

    def rows(self, form: Form) -> int:
        return 1 + 2 * self.stages

    def table(self, mp: Any, form: Form, parameters: Any, roundoff: Any) -> Table:
        rows, weights, nystrom = stage_rows(mp, self.stages, isinstance(form, SecondOrder), mp.prec)
        second = isinstance(form, SecondOrder)
        last = [[roundoff, *weights], *([nystrom] if second else [])]
        stages = rows[: self.stages]
        taken = [mp.fsum(halves(mp, row[:1] if second else row[1:], roundoff)[1]) for row in stages]
        return [*rows, *(half for row in last for half in halves(mp, row, roundoff)), taken]

    def binary64(self, form: Form, parameters: Sequence[float], h: float) -> Floats:
        name = f"Gauss {self.stages} {isinstance(form, SecondOrder)}"
        return kept(name, (__name__,), lambda: super(Gauss, self).binary64(form, parameters, h))

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        c, a, b = cls.tableau(mp)
        return [*([node, *row] for node, row in zip(c, a, strict=True)), [mp.mpf(0), *b]]

    @classmethod
    def tableau(cls, mp: Any) -> tuple[list[Any], list[list[Any]], list[Any]]:
        """Nodes, matrix and weights: collocation at the zeros of the Legendre polynomial shifted to [0, 1]."""
        c = nodes(mp, cls.stages)
        return c, [integrals(mp, c, node) for node in c], integrals(mp, c, mp.mpf(1))


def halves(mp: Any, row: Sequence[Any], roundoff: Any) -> tuple[list[Any], list[Any]]:
    """A row of numbers and what rounding to binary64 takes from it: nothing where the step runs in the context's digits."""
    if roundoff <= mp.eps:
        return list(row), [mp.mpf(0)] * len(row)
    high = [mp.mpf(nearest_double(value)) for value in row]
    return high, [value - double for value, double in zip(row, high, strict=True)]


@cache
def stage_rows(mp: Any, stages: int, second_order: bool, precision: int) -> tuple[Table, list[Any], list[Any]]:
    """Rows c_j, a_j1 ... and rows 0, values of the last step's polynomial at this step's nodes; weights; and 0, weights
    of positions. For second-order equations the matrix is squared."""
    c = nodes(mp, stages)
    a, b = [integrals(mp, c, node) for node in c], integrals(mp, c, mp.mpf(1))
    s = range(stages)
    if second_order:
        a = [[mp.fsum(a[j][m] * a[m][k] for m in s) for k in s] for j in s]
    rows = [[c[j], *a[j]] for j in s] + [[mp.mpf(0), *row] for row in lagrange(mp, c, [1 + node for node in c])]
    return rows, b, [mp.mpf(0), *(b[j] * (1 - c[j]) for j in s)]


def nodes(mp: Any, stages: int) -> list[Any]:
    """The zeros of the shifted Legendre polynomial, by Newton's method from the Chebyshev-like estimates."""
    found = []
    for j in range(1, stages + 1):
        x = -mp.cos(mp.pi * (4 * j - 1) / (4 * stages + 2))
        for _ in range(12):
            previous, value = mp.mpf(1), x
            for n in range(1, stages):
                previous, value = value, ((2 * n + 1) * x * value - n * previous) / (n + 1)
            x -= value * (x * x - 1) / (stages * (x * value - previous))
        found.append((1 + x) / 2)
    return found


def basis(mp: Any, c: list[Any]) -> list[list[Any]]:
    """Coefficients, lowest first, of the polynomials that are 1 at one node and 0 at the others."""
    found = []
    for j, node in enumerate(c):
        polynomial = [mp.mpf(1)]
        for other in [*c[:j], *c[j + 1 :]]:
            shifted = [mp.mpf(0), *polynomial]
            polynomial = [(s - other * q) / (node - other) for s, q in zip(shifted, [*polynomial, 0], strict=True)]
        found.append(polynomial)
    return found


def integrals(mp: Any, c: list[Any], upper: Any) -> list[Any]:
    """Integrals of the basis polynomials from 0 to `upper`."""
    return [mp.fsum(q * upper ** (k + 1) / (k + 1) for k, q in enumerate(p)) for p in basis(mp, c)]


def lagrange(mp: Any, c: list[Any], points: list[Any]) -> list[list[Any]]:
    """Values of the basis polynomials at each of `points`."""
    polynomials = basis(mp, c)
    return [[mp.fsum(q * x**k for k, q in enumerate(p)) for p in polynomials] for x in points]


class ImplicitMidpoint(Gauss):
    """One stage: the implicit midpoint rule. Order 2."""

    name, order, stages = "Implicit midpoint", 2, 1
    everywhere = False


class Gauss2(Gauss):
    """Two stages (Hammer and Hollingsworth, 1955). Order 4."""

    name, order, stages = "Gauss 2-stage", 4, 2


class Gauss3(Gauss):
    """Three stages. Order 6."""

    name, order, stages = "Gauss 3-stage", 6, 3
    everywhere = False


class Gauss4(Gauss):
    """Four stages. Order 8."""

    name, order, stages = "Gauss 4-stage", 8, 4
    sweep = Steps(coarsest=1.0, halvings=8)


class Gauss5(Gauss):
    """Five stages. Order 10."""

    name, order, stages = "Gauss 5-stage", 10, 5
    everywhere = False
    sweep = Steps(coarsest=1.0, halvings=7)


class Gauss6(Gauss):
    """Six stages. Order 12."""

    name, order, stages = "Gauss 6-stage", 12, 6
    everywhere = False
    sweep = Steps(coarsest=1.0, halvings=7)


class Gauss7(Gauss):
    """Seven stages. Order 14."""

    name, order, stages = "Gauss 7-stage", 14, 7
    everywhere = False
    sweep = Steps(coarsest=1.0, halvings=7)


class Gauss8(Gauss):
    """Eight stages. Order 16."""

    name, order, stages = "Gauss 8-stage", 16, 8
    everywhere = False
    sweep = Steps(coarsest=2.0, halvings=7)


INTEGRATORS: tuple[type[Integrator], ...] = (
    ImplicitMidpoint, Gauss2, Gauss3, Gauss4, Gauss5, Gauss6, Gauss7, Gauss8,
)  # fmt: skip
