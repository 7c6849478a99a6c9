"""Störmer's multistep methods for q'' = a(t, q) in compensated summed form: high order, one right-hand side a step."""

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any, ClassVar

from gnomon.cases.core.forms import Form, SecondOrder
from gnomon.harness.contract.integrator import Floats, Integrator, Steps
from gnomon.harness.integrators.base import tableau
from gnomon.harness.integrators.base.fixed_step import FixedStep, Table, keep_table
from gnomon.harness.integrators.base.stepping import StepData, evaluate
from gnomon.harness.integrators.runge_kutta import nystrom_table
from gnomon.harness.integrators.runge_kutta.nystrom import nystrom_increment

STARTER = nystrom_table.RKN_12_10
HISTORY = 4
"""Rows of `store` before the differences of the accelerations and the stages of the starting method: the number of
steps made; the last change of the position and the compensation of its sum; Störmer's sum for the next step; the newest
acceleration, which is not yet in the differences."""


def stormer_step(s: StepData, t: Any, h: Any) -> bool:
    """One step by Störmer's formula, or by the starting method until there are enough accelerations for the formula.

    Rows of `table`: weights of the newest acceleration a and of the backward differences of the accelerations before
    it, for the position and for the velocity (see `coefficients`); then the rows of the starting method.

    q_n+1 - q_n is kept and summed with compensation, so no difference of neighbouring positions is computed. Weights of
    accelerations, instead of differences, would be large and cancel: rounded equally in every step, they would make the
    energy drift as t. Here the terms of differences 0 and 1 are summed without rounding, and the other weights are
    small.
    """
    table, y, x, slope, store, increment = s.table, s.y, s.x, s.slope, s.store, s.increment
    half = x.size
    stages = table.shape[0] - 4
    order = store.shape[0] - HISTORY - stages
    made = int(store[0, 0])
    store[0, 0] += 1
    if made == 0:
        for i in range(half):
            x[i] = y[i]
        evaluate(s, t)
        for i in range(half):
            store[3, i] = slope[i]
    if made < order - 1:
        work = store[HISTORY + order :]
        for i in range(half):
            work[0, i] = store[3, i]
        nystrom_increment(s._replace(table=table[2:], store=work), t, h, stages)
        for i in range(half):
            store[1, i] = increment[i]
    else:
        for i in range(half):
            change = h * h * store[2, i] + store[1, half + i]
            updated = store[1, i] + change
            store[1, half + i] = change - (updated - store[1, i])
            store[1, i] = updated
            increment[i] = updated
    for i in range(half):
        x[i] = y[i] + increment[i]
    evaluate(s, t + h)
    for i in range(half):
        # All terms but the last are summed while the processor waits for the slope, small terms first: differences have
        # so few bits that ties would be frequent, and their rounding biased.
        last = store[3, i]
        ahead = 2.0 * last - store[HISTORY, i]
        difference, position, velocity = last, 0.0, 0.0
        for m in range(order):
            before = store[HISTORY + m, i]
            store[HISTORY + m, i] = difference
            position += table[0, m + 1] * difference
            velocity += table[1, m + 1] * difference
            difference -= before
        store[2, i] = position + (1.0 - table[0, 0]) * ahead + table[0, 0] * slope[i]
        store[3, i] = slope[i]
        if made >= order - 1:
            increment[half + i] = h * (velocity + table[1, 0] * (slope[i] - last) + last)
    return True


class Stormer(FixedStep):
    """Störmer's explicit formula for the position with the implicit Adams formula for the velocity.

    Both are explicit, as the acceleration does not depend on the velocity. RKN 12(10) makes the first steps, with the
    same step size. Sums are compensated.

    Störmer 1907; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, III.1 and III.10.
    """

    accepts = (SecondOrder,)
    step = stormer_step
    compensated = True
    order: ClassVar[int]

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        """The weights of the formulas for position and velocity, then the rows of the starting method.

        b_0, 0, 0, b_2, b_3, ... of q_n+1 - 2 q_n + q_n-1 = h^2 (b_0 a + (1 - b_0)(2 a_1 - a_2) + sum of b_m D_m) and
        c_0, 0, c_1, c_2, ... of v_n - v_n-1 = h (a_1 + c_0 (a - a_1) + sum of c_m D_m). Here a is the newest
        acceleration, a_1 and a_2 are the accelerations before it, and D_m is the difference of order m of a_1.
        """
        tails = [
            [sum(weights[m:], Fraction(0)) for m in range(len(weights))]
            for weights in (stormer_weights(cls.order), adams_weights(cls.order + 1))
        ]
        formulas = [
            [tail[0], *[Fraction(0)] * zeros, *(-x for x in tail[zeros + 1 :])]
            for zeros, tail in zip((2, 1), tails, strict=True)
        ]
        rows = [[mp.mpf(x.numerator) / x.denominator for x in formula] for formula in formulas]
        return [*rows, *STARTER.fixed_rows(mp)]

    def binary64(self, form: Form, parameters: Sequence[float], h: float) -> Floats:
        modules = (__name__, tableau.__name__, nystrom_table.__name__)
        return keep_table(f"Störmer {self.order}", modules, lambda: super(Stormer, self).binary64(form, parameters, h))

    def rows(self, form: Form) -> int:
        return HISTORY + self.order + len(STARTER.a)


@cache
def stormer_weights(count: int) -> tuple[Fraction, ...]:
    """The weights s_m of Störmer's method, q_n+1 - 2 q_n + q_n-1 = h^2 sum of s_m D_m over m < count.

    D_m is the difference of order m of the accelerations a_n, a_n-1, ... The method is exact for polynomials.
    """
    logarithm = reciprocal([Fraction(1, j + 1) for j in range(count)])
    return tuple(times(times(logarithm, logarithm), [Fraction(1)] * count))


@cache
def adams_weights(count: int) -> tuple[Fraction, ...]:
    """The weights c_m of the implicit Adams method, v_n+1 - v_n = h sum of c_m D_m over m < count.

    D_m is the difference of order m of the accelerations a_n+1, a_n, ... The method is exact for polynomials.
    """
    return tuple(reciprocal([Fraction(1, j + 1) for j in range(count)]))


def reciprocal(series: list[Fraction]) -> list[Fraction]:
    """The reciprocal of a power series that begins with 1, with as many terms."""
    terms = [Fraction(1)]
    for n in range(1, len(series)):
        terms.append(-sum((series[j] * terms[n - j] for j in range(1, n + 1)), Fraction(0)))
    return terms


def times(a: list[Fraction], b: list[Fraction]) -> list[Fraction]:
    """The product of two power series of equally many terms, with as many terms."""
    return [sum((a[j] * b[n - j] for j in range(n + 1)), Fraction(0)) for n in range(len(a))]


class Stormer8(Stormer):
    """Störmer's method with eight accelerations. Order 8."""

    name, order = "Störmer 8", 8
    primary = False
    sweep = Steps(coarsest=0.25, halvings=8)


class Stormer12(Stormer):
    """Störmer's method with twelve accelerations. Order 12."""

    name, order = "Störmer 12", 12
    primary = False
    sweep = Steps(coarsest=0.125, halvings=7)


INTEGRATORS: tuple[type[Integrator], ...] = (Stormer8, Stormer12)
