"""Embedded explicit Runge-Kutta-Nyström pairs for q'' = a(t, q): a method is its tableau.

Step sizes: `base/step_control.py`.
"""

from math import sqrt
from typing import Any, ClassVar

from gnomon.cases.core.forms import SecondOrder
from gnomon.harness.contract.integrator import Floats, Integrator, Tolerance
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
from gnomon.harness.integrators.base.stepping import evaluate
from gnomon.harness.integrators.base.tableau import NystromTableau, parse_rows
from gnomon.harness.integrators.runge_kutta.nystrom_table import RKN_12_10


class Nystrom(Adaptive):
    """An explicit Nyström pair, given by its tableau. A sample is a separate step of the same order within the step."""

    accepts = (SecondOrder,)
    tableau: ClassVar[NystromTableau]

    @classmethod
    def constants(cls) -> dict[str, int]:
        tableau, stages = cls.tableau, len(cls.tableau.a)
        assert cls.order is not None
        return {
            "WIDTHS": 2, "ORDER": cls.order, "ERROR_ORDER": tableau.orders[1] + 1, "STAGES": stages, "LAST": stages + 2,
            "ENDS": int(tableau.uses_end),
        }  # fmt: skip


def attempt(s: AttemptData, t: float, h: float) -> bool:
    """Compute the stages of a step and the state at its end."""
    step_into(s, t, h)
    return True


def error_norm(s: AttemptData, h: float) -> float:
    """The norm (root mean square) of the estimated error of a step."""
    y, end, table, k, inverse = s.y, s.end, s.table, s.k, s.inverse
    half = y.size // 2
    total = 0.0
    for i in range(half):
        a, b = 0.0, 0.0
        for m in range(STAGES + ENDS):
            a += table[STAGES + 2, m + 1] * k[m, i]
            b += table[STAGES + 3, m + 1] * k[m, i]
        total += (h * h * a * one_over(i, y, end, inverse)) ** 2
        total += (h * b * one_over(half + i, y, end, inverse)) ** 2
    return sqrt(total / y.size)


def step_into(s: AttemptData, t: float, h: float) -> None:
    """One step from the acceleration k[0] at its start: computes the change of the state and the state at its end."""
    table, y, x, slope, k = s.table, s.y, s.x, s.slope, s.k
    compensation, change, end = s.compensation, s.change, s.end
    half = x.size
    for j in range(1, STAGES):
        ahead = table[j, 0] * h
        for i in range(half):
            total = 0.0
            for m in range(j):
                total += table[j, m + 1] * k[m, i]
            x[i] = y[i] + (ahead * y[half + i] + h * h * total)
        evaluate(s, t + ahead)
        for i in range(half):
            k[j, i] = slope[i]
    for i in range(half):
        total = 0.0
        for m in range(STAGES):
            total += table[STAGES, m + 1] * k[m, i]
        change[i] = h * y[half + i] + h * h * total + compensation[i] + h * compensation[half + i]
        end[i] = y[i] + change[i]
    if ENDS == 1:
        end_slope(s, t + h)
    for i in range(half):
        total = 0.0
        for m in range(STAGES + ENDS):
            total += table[STAGES + 1, m + 1] * k[m, i]
        change[half + i] = h * total + compensation[half + i]
        end[half + i] = y[half + i] + change[half + i]


def open_step(s: AttemptData, t: float, h: float) -> None:
    """Do nothing: a Nyström pair has no interpolant to prepare."""


def between(s: AttemptData, t: float, h: float, ahead: float, out: Floats) -> None:
    """Write the state within a step into `out`, by a separate step; the acceleration k[STAGES] of the step is kept."""
    k = s.k
    if ahead == h:
        for i in range(s.y.size):
            out[i] = s.end[i]
        return
    for i in range(s.x.size):
        k[STAGES + 1, i] = k[STAGES, i]
    step_into(s._replace(change=s.spare, end=out), t, ahead)
    for i in range(s.x.size):
        k[STAGES, i] = k[STAGES + 1, i]


Nystrom.pieces = (first_step, attempt, error_norm, arrive, open_step, between)


def nystrom_increment(s: Any, t: Any, h: Any, stages: int) -> None:
    """One step at a fixed step size, in any arithmetic, from the acceleration s.store[0] at its start.

    The first `stages` rows of `s.table` are the stages, the next two the weights of position and velocity.
    """
    table, y, x, slope, store, increment = s.table, s.y, s.x, s.slope, s.store, s.increment
    half = x.size
    for j in range(1, stages):
        for i in range(half):
            total = 0.0
            for m in range(j):
                total += table[j, m + 1] * store[m, i]
            x[i] = y[i] + (table[j, 0] * h * y[half + i] + h * h * total)
        evaluate(s, t + table[j, 0] * h)
        for i in range(half):
            store[j, i] = slope[i]
    for i in range(half):
        total, weighted = 0.0, 0.0
        for m in range(stages):
            total += table[stages, m + 1] * store[m, i]
            weighted += table[stages + 1, m + 1] * store[m, i]
        increment[i] = h * y[half + i] + h * h * total
        increment[half + i] = h * weighted


class DormandPrinceNystrom6(Nystrom):
    """Dormand, El-Mikkawy and Prince's pair RKN 6(4)6FM (IMA J. Numerical Analysis 7, 1987, p. 235). Order 6."""

    name, order = "RKN 6(4)", 6
    primary = False
    sweep = Tolerance(1e-3, 1e-13)
    tableau = NystromTableau(
        orders=(6, 4),
        c=("0", "1/10", "3/10", "7/10", "17/25"),
        a=parse_rows("""
            ;
            1/200;
            -1/2200 1/22;
            637/6600 -7/110 7/33;
            225437/1968750 -30073/281250 65569/281250 -9367/984375;
        """),
        b=parse_rows("151/2142 5/116 385/1368 55/168 -6250/28101;")[0],
        d=parse_rows("151/2142 25/522 275/684 275/252 -78125/112404 1/12;")[0],
        embedded=parse_rows("""
            1349/157500 7873/50000 192199/900000 521683/2100000 -16/125;
            1349/157500 7873/45000 27457/90000 521683/630000 -2/5 1/12;
        """),
    )


class DormandPrinceNystrom12(Nystrom):
    """Dormand, El-Mikkawy and Prince's pair RKN 12(10)17M (IMA J. Numerical Analysis 7, 1987, p. 423). Order 12."""

    name, order = "RKN 12(10)", 12
    primary = False
    sweep = Tolerance(1e-3, 1e-14)
    tableau = RKN_12_10


INTEGRATORS: tuple[type[Integrator], ...] = (DormandPrinceNystrom6, DormandPrinceNystrom12)
