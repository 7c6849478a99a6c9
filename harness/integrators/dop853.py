"""Dormand and Prince's method of order 8 with error control and dense output."""

from __future__ import annotations

import math
from math import sqrt
from typing import Any

import numpy as np
from gnomon.cases.forms import FirstOrder
from gnomon.harness.compile import right_hand_side
from gnomon.harness.integrator import Integrator, Problem, Refused, Solution, Solve, Tolerance
from gnomon.harness.integrators import dop853_table as published
from gnomon.harness.integrators.fixed_step import DIGITS, Table, rounded
from gnomon.harness.integrators.stepping import call, compiled_whole
from gnomon.reference.precision import working
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LEAST_TOLERANCE = 1e-15
"""About four units of round-off: no step can be held to less."""

MOST_STEPS = 5_000_000
"""A few seconds: past that the tolerance is out of proportion to the span, or the equations are stiff."""

NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS = 1, 2, 3
REASONS = {
    NOT_FINITE: "the equations gave a value that is not finite",
    STEP_TOO_SMALL: "the step size fell below the spacing of times",
    TOO_MANY_STEPS: f"more than {MOST_STEPS} steps",
}
# Rows of the table: twelve stages, the end of the step, three stages for dense output, two errors, dense output.
WEIGHTS, LAST, ERROR_5, ERROR_3, DENSE, ROWS = 12, 16, 16, 17, 18, 22
SAFETY, SHRINK_MOST, GROW_MOST = 0.9, 3.0, 6.0
BETA = 0.04
"""The integral part of the PI controller (Hairer, Norsett, Wanner II.4)."""


class Dop853(Integrator):
    """Dormand and Prince's 8(5,3) pair, PI step control, dense output of order 7. Order 8.

    Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 1993, II.5 and II.10. The tolerance is both
    relative and absolute, the error the root mean square over the components. Sums are compensated.
    """

    name, order = "DOP853", 8
    accepts = (FirstOrder,)
    sampling = "dense output"
    sweep = Tolerance(1e-3, 1e-14)

    def prepare(self, problem: Problem, setting: float) -> Solve:
        if not (math.isfinite(setting) and LEAST_TOLERANCE <= setting < 1):
            raise Refused(f"tolerance {setting} is not between {LEAST_TOLERANCE:g} and 1")
        kernel = right_hand_side(problem)
        run = compiled_whole(integrate, SIGNATURE)
        with working(DIGITS) as mp:
            table = rounded(rows(mp))
        address, buffer, times = kernel.address, problem.buffer, problem.times

        def solve(initial: Floats) -> Solution:
            out = np.full((len(initial), len(times), initial.shape[1]), np.nan)
            stop = np.zeros(2, dtype=np.int64)
            steps = run(address, buffer, table, initial, times, setting, out, stop)
            stopped = f"{REASONS[int(stop[0])]}, before sample {stop[1] + 1}" if stop[0] else None
            return Solution(out, int(steps), stopped)

        return solve


def rows(mp: Any) -> Table:
    """The 22 rows of the table: c_j, a_j1, ... for the stages; 0 and the weights for the others."""

    def dense(row: published.Row) -> list[Any]:
        return [mp.mpf(row.get(j, 0)) for j in range(LAST)]

    stages = [dense(row) for row in (*published.STAGES, published.WEIGHTS, *published.EXTRA_STAGES)]
    third = [b - d for b, d in zip(dense(published.WEIGHTS), dense(published.WEIGHTS_3), strict=True)]
    others = [dense(published.ERROR_5), third, *map(dense, published.DENSE)]
    return [*([mp.fsum(row), *row] for row in stages), *([mp.mpf(0), *row] for row in others)]


SIGNATURE = (
    "int64(intp, float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64[:, :, ::1], int64[::1])"
)


def integrate(
    f: Any,
    p: Floats,
    table: Floats,
    initial: Floats,
    times: Floats,
    tolerance: float,
    out: Floats,
    stop: NDArray[np.int64],
) -> int:
    """Integrate each of `initial` (n, dim) into `out` (n, len(times), dim); returns the number of steps accepted.

    `stop` gets the reason and the sample where a trajectory ended early.
    """
    dimension = initial.shape[1]
    y, low, end = np.empty(dimension), np.empty(dimension), np.empty(dimension)
    x, slope, change = np.empty(dimension), np.empty(dimension), np.empty(dimension)
    k = np.empty((LAST, dimension))
    taken = 0
    for n in range(initial.shape[0]):
        y[:] = initial[n]
        low[:] = 0.0
        t, sample, attempts = 0.0, 0, 0
        call(f, t, y, p, slope)
        k[0] = slope
        h = initial_step(f, y, p, k, x, slope, tolerance, times[-1])
        before = 1e-4
        rejected = False
        reason = 0
        while sample < times.size:
            if not (h > 0.0 and h < np.inf):
                reason = NOT_FINITE
                break
            if t + h / 4 <= t:
                reason = STEP_TOO_SMALL
                break
            # The step is h rounded so that t + step is exact; the last one ends at the last sample.
            step = times[-1] - t if t + h >= times[-1] else (t + h) - t
            attempts += 1
            if attempts > MOST_STEPS:
                reason = TOO_MANY_STEPS
                break
            for j in range(1, WEIGHTS):
                stage(f, t, step, y, p, table, j, x, slope, k)
            for i in range(dimension):
                total = 0.0
                for m in range(WEIGHTS):
                    total += table[WEIGHTS, m + 1] * k[m, i]
                change[i] = step * total + low[i]
                end[i] = y[i] + change[i]
            error = error_norm(step, y, end, table, k, tolerance)
            if not error < np.inf:
                h = min(h, step) / 10
                rejected = True
                continue
            if error > 1.0:
                h = min(h, step) / min(SHRINK_MOST, error ** (1 / 8 - 0.2 * BETA) / SAFETY)
                rejected = True
                continue
            call(f, t + step, end, p, slope)
            for i in range(dimension):
                if not abs(slope[i]) < np.inf:
                    reason = NOT_FINITE
                k[WEIGHTS, i] = slope[i]
                low[i] = change[i] - (end[i] - y[i])
            if reason != 0:
                break
            if times[sample] <= t + step:
                for j in range(WEIGHTS + 1, LAST):
                    stage(f, t, step, y, p, table, j, x, slope, k)
                while sample < times.size and times[sample] <= t + step:
                    interpolate((times[sample] - t) / step, step, y, end, table, k, out[n, sample])
                    sample += 1
            taken += 1
            t += step
            for i in range(dimension):
                y[i] = end[i]
                k[0, i] = k[WEIGHTS, i]
            factor = error ** (1 / 8 - 0.2 * BETA) / before**BETA / SAFETY
            factor = max(1 / GROW_MOST, min(SHRINK_MOST, factor))
            h = step / (max(1.0, factor) if rejected else factor)
            before = max(error, 1e-4)
            rejected = False
        if reason != 0 and stop[0] == 0:
            stop[0] = reason
            stop[1] = sample
    return taken


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


def error_norm(h: float, y: Floats, end: Floats, table: Floats, k: Floats, tolerance: float) -> float:
    """The estimated error of a step over the tolerance: that of order 5, damped by that of order 3 (II.10.17)."""
    fifth, third = 0.0, 0.0
    for i in range(y.size):
        scale = tolerance * (1.0 + max(abs(y[i]), abs(end[i])))
        a, b = 0.0, 0.0
        for m in range(WEIGHTS):
            a += table[ERROR_5, m + 1] * k[m, i]
            b += table[ERROR_3, m + 1] * k[m, i]
        fifth += (a / scale) ** 2
        third += (b / scale) ** 2
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return h * fifth / sqrt((fifth + 0.01 * third) * y.size)


def initial_step(
    f: Any, y: Floats, p: Floats, k: Floats, x: Floats, slope: Floats, tolerance: float, most: float
) -> float:
    """A first step from the sizes of y, y' and y'' (Hairer, Norsett, Wanner II.4); nan where they are not finite."""
    size, speed = 0.0, 0.0
    for i in range(y.size):
        scale = tolerance * (1.0 + abs(y[i]))
        size += (y[i] / scale) ** 2
        speed += (k[0, i] / scale) ** 2
    if speed != speed or speed == np.inf:
        return np.nan
    h = 1e-6 if size <= 1e-10 or speed <= 1e-10 else 0.01 * sqrt(size / speed)
    h = min(h, most)
    for i in range(y.size):
        x[i] = y[i] + h * k[0, i]
    call(f, h, x, p, slope)
    bend = 0.0
    for i in range(y.size):
        bend += ((slope[i] - k[0, i]) / (tolerance * (1.0 + abs(y[i])))) ** 2
    largest = max(sqrt(bend) / h, sqrt(speed)) / sqrt(float(y.size))
    if not largest < np.inf:
        return h
    step = max(1e-6, h * 1e-3) if largest <= 1e-15 else (0.01 / largest) ** (1 / 8)
    return min(100 * h, step, most)


def interpolate(x: float, h: float, y: Floats, end: Floats, table: Floats, k: Floats, out: Floats) -> None:
    """The state at the fraction x of the step (II.6.20)."""
    for i in range(y.size):
        change = end[i] - y[i]
        value = 0.0
        for row in range(3, -1, -1):
            total = 0.0
            for m in range(LAST):
                total += table[DENSE + row, m + 1] * k[m, i]
            value = (value + h * total) * (x if row % 2 == 1 else 1.0 - x)
        value = (value + 2.0 * change - h * (k[WEIGHTS, i] + k[0, i])) * x
        value = (value + h * k[0, i] - change) * (1.0 - x)
        out[i] = y[i] + (value + change) * x


INTEGRATORS: tuple[type[Integrator], ...] = (Dop853,)
