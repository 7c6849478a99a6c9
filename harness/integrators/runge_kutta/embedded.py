"""Embedded explicit Runge-Kutta pairs for y' = f(t, y): a method is its tableau.

Step sizes: `base/step_control.py`. Numbers as II.6.20: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I.
"""

from math import sqrt
from typing import ClassVar

from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.integrators.base.sizes import one_over
from gnomon.harness.integrators.base.step_control import (
    ENDS,
    STAGES,
    Adaptive,
    AttemptData,
    arrive,
    end_slope,
    first_step,
)
from gnomon.harness.integrators.base.tableau import ButcherTableau
from gnomon.harness.integrators.runge_kutta.explicit import stage

LAST = ERRORS = DENSE = DENSE_ROWS = 0
"""Set when a method is compiled. LAST: the number of rows of slopes; ERRORS, DENSE: the first rows of the errors and of
dense output; DENSE_ROWS: the number of rows of dense output, -1 without it."""


class Embedded(Adaptive):
    """An explicit embedded Runge-Kutta pair, given by its tableau.

    A second embedded formula damps the estimated error of the first, as in DOP853. If the method has no interpolant, a
    sample is a separate step of the same order within the step.
    """

    accepts: ClassVar[tuple[type[FirstOrder], ...]] = (FirstOrder,)
    tableau: ClassVar[ButcherTableau]

    @classmethod
    def constants(cls) -> dict[str, int]:
        tableau, stages = cls.tableau, len(cls.tableau.a)
        last = stages + 1 + len(tableau.extra)
        assert cls.order is not None
        return {
            "WIDTHS": 1, "ORDER": cls.order, "ERROR_ORDER": cls.order, "STAGES": stages, "LAST": last,
            "ENDS": int(any(stages in row for row in tableau.errors)), "ERRORS": last, "DENSE": last + 2,
            "DENSE_ROWS": -1 if tableau.dense is None else len(tableau.dense),
        }  # fmt: skip


def attempt(s: AttemptData, t: float, h: float) -> bool:
    """Compute the stages of a step and the state at its end."""
    propagate(s, t, h)
    if ENDS == 1:
        end_slope(s, t + h)
    return True


def propagate(s: AttemptData, t: float, h: float) -> None:
    """Compute the stages of a step, the change of the state and the state at the end."""
    for j in range(1, STAGES):
        stage(s, t, h, j, s.k)
    for i in range(s.y.size):
        total = 0.0
        for m in range(STAGES):
            total += s.table[STAGES, m + 1] * s.k[m, i]
        s.change[i] = h * total + s.compensation[i]
        s.end[i] = s.y[i] + s.change[i]


def error_norm(s: AttemptData, h: float) -> float:
    """The norm of the estimated error of a step, damped by the second estimate if there is one (II.10.17)."""
    y, table, k = s.y, s.table, s.k
    first, second = 0.0, 0.0
    for i in range(y.size):
        weight = one_over(i, y, s.end, s.inverse)
        a, b = 0.0, 0.0
        for m in range(STAGES + ENDS):
            a += table[ERRORS, m + 1] * k[m, i]
            b += table[ERRORS + 1, m + 1] * k[m, i]
        first += (a * weight) ** 2
        second += (b * weight) ** 2
    if first == 0.0 and second == 0.0:
        return 0.0
    return h * first / sqrt((first + 0.01 * second) * y.size)


def open_step(s: AttemptData, t: float, h: float) -> None:
    """Compute the extra stages of the dense output."""
    for j in range(STAGES + 1, LAST):
        stage(s, t, h, j, s.k)


def between(s: AttemptData, t: float, h: float, ahead: float, out: Floats) -> None:
    """Write the state within a step into `out`: by the interpolant, or by a separate step if there is none."""
    state_within(s, t, h, ahead, out)


def state_within(s: AttemptData, t: float, h: float, ahead: float, out: Floats) -> None:
    """Write the state at t + `ahead` into `out`, as `between`; `projected` calls it, and then projects the state."""
    if DENSE_ROWS >= 0:
        interpolate(s, ahead / h, h, out)
    elif ahead == h:
        for i in range(s.y.size):
            out[i] = s.end[i]
    else:
        for j in range(1, STAGES):
            stage(s, t, ahead, j, s.k)
        for i in range(s.y.size):
            total = 0.0
            for m in range(STAGES):
                total += s.table[STAGES, m + 1] * s.k[m, i]
            out[i] = s.y[i] + (ahead * total + s.compensation[i])


def interpolate(s: AttemptData, x: float, h: float, out: Floats) -> None:
    """Write the state at the fraction x of the step into `out` (II.6.20)."""
    y, end, table, k = s.y, s.end, s.table, s.k
    for i in range(y.size):
        change = end[i] - y[i]
        value = 0.0
        for row in range(DENSE_ROWS - 1, -1, -1):
            total = 0.0
            for m in range(LAST):
                total += table[DENSE + row, m + 1] * k[m, i]
            value = (value + h * total) * (x if row % 2 == 1 else 1.0 - x)
        value = (value + 2.0 * change - h * (k[STAGES, i] + k[0, i])) * x
        value = (value + h * k[0, i] - change) * (1.0 - x)
        out[i] = y[i] + (value + change) * x


Embedded.pieces = (first_step, attempt, error_norm, arrive, open_step, between)
