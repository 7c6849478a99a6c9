"""Extrapolation: Gragg's rule with 2, 4, 6, ... substeps, extrapolated to step size 0; order and step are adaptive."""

from math import sqrt
from typing import Any

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Floats, Integrator
from gnomon.harness.integrators.base.fixed_step import Table
from gnomon.harness.integrators.base.sizes import (
    SHORTEST,
    YOUNG,
    enlarge,
    enlarge_roundoff,
    first_sizes,
    forget,
    invert,
    limit_by_roundoff,
    one_over,
    perturb_by_roundoff,
    size_by_end,
    size_by_power,
)
from gnomon.harness.integrators.base.step_control import (
    FIRST,
    MOST,
    NOT_FINITE,
    SCALE,
    SHRINK_MOST,
    Adaptive,
    first_step,
    obstacle,
)
from gnomon.harness.integrators.base.stepping import StepData, call, evaluate
from numpy.typing import NDArray

COLUMNS = 10
"""The largest number of columns of the extrapolation table: order 20, 111 right-hand sides."""

FEWER, MORE = 0.8, 0.9
"""The next step has one column fewer if its work per unit of time is less than 0.8 times as large; one column more, if less
than 0.9 times (ODEX)."""


class GraggBulirschStoer(Adaptive):
    """Gragg's rule extrapolated, up to ten columns, order and step chosen as in ODEX. Order 20.

    Gragg, SIAM J. Numerical Analysis 2, 1965; Bulirsch and Stoer, Numerische Mathematik 8, 1966; Hairer, Norsett,
    Wanner, Solving Ordinary Differential Equations I, II.9. The table extrapolates the change over the step, not the
    state, so that its round-off is relative to the change.
    """

    name, order = "Gragg-Bulirsch-Stoer", 2 * COLUMNS
    primary = False
    accepts = (FirstOrder,)
    sampling = "stops at samples"
    most_steps = 500_000  # of up to 111 right-hand sides
    pieces = ()

    @classmethod
    def rows(cls, mp: Any) -> Table:
        """Row j: the factors n_m^2 / (n_j^2 - n_m^2) of the columns m < j, with n_j = 2 (j + 1)."""
        squares = [mp.mpf((j + 1) ** 2) for j in range(COLUMNS)]
        return [[squares[m] / (squares[j] - squares[m]) for m in range(j)] or [mp.mpf(0)] for j in range(COLUMNS)]

    @classmethod
    def constants(cls) -> dict[str, int]:
        return {"ORDER": 8}  # used only by the estimate of the first step


def integrate(
    f: Any, p: Floats, table: Floats, initial: Floats, times: Floats, tolerance: float, groups: NDArray[np.int64],
    limits: Floats, out: Floats, stop: NDArray[np.int64],
) -> int:  # fmt: skip
    """Integrate as `step_control.integrate` does, but choose the order together with the step.

    An attempt ends at the first column within the tolerance, but not earlier than one column before its target. The
    errors and the work of all columns determine the next step. A step that would pass a sample ends at the sample, with
    the first column within the tolerance.
    """
    dimension = initial.shape[1]
    y, compensation, x, slope = np.empty(dimension), np.empty(dimension), np.empty(dimension), np.empty(dimension)
    before, now = np.empty(dimension), np.empty(dimension)
    first, columns = np.empty((1, dimension)), np.empty((COLUMNS, dimension))
    s = StepData(f, y, p, table, x, slope, columns, now)
    lengths, work = np.zeros(COLUMNS), np.zeros(COLUMNS)
    sizes, inverse, rough = np.empty(dimension), np.empty(dimension), np.zeros(dimension)
    young = np.zeros((YOUNG, dimension))
    taken, shortest = 0, SHORTEST * min(times[-1], limits[SCALE])
    for n in range(initial.shape[0]):
        y[:] = initial[n]
        compensation[:] = 0.0
        t, sample, attempts = 0.0, 0, 0
        h = first_step(s, first, tolerance, min(times[-1], limits[SCALE]), groups)
        if limits[FIRST] > 0.0 and h > 0.0:
            h = limits[FIRST]
        # Zero-based: the column at which the error is expected to be within the tolerance.
        target = max(1, min(COLUMNS - 2, int(0.5 - 0.6 * np.log10(tolerance))))
        rejected, known, noisy, moved, fresh = False, True, False, False, True
        forget(young)
        rough[:] = 0.0
        reason = 0
        while sample < times.size:
            if not known:
                call(f, t, y, p, slope)
                for i in range(dimension):
                    first[0, i] = slope[i]
                    if not abs(slope[i]) < np.inf:
                        reason = NOT_FINITE
                known = True
            attempts += 1
            if reason == 0:
                reason = obstacle(t, h, attempts)
            if reason != 0:
                break
            h = min(h, limits[MOST])
            cut = t + 1.01 * h >= times[sample]
            step = times[sample] - t if cut else (t + h) - t
            if fresh:
                for i in range(dimension):
                    now[i] = step * first[0, i]
                first_sizes(y, now, groups, sizes, inverse)
            elif noisy or moved:
                invert(groups, sizes, inverse)
            good, last, previous = -1, 0, np.inf
            for j in range(target + 2):
                midpoint(s, t, step, 2 * (j + 1), first, before, now)
                extrapolate(j, table, now, columns)
                if j == 0:
                    continue
                if j == 1:
                    for i in range(dimension):
                        x[i] = y[i] + columns[1, i]
                    moved = size_by_end(step, x, groups, inverse, young)
                    if noisy:
                        limit_by_roundoff(step / tolerance, groups, rough, inverse)
                error = column_error(j, y, columns, inverse, x) / tolerance
                last = j
                if not error < previous:
                    lengths[j] = step / 4
                    work[j] = np.inf
                    break
                previous = max(4.0 * error, 1.0)
                lengths[j] = step * growth(error, 2 * j + 1)
                work[j] = cost(j) / lengths[j]
                if error <= 1.0 and (j >= target - 1 or cut):
                    good = j
                    break
                # The columns up to target + 1 are not expected to bring the error below 1.
                if not cut and j >= target - 1 and error > hopeless(j, target):
                    break
            if good < 0:
                perturb_by_roundoff(y, x)
                evaluate(s, t)
                enlarge_roundoff(first[0], slope, 0, groups, rough)
                noisy = limit_by_roundoff(step / tolerance, groups, rough, inverse) or noisy
                target = max(1, min(target, last))
                if target > 1 and work[target - 1] < FEWER * work[target]:
                    target -= 1
                h = min(lengths[target], step / SHRINK_MOST if moved else 0.9 * step)
                if moved and h < shortest:
                    h, fresh = size_by_power(groups, sizes, young), False
                rejected = True
                continue
            for i in range(dimension):
                change = columns[good, i] + compensation[i]
                end = y[i] + change
                compensation[i] = change - (end - y[i])
                y[i] = end
            if enlarge(y, groups, sizes) or t == 0.0:
                invert(groups, sizes, inverse)
            forget(young)
            moved = fresh = False
            taken += 1
            known = False
            if cut:
                t = times[sample]
                for i in range(dimension):
                    out[n, sample, i] = y[i]
                sample += 1
                # A step that a sample cut short predicts the next step only if it had nearly its full length.
                if step < 0.9 * h:
                    continue
            else:
                t += step
            best = better_column(good, target, rejected, work)
            if rejected:
                best = min(best, good)
                h = min(step, lengths[best])
            elif best <= good:
                h = lengths[best]
            elif good < target and work[good] < MORE * work[good - 1]:
                h = lengths[good] * cost(best + 1) / cost(good)
            else:
                h = lengths[good] * cost(best) / cost(good)
            target = best
            rejected = False
        if reason != 0 and stop[0] == 0:
            stop[0] = reason
            stop[1] = sample
    return taken


def midpoint(s: Any, t: Any, h: Any, substeps: int, start: Any, before: Any, now: Any) -> None:
    """Write the change of the state over h into `now`, by Gragg's rule with smoothing, from the slope `start` at t."""
    y, x, slope = s.y, s.x, s.slope
    small = h / substeps
    for i in range(y.size):
        before[i] = 0.0
        now[i] = small * start[0, i]
    for m in range(1, substeps):
        for i in range(y.size):
            x[i] = y[i] + now[i]
        evaluate(s, t + m * small)
        for i in range(y.size):
            following = before[i] + 2 * small * slope[i]
            before[i] = now[i]
            now[i] = following
    for i in range(y.size):
        x[i] = y[i] + now[i]
    evaluate(s, t + h)
    for i in range(y.size):
        now[i] = (before[i] + now[i] + small * slope[i]) / 2


def extrapolate(j: int, table: Any, now: Any, columns: Any) -> None:
    """Replace row j - 1 of the scheme of Aitken and Neville, in `columns` (:, dim), by row j, which begins with `now` (dim,).

    The factors `table`[j] belong to the numbers of substeps.
    """
    for i in range(now.size):
        value = now[i]
        for m in range(j):
            old = columns[m, i]
            columns[m, i] = value
            value += (value - old) * table[j, j - 1 - m]
        columns[j, i] = value


def column_error(j: int, y: Floats, columns: Floats, inverse: Floats, end: Floats) -> float:
    """The norm (root mean square) of the difference of the last two columns; the state at the end goes to `end`."""
    total = 0.0
    for i in range(y.size):
        end[i] = y[i] + columns[j, i]
        total += ((columns[j, i] - columns[j - 1, i]) * one_over(i, y, end, inverse)) ** 2
    return sqrt(total / y.size)


def growth(error: float, power: int) -> float:
    """The factor to the next step size (ODEX)."""
    least = 0.02 ** (1 / power)
    return float(max(least / 4, min(1 / least, 0.94 * (0.65 / max(error, 1e-30)) ** (1 / power))))


def cost(j: int) -> float:
    """The number of right-hand sides of a step that ends with column j."""
    return 1.0 + (j + 1) * (j + 2)


def hopeless(j: int, target: int) -> float:
    """The error at column j, near the target, above which later columns are not expected to bring it below 1."""
    if j < target:
        return float(((target + 1) * (target + 2)) ** 2)
    return float((target + 2) ** 2) if j == target else 1.0


def better_column(good: int, target: int, rejected: bool, work: Floats) -> int:
    """The target column of the next step, as in ODEX: the column with the least `work`, right-hand sides per unit of time.

    `good` is the column at which this step converged, and `target` its target.
    """
    if good == 1:
        return 1 if rejected else 2
    best = good if good <= target else good - 1
    if best > 1 and work[best - 1] < FEWER * work[best]:
        best -= 1
    if good <= target:
        return min(good + 1, COLUMNS - 2) if work[good] < MORE * work[good - 1] else best
    return min(good, COLUMNS - 2) if work[good] < MORE * work[best] else best


GraggBulirschStoer.loop = integrate

INTEGRATORS: tuple[type[Integrator], ...] = (GraggBulirschStoer,)
