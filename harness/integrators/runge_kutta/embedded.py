"""Embedded explicit Runge-Kutta pairs for y' = f(t, y): a method is its tableau. Step sizes: `base/step_control.py`."""

from __future__ import annotations

from math import sqrt
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.integrators.base.fixed_step import Table, fraction
from gnomon.harness.integrators.base.sizes import one_over, trial_step, turning_time
from gnomon.harness.integrators.base.step_control import STAGES, Adaptive
from gnomon.harness.integrators.base.stepping import call
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Row = dict[int, str]

ORDER = ENDS = LAST = ERRORS = DENSE = DENSE_ROWS = 0
"""Set when a method is compiled: its order; 1 where the error uses the slope at the end (first same as last); the number
of rows of slopes; the first rows of the errors and of dense output; the number of rows of dense output, -1 without it."""


class Embedded(Adaptive):
    """An explicit Runge-Kutta pair given by its tableau, each row as {column: decimal or fraction}.

    `stages`: the rows a_j1 ... of the s stages; `weights`: b_j of the formula that is continued; `errors`: weights of the
    stages and, in column s, of the slope at the end of the step in the estimated error. A second row of errors damps the
    first as in DOP853. `extra`: stages of the dense output, after the slope at the end. `dense`: coefficients d_0, d_1, ...
    of the interpolant

        u(x) = y + x (D + x' (h k_0 - D + x (2 D - h (k_0 + k_s) + x' (h d_0 + x (h d_1 + x' ...))))),   x' = 1 - x

    with D the step's change: the form of every interpolant whose values and slopes at both ends are those of the step.
    None where a method has no interpolant: a sample is then a separate step of the same order within the step.
    """

    accepts = (FirstOrder,)
    stages: ClassVar[tuple[Row, ...]]
    weights: ClassVar[Row]
    errors: ClassVar[tuple[Row, ...]]
    extra: ClassVar[tuple[Row, ...]] = ()
    dense: ClassVar[tuple[Row, ...] | None] = None

    @classmethod
    def rows(cls, mp: Any) -> Table:
        """c_j, a_j1, ... for the stages, the end of the step and the extra stages; 0 and the weights for the others."""
        last = len(cls.stages) + 1 + len(cls.extra)
        nodes = [full(mp, row, last) for row in (*cls.stages, cls.weights, *cls.extra)]
        first, *second = [full(mp, row, last) for row in cls.errors]
        others = [first, *(second or [[mp.mpf(0)] * last]), *(full(mp, row, last) for row in cls.dense or ())]
        return [*([mp.fsum(row), *row] for row in nodes), *([mp.mpf(0), *row] for row in others)]

    @classmethod
    def constants(cls) -> tuple[tuple[str, int], ...]:
        stages = len(cls.stages)
        last = stages + 1 + len(cls.extra)
        values = {
            "WIDTHS": 1, "ORDER": cls.order, "ERROR_ORDER": cls.order, "STAGES": stages, "LAST": last,
            "ENDS": int(any(stages in row for row in cls.errors)), "ERRORS": last, "DENSE": last + 2,
            "DENSE_ROWS": -1 if cls.dense is None else len(cls.dense),
        }  # fmt: skip
        return tuple(values.items())  # type: ignore[arg-type]


def full(mp: Any, row: Row, length: int) -> list[Any]:
    """A sparse row as numbers of the context."""
    return [fraction(mp, row[j]) if j in row else mp.zero for j in range(length)]


def first_step(
    f: Any, y: Floats, p: Floats, k: Floats, x: Floats, slope: Floats, tolerance: float, most: float, groups: Integers
) -> float:
    """A first step size from the sizes of y, y' and y''; nan where y' is not finite."""
    call(f, 0.0, y, p, slope)
    for i in range(y.size):
        k[0, i] = slope[i]
        if not abs(slope[i]) < np.inf:
            return np.nan
    h = trial_step(y, slope, groups, most)
    for i in range(y.size):
        x[i] = y[i] + h * k[0, i]
    call(f, h, x, p, slope)
    return step_for(h, turning_time(y, k[0], slope, h, groups, most), tolerance)


def step_for(h: float, time: float, tolerance: float) -> float:
    """The first step size, for an error (step / time)^ORDER of a hundredth of the tolerance; h where `time` is 0."""
    return time * (0.01 * tolerance) ** (1 / ORDER) if time > 0.0 else h


def attempt(
    f: Any, t: float, h: float, y: Floats, compensation: Floats, p: Floats, table: Floats, inverse: Floats, x: Floats,
    slope: Floats, k: Floats, change: Floats, end: Floats,
) -> float:  # fmt: skip
    """Compute the stages of a step and the state at its end; returns the norm of the estimated error."""
    for j in range(1, STAGES):
        stage(f, t, h, y, p, table, j, x, slope, k)
    for i in range(y.size):
        total = 0.0
        for m in range(STAGES):
            total += table[STAGES, m + 1] * k[m, i]
        change[i] = h * total + compensation[i]
        end[i] = y[i] + change[i]
    if ENDS == 1:
        end_slope(f, t + h, end, p, slope, k)
    return error_norm(h, y, end, table, k, inverse)


def stage(
    f: Any, t: float, h: float, y: Floats, p: Floats, table: Floats, j: int, x: Floats, slope: Floats, k: Floats
) -> None:
    """The slope of stage j from those before it."""
    for i in range(y.size):
        total = 0.0
        for m in range(j):
            total += table[j, m + 1] * k[m, i]
        x[i] = y[i] + h * total
    call(f, t + table[j, 0] * h, x, p, slope)
    for i in range(y.size):
        k[j, i] = slope[i]


def end_slope(f: Any, t: float, end: Floats, p: Floats, slope: Floats, k: Floats) -> None:
    call(f, t, end, p, slope)
    for i in range(end.size):
        k[STAGES, i] = slope[i]


def error_norm(h: float, y: Floats, end: Floats, table: Floats, k: Floats, inverse: Floats) -> float:
    """The norm of the estimated error of a step, damped by the second estimate where there is one (II.10.17)."""
    first, second = 0.0, 0.0
    for i in range(y.size):
        weight = one_over(i, y, end, inverse)
        a, b = 0.0, 0.0
        for m in range(STAGES + ENDS):
            a += table[ERRORS, m + 1] * k[m, i]
            b += table[ERRORS + 1, m + 1] * k[m, i]
        first += (a * weight) ** 2
        second += (b * weight) ** 2
    if first == 0.0 and second == 0.0:
        return 0.0
    return h * first / sqrt((first + 0.01 * second) * y.size)


def arrive(f: Any, t: float, end: Floats, p: Floats, x: Floats, slope: Floats, k: Floats) -> bool:
    """Compute the slope at the end of an accepted step, unless the error estimate did; returns whether it is finite."""
    if ENDS == 0:
        end_slope(f, t, end, p, slope, k)
    finite = True
    for i in range(end.size):
        if not abs(k[STAGES, i]) < np.inf:
            finite = False
    return finite


def open_step(
    f: Any, t: float, h: float, y: Floats, p: Floats, table: Floats, x: Floats, slope: Floats, k: Floats
) -> None:
    """The extra stages of the dense output."""
    for j in range(STAGES + 1, LAST):
        stage(f, t, h, y, p, table, j, x, slope, k)


def between(
    f: Any, t: float, h: float, ahead: float, y: Floats, compensation: Floats, end: Floats, p: Floats, table: Floats, x: Floats,
    slope: Floats, k: Floats, spare: Floats, out: Floats,
) -> None:  # fmt: skip
    """The state within a step, into `out`: by the interpolant, or by a separate step where there is none."""
    if DENSE_ROWS >= 0:
        interpolate(ahead / h, h, y, end, table, k, out)
    elif ahead == h:
        for i in range(y.size):
            out[i] = end[i]
    else:
        for j in range(1, STAGES):
            stage(f, t, ahead, y, p, table, j, x, slope, k)
        for i in range(y.size):
            total = 0.0
            for m in range(STAGES):
                total += table[STAGES, m + 1] * k[m, i]
            out[i] = y[i] + (ahead * total + compensation[i])


def interpolate(x: float, h: float, y: Floats, end: Floats, table: Floats, k: Floats, out: Floats) -> None:
    """The state at the fraction x of the step (II.6.20)."""
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


Embedded.pieces = (first_step, attempt, arrive, open_step, between)
