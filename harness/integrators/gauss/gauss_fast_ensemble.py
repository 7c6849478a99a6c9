"""The fast Gauss method for ensembles: the lanes of a vector are eight trajectories.

Guesses, rounds, error, compensated sums and step control are as in `gauss_fast_steps`. The differences:

- The eight trajectories of a vector share t and the step, and a whole number of steps fills the interval between two
  samples, so that samples are ends of steps.
- The stages lie in memory, in the rows of `work`. One loop computes their states and the next one the slopes: the
  processor has too few registers for both.
- Sharp turns between two stages are not detected.

Here too, no operation rounds in the same way in every step: at the finest tolerance the error of energy is a random
walk.

`left_over` records a vector that cannot go on or that passes a pole. The method for single trajectories integrates
these trajectories again, and gives the reason if it stops too.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

from gnomon.harness.integrators.gauss import constants
from gnomon.harness.integrators.gauss.constants import TUNING
from gnomon.harness.integrators.gauss.gauss_fast_control import (
    equal_length,
    few_bits,
    first_length,
    growth,
    limit_growth,
    root_15,
)
from gnomon.harness.integrators.gauss.gauss_fast_layout import Equations
from gnomon.harness.integrators.gauss.gauss_fast_stages import (
    Accuracy,
    Numbers,
    Start,
    Vectors,
    add_exactly,
    convergence,
    rates,
    replace_vectors,
)
from gnomon.harness.integrators.gauss.lanes import (
    Lanes,
    Table,
    fma,
    highest,
    lane,
    lanes,
    larger,
    put,
    row,
    with_lane,
)
from gnomon.harness.kernels.emission import turns


@dataclass(frozen=True)
class Work:
    """First rows of the parts of `work`, and the number of its rows.

    after: the matrix that gives the guesses; onward: both stage matrices times it; fresh: both stage matrices; slopes
    and slopes_too: the slopes of the last step and of this one; guess: the last guess; points: places and velocities of
    the stages; apart: their rounding residuals; plain: slopes before correction; derivative: derivatives.
    """

    after: int
    onward: int
    fresh: int
    slopes: int
    slopes_too: int
    guess: int
    points: int
    apart: int
    plain: int
    derivative: int
    rows: int


def work_of(count: int, derivatives: int) -> Work:
    """The places for `count` slopes and this number of derivatives."""
    sizes = 8, 16, 16, 8 * count, 8 * count, count, 16 * count, 16 * count, 8 * count, 8 * derivatives
    return Work(*itertools.accumulate(sizes, initial=0))


def advance_eight(
    equations: Equations, places: Work, p_: Any, table: Table, initial: Any, times: Any, tolerance: float, out: Any,
    left_over: Any, work: Table,
) -> int:  # fmt: skip
    """Integrate trajectories, eight at a time; gives the number of accepted steps.

    The arrays are as in `gauss_fast_steps.advance`, but `initial` is (trajectories, dimension) and `out` (trajectories,
    samples, dimension). `left_over`: for each eight whether they failed, then the number of right-hand sides. `work`:
    (places.rows, 8).
    """
    n = equations.count
    k = equations.constants(tuple(p_[i] for i in range(equations.parameters)))
    end = times[-1]
    fine_ratio = min(tolerance / TUNING.fine, 1.0)
    share = 8 * TUNING.iteration_share_of_ensemble * fine_ratio**10
    allowed_change, noise = share * max(tolerance, constants.ROUNDOFF / 4), 8 * TUNING.roundings * constants.ROUNDOFF
    for j in turns(8):
        put(work, places.fresh + j, row(table, constants.STAGES + j))
        put(work, places.fresh + 8 + j, row(table, constants.ONCE + j))
    taken, evaluations, many = 0, 0, initial.shape[0]
    for first in range(0, many, 8):
        some = min(8, many - first)
        y = tuple(lanes(0.0) for _ in equations.moving)
        for i in turns(8):  # if there are fewer, the last one fills the other lanes
            y = tuple(with_lane(y[m], i, initial[first + min(i, some - 1), m]) for m in equations.moving)
        compensation = tuple(lanes(0.0) for _ in y)
        at_start = equations.slopes(y, equations.forcing(lanes(0.0), k), k)[:n]
        sizes = tuple(abs(x) for x in at_start)
        sides = signs(equations, y, 0.0, k)
        reach, extent = highest_of(y[:n]), highest_of(y)
        wanted_step = first_length(
            equations.second_order,
            end,
            highest(reach),
            highest(highest_of(rates(equations, y))),
            highest(highest_of(sizes)),
        )
        old, new, steps_left, last, ratio = places.slopes, places.slopes_too, 0.0, 0.0, 0.0
        t, sample, attempts, stiff, rejected, failed = 0.0, 0, 0, 0, False, False
        equal = 0, TUNING.grow_most, TUNING.many_steps
        for i in range(some):
            failed = failed or lane(extent, i) > constants.LARGEST or 0.0 < lane(extent, i) < constants.SMALLEST
        while sample < times.size and not failed:
            if steps_left < 1.0:
                steps_left = math.ceil((times[sample] - t) / (wanted_step * (1.0 + constants.EQUAL_WITHIN)))
            h = (times[sample] - t) / steps_left if steps_left < 1e15 else 0.0
            h = few_bits(h) if steps_left > 1.0 else h
            attempts += 1
            if not (t + h / 4 > t and h < math.inf) or attempts > constants.MOST_ATTEMPTS:
                failed = True
                break

            if last > 0.0 and not abs(h / last - ratio) < constants.EQUAL_WITHIN:
                ratio = h / last
                carry_on(places, table, work, ratio)
            guess(equations, places, work, old, last > 0.0, at_start)
            scale, slope_roundoff = scales(equations, h, y, sizes, reach, tolerance)
            change_weight = tuple(lanes(h) / x for x in scale)
            most = lanes(0.0)
            for x in scale:
                most = larger(most, slope_roundoff / x)
            step_noise = noise * max(1.0, h * highest(most) / (TUNING.roundings * constants.ROUNDOFF))
            start = Start(t, h, y, compensation)
            assumed_rate = TUNING.best_rate_finest if last > 0.0 else 1.0
            accuracy = Accuracy(change_weight, allowed_change, step_noise, assumed_rate, False)
            matrix = places.onward if last > 0.0 else places.fresh
            rounds, rate = eight_stages(equations, places, start, k, table, work, accuracy, old, matrix, new)
            evaluations += abs(rounds)
            if rounds < 0:
                wanted_step, steps_left, rejected = TUNING.shrink * h, 0.0, True
                continue

            change, sizes, worst = end_of_step(equations, start, table, work, new, scale, slope_roundoff)
            worst *= TUNING.error_factor * h / (tolerance * fine_ratio**4)
            grow = TUNING.safety / root_15(max(worst, constants.TINY))
            if not worst <= 1.0:
                wanted_step, steps_left, rejected = h * max(TUNING.shrink, grow), 0.0, True
                continue
            both = tuple(add_exactly(y[i], change[i]) for i in range(len(y)))
            y, compensation = tuple(x for x, _ in both), tuple(x for _, x in both)
            if equations.divisors:
                beyond = signs(equations, y, t + h, k)
                for after, before in zip(beyond, sides, strict=True):
                    failed = failed or highest(-(after * before)) > 0.0
            old, new = new, old
            last, taken, steps_left = h, taken + some, steps_left - 1.0
            t = times[sample] if steps_left < 1.0 else t + h
            if steps_left < 1.0:
                finite = lanes(0.0)
                for x in y:
                    finite = finite + abs(x - x)
                failed = failed or highest(finite) != 0.0
                for i in range(some):
                    for m in equations.moving:
                        out[first + i, sample, m] = lane(y[m], i)
                sample += 1
            if rate > TUNING.stiff_rate:
                slow = highest(motion(equations, h, y, sizes)) < TUNING.slow_motion
                stiff = stiff + 1 if slow else max(stiff - 1, 0)
                failed = failed or stiff > constants.MOST_STIFF

            grow = limit_growth(grow, rate, rounds)
            more, equal = growth(grow, rejected, equal)
            wanted_step, equal = equal_length(h, grow, more, rejected, equal)
            if wanted_step != h:
                steps_left = 0.0
            rejected = False
        left_over[first // 8] = 1 if failed else 0
    left_over[-1] += 64 * evaluations
    return taken


def signs(equations: Equations, y: Vectors, t: float, k: Numbers) -> Vectors:
    """The divisors that may change their sign."""
    return equations.poles(y, equations.forcing(lanes(t), k), k) if equations.divisors else ()


def highest_of(values: Vectors) -> Lanes:
    """The largest size in each lane."""
    highest = lanes(0.0)
    for x in values:
        highest = larger(highest, abs(x))
    return highest


def carry_on(places: Work, table: Table, work: Table, ratio: float) -> None:
    """The matrix that extrapolates the stage polynomial into a step `ratio` times as long, and its integrals."""
    for k in turns(8):
        after = lanes(0.0)
        power = 1.0
        for m in turns(8):
            after = fma(row(table, constants.POWERS + m), lanes(power * table[constants.MONOMIALS + k, m]), after)
            power *= ratio
        put(work, places.after + k, after)
    for k in turns(8):
        twice, once = lanes(0.0), lanes(0.0)
        for m in turns(8):
            twice = fma(row(table, constants.STAGES + m), lanes(work[places.after + k, m]), twice)
            once = fma(row(table, constants.ONCE + m), lanes(work[places.after + k, m]), once)
        put(work, places.onward + k, twice)
        put(work, places.onward + 8 + k, once)


def guess(equations: Equations, places: Work, work: Table, old: int, extrapolated: bool, at_start: Vectors) -> None:
    """The guess for the last stage, which measures the error of the guesses.

    One matrix gives the states of the stages directly from the slopes of the last step, so that no other guess is
    computed.
    """
    n = equations.count
    for i in equations.components:
        if extrapolated:
            x = lanes(work[places.after, 7]) * row(work, old + i)
            for j in range(1, 8):
                x = fma(lanes(work[places.after + j, 7]), row(work, old + n * j + i), x)
            put(work, places.guess + i, x)
        else:
            put(work, places.guess + i, at_start[i])
            for j in turns(8):
                put(work, old + n * j + i, at_start[i])


def scales(
    equations: Equations, h: float, y: Vectors, sizes: Vectors, reach: Lanes, tolerance: float
) -> tuple[Vectors, Lanes]:
    """The scale of each component, and the round-off of slopes whose terms cancel, as for single trajectories."""
    roundoff = lanes(TUNING.roundings * constants.ROUNDOFF / (h * h)) * reach if equations.second_order else lanes(0.0)
    share = TUNING.roundings * constants.ROUNDOFF / tolerance
    least = larger(lanes(h * share) * highest_of(sizes), lanes(h) * roundoff)
    v = rates(equations, y)
    scale = tuple(
        larger(larger(larger(abs(v[i]), lanes(h) * sizes[i]), least), lanes(constants.TINY))
        for i in range(equations.count)
    )
    return scale, roundoff


def eight_stages(
    equations: Equations, places: Work, start: Start, k: Numbers, table: Table, work: Table, accuracy: Accuracy, source: int,
    matrix: int, new: int,
) -> tuple[int, float]:  # fmt: skip
    """The iteration for eight trajectories (see `gauss_fast_stages`): rounds, and rate of convergence.

    First rows in `work`: `source`, the slopes of the round before, or of the last step in the first round; `matrix`, the
    matrix that gives places from these slopes; `new`, the result.
    """
    n, change_weight = equations.count, accuracy.change_weight
    before, rate, rounds = 0.0, 0.0, 0
    while True:
        locate(equations, places, start, table, work, source, matrix)
        if equations.derivatives:
            off, rest = correct_round(equations, places, start, k, table, work, change_weight, new)
        else:
            off, rest = plain_round(equations, places, start, k, table, work, change_weight, new), lanes(0.0)
        if rounds == 0:
            off = lanes(0.0)
            for i in equations.components:
                off = fma(abs(row(work, new + 7 * n + i) - row(work, places.guess + i)), change_weight[i], off)
        change = highest(off)
        rounds += 1
        done = False
        if rounds > 1:
            rate = change / before if before > 0.0 else 0.0
            if equations.derivatives:
                # If the corrections have converged, the error after the round is proportional to the square of the error
                # before it, and so is the next change: two rounds are usual at fine tolerances.
                expected = change * max(rate * rate, accuracy.assumed_rate)
                done = (
                    expected <= accuracy.allowed_change
                    and rate < TUNING.slow
                    and highest(rest) <= accuracy.allowed_change
                )
            if not done:
                done, rounds = convergence(change, rate, rounds, accuracy)
        if done:
            break
        before, source, matrix = change, new, places.fresh
    return rounds, rate


def apply_column(table: Table, matrix: int, j: int, r: Vectors) -> Lanes:
    """Column j of the matrix with the rows from `matrix` on, times eight vectors."""
    total = lanes(table[matrix, j]) * r[0]
    for m in range(1, 8):
        total = fma(lanes(table[matrix + m, j]), r[m], total)
    return total


def stage_vectors(equations: Equations, work: Table, first: int) -> tuple[Vectors, ...]:
    """The vectors of the eight stages of each slope, from row `first` on."""
    n = equations.count
    return tuple(tuple(row(work, first + n * j + i) for j in range(8)) for i in range(n))


def locate(
    equations: Equations, places: Work, start: Start, table: Table, work: Table, source: int, matrix: int
) -> None:
    """The places and velocities of the stages and, for corrections, their rounding residuals."""
    _, h, y, compensation = start
    n, hh = equations.count, lanes(h)
    step = hh * hh if equations.second_order else hh
    r = stage_vectors(equations, work, source)
    for j in turns(8):
        high, low = lanes(h * table[constants.NODES_HIGH, j]), lanes(h * table[constants.NODES_LOW, j])
        for i in equations.components:
            b, rest = y[i], lanes(0.0)
            if equations.second_order:
                b = fma(high, y[n + i], fma(low, y[n + i], y[i]))
                rest = fma(low, y[n + i], fma(high, y[n + i], y[i] - b))
            x = fma(step, apply_column(work, matrix, j, r[i]), b)
            put(work, places.points + n * j + i, x)
            if equations.derivatives:
                put(work, places.apart + n * j + i, (b - x) + (rest + compensation[i]))
            if equations.with_velocity:
                u = fma(hh, apply_column(work, matrix + 8, j, r[i]), y[n + i])
                put(work, places.points + n * (8 + j) + i, u)
                if equations.derivatives:
                    put(work, places.apart + n * (8 + j) + i, (y[n + i] - u) + compensation[n + i])


def slopes_of_stage(
    equations: Equations, places: Work, start: Start, k: Numbers, table: Table, work: Table, j: int
) -> Vectors:
    """The slopes of a stage, and the derivatives."""
    n = equations.count
    x = tuple(row(work, places.points + n * j + i) for i in range(n))
    if equations.with_velocity:
        x = (*x, *(row(work, places.points + n * (8 + j) + i) for i in range(n)))
    t = start.t + start.h * table[constants.NODES, j]
    slopes: Vectors = equations.slopes(x, equations.forcing(lanes(t), k), k)
    return slopes


def plain_round(
    equations: Equations, places: Work, start: Start, k: Numbers, table: Table, work: Table, change_weight: Vectors, new: int
) -> Lanes:  # fmt: skip
    """A round without derivatives writes the new slopes and gives their change."""
    n, off = equations.count, lanes(0.0)
    for j in turns(8):
        g = slopes_of_stage(equations, places, start, k, table, work, j)
        for i in equations.components:
            off = fma(abs(g[i] - row(work, new + n * j + i)), change_weight[i], off)
            put(work, new + n * j + i, g[i])
    return off


def correct_round(
    equations: Equations, places: Work, start: Start, k: Numbers, table: Table, work: Table, change_weight: Vectors, new: int
) -> tuple[Lanes, Lanes]:  # fmt: skip
    """A round with derivatives J, which correct the new slopes twice: gives the change and that by the second one.

    The first correction is J times the change of the places that the new slopes cause, the second one J times the
    change that the corrected slopes cause.
    """
    n, count = equations.count, len(equations.derivatives)
    for j in turns(8):
        g = slopes_of_stage(equations, places, start, k, table, work, j)
        for i in equations.components:
            put(work, places.plain + n * j + i, g[i])
        for m, derivative in enumerate(g[n:]):
            put(work, places.derivative + count * j + m, derivative)
    r = stage_vectors(equations, work, places.plain)
    for j in turns(8):
        c = corrections(equations, places, start.h, table, work, r, j)
        for i in equations.components:
            put(work, places.points + n * j + i, row(work, places.plain + n * j + i) + c[i])
    r = stage_vectors(equations, work, places.points)
    off, rest = lanes(0.0), lanes(0.0)
    for j in turns(8):
        c = corrections(equations, places, start.h, table, work, r, j)
        for i in equations.components:
            f = row(work, places.plain + n * j + i) + c[i]
            off = fma(abs(f - row(work, new + n * j + i)), change_weight[i], off)
            rest = fma(abs(f - row(work, places.points + n * j + i)), change_weight[i], rest)
            put(work, new + n * j + i, f)
    return off, rest


def corrections(
    equations: Equations, places: Work, h: float, table: Table, work: Table, r: tuple[Vectors, ...], j: int
) -> Vectors:
    """The changes of the slopes of a stage by the changes s of the places and w of the velocities."""
    n, hh, count = equations.count, lanes(h), len(equations.derivatives)
    step = hh * hh if equations.second_order else hh
    moves = tuple(
        fma(step, apply_column(table, constants.STAGES, j, r[i]), row(work, places.apart + n * j + i)) for i in range(n)
    )
    if equations.with_velocity:
        turned = (
            fma(hh, apply_column(table, constants.ONCE, j, r[i]), row(work, places.apart + n * (8 + j) + i))
            for i in range(n)
        )
        moves = (*moves, *turned)
    c = tuple(lanes(0.0) for _ in range(n))
    for m, i, by in equations.derivatives:
        c = replace_vectors(c, i, fma(row(work, places.derivative + count * j + m - n), moves[by], c[i]))
    return c


def end_of_step(
    equations: Equations, start: Start, table: Table, work: Table, new: int, scale: Vectors, slope_roundoff: Lanes
) -> tuple[Vectors, Vectors, float]:
    """The changes of the state, mean sizes of the slopes, and the error of the worst trajectory, up to a factor.

    The error is estimated as for single trajectories, from the Legendre coefficients of degree 6 and 7, but without
    sharp turns.
    """
    _, h, y, compensation = start
    n, zero = equations.count, lanes(0.0)
    speeds: Vectors = ()
    positions: Vectors = ()
    sizes: Vectors = ()
    error = zero
    for i in equations.components:
        a, b, e, p, c, d, s = zero, zero, zero, zero, zero, zero, zero
        for j in range(8):
            f = row(work, new + n * j + i)
            a = fma(lanes(table[constants.WEIGHTS, j]), f, a)
            e = fma(lanes(table[constants.WEIGHTS + constants.LOW, j]), f, e)
            c = fma(lanes(table[constants.HIGHEST + 2, j]), f, c)
            d = fma(lanes(table[constants.HIGHEST + 3, j]), f, d)
            s = s + abs(f)
            if equations.second_order:
                b = fma(lanes(table[constants.POSITIONS, j]), f, b)
                p = fma(lanes(table[constants.POSITIONS + constants.LOW, j]), f, p)
        at = n + i if equations.second_order else i
        speeds = (*speeds, fma(lanes(h), a, fma(lanes(h), e, compensation[at])))
        if equations.second_order:
            place = fma(lanes(h * h), p, fma(lanes(h), compensation[at], compensation[i]))
            positions = (*positions, fma(lanes(h), y[at], fma(lanes(h * h), b, place)))
        sizes = (*sizes, s * lanes(0.125))
        c, d = larger(abs(c) - slope_roundoff, zero), larger(abs(d) - slope_roundoff, zero)
        m, w = lanes(1.0) / larger(sizes[i], lanes(constants.TINY)), lanes(1.0) / scale[i]
        error = error + ((d * m) * (d * w) + lanes(TUNING.lower_weight) * (c * m) * (c * w))
    return (*positions, *speeds), sizes, highest(error)


def motion(equations: Equations, h: float, y: Vectors, sizes: Vectors) -> Lanes:
    """The largest relative change of a component in a step (see `gauss_fast_steps.motion`)."""
    v = rates(equations, y)
    most, largest = larger(highest_of(v), lanes(constants.TINY)), lanes(0.0)
    for i in equations.components:
        below = larger(abs(v[i]) + lanes(constants.LEAST_MOVING) * most, lanes(constants.TINY))
        largest = larger(largest, lanes(h) * sizes[i] / below)
    return largest
