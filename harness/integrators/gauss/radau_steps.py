"""The stepping of Radau IIA 5: simplified Newton iteration on the transformed system, error estimate, step control."""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.integrators.base.linear import factor, substitute
from gnomon.harness.integrators.base.sizes import (
    SHORTEST,
    YOUNG,
    enlarge,
    first_sizes,
    forget,
    invert,
    limit_by_roundoff,
    perturb_by_roundoff,
    size_by_end,
    size_by_power,
)
from gnomon.harness.integrators.base.step_control import FIRST, MOST, NOT_FINITE, NOT_SOLVED, SCALE, obstacle
from gnomon.harness.integrators.base.stepping import call, evaluate
from numpy.typing import NDArray

DIMENSION = 0
"""The number of components, set when compiled for a problem: short loops of unknown length would take longer than their
content."""

ABSOLUTE = 0
"""Set when compiled: 1 if errors are divided by 1 + |y| in SI units instead of `sizes`."""

MOST_ITERATIONS = 10
ROUNDOFF = 2e-15
"""Relative to the scale of errors: changes of stages that do not shrink below it are round-off."""

HEAVIEST = 1e300
"""The largest weight of an error: the error of a motion that has just left zero would have an infinite one."""

SAFETY, SHRINK_MOST, GROW_MOST = 0.9, 0.2, 8.0
PREDICTED_MOST = 10**0.5
"""The step-size factor of an error of 1e-2 of the tolerance: smaller errors do not predict the next one."""


C, EIGENVALUES, FORWARD, BACK, ERROR, BASIS = 0, 1, 2, 5, 8, 9
"""First rows of the parts of the table."""


class RadauData(NamedTuple):
    """The equations, numbers and arrays of a step. For those that are not explained here see `stepping.StepData`."""

    f: Any
    y: Any
    p: Any
    table: Any
    x: Any
    slopes: Any
    """The slopes at the stages."""
    weight: Any
    """Errors are multiplied by it, in units of the tolerance."""
    slope: Any
    start: Any
    """The slope at the start of the step."""
    error: Any
    real: Any
    """The factors of gamma/h - J, for which `pivots` are."""
    pivots: Any
    both: Any
    """The factors of (alpha + i beta)/h - J, for which `pivots_both` are."""
    pivots_both: Any
    right: Any
    """The right-hand side of the real system."""
    pair: Any
    """The right-hand side of the complex system."""
    w: Any
    """`z` in the eigenvectors of the method's matrix."""
    z: Any
    """The changes of the state up to the stages, (3, dim)."""


SIGNATURE = "int int float[1] float[2] float[2] float[1] float float int[1] float[1] float[3] int[1]"


def integrate(
    f: Any, derivative: Any, p: Floats, table: Floats, initial: Floats, times: Floats, tolerance: float, fixed: float,
    groups: NDArray[np.int64], limits: Floats, out: Floats, stop: NDArray[np.int64],
) -> int:  # fmt: skip
    """Integrate each of `initial` (n, dim) into `out` (n, len(times), dim); returns the number of steps accepted.

    `stop` gets the reason and the sample of the first trajectory that ended early. `fixed` > 0: all steps have that
    size, and only the iteration uses `tolerance`.

    The loop of `step_control` does not fit: a sample may need a step of its own, whose iteration can fail, and then the
    step is repeated. Matrices, their factors and the stages of the last step are kept from one attempt to the next.

    A sample within a step is a value of the step's polynomial if the polynomial is as accurate as the step (`is_smooth`).
    Otherwise it is a separate step from the start of the step: for stiff equations the polynomial of a long step is
    inaccurate between its stages.
    """
    n = DIMENSION or initial.shape[1]
    y, compensation, x, slope, start, error = (
        np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n),
    )  # fmt: skip
    z, w, before_z, slopes = np.empty((3, n)), np.empty((3, n)), np.empty((3, n)), np.empty((3, n))
    z_step = np.empty((3, n))
    partial, real, both = np.empty(n * n), np.empty((n, n)), np.empty((n, n), dtype=np.complex128)
    weight, right, pair = np.empty(n), np.empty(n), np.empty(n, dtype=np.complex128)
    sizes, inverse, rough = np.zeros(n), np.zeros(n), np.zeros(n)
    pivots, pivots_both = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    young = np.zeros((YOUNG, n))
    s = RadauData(
        f, y, p, table, x, slopes, weight, slope, start, error, real, pivots, both, pivots_both, right, pair, w, z
    )
    taken, shortest = 0, SHORTEST * limits[SCALE]
    for m in range(initial.shape[0]):
        for i in range(n):
            y[i] = initial[m, i]
            compensation[i], rough[i] = 0.0, 0.0
        t, h, sample, attempts, reason = 0.0, 1e-6 * limits[SCALE], 0, 0, 0
        if limits[FIRST] > 0.0:
            h = limits[FIRST]
        last, reach, steps = 0.0, 1.0, 0
        rejected, aside, noisy, moved, fresh = False, False, False, False, True
        forget(young)
        end, step, length, norm, scale, wanted = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        call(f, t, y, p, start)
        while sample < times.size:
            attempts += 1
            h = fixed if fixed > 0.0 else min(h, limits[MOST])
            reason = obstacle(t, h, attempts)
            if reason != 0:
                break
            if aside:
                length = times[sample] - t
            else:
                # The step is h, rounded so that t + step is exact; the last step ends at the last sample.
                step = times[-1] - t if t + h >= times[-1] else (t + h) - t
                length = step
                call(derivative, t, y, p, partial)
            iterations = 0
            solvable = factor_shifted(s, length, partial)
            if solvable:
                if not aside:
                    if ABSOLUTE == 0:
                        if fresh:
                            for i in range(n):
                                error[i] = start[i]
                            substitute(real, pivots, error)
                            first_sizes(y, error, groups, sizes, inverse)
                        elif noisy or moved:
                            invert(groups, sizes, inverse)
                        if noisy:
                            limit_by_roundoff(1.0 / tolerance, groups, rough, inverse)
                        moved = False
                    for i in range(n):
                        over = 1.0 / (1.0 + abs(y[i])) if ABSOLUTE == 1 else inverse[i]
                        weight[i] = min(over / tolerance, HEAVIEST)
                if aside:
                    for j in range(3):
                        for i in range(n):
                            z[j, i] = between(table[C, j] * length / step, table, z_step, i)
                else:
                    guess(s, step, last, before_z)
                # The iteration goes on if a group at zero moves: only with its size do changes show whether it converged.
                again = True
                while again:
                    iterations = newton(s, t, length, tolerance)
                    again = False
                    if ABSOLUTE == 0 and not aside and iterations > 0:
                        for i in range(n):
                            x[i] = y[i] + z[2, i]
                        again = size_by_end(step, x, groups, inverse, young)
                        if again:
                            moved = True
                            if noisy:
                                limit_by_roundoff(1.0 / tolerance, groups, rough, inverse)
                            for i in range(n):
                                weight[i] = min(inverse[i] / tolerance, HEAVIEST)
            if iterations == 0:
                if fixed > 0.0 or not is_finite(start):
                    reason = NOT_SOLVED if is_finite(start) else NOT_FINITE
                    break
                if ABSOLUTE == 0 and solvable:
                    noise(s, t, groups, rough)
                    noisy = True
                h = length if aside else min(h, step) / 2
                rejected, aside = True, False
                continue
            if aside:
                for i in range(n):
                    out[m, sample, i] = y[i] + (compensation[i] + z[2, i])
                sample += 1
                aside = times[sample] < end
                if aside:
                    continue
                for j in range(3):
                    for i in range(n):
                        z[j, i] = z_step[j, i]
            else:
                norm = estimate(s, t, step, rejected or steps == 0)
                safety = SAFETY * (2 * MOST_ITERATIONS + 1) / (2 * MOST_ITERATIONS + iterations)
                scale = 1.0 / sqrt(sqrt(norm)) if norm > 0.0 else np.inf
                wanted = min(scale, PREDICTED_MOST)
                if steps > 0 and not rejected:
                    scale *= min(1.0, step / reach * scale)
                scale = min(GROW_MOST, max(SHRINK_MOST, safety * scale))
                if not norm < 1.0 and fixed == 0.0:
                    if ABSOLUTE == 0:
                        noise(s, t, groups, rough)
                    noisy = True
                    h = min(h, step) * (0.1 if moved or not norm < np.inf else scale)
                    if moved and h < shortest:
                        h, fresh = size_by_power(groups, sizes, young), False
                    rejected = True
                    continue
                for i in range(n):
                    x[i] = y[i] + (z[2, i] + compensation[i])
                end = times[-1] if t + h >= times[-1] else t + step
                call(f, end, x, p, slope)
                if not is_finite(slope) or not is_finite(x):
                    reason = NOT_FINITE
                    break
                if times[sample] < end and not is_smooth(s, step, norm):
                    aside = True
                    for j in range(3):
                        for i in range(n):
                            z_step[j, i] = z[j, i]
                    continue
            while sample < times.size and times[sample] <= end:
                part = (times[sample] - t) / step
                for i in range(n):
                    out[m, sample, i] = y[i] + (compensation[i] + between(part, table, z, i))
                sample += 1
            for i in range(n):
                change = z[2, i] + compensation[i]
                compensation[i] = change - (x[i] - y[i])
                y[i] = x[i]
                start[i] = slope[i]
                for j in range(3):
                    before_z[j, i] = z[j, i]
            if ABSOLUTE == 0 and (enlarge(y, groups, sizes) or t == 0.0):
                invert(groups, sizes, inverse)
            forget(young)
            moved = fresh = False
            h = step * (min(1.0, scale) if rejected else scale)
            last, reach, t = step, step * wanted, end
            rejected = False
            steps += 1
        taken += steps
        if reason != 0 and stop[0] == 0:
            stop[0], stop[1] = reason, sample
    return taken


def noise(s: RadauData, t: Any, groups: Any, rough: Any) -> None:
    """Raise `rough`, the lower limit of the scale of errors (`sizes.limit_by_roundoff`), to the round-off of the stages.

    The round-off of the stages of a fast mode is its own, not h times the round-off of its rates.
    """
    change = s.error
    perturb_by_roundoff(s.y, s.x)
    evaluate(s, t)
    for i in range(change.size):
        change[i] = s.slope[i] - s.start[i]
    substitute(s.real, s.pivots, change)
    enlarge(change, groups, rough)


def is_finite(values: Any) -> bool:
    total = 0.0
    for value in values:
        total += 0.0 * value
    return total == 0.0


def factor_shifted(s: RadauData, h: Any, partial: Any) -> bool:
    """Factor the matrices `s.real` and `s.both`; returns False if one is singular.

    `partial` (dim * dim,) is the Jacobian J row by row, and gamma, alpha, beta are the eigenvalues in `s.table`.
    """
    table, real, both = s.table, s.real, s.both
    n = DIMENSION or s.pivots.size
    gamma, alpha, beta = table[EIGENVALUES, 0] / h, table[EIGENVALUES, 1] / h, table[EIGENVALUES, 2] / h
    for i in range(n):
        for j in range(n):
            real[i, j] = -partial[i * n + j]
            both[i, j] = -partial[i * n + j]
        real[i, i] += gamma
        both[i, i] += complex(alpha, beta)
    return bool(factor(real, s.pivots) and factor(both, s.pivots_both))


def basis(k: int, x: Any, table: Any) -> Any:
    """The polynomial that is 1 at c_k, 0 at the other nodes and at 0."""
    value = x * table[BASIS, k]
    for j in range(3):
        if j != k:
            value *= x - table[C, j]
    return value


def between(x: Any, table: Any, z: Any, i: int) -> Any:
    """The change of component i at the fraction x of the step, by the collocation polynomial."""
    return basis(0, x, table) * z[0, i] + basis(1, x, table) * z[1, i] + basis(2, x, table) * z[2, i]


def is_smooth(s: RadauData, h: Any, norm: Any) -> bool:
    """Whether the polynomial is as accurate within the step as at its end.

    Its error follows the fourth derivative, as does the estimate before it is filtered. The filter is 1 if no component
    is stiff, up to h |df/dy| of about gamma. If it reduces the estimate to less than half, the estimate holds only for
    the end of the step.
    """
    table, weight, z = s.table, s.weight, s.z
    n = DIMENSION or weight.size
    square = 0.0
    for i in range(n):
        weighted = table[ERROR, 0] * z[0, i] + table[ERROR, 1] * z[1, i] + table[ERROR, 2] * z[2, i]
        square += ((h * s.start[i] + weighted) * weight[i]) ** 2
    return bool(sqrt(square / n) <= 2.0 * table[EIGENVALUES, 0] * norm)


def guess(s: RadauData, h: Any, last: Any, before_z: Any) -> None:
    """First values of the stages: the extrapolated polynomial of the last step, of that size; 0 in the first step."""
    table, z = s.table, s.z
    n = DIMENSION or z.shape[1]
    ratio = h / last if last > 0.0 else 0.0
    for j in range(3):
        for i in range(n):
            z[j, i] = 0.0
        if last > 0.0:
            x = 1.0 + table[C, j] * ratio
            a, b, c = basis(0, x, table), basis(1, x, table), basis(2, x, table) - 1.0
            for i in range(n):
                z[j, i] = a * before_z[0, i] + b * before_z[1, i] + c * before_z[2, i]


def newton(s: RadauData, t: Any, h: Any, tolerance: Any) -> int:
    """Simplified Newton iteration for the stages z, from their first values.

    Returns the number of iterations, 0 if it failed. The rate at which changes shrink gives an estimate of the
    remaining error. The iteration ends when this is below `enough` of the tolerance: 3 %, the root of the tolerance if this
    is less, or round-off if this is more. `s.error` holds the state of a stage meanwhile.
    """
    table, y, z, w, slopes, right, pair, weight = s.table, s.y, s.z, s.w, s.slopes, s.right, s.pair, s.weight
    n = DIMENSION or y.size
    gamma, alpha, beta = table[EIGENVALUES, 0] / h, table[EIGENVALUES, 1] / h, table[EIGENVALUES, 2] / h
    for j in range(3):
        for i in range(n):
            w[j, i] = table[BACK + j, 0] * z[0, i] + table[BACK + j, 1] * z[1, i] + table[BACK + j, 2] * z[2, i]
    rest = ROUNDOFF / tolerance
    enough = max(rest, min(0.03, sqrt(tolerance)))
    before, rate = 0.0, 0.0
    iteration = 0
    # Not a range, which the compiler would unroll: ten iterations take ten times as long to compile.
    while iteration < MOST_ITERATIONS:
        iteration += 1
        for j in range(3):
            for i in range(n):
                s.error[i] = y[i] + z[j, i]
            call(s.f, t + table[C, j] * h, s.error, s.p, slopes[j])
            if not is_finite(slopes[j]):
                return 0
        for i in range(n):
            a, b, c = slopes[0, i], slopes[1, i], slopes[2, i]
            right[i] = table[BACK, 0] * a + table[BACK, 1] * b + table[BACK, 2] * c - gamma * w[0, i]
            u = table[BACK + 1, 0] * a + table[BACK + 1, 1] * b + table[BACK + 1, 2] * c
            v = table[BACK + 2, 0] * a + table[BACK + 2, 1] * b + table[BACK + 2, 2] * c
            pair[i] = complex(u - (alpha * w[1, i] - beta * w[2, i]), v - (beta * w[1, i] + alpha * w[2, i]))
        substitute(s.real, s.pivots, right)
        substitute(s.both, s.pivots_both, pair)
        square = 0.0
        for i in range(n):
            w[0, i] += right[i]
            w[1, i] += pair[i].real
            w[2, i] += pair[i].imag
            a, b, c = right[i] * weight[i], pair[i].real * weight[i], pair[i].imag * weight[i]
            square += a * a + b * b + c * c
            for j in range(3):
                z[j, i] = (
                    table[FORWARD + j, 0] * w[0, i] + table[FORWARD + j, 1] * w[1, i] + table[FORWARD + j, 2] * w[2, i]
                )
        norm = sqrt(square / (3 * n))
        if not norm < 1e300:
            return 0
        if iteration > 1:
            rate = norm / before
            left = MOST_ITERATIONS - iteration
            if norm > enough and (rate >= 1.0 or rate**left / (1.0 - rate) * norm > enough):
                return 0
        # After the first iteration the rate is unknown: only a negligible change ends the iteration. Changes that do
        # not shrink do not bound the error left, unless they are round-off.
        if norm <= 1e-3 * enough or (iteration > 1 and rate < 1.0 and rate / (1.0 - rate) * norm <= enough):
            return iteration
        if iteration > 1 and rate >= 1.0 and norm <= rest:
            return iteration
        before = norm
    return 0


def estimate(s: RadauData, t: Any, h: Any, twice: bool) -> float:
    """The error of the embedded formula of order 3 over the tolerance, filtered by the real system (IV.8.19-20).

    `twice`: an estimate above 1 is filtered again, in the first step and after a rejected one.
    """
    y, table, z, error = s.y, s.table, s.z, s.error
    n = DIMENSION or y.size
    norm = 0.0
    for again in range(2):
        for i in range(n):
            rate = s.slope[i] if again == 1 else s.start[i]
            weighted = table[ERROR, 0] * z[0, i] + table[ERROR, 1] * z[1, i] + table[ERROR, 2] * z[2, i]
            error[i] = rate + weighted / h
        substitute(s.real, s.pivots, error)
        square = 0.0
        for i in range(n):
            square += (error[i] * s.weight[i]) ** 2
        norm = sqrt(square / n)
        if norm < 1.0 or again == 1 or not twice:
            break
        # While a fast mode has not decayed, the estimate is too large; the second evaluation damps it.
        for i in range(n):
            s.x[i] = y[i] + error[i]
        evaluate(s, t)
    return norm


INLINED = (factor, newton, factor_shifted)
"""Functions that are called at one or two places: one piece with the loop of steps compiles faster than several."""
