"""The stepping of the fast Gauss method, as source text that is generated around the equations of one case.

The eight stages are the eight lanes of one vector; there is one vector for each component. The stepping is written once
below and expanded: a line with an `@` is repeated for each component of the derivative, a line with a `%` for each
component of the state, and `<|x@|>` becomes `x0, x1, `. So a step has no inner loop and stores nothing in memory,
whatever the dimension.

What a step does:

1. First guesses of the slopes. After a step of the same length: the best linear estimate for functions as smooth as the
   tolerance implies (`gauss_fast.extrapolation_weights`). Otherwise: the last stage polynomial continued (its monomials,
   times the powers of the ratio of the steps).
2. Fixed-point iteration f = f(y + h A f), or a = a(q + h c v + h^2 A^2 a), until the change expected in the next round is
   a fraction of the tolerance. Changes are computed only in the last rounds: from three rounds before the number that
   the last step took. Where they do not shrink, the step is repeated with a smaller size. With many first-order equations
   the slopes are computed in groups, each with the new slopes of the groups before it (Gauss-Seidel): a pair x' = v,
   v' = -x converges with the square of the rate.
3. The error estimate, from the decay of the stage polynomial. Let a be the size of its two highest Legendre coefficients
   and F that of the derivative. Coefficient 8, the first that is missing, is about a; collocation at the Gauss nodes
   squares it (exactly so for a linear equation), so a step errs by about h a^2 / F. That holds while coefficients keep
   falling. A sharp turn between two nodes leaves all of them equally large: then a d^2 is added, where d is the share of
   the two highest in the squares of the last four, if they are more than NOT_FALLING of the other two.
4. A compensated update, and the next step size.

Constants found by measuring on the pendulum, Kepler's orbit and the free rigid body:

- ITERATION_SHARE of the tolerance may remain of the iteration, whose error is biased and makes energy drift. The assumed
  rate of convergence is never below BEST_RATE, nor below BEST_RATE_FINEST at tolerances under FINEST, where changes reach
  round-off early.
- The error is ERROR_FACTOR a^2, where a^2 counts coefficient 6 with LOWER_WEIGHT beside coefficient 7, and ERROR_FACTOR
  NOT_FALLING_FACTOR a d^2, of the part of a above NOISE roundings. A step that errs by more than MOST_ERROR tolerances is
  repeated.
- Steps are kept equal (guesses are better, and energy does not drift) while the next one could be HOLD_FROM to HOLD times
  as long. From HOLD times on, the next step is longer by LEAP times less than that. After EQUAL_STEPS_NEEDED equal steps
  (FIRST_EQUAL_STEPS_NEEDED the first time: the first step is a guess) it grows by the factor that all of them allowed.
- The scale of a component is at least LEAST_SHARE of the largest change in a step. Changes below NOISE roundings are
  round-off: a step in which no other change is seen is not limited by convergence (FAST).
- TINY replaces 0 where nothing moves, at an equilibrium; nothing else is compared with an absolute number.

Motions with quick and slow parts (a pericentre): equal steps would be too short for most of the orbit, and with steps
that follow the error alone energy drifts. Where the derivatives J of the acceleration are known, its frequency
|J|^(1/2), with the norm of Frobenius, can choose the step size: the mean of 1/h on both sides of a point is the frequency
there over a constant stride. That rule is the same backwards in time, so what energy gains towards a pericentre is lost
on the way back (Huang, Leimkuhler, SIAM Journal on Scientific Computing 18, 1997). It is tried where the wanted step
varies HOLD times within WINDOW steps, and kept while the wanted stride varies less than that and less than STEADIER of
the former variation.

For energy not to drift, nothing may be rounded the same way in every step (Hairer, McLachlan, Razakarivony, BIT 48,
2008): weights and nodes come with their rounding residuals, each row of the stage matrix is rounded so that the
sum of the row is not, step sizes have so few bits that their products are exact. Nor may a biased part of the truncation
or of the iteration remain: tolerances below FINE leave less of both, and the error of energy is then the random walk of
round-off (Brouwer's law). Four fifths of that come from the sums of a step where they are made in binary64 (the pendulum,
23 steps a period), one fifth from those of the slopes. So for tolerances below EXACT the rounding residual of every sum
and product is carried too. That takes a twentieth to an eighth of the time of a step.

A divisor of the equations keeps its sign on a smooth motion: where it goes through 0 they have a pole. A wall that turns
the motion round within 1e-8 of a step is met by none of its stages, and the step, right as it looks, ends beyond the pole.
So a step in which a divisor changes its sign is repeated with a smaller size, down to SHORTEST_AT_POLE of the span: the
divisor of sin(x) / x passes 0 without a pole.

A sample is a separate step from the start of the step that it lies in, with that step's stage polynomial as the first
guess: it has the order of the end of a step, and the steps do not depend on the samples. Nothing is computed from it, so
its iteration may leave 1 / SAMPLE_FACTOR times as much.
"""

from __future__ import annotations

import textwrap

NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, STIFF, OUT_OF_RANGE = 1, 2, 3, 4, 5

MOST_STEPS, MOST_STIFF = 40_000_000, 1000
"""Attempts for one trajectory, about twenty seconds; and steps of a slow motion that only convergence limits."""

# First rows of the parts of the table (rows, 8): columns of the stage matrix (squared for second-order equations), of the
# monomials of the stage polynomial about its end and of the powers of the nodes; nodes; weights; weights of positions;
# columns of the guesses one step ahead and of the stage matrix not squared; both stage matrices times these guesses; the
# nodes to few bits, and the rest; rounding residuals of both rows of weights; both stage matrices times the powers of the
# nodes; weights of the value at the end of a step; columns of the Legendre coefficients, and weights of the last four.
STAGES, MONOMIALS, POWERS, NODES, WEIGHTS, POSITIONS, AHEAD, ONCE, CARRIED = 0, 8, 16, 24, 25, 26, 27, 35, 43
ONCE_CARRIED, NODES_HIGH, NODES_LOW, WEIGHTS_LOW, POWERED, ONCE_POWERED, ENDS = 51, 59, 60, 61, 63, 71, 79
LEGENDRE, HIGHEST = 80, 88

SMALLEST, LARGEST = 1e-290, 1e290
"""The largest component of an initial state must lie between them: outside, products of it with a tolerance or with
stages underflow or overflow. A motion that decays from such a start may go below."""

SCRATCH, SCRATCH_ROWS = 136, 120
"""Rows of the table that products write their vectors to. A processor delays a load whose address has the same last
twelve bits as that of a recent store: with vectors on the stack, whose address varies, one process in ten took up to a
fifth more time. The first of these rows have such addresses in common with MONOMIALS and POWERS, which few steps read."""

HEAD = f"""
import math
import numpy as np
from gnomon.harness.integrators.gauss.lanes import fma, highest, lane, lanes, larger, minus, over, products, put, row, size, total, totals, with_lane
from gnomon.harness.integrators.gauss.lanes_math import sin_and_cos, turned, turned_first
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic
NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, STIFF = {NOT_FINITE}, {STEP_TOO_SMALL}, {TOO_MANY_STEPS}, {STIFF}
OUT_OF_RANGE, SMALLEST, LARGEST = {OUT_OF_RANGE}, {SMALLEST}, {LARGEST}
MOST_STEPS, MOST_STIFF, MOST_ROUNDS, MOST_CHANGE = {MOST_STEPS}, {MOST_STIFF}, 24, 1e80
STAGES, MONOMIALS, POWERS, NODES = {STAGES}, {MONOMIALS}, {POWERS}, {NODES}
WEIGHTS, POSITIONS, LEGENDRE, HIGHEST = {WEIGHTS}, {POSITIONS}, {LEGENDRE}, {HIGHEST}
AHEAD, ONCE, CARRIED, ONCE_CARRIED = {AHEAD}, {ONCE}, {CARRIED}, {ONCE_CARRIED}
NODES_HIGH, NODES_LOW, LOW = {NODES_HIGH}, {NODES_LOW}, {WEIGHTS_LOW - WEIGHTS}
POWERED, ONCE_POWERED, ENDS = {POWERED}, {ONCE_POWERED}, {ENDS}
ROUNDOFF, ONE = 2.0**-52, 0x3FF0000000000000
ITERATION_SHARE, SAMPLE_FACTOR, NOISE, FAST, SLOW, BEST_RATE_FINEST, BEST_RATE = 1e-3, 1e-2, 1e2, 0.3, 0.7, 1e-6, 1e-5
ERROR_FACTOR, LOWER_WEIGHT, HOLD, LEAP, LEAST_SHARE = 0.002, 0.1, 3.0, 1.3, 1e-6
HOLD_FROM, FIRST_EQUAL_STEPS_NEEDED, EQUAL_STEPS_NEEDED, FIRST_WINDOW, WINDOW, STEADIER = 0.9, 12, 100, 12, 32, 0.7
SLOW_MOTION, LEAST_MOVING, COARSE, FINE, TRIES = 1e-3, 1e-12, 1e-6, 3e-16, 4
EXACT, SPLITTER, FINEST = 1e-11, 256.0, 5e-14
SAFETY, MOST_ERROR, SHRINK_MOST, GROW_MOST, TINY = 0.9, 4.0, 0.1, 4.0, 1e-300
NOT_FALLING, NOT_FALLING_FACTOR, SHORTEST_AT_POLE = 0.03, 4.0, 1e-12


@intrinsic
def bits(typingctx, x):
    return types.int64(types.float64), lambda c, builder, s, values: builder.bitcast(values[0], ir.IntType(64))


@intrinsic
def double(typingctx, n):
    return types.float64(types.int64), lambda c, builder, s, values: builder.bitcast(values[0], ir.DoubleType())


@njit(INNER)
def root_15(x):
    # x^(1/15) within 1 %: the bits of a double, read as an integer, are nearly its logarithm.
    return double(ONE + (bits(x) - ONE) // 15)


@njit(INNER)
def powers(r):
    r2, v = r * r, lanes(1.0)
    r4 = r2 * r2
    v = with_lane(with_lane(with_lane(v, 1, r), 2, r2), 3, r2 * r)
    return with_lane(with_lane(with_lane(with_lane(v, 4, r4), 5, r4 * r), 6, r4 * r2), 7, r4 * r2 * r)


@intrinsic
def fused(typingctx, a, b, c):
    return types.float64(types.float64, types.float64, types.float64), lambda x, builder, s, values: builder.fma(*values)


@njit(forceinline=True, INNER)
def weighted(f, table, weights):
    return fma(f, row(table, weights), f * row(table, weights + LOW))


@njit(forceinline=True, INNER)
def weighted_exactly(f, splitter, table, weights):
    # The sum of the lanes in two parts. Adding and subtracting the much larger splitter leaves few bits of each
    # lane: their sum is exact.
    w = row(table, weights)
    parts = f * w
    high = minus(parts + lanes(splitter), lanes(splitter))
    return total(high), total(minus(parts, high) + fma(f, row(table, weights + LOW), fma(f, w, -parts)))


@njit(forceinline=True, INNER)
def summed(y, change):
    # The sum and its rounding residual.
    end = y + change
    back = end - y
    return end, (y - (end - back)) + (change - back)


@njit(forceinline=True, INNER)
def added(y, compensation, h, rate):
    # y + compensation + h * rate, and its rounding residual.
    change = fused(h, rate, compensation)
    end, residual = summed(y, change)
    return end, residual + (fused(h, rate, -change) + compensation)


@njit(forceinline=True, INNER)
def legendre_of_one(f, table):
    # The coefficients 4 to 7 in their lanes.
    return totals(
        f * row(table, HIGHEST), f * row(table, HIGHEST + 1), f * row(table, HIGHEST + 2), f * row(table, HIGHEST + 3)
    )


@njit(INNER)
def at(m, x):
    # The polynomial with the coefficients m.
    v = lanes(lane(m, 7))
    for k in range(6, -1, -1):
        v = fma(v, x, lanes(lane(m, k)))
    return v
"""

FIRST_ORDER = {
    "prepare": "",
    "sums": "p = products(table, first, (<|f@, |>))\n    v = p",
    "place": "x@ = fma(hh, p[@], lanes(y[@]))",
    "placed": "<|x@, |>",
    "shift": "q = products(table, STAGES, (<|d@, |>))",
    "next_state": "<|h * total(weighted(f@, table, WEIGHTS)) + compensation[@], |>",
    "next_state_exactly": "high@, rest@ = weighted_exactly(f@, splitter[@], table, WEIGHTS)\n"
    "    end@, residual@ = added(y[@], fused(h, rest@, compensation[@]), h, high@)",
    "ends": "<|end@, |>), (<|residual@, |>",
    "rate": "y[@]",
    "slope": "slopes((<|lanes(y[%]), |>), forcing(lanes(0.0), k), k)",
    "first": "0.1 * largest / fastest if largest > 0.0 and fastest > 0.0 else 1e-3 * end",
    "slope_roundoff": "0.0",
}
SECOND_ORDER = FIRST_ORDER | {
    "prepare": "m, n = hh * row(table, NODES_HIGH), hh * row(table, NODES_LOW)\n    "
    "b@ = fma(m, lanes(y[N + @]), fma(n, lanes(y[N + @]), lanes(y[@])))\n    "
    "e@ = lanes(0.0)\n    if exactly:\n        "
    "e@ = fma(n, lanes(y[N + @]), fma(m, lanes(y[N + @]), lanes(y[@]) - b@)) + lanes(compensation[@])",
    "stage_residual": "s@ = fma(hh * hh, p[@], b@ - x@) + e@",
    "place": "x@ = fma(hh * hh, p[@], b@)",
    "next_state": "<|h * y[N + @] + (h * (h * total(weighted(f@, table, POSITIONS)) + compensation[N + @]) + compensation[@]), |>"
    "<|h * total(weighted(f@, table, WEIGHTS)) + compensation[N + @], |>",
    "next_state_exactly": "place@, place_residual@ = added(y[@], fused(h, compensation[N + @], compensation[@]), h, y[N + @])\n"
    "    high@, rest@ = weighted_exactly(f@, splitter[@], table, POSITIONS)\n"
    "    end@, residual@ = added(place@, fused(h * h, rest@, place_residual@), h * h, high@)\n"
    "    high@, rest@ = weighted_exactly(f@, splitter[@], table, WEIGHTS)\n"
    "    speed@, speed_residual@ = added(y[N + @], fused(h, rest@, compensation[N + @]), h, high@)",
    "ends": "<|end@, |><|speed@, |>), (<|residual@, |><|speed_residual@, |>",
    "rate": "y[N + @]",
    "first": "0.1 * (largest / fastest + np.sqrt(furthest / fastest)) "
    "if fastest > 0.0 and furthest + largest > 0.0 else 1e-3 * end",
    "slope_roundoff": "4 * ROUNDOFF * furthest / (step * step)",
}
WITH_VELOCITY = SECOND_ORDER | {
    "sums": "p = products(table, first, (<|f@, |>))\n    v = products(table, once, (<|f@, |>))",
    "place": SECOND_ORDER["place"] + "\n        u@ = fma(hh, v[@], lanes(y[N + @]))",
    "placed": "<|x@, |><|u@, |>",
    "shift": SECOND_ORDER["shift"] + "\n        r = products(table, ONCE, (<|d@, |>))",
}

SIDES = """beyond = poles((<|lanes(y[%]), |>), forcing(lanes(0.0), k), k)
sides = (FIRST)"""

CROSSED = """beyond = poles((<|lanes(end_state[%]), |>), forcing(lanes(after), k), k)
if step > SHORTEST_AT_POLE * end and (CHANGED):
    h, unmonitored, rejected = 0.3 * step, 0, True
    {shorter}
    continue
sides = (FIRST)"""

LEGENDRE_OF_MANY = "legendre = products(table, LEGENDRE, f)"
LEGENDRE_OF_ONE = "legendre = (legendre_of_one(f0, table),)"
"""For one component only the last four, by sums: eight columns do not fit the processor's registers beside the rest."""

EQUAL_STEPS = """
if HOLD_FROM <= grow < HOLD:
    # The usual case in a branch of its own: the next step can start before `grow` is known.
    h = step * more
elif grow >= HOLD and rejected:
    h = step
elif grow >= HOLD:
    h = step * min(grow / LEAP, GROW_MOST)
    equal_steps, common_growth = 0, GROW_MOST
else:
    h = step * grow
"""

NONE_SEEN = """by_frequency, stride, step_frequency, norm, step_variation, windows_to_wait = False, 0.0, 0.0, 0.0, 1.0, 0
window, steps_seen, shortest, longest, least_stride_8, largest_stride_8 = FIRST_WINDOW, 0, np.inf, 0.0, np.inf, 0.0
"""

BY_FREQUENCY = """
before, norm = norm, square
if 0.0 < before and grow < GROW_MOST:
    # A step far too short gives no good estimate of the fitting one. Eighth powers of strides need no root.
    fitting_step = step * grow
    fourth = (fitting_step * fitting_step) * (fitting_step * fitting_step)
    stride_8 = (fourth * before) * (fourth * norm)
    shortest, longest, least_stride_8, largest_stride_8 = (
        min(shortest, fitting_step), max(longest, fitting_step),
        min(least_stride_8, stride_8), max(largest_stride_8, stride_8),
    )
    steps_seen += 1
if by_frequency and (
    grow >= GROW_MOST
    or steps_seen == window and largest_stride_8 > min(STEADIER * step_variation, HOLD) ** 8 * least_stride_8
):
    # The frequency does not predict where steps must be short; it is tried again after ever more windows.
    by_frequency, windows_to_wait, steps_seen = False, 2 * windows_to_wait + 4, window
elif steps_seen == window and not by_frequency and windows_to_wait > 0:
    windows_to_wait -= 1
elif (
    steps_seen == window and not by_frequency and longest > HOLD * shortest
    and largest_stride_8 < (2 * longest / shortest) ** 8 * least_stride_8
):
    by_frequency, step_variation, stride, step_frequency = (
        True, longest / shortest, 0.95 * least_stride_8**0.125, math.sqrt(math.sqrt(norm))
    )
    equal_steps, common_growth, more = 0, GROW_MOST, 1.0
if steps_seen == window:
    window, steps_seen, shortest, longest, least_stride_8, largest_stride_8 = WINDOW, 0, np.inf, 0.0, np.inf, 0.0
if by_frequency:
    frequency = math.sqrt(math.sqrt(norm))
    if grow < HOLD_FROM:
        stride, step_frequency = stride * grow, frequency
    elif more > 1.0:
        stride, step_frequency = stride * more, frequency
    else:
        step_frequency = min(max(2 * frequency - step_frequency, 0.5 * frequency), 2 * frequency)
    h = min(stride / step_frequency, GROW_MOST * step)
else:
"""

CONVERGENCE_TEST = """if change * max(rate, assumed_rate) <= allowed_change and rate < SLOW:
    break
if change < noise and (rate > SLOW or rounds > 16):
    break
if not change < MOST_CHANGE or rounds == MOST_ROUNDS or (rounds > 2 and rate > SLOW):
    rounds = -rounds
    break"""


def settled(depth: int) -> str:
    """The lines, indented by `depth`, that end the loop of rounds; `rounds` is negative where it does not converge."""
    return textwrap.indent(CONVERGENCE_TEST, " " * depth).lstrip()


ROUND = """{place}
        {slopes}
        {correct}"""

SLOPES = "g = slopes(({placed}), w, k)"

SLOPES_BY_TURNS = """if rounds == 0:
            g, near = slopes_first(({placed}), w, k)
        else:
            g, near = slopes_again(({placed}), w, k, near)"""

STAGES_OF_A_STEP = """
@njit(INLINE INNER)
def NAME(
    t, h, y, compensation, f, p, v, k, table, change_weight, allowed_change, noise, assumed_rate, expected, unmonitored,
    exactly
):
    <|f@, |> = f
    hh = lanes(h)
    w = forcing(fma(hh, row(table, NODES), lanes(t)), k)
    {prepare}
    before, rate, rounds = 0.0, expected, 0
    while True:
        {round}
        rounds += 1
        if rounds > unmonitored:
            off = lanes(0.0)
            off = fma(size(g@ - f@), lanes(change_weight[@]), off)
            change = total(off)
            if rounds > unmonitored + 1:
                rate = change / before if before > 0.0 else 0.0
            if rounds > unmonitored + 1 or expected > 0.0 or (unmonitored > 0 and change <= allowed_change):
                f@ = g@
                {convergence_test}
            before = change
        f@ = g@
        {sums_of_a_round}
    {squares}
    # Changes that are round-off give no rate.
    return rounds, rate if before > noise else 0.0, (<|f@, |>), {at_end}
""".replace("{convergence_test}", settled(16))

ADVANCE = """
@njit(forceinline=True, INNER)
def sums(f, table, first, once):
    <|f@, |> = f
    {sums}
    return p, v


@njit(INNER)
def next_state(h, y, compensation, f, table):
    # The state after a step, and the rounding residual of the last sum.
    <|f@, |> = f
    change = ({next_state})
    end%, residual% = summed(y[%], change[%])
    return (<|end%, |>), (<|residual%, |>)


@njit(INNER)
def next_state_exactly(h, y, compensation, f, splitter, table):
    # The same with the rounding residuals of all sums and products.
    <|f@, |> = f
    {next_state_exactly}
    return ({ends})


@njit(SIGNATURE, OPTIONS)
def advance(p_, table, initial, times, tolerance, out, stop):
    end = times[-1]
    # Sums of times stay exact while steps are multiples of the spacing of numbers next to this one.
    grid = 2.0 ** np.ceil(np.log2(end)) if end > 0.0 else 1.0
    fine_ratio = min(tolerance / FINE, 1.0)
    # Changes are sums over eight stages.
    allowed_change, noise = 8 * ITERATION_SHARE * max(tolerance, ROUNDOFF / 4) * fine_ratio**10, 8 * NOISE * ROUNDOFF
    exactly = tolerance < EXACT
    best_rate = BEST_RATE_FINEST if tolerance < FINEST else BEST_RATE
    taken = 0
    for n in range(initial.shape[0]):
        k = constants((PARAMETERS))
        t, sample, attempts, stiff, reason = 0.0, 0, 0, 0, 0
        compensation% = 0.0
        y, compensation = (<|initial[n, %], |>), (<|compensation%, |>)
        g = {slope}
        f@ = lanes(lane(lanes(g[@]), 0))
        size@ = abs(lane(f@, 0))
        furthest, largest, fastest = 0.0, 0.0, 0.0
        furthest = max(furthest, abs(y[@]))
        largest = max(largest, abs({rate}))
        fastest = max(fastest, size@)
        h = min({first}, end)
        last, rejected, equal_steps, common_growth, equal_steps_needed, unmonitored, rate = (
            h, False, 0, GROW_MOST, FIRST_EQUAL_STEPS_NEEDED, 0, 0.0
        )
        {none_seen}
        {sides}
        old@ = f@
        extent = 0.0
        extent = max(extent, abs(y[%]))
        if extent > LARGEST or 0.0 < extent < SMALLEST:
            reason = OUT_OF_RANGE
        while reason == 0 and sample < times.size:
            if not (h > 0.0 and h < np.inf):
                reason = NOT_FINITE
                break
            if t + h / 4 <= t:
                reason = STIFF if stiff > 0 else STEP_TOO_SMALL
                break
            # Few bits: products with the high parts of the nodes, and the square, are then exact.
            h = double(bits(h) & -(1 << 27))
            if h > COARSE * grid:
                h = (h + grid) - grid
            # The step is h rounded so that t + step is exact; the last one ends at the last sample.
            step = end - t if t + h >= end else (t + h) - t
            after = end if t + h >= end else t + step
            attempts += 1
            if attempts > MOST_STEPS:
                reason = TOO_MANY_STEPS
                break
            if stiff > MOST_STIFF:
                reason = STIFF
                break
            largest = 0.0
            largest = max(largest, size@)
            # At an equilibrium the terms of the slopes cancel, and round-off remains.
            slope_roundoff, least_scale = {slope_roundoff}, np.inf
            scale_floor = max(step * largest * max(LEAST_SHARE, 16 * ROUNDOFF / tolerance), step * slope_roundoff)
            scale@ = max(max(max(abs({rate}), step * size@), scale_floor), TINY)
            change_weight@ = step / scale@
            splitter@ = SPLITTER * size@
            least_scale = min(least_scale, scale@)
            step_noise = noise * max(1.0, step * (slope_roundoff / least_scale) / (4 * ROUNDOFF))
            if step == last:
                # The guesses themselves are needed only where their first change is computed.
                ahead = (<|old@, |>)
                if unmonitored == 0 or CORRECTED:
                    ahead = products(table, AHEAD, (<|old@, |>))
                p, v = sums((<|old@, |>), table, CARRIED, ONCE_CARRIED)
            else:
                ratios = powers(step / last)
                m = products(table, MONOMIALS, (<|old@, |>))
                ahead = products(table, POWERS, (<|m[@] * ratios, |>))
                p, v = sums((<|m[@] * ratios, |>), table, POWERED, ONCE_POWERED)
            assumed_rate = best_rate if t > 0.0 else 1.0
            rounds, seen_rate, f, square = stages(
                t, step, y, compensation, ahead, p, v, k, table, (<|change_weight@, |>), allowed_change, step_noise,
                assumed_rate, 0.0, unmonitored, exactly
            )
            COUNT abs(rounds)
            rate = seen_rate if seen_rate > 0.0 else min(rate, FAST)
            if rounds < 0:
                h, unmonitored = 0.3 * step, 0
                {shorter}
                rejected = True
                continue
            f@ = lanes(f[@])
            size@ = total(size(f@)) / 8
            worst = lanes(0.0)
            {legendre}
            c@ = larger(size(legendre[@]) - lanes(slope_roundoff), lanes(0.0))
            worst = fma(c@ * lanes(1.0 / max(size@, TINY)), c@ * lanes(1.0 / scale@), worst)
            error = lane(worst, 7) + LOWER_WEIGHT * lane(worst, 6)
            if lane(worst, 7) + lane(worst, 6) > NOT_FALLING * (lane(worst, 5) + lane(worst, 4)):
                worst = lanes(0.0)
                worst = fma(c@ / lanes(scale@), c@ / lanes(scale@), worst)
                high, lower = lane(worst, 7) + lane(worst, 6), lane(worst, 5) + lane(worst, 4)
                decay = high / max(high + lower, TINY)
                error += NOT_FALLING_FACTOR * max(math.sqrt(high) - NOISE * ROUNDOFF / step, 0.0) * decay * decay
            error *= ERROR_FACTOR * step / (tolerance * fine_ratio**4)
            grow = SAFETY / root_15(max(error, TINY))
            if not error <= MOST_ERROR:
                h = step * max(SHRINK_MOST, grow) if error < np.inf else step * SHRINK_MOST
                {shorter}
                rejected = True
                continue
            if exactly:
                end_state, residual = next_state_exactly(step, y, compensation, f, (<|splitter@, |>), table)
            else:
                end_state, residual = next_state(step, y, compensation, f, table)
            finite = 0.0
            finite += end_state[%] - end_state[%]
            if finite != 0.0:
                reason = NOT_FINITE
                break
            {crossed}
            unsolved = False
            if times[sample] <= after:
                m = products(table, MONOMIALS, f)
                while sample < times.size and times[sample] <= after:
                    part = times[sample] - t
                    if times[sample] == after:
                        out[n, sample, %] = end_state[%]
                    else:
                        x = fma(lanes(part / step), row(table, NODES), lanes(-1.0))
                        near = (<|at(m[@], x), |>)
                        unsolved = True
                        for _ in range(TRIES):
                            # The step has converged, so this converges too, though a change may exceed the one before.
                            p, v = sums(near, table, STAGES, ONCE)
                            again, _rate, near, _square = aside(
                                t, part, y, compensation, near, p, v, k, table, (<|change_weight@, |>),
                                allowed_change / SAMPLE_FACTOR, step_noise, 1e-3, max(rate, 1e-3), 0, exactly
                            )
                            COUNT abs(again)
                            unsolved = again <= 0
                            if not unsolved:
                                break
                        if unsolved:
                            break
                        place, _residual = next_state(part, y, compensation, near, table)
                        out[n, sample, %] = place[%]
                    FROZEN
                    sample += 1
            if unsolved:
                # A sample whose stages do not converge is computed within a shorter step.
                h, unmonitored, rejected = 0.3 * step, 0, True
                {shorter}
                continue
            old@ = f@
            taken += 1
            t = after
            y, compensation = end_state, residual
            last = step
            if rate > FAST and rounds > 2:
                grow = min(grow, max(0.5, FAST / rate))
            equal_steps, common_growth = (
                (equal_steps + 1, min(common_growth, grow)) if grow >= HOLD_FROM and not rejected else (0, GROW_MOST)
            )
            more = 1.0
            if equal_steps == equal_steps_needed:
                more, equal_steps, common_growth, equal_steps_needed = (
                    common_growth if common_growth >= 1.1 else 1.0, 0, GROW_MOST, EQUAL_STEPS_NEEDED
                )
            {control}
            unmonitored = max(rounds - 3, 0)
            if rate > FAST / 4:
                # A component that has decayed goes on changing at the same relative rate.
                most, moves = 0.0, 0.0
                most = max(most, abs({rate}))
                moves = max(moves, step * size@ / max(abs({rate}) + LEAST_MOVING * most, TINY))
                stiff = stiff + 1 if moves < SLOW_MOTION else max(stiff - 1, 0)
            rejected = False
        if reason != 0 and stop[0] == 0:
            stop[0] = reason
            stop[1] = n
            stop[2] = sample
    return taken
"""
