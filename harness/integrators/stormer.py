"""Störmer's multistep methods of high order for q'' = a(t, q): one right-hand side a step, in compensated summed form."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from math import comb
from typing import Any, ClassVar

from gnomon.cases.forms import Form, SecondOrder
from gnomon.harness.integrator import Integrator, Steps
from gnomon.harness.integrators import embedded, nystrom, nystrom_table
from gnomon.harness.integrators.fixed_step import FixedStep, Floats, Table, kept
from gnomon.harness.integrators.nystrom import DormandPrinceNystrom12, nystrom_increment
from gnomon.harness.integrators.stepping import call

STARTER = DormandPrinceNystrom12
HISTORY = 3
"""Rows of `store` before the accelerations, newest first, and the stages of the starting method: the number of steps
made; the last change of the position and what its sum has lost to round-off; Störmer's sum for the next step."""


def stormer_step(
    f: Any, t: Any, h: Any, y: Any, p: Any, table: Any, x: Any, slope: Any, store: Any, increment: Any
) -> bool:
    """Rows of `table`: Störmer's coefficients of a_n, a_n-1, ...; those of the velocity of a_n+1, a_n, ...; then the
    starting method's, which makes the steps until there are as many accelerations as Störmer's formula takes.

    q_n+1 - q_n is kept and summed with compensation, so that no difference of neighbouring positions is ever taken.
    """
    half = x.size
    stages = table.shape[0] - 4
    order = store.shape[0] - HISTORY - stages - 1
    made = int(store[0, 0])
    store[0, 0] += 1
    if made == 0:
        for i in range(half):
            x[i] = y[i]
        call(f, t, x, p, slope)
        for i in range(half):
            store[HISTORY, i] = slope[i]
    if made < order - 1:
        work = store[HISTORY + order + 1 :]
        for i in range(half):
            work[0, i] = store[HISTORY, i]
        nystrom_increment(f, t, h, y, p, table[2:], stages, x, slope, work, increment)
        for i in range(half):
            store[1, i] = increment[i]
    else:
        for i in range(half):
            change = h * h * store[2, i] + store[1, half + i]
            moved = store[1, i] + change
            store[1, half + i] = change - (moved - store[1, i])
            store[1, i] = moved
            increment[i] = moved
    for i in range(half):
        x[i] = y[i] + increment[i]
    call(f, t + h, x, p, slope)
    for i in range(half):
        # Oldest first: all but the last terms are summed while the processor waits for the slope.
        position, velocity = 0.0, 0.0
        for m in range(order, 0, -1):
            value = store[HISTORY + m - 1, i]
            store[HISTORY + m, i] = value
            position += table[0, m] * value
            velocity += table[1, m] * value
        store[HISTORY, i] = slope[i]
        store[2, i] = position + table[0, 0] * slope[i]
        if made >= order - 1:
            increment[half + i] = h * (velocity + table[1, 0] * slope[i])
    return True


class Stormer(FixedStep):
    """Störmer's explicit formula for the position, the implicit Adams formula for the velocity: as the acceleration
    does not depend on the velocity, both are explicit. Started by RKN 12(10) at the same step. Sums are compensated.

    Störmer 1907; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, III.1 and III.10.
    """

    accepts = (SecondOrder,)
    step = stormer_step
    compensated = True
    order: ClassVar[int]

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        formulas = (stormer_weights(cls.order), adams_weights(cls.order + 1))
        rows = [[mp.mpf(x.numerator) / x.denominator for x in formula] for formula in formulas]
        return [*rows, *STARTER.fixed_rows(mp)]

    def binary64(self, form: Form, parameters: Sequence[float], h: float) -> Floats:
        modules = (__name__, *(module.__name__ for module in (embedded, nystrom, nystrom_table)))
        return kept(f"Störmer {self.order}", modules, lambda: super(Stormer, self).binary64(form, parameters, h))

    def rows(self, form: Form) -> int:
        return HISTORY + self.order + 1 + len(STARTER.stages)


@cache
def stormer_weights(count: int) -> tuple[Fraction, ...]:
    """Of a_n, a_n-1, ..., `count` of them: q_n+1 - 2 q_n + q_n-1 = h^2 sum, exact for polynomials."""
    logarithm = reciprocal([Fraction(1, j + 1) for j in range(count)])
    differences = times(times(logarithm, logarithm), [Fraction(1)] * count)
    return ordinates(differences)


@cache
def adams_weights(count: int) -> tuple[Fraction, ...]:
    """Of a_n+1, a_n, ..., `count` of them: v_n+1 - v_n = h sum, exact for polynomials."""
    return ordinates(reciprocal([Fraction(1, j + 1) for j in range(count)]))


def reciprocal(series: list[Fraction]) -> list[Fraction]:
    """1 over a power series that begins with 1, to as many terms."""
    found = [Fraction(1)]
    for n in range(1, len(series)):
        found.append(-sum((series[j] * found[n - j] for j in range(1, n + 1)), Fraction(0)))
    return found


def times(a: list[Fraction], b: list[Fraction]) -> list[Fraction]:
    """The product of two power series, to as many terms."""
    return [sum((a[j] * b[n - j] for j in range(n + 1)), Fraction(0)) for n in range(len(a))]


def ordinates(differences: list[Fraction]) -> tuple[Fraction, ...]:
    """Weights of values, newest first, from those of their backward differences of order 0, 1, ..."""
    return tuple(
        sum(((-1) ** m * comb(j, m) * weight for j, weight in enumerate(differences)), Fraction(0))
        for m in range(len(differences))
    )


class Stormer8(Stormer):
    """Eight accelerations. Order 8."""

    name, order = "Störmer 8", 8
    everywhere = False
    sweep = Steps(coarsest=0.25, halvings=8)


class Stormer12(Stormer):
    """Twelve accelerations. Order 12."""

    name, order = "Störmer 12", 12
    everywhere = False
    sweep = Steps(coarsest=0.125, halvings=7)


INTEGRATORS: tuple[type[Integrator], ...] = (Stormer8, Stormer12)
