"""The fast Gauss method for single trajectories: first guesses, error of a step, update, samples.

The eight stages are the eight lanes of one vector. See `gauss_fast_stages` for the stages, `gauss_fast_control` for step
sizes. The functions run on arrays of NumPy, step by step in a debugger; `gauss_fast_kernel` compiles them.

The energy drifts if an operation rounds in the same way in every step (Hairer, McLachlan, Razakarivony, BIT 48, 2008).
So weights and nodes have rounding residuals, each row of the stage matrix is rounded but keeps its sum, and step sizes
have so few bits that their products are exact. Biased errors of truncation and iteration must not remain either: below
`fine`, a tolerance makes both smaller, and the error of energy is then the random walk of round-off (Brouwer's law). With
sums in binary64 (the pendulum, 23 steps a period) four fifths of this error come from the sums of a step, and one fifth
from the slopes. So for tolerances below `exact` the rounding residual of every sum and product is carried too.
"""

from __future__ import annotations

import math
from typing import Any

from gnomon.harness.integrators.gauss import constants
from gnomon.harness.integrators.gauss.constants import TUNING
from gnomon.harness.integrators.gauss.gauss_fast_control import (
    choose_frequency,
    equal_length,
    few_bits,
    first_length,
    growth,
    length_by_frequency,
    limit_growth,
    no_frequency,
    restart,
    root_15,
)
from gnomon.harness.integrators.gauss.gauss_fast_layout import Equations
from gnomon.harness.integrators.gauss.gauss_fast_stages import (
    Accuracy,
    Numbers,
    Start,
    Vectors,
    at,
    legendre_of_one,
    next_state,
    next_state_exactly,
    powers,
    rates,
    stages,
    sums,
)
from gnomon.harness.integrators.gauss.lanes import Table, fma, lane, lanes, larger, products, row, total


def advance(
    equations: Equations, p_: Any, table: Table, initial: Any, times: Any, tolerance: float, out: Any, stop: Any
) -> int:
    """Integrate one trajectory; gives the number of accepted steps.

    p_ (parameters,), `table` as `gauss_fast.table` gives it, `initial` (dimension,), `times` (samples,), `out`
    (samples, dimension). `stop` (4,) gets the reason of an early end and, in its element 2, the sample; element 3 counts
    right-hand sides.
    """
    n = equations.count
    end = times[-1]
    # A power of two that is at least the span: steps that are multiples of its spacing keep sums of times exact.
    grid = 2.0 ** math.ceil(math.log2(end)) if end > 0.0 else 1.0
    fine_ratio = min(tolerance / TUNING.fine, 1.0)
    allowed_change = (
        8 * TUNING.iteration_share * max(tolerance, constants.ROUNDOFF / 4) * fine_ratio**10
    )  # over eight stages
    noise = 8 * TUNING.roundings * constants.ROUNDOFF
    exactly = tolerance < TUNING.exact
    best_rate = TUNING.best_rate_finest if tolerance < TUNING.finest else TUNING.best_rate

    y, k = equations.at_start(p_, initial)
    compensation = tuple(0.0 for _ in y)
    f = at_rest(equations, y, 0.0, k)
    sizes = tuple(abs(lane(x, 0)) for x in f)
    furthest, extent = largest_of(y[:n]), largest_of(y)
    h = first_length(equations.second_order, end, furthest, largest_of(rates(equations, y)), largest_of(sizes))
    equal, seen = (0, TUNING.grow_most, TUNING.few_steps), no_frequency()
    sides = signs(equations, y, 0.0, k)
    old, last, rejected, unmonitored, rate = f, h, False, 0, 0.0
    t, sample, attempts, stiff, taken, evaluations = 0.0, 0, 0, 0, 0, 0
    reason = constants.OUT_OF_RANGE if extent > constants.LARGEST or 0.0 < extent < constants.SMALLEST else 0
    while reason == 0 and sample < times.size:
        reason = no_step(t, h, attempts, stiff)
        if reason != 0:
            break
        h = few_bits(h)
        if h > constants.COARSE * grid:
            h = (h + grid) - grid
        # The step is h, rounded so that t + step is exact. The last step ends at the last sample.
        step = end - t if t + h >= end else (t + h) - t
        after = end if t + h >= end else t + step
        attempts += 1

        scale, slope_roundoff = scales(equations, step, y, sizes, furthest, tolerance)
        change_weight = tuple(step / x for x in scale)
        least_scale = scale[0]
        for x in scale[1:]:
            least_scale = min(least_scale, x)
        step_noise = noise * max(1.0, step * (slope_roundoff / least_scale) / (TUNING.roundings * constants.ROUNDOFF))
        start = Start(t, step, y, compensation)
        accuracy = Accuracy(change_weight, allowed_change, step_noise, best_rate if t > 0.0 else 1.0, exactly)
        ahead = guesses(equations, step, last, old, unmonitored, table)
        rounds, seen_rate, f, square = stages(equations, start, k, table, ahead, accuracy, 0.0, unmonitored)
        evaluations += abs(rounds)
        rate = seen_rate if seen_rate > 0.0 else min(rate, TUNING.fast)
        if rounds < 0:
            h, unmonitored, rejected = TUNING.shrink * step, 0, True
            seen = restart(h, seen)
            continue

        sizes = tuple(total(abs(x)) / 8 for x in f)
        error = error_of(equations, step, f, sizes, scale, slope_roundoff, table)
        error *= TUNING.error_factor * step / (tolerance * fine_ratio**4)
        grow = TUNING.safety / root_15(max(error, constants.TINY))
        if not error <= 1.0:
            h = step * max(TUNING.shrink, grow) if error < math.inf else step * TUNING.shrink
            seen, rejected = restart(h, seen), True
            continue

        if exactly:
            splitter = tuple(constants.SPLITTER * x for x in sizes)
            end_state, residual = next_state_exactly(equations, step, y, compensation, f, splitter, table)
        else:
            end_state, residual = next_state(equations, step, y, compensation, f, table)
        finite = 0.0
        for x in end_state:
            finite += x - x
        if finite != 0.0:
            reason = constants.NOT_FINITE
            break
        unsolved = False
        if equations.divisors:
            # A divisor keeps its sign on a smooth motion, as its zero is a pole of the equations. If a wall reverses the
            # motion within 1e-8 of a step, no stage meets the wall: the step looks right but ends beyond the pole. Short
            # steps are not repeated: the divisor of sin(x) / x passes 0 without a pole.
            beyond = signs(equations, end_state, after, k)
            unsolved = step > constants.SHORTEST_AT_POLE * end and has_crossed(beyond, sides)
        if not unsolved and times[sample] <= after:
            monomials = products(table, constants.MONOMIALS, f)
            while sample < times.size and times[sample] <= after:
                place = end_state
                if times[sample] < after:
                    part = times[sample] - t
                    unsolved, rounds_of_sample, place = sample_at(
                        equations, part, start, k, table, monomials, accuracy, rate
                    )
                    evaluations += rounds_of_sample
                if unsolved:
                    break
                write(equations, out, sample, place, initial)
                sample += 1
        if unsolved:
            h, unmonitored, rejected = TUNING.shrink * step, 0, True
            seen = restart(h, seen)
            continue

        if equations.divisors:
            sides = beyond
        old, y, compensation, t, last = f, end_state, residual, after, step
        taken += 1
        grow = limit_growth(grow, rate, rounds)
        more, equal = growth(grow, rejected, equal)
        if equations.by_position:
            more, equal, seen = choose_frequency(step, grow, more, square, equal, seen)
        if seen[0]:
            h, seen = length_by_frequency(step, grow, more, seen)
        else:
            h, equal = equal_length(step, grow, more, rejected, equal)
        unmonitored = max(rounds - TUNING.unmonitored, 0)
        if rate > TUNING.stiff_rate:
            stiff = stiff + 1 if motion(equations, step, y, sizes) < TUNING.slow_motion else max(stiff - 1, 0)
        rejected = False
    stop[0] = reason
    stop[2] = sample
    stop[3] += 8 * evaluations
    return taken


def at_rest(equations: Equations, y: Numbers, t: float, k: Numbers) -> Vectors:
    """The slopes at one state, in all lanes."""
    g = equations.slopes(tuple(lanes(x) for x in y), equations.forcing(lanes(t), k), k)
    return tuple(lanes(lane(g[i], 0)) for i in range(equations.count))


def largest_of(values: Numbers) -> float:
    largest = 0.0
    for x in values:
        largest = max(largest, abs(x))
    return largest


def no_step(t: float, h: float, attempts: int, stiff: int) -> int:
    """The reason not to take a step; 0 if there is none."""
    reason = 0
    if not (h > 0.0 and h < math.inf):
        reason = constants.NOT_FINITE
    elif t + h / 4 <= t:
        reason = constants.STIFF if stiff > 0 else constants.STEP_TOO_SMALL
    elif attempts >= constants.MOST_STEPS:
        reason = constants.TOO_MANY_STEPS
    elif stiff > constants.MOST_STIFF:
        reason = constants.STIFF
    return reason


def scales(
    equations: Equations, step: float, y: Numbers, sizes: Numbers, furthest: float, tolerance: float
) -> tuple[Numbers, float]:
    """The scale of each component, which divides its error: its size or its change in a step, whichever is larger.

    At an equilibrium the terms of the slopes cancel, and their round-off, the second result, remains.
    """
    roundoff = TUNING.roundings * constants.ROUNDOFF * furthest / (step * step) if equations.second_order else 0.0
    least = step * max(largest_of(sizes) * TUNING.roundings * constants.ROUNDOFF / tolerance, roundoff)
    v = rates(equations, y)
    scale = tuple(max(max(max(abs(v[i]), step * sizes[i]), least), constants.TINY) for i in range(equations.count))
    return scale, roundoff


def guesses(
    equations: Equations, step: float, last: float, old: Vectors, unmonitored: int, table: Table
) -> tuple[Vectors, Vectors, Vectors]:
    """First guesses of the slopes, and their sums.

    After a step of equal length they are the best linear estimate for functions as smooth as the tolerance implies
    (`gauss_fast.extrapolation_weights`). Otherwise they extrapolate the last stage polynomial: its monomials times the
    powers of the ratio of the steps.

    The sums are always needed, the guesses only if their first change is computed or multiplied by derivatives.
    """
    if step == last:
        ahead = old
        if equations.derivatives or unmonitored == 0:
            ahead = products(table, constants.AHEAD, old)
        p, v = sums(equations, old, table, constants.CARRIED, constants.ONCE_CARRIED)
    else:
        ratios = powers(step / last)
        scaled = tuple(m * ratios for m in products(table, constants.MONOMIALS, old))
        ahead = products(table, constants.POWERS, scaled)
        p, v = sums(equations, scaled, table, constants.POWERED, constants.ONCE_POWERED)
    return ahead, p, v


def error_of(
    equations: Equations, step: float, f: Vectors, sizes: Numbers, scale: Numbers, slope_roundoff: float, table: Table
) -> float:
    """The error of the step, up to a factor, from the decay of the Legendre coefficients of the stage polynomial.

    Let a be the size of the two highest coefficients and F the size of the derivative. Coefficient 8, the first missing
    one, is about a. Collocation at the Gauss nodes squares it (exactly so for a linear equation), so the error of a
    step is about h a^2 / F as long as the coefficients fall. After a sharp turn between two nodes they are all equally
    large: then a d^2 is added, with d the share of the two highest coefficients in the squares of the last four.

    For one component only the last four coefficients are computed, as sums: eight columns would not fit into the
    processor's registers.
    """
    n = equations.count
    legendre = products(table, constants.LEGENDRE, f) if n > 1 else (legendre_of_one(f[0], table),)
    c = tuple(larger(abs(x) - lanes(slope_roundoff), lanes(0.0)) for x in legendre)
    worst = lanes(0.0)
    for i in equations.components:
        worst = fma(c[i] * lanes(1.0 / max(sizes[i], constants.TINY)), c[i] * lanes(1.0 / scale[i]), worst)
    error = lane(worst, 7) + TUNING.lower_weight * lane(worst, 6)
    if lane(worst, 7) + lane(worst, 6) > TUNING.not_falling * (lane(worst, 5) + lane(worst, 4)):
        sharp = lanes(0.0)
        for i in equations.components:
            sharp = fma(c[i] / lanes(scale[i]), c[i] / lanes(scale[i]), sharp)
        high, lower = lane(sharp, 7) + lane(sharp, 6), lane(sharp, 5) + lane(sharp, 4)
        decay = high / max(high + lower, constants.TINY)
        error += max(math.sqrt(high) - TUNING.roundings * constants.ROUNDOFF / step, 0.0) * decay * decay
    return error


def signs(equations: Equations, y: Numbers, t: float, k: Numbers) -> Numbers:
    """The divisors that may change their sign."""
    if not equations.divisors:
        return ()
    divisors = equations.poles(tuple(lanes(x) for x in y), equations.forcing(lanes(t), k), k)
    return tuple(lane(x, 0) for x in divisors)


def has_crossed(beyond: Numbers, sides: Numbers) -> bool:
    """Whether a divisor has changed its sign."""
    crossed = False
    for after, before in zip(beyond, sides, strict=True):
        crossed = crossed or (after < 0.0) != (before < 0.0)
    return crossed


def sample_at(
    equations: Equations, part: float, start: Start, k: Numbers, table: Table, monomials: Vectors, accuracy: Accuracy, rate: float
) -> tuple[bool, int, Numbers]:  # fmt: skip
    """Compute a sample by a separate step of length `part` from the start of the step: (has failed, rounds, state).

    A sample has the order of the end of a step, and the steps do not depend on the samples. The stage polynomial of the
    whole step gives the first guess. A sample has failed if its stages do not converge, although the stages of the step did.
    """
    x = fma(lanes(part / start.h), row(table, constants.NODES), lanes(-1.0))
    near = tuple(at(m, x) for m in monomials)
    p, v = sums(equations, near, table, constants.STAGES, constants.ONCE)
    least = TUNING.best_rate_of_sample
    finer = accuracy._replace(allowed_change=accuracy.allowed_change / TUNING.sample_factor, assumed_rate=least)
    rounds, _rate, near, _square = stages(
        equations, start._replace(h=part), k, table, (near, p, v), finer, max(rate, least), 0
    )
    place, _residual = next_state(equations, part, start.y, start.compensation, near, table)
    return rounds <= 0, abs(rounds), place


def write(equations: Equations, out: Any, sample: int, state: Numbers, initial: Any) -> None:
    """Write a sample, with the components that never change."""
    for i, x in zip(equations.moving, state, strict=True):
        out[sample, i] = x
    for i in equations.frozen:
        out[sample, i] = initial[i]


def motion(equations: Equations, step: float, y: Numbers, sizes: Numbers) -> float:
    """The largest relative change of a component in a step.

    LEAST_MOVING excludes decayed components, whose relative rate of change stays large.
    """
    v = rates(equations, y)
    most, largest = largest_of(v), 0.0
    for i in equations.components:
        largest = max(largest, step * sizes[i] / max(abs(v[i]) + constants.LEAST_MOVING * most, constants.TINY))
    return largest
