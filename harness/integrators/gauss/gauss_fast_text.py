"""The stepping of the fast Gauss method, as source text around the equations of one case.

Eight stages stand in the eight lanes of one vector, one vector for each component; the stepping is written once below
and expanded: a line with an `@` is repeated for each component of the derivative, with a `%` for each of the state, and
`<|x@|>` becomes `x0, x1, `. So nothing is looped over or stored in memory inside a step, whatever the dimension.

What a step does:

1. First guesses: of the slopes of a step as long as the last one the best estimate for functions that are as smooth as
   the tolerance says, of another the last stage polynomial carried on (its monomials, times the powers of the ratio of
   the steps).
2. Fixed point of f = f(y + h A f), or of a = a(q + h c v + h^2 A^2 a), until the change that the next round would
   bring is a fraction of the tolerance; changes are looked at from three rounds before the number that the last step
   took. Where they do not shrink the step is tried again shorter. Of many first-order equations the slopes are found in
   groups, each with the new ones of the groups before it (Gauss-Seidel): a pair x' = v, v' = -x converges with the
   square of the rate.
3. The error from the decay of the stage polynomial. Let a be the size of its two highest Legendre coefficients and F
   that of the derivative itself. Coefficient 8, the first that is missing, is about a; collocation at the Gauss nodes
   squares it (the error of a linear equation is exactly of that form), so that a step errs by about h a^2 / F. That
   holds while coefficients go on falling. A sharp turn between two nodes leaves all of them equally large: a d^2 counts
   too, where d is the part that the two highest have in the squares of the last four, above STAGNANT of the others.
4. A compensated update, and the next step size.

Numbers that were found by measuring on the pendulum, Kepler's orbit and the free rigid body: SHARE of the tolerance
is left to the iteration, whose error has a sign that lasts and makes energy drift; it is taken to shrink by SURER in a
round at best, by SURE at the finest tolerances, where changes are round-off soon. ERRS a^2 is the error where a^2
counts coefficient 6 LESS than 7, and ERRS STALE a d^2, of a what is above NOISE roundings; a step that errs by more than
SLACK tolerances is taken again. Steps are kept equal (guesses are better, and energy does not drift) until one could
grow HOLD times, then grow LEAP times less than that; or until CALM of them in turn could have grown, by what all of them
could (FIRST_CALM once: the first step is a guess). A component counts for at least LEAST of the largest change in a step,
and changes below NOISE roundings are round-off: a step in which no other change is seen is not short of convergence
(FAST). TINY stands where nothing moves, at an equilibrium; nothing else is compared with an absolute number.

Motions with quick and slow parts (a pericentre) would have equal steps that are too short for most of the way, and with
steps that follow the error alone energy drifts. Where the derivatives J of the acceleration are at hand its frequency,
|J|^(1/2) with the norm of Frobenius, can say how long a step may be: the mean of 1/h on both sides of a point is the
frequency there over a constant stride. That rule is the same backwards in time, so that what energy gains on the way to
a pericentre is lost on the way back (Huang, Leimkuhler, SIAM Journal on Scientific Computing 18, 1997). It is tried
where the step that is wanted varies HOLD times within LOOK steps, and kept while the stride that is wanted varies less
than that and than EVEN of the former variation.

So that energy does not drift, nothing may be rounded the same way in every step (Hairer, McLachlan, Razakarivony, BIT
48, 2008): weights and nodes come with what rounding has taken from them, rows of the stage matrix are rounded so that
their sums are not, step sizes have so few bits that their products are exact. Nor may a part of the truncation or of
the iteration remain, which has a sign that lasts: tolerances below FINE leave less of both, and the error of energy is
then the random walk of round-off (Brouwer's law). Of that the sums of a step are four fifths where they are made in
binary64 (the pendulum, 23 steps a period), those of the slopes themselves one fifth: from tolerances of EXACT on what
every sum and product loses is carried on too. That takes a twentieth to an eighth of the time of a step.

What the equations divide by keeps its sign on a smooth motion: where that goes through 0 they have a pole. A wall that
turns the motion round within 1e-8 of a step is seen by none of its stages, and the step, right as it looks, ends beyond
the pole. So a step in which a sign changes is taken again shorter, down to VERGE of the span: sin(x) / x has none.

A sample is a step of its own, taken aside from the start of the step that it lies in, with that step's stage polynomial
as the first guess: it has the order of the end of a step, and steps are free of the samples. Nothing follows from it, so
its iteration may leave 1 / ASIDE times as much.
"""

from __future__ import annotations

import textwrap

NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, STIFF, OUT_OF_RANGE = 1, 2, 3, 4, 5

MOST_STEPS, MOST_STIFF = 40_000_000, 1000
"""Attempts for one trajectory, some twenty seconds; and steps of a slow motion that convergence alone limits."""

# Rows of the table (rows, 8): columns of the stage matrix (squared for second-order equations), of the monomials of the
# stage polynomial about its end and of the powers of the nodes; nodes; weights; those of positions; columns of the
# guesses one step ahead and of the stage matrix itself; the stage matrices times the former; the nodes in few bits, and
# the rest; what rounding has taken from both rows of weights; the stage matrices times the powers of the nodes; the
# value at the end of a step from those at the nodes; columns of the Legendre coefficients, and weights of the last four.
STAGES, MONOMIALS, POWERS, NODES, WEIGHTS, POSITIONS, AHEAD, ONCE, CARRIED = 0, 8, 16, 24, 25, 26, 27, 35, 43
ONCE_CARRIED, NODES_HIGH, NODES_LOW, WEIGHTS_LOW, POWERED, ONCE_POWERED, ENDS = 51, 59, 60, 61, 63, 71, 79
LEGENDRE, HIGHEST = 80, 88

SMALLEST, LARGEST = 1e-290, 1e290
"""Between them the largest component of a start must lie: beyond, products of it with a tolerance or with stages
underflow or overflow. A motion that dies away from such a start may go below."""

SCRATCH, SCRATCH_ROWS = 136, 120
"""Rows of the table that products write their vectors to. A processor that takes a load for one of a number just stored
where the last twelve bits of their addresses agree waits in vain: with vectors on the stack, which lies anywhere, one
process in ten took up to a fifth more time. The first of these rows agree with MONOMIALS and POWERS, which few steps read.
"""

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
SHARE, ASIDE, NOISE, FAST, SLOW, SURE, SURER = 1e-3, 1e-2, 1e2, 0.3, 0.7, 1e-6, 1e-5
ERRS, LESS, HOLD, LEAP, LEAST = 0.002, 0.1, 3.0, 1.3, 1e-6
ENOUGH, FIRST_CALM, CALM, FIRST_LOOK, LOOK, EVEN = 0.9, 12, 100, 12, 32, 0.7
SLOWLY, FAINT, COARSE, FINE, TRIES = 1e-3, 1e-12, 1e-6, 3e-16, 4
EXACT, COARSER, SURE_BELOW = 1e-11, 256.0, 5e-14
SAFETY, SLACK, SHRINK_MOST, GROW_MOST, TINY = 0.9, 4.0, 0.1, 4.0, 1e-300
STAGNANT, STALE, VERGE = 0.03, 4.0, 1e-12


@intrinsic
def bits(typingctx, x):
    return types.int64(types.float64), lambda c, builder, s, values: builder.bitcast(values[0], ir.IntType(64))


@intrinsic
def double(typingctx, n):
    return types.float64(types.int64), lambda c, builder, s, values: builder.bitcast(values[0], ir.DoubleType())


@njit(OPTIONS)
def root_15(x):
    # About x^(1/15) within 1 %: the bits of a double, read as an integer, are nearly its logarithm.
    return double(ONE + (bits(x) - ONE) // 15)


@njit(OPTIONS)
def powers(r):
    r2, v = r * r, lanes(1.0)
    r4 = r2 * r2
    v = with_lane(with_lane(with_lane(v, 1, r), 2, r2), 3, r2 * r)
    return with_lane(with_lane(with_lane(with_lane(v, 4, r4), 5, r4 * r), 6, r4 * r2), 7, r4 * r2 * r)


@intrinsic
def fused(typingctx, a, b, c):
    return types.float64(types.float64, types.float64, types.float64), lambda x, builder, s, values: builder.fma(*values)


@njit(forceinline=True, OPTIONS)
def weighted(f, table, weights):
    return fma(f, row(table, weights), f * row(table, weights + LOW))


@njit(forceinline=True, OPTIONS)
def weighted_exactly(f, coarse, table, weights):
    # The sum of the lanes in two parts: of what adding a much larger number leaves of each, it is not rounded.
    w = row(table, weights)
    parts = f * w
    high = minus(parts + lanes(coarse), lanes(coarse))
    return total(high), total(minus(parts, high) + fma(f, row(table, weights + LOW), fma(f, w, -parts)))


@njit(forceinline=True, OPTIONS)
def summed(y, change):
    # Their sum, and what rounding takes from it.
    end = y + change
    back = end - y
    return end, (y - (end - back)) + (change - back)


@njit(forceinline=True, OPTIONS)
def added(y, low, h, rate):
    # y + low + h * rate, and what rounding takes from it.
    change = fused(h, rate, low)
    end, left = summed(y, change)
    return end, left + (fused(h, rate, -change) + low)


@njit(forceinline=True, OPTIONS)
def legendre_of_one(f, table):
    # The coefficients 4 to 7 in their lanes.
    return totals(
        f * row(table, HIGHEST), f * row(table, HIGHEST + 1), f * row(table, HIGHEST + 2), f * row(table, HIGHEST + 3)
    )


@njit(OPTIONS)
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
    "moved": "<|h * total(weighted(f@, table, WEIGHTS)) + low[@], |>",
    "moved_exactly": "high@, rest@ = weighted_exactly(f@, coarse[@], table, WEIGHTS)\n"
    "    end@, left@ = added(y[@], fused(h, rest@, low[@]), h, high@)",
    "ends": "<|end@, |>), (<|left@, |>",
    "rate": "y[@]",
    "slope": "slopes((<|lanes(y[%]), |>), forcing(lanes(0.0), k), k)",
    "first": "0.1 * largest / fastest if largest > 0.0 and fastest > 0.0 else 1e-3 * end",
    "blur": "0.0",
}
SECOND_ORDER = FIRST_ORDER | {
    "prepare": "m, n = hh * row(table, NODES_HIGH), hh * row(table, NODES_LOW)\n    "
    "b@ = fma(m, lanes(y[N + @]), fma(n, lanes(y[N + @]), lanes(y[@])))\n    "
    "e@ = lanes(0.0)\n    if exactly:\n        "
    "e@ = fma(n, lanes(y[N + @]), fma(m, lanes(y[N + @]), lanes(y[@]) - b@)) + lanes(low[@])",
    "lost": "s@ = fma(hh * hh, p[@], b@ - x@) + e@",
    "place": "x@ = fma(hh * hh, p[@], b@)",
    "moved": "<|h * y[N + @] + (h * (h * total(weighted(f@, table, POSITIONS)) + low[N + @]) + low[@]), |>"
    "<|h * total(weighted(f@, table, WEIGHTS)) + low[N + @], |>",
    "moved_exactly": "place@, lost@ = added(y[@], fused(h, low[N + @], low[@]), h, y[N + @])\n"
    "    high@, rest@ = weighted_exactly(f@, coarse[@], table, POSITIONS)\n"
    "    end@, left@ = added(place@, fused(h * h, rest@, lost@), h * h, high@)\n"
    "    high@, rest@ = weighted_exactly(f@, coarse[@], table, WEIGHTS)\n"
    "    speed@, slow@ = added(y[N + @], fused(h, rest@, low[N + @]), h, high@)",
    "ends": "<|end@, |><|speed@, |>), (<|left@, |><|slow@, |>",
    "rate": "y[N + @]",
    "first": "0.1 * (largest / fastest + np.sqrt(furthest / fastest)) "
    "if fastest > 0.0 and furthest + largest > 0.0 else 1e-3 * end",
    "blur": "4 * ROUNDOFF * furthest / (step * step)",
}
WITH_VELOCITY = SECOND_ORDER | {
    "sums": "p = products(table, first, (<|f@, |>))\n    v = products(table, once, (<|f@, |>))",
    "place": SECOND_ORDER["place"] + "\n        u@ = fma(hh, v[@], lanes(y[N + @]))",
    "placed": "<|x@, |><|u@, |>",
    "shift": SECOND_ORDER["shift"] + "\n        r = products(table, ONCE, (<|d@, |>))",
}

SIDES = """beyond = poles((<|lanes(y[%]), |>), forcing(lanes(0.0), k), k)
sides = (FIRST)"""

CROSSED = """beyond = poles((<|lanes(there[%]), |>), forcing(lanes(after), k), k)
if step > VERGE * end and (CHANGED):
    h, usual, rejected = 0.3 * step, 0, True
    {shorter}
    continue
sides = (FIRST)"""

LEGENDRE_OF_MANY = "legendre = products(table, LEGENDRE, f)"
LEGENDRE_OF_ONE = "legendre = (legendre_of_one(f0, table),)"
"""Of one component the last four, by sums: eight columns are too many for the processor's registers beside all else."""

EQUAL_STEPS = """
if ENOUGH <= grow < HOLD:
    # The usual case on its own: the next step need not wait for the size that is wanted of it.
    h = step * more
elif grow >= HOLD and rejected:
    h = step
elif grow >= HOLD:
    h = step * min(grow / LEAP, GROW_MOST)
    calm, room = 0, GROW_MOST
else:
    h = step * grow
"""

NONE_SEEN = """follows, stride, pace, norm, spread, pause = False, 0.0, 0.0, 0.0, 1.0, 0
look, seen, shortest, longest, lowest, highest_ = FIRST_LOOK, 0, np.inf, 0.0, np.inf, 0.0
"""

BY_FREQUENCY = """
before, norm = norm, square
if 0.0 < before and grow < GROW_MOST:
    # A step far too short says little of the one that fits. Eighth powers of strides: most steps then need no root.
    fits = step * grow
    fourth = (fits * fits) * (fits * fits)
    turn = (fourth * before) * (fourth * norm)
    shortest, longest, lowest, highest_ = min(shortest, fits), max(longest, fits), min(lowest, turn), max(highest_, turn)
    seen += 1
if follows and (grow >= GROW_MOST or seen == look and highest_ > min(EVEN * spread, HOLD) ** 8 * lowest):
    # The frequency does not say where steps must be short; it is tried again ever more rarely.
    follows, pause, seen = False, 2 * pause + 4, look
elif seen == look and not follows and pause > 0:
    pause -= 1
elif seen == look and not follows and longest > HOLD * shortest and highest_ < (2 * longest / shortest) ** 8 * lowest:
    follows, spread, stride, pace = True, longest / shortest, 0.95 * lowest**0.125, math.sqrt(math.sqrt(norm))
    calm, room, more = 0, GROW_MOST, 1.0
if seen == look:
    look, seen, shortest, longest, lowest, highest_ = LOOK, 0, np.inf, 0.0, np.inf, 0.0
if follows:
    frequency = math.sqrt(math.sqrt(norm))
    if grow < ENOUGH:
        stride, pace = stride * grow, frequency
    elif more > 1.0:
        stride, pace = stride * more, frequency
    else:
        pace = min(max(2 * frequency - pace, 0.5 * frequency), 2 * frequency)
    h = min(stride / pace, GROW_MOST * step)
else:
"""

VERDICT = """if change * max(rate, sure) <= enough and rate < SLOW:
    break
if change < noise and (rate > SLOW or rounds > 16):
    break
if not change < MOST_CHANGE or rounds == MOST_ROUNDS or (rounds > 2 and rate > SLOW):
    rounds = -rounds
    break"""


def settled(depth: int) -> str:
    """The lines that end a loop of rounds so deep, with `rounds` below zero where it does not converge."""
    return textwrap.indent(VERDICT, " " * depth).lstrip()


ROUND = """{place}
        {slopes}
        {correct}"""

SLOPES = "g = slopes(({placed}), w, k)"

SLOPES_BY_TURNS = """if rounds == 0:
            g, near = slopes_first(({placed}), w, k)
        else:
            g, near = slopes_again(({placed}), w, k, near)"""

STAGES_OF_A_STEP = """
@njit(INLINE OPTIONS)
def NAME(t, h, y, low, f, p, v, k, table, fine, enough, noise, sure, expected, quiet, exactly):
    <|f@, |> = f
    hh = lanes(h)
    w = forcing(fma(hh, row(table, NODES), lanes(t)), k)
    {prepare}
    before, rate, rounds = 0.0, expected, 0
    while True:
        {round}
        rounds += 1
        if rounds > quiet:
            off = lanes(0.0)
            off = fma(size(g@ - f@), lanes(fine[@]), off)
            change = total(off)
            if rounds > quiet + 1:
                rate = change / before if before > 0.0 else 0.0
            if rounds > quiet + 1 or expected > 0.0 or (quiet > 0 and change <= enough):
                f@ = g@
                {verdict}
            before = change
        f@ = g@
        {sums_of_a_round}
    {squares}
    # What changes by round-off shows no rate.
    return rounds, rate if before > noise else 0.0, (<|f@, |>), {at_end}
""".replace("{verdict}", settled(16))

ADVANCE = """
@njit(forceinline=True, OPTIONS)
def sums(f, table, first, once):
    <|f@, |> = f
    {sums}
    return p, v


@njit(OPTIONS)
def moved(h, y, low, f, table):
    # The state after a step, and what rounding takes from the last sum.
    <|f@, |> = f
    change = ({moved})
    end%, left% = summed(y[%], change[%])
    return (<|end%, |>), (<|left%, |>)


@njit(OPTIONS)
def moved_exactly(h, y, low, f, coarse, table):
    # The same with what all roundings take.
    <|f@, |> = f
    {moved_exactly}
    return ({ends})


@njit(SIGNATURE, OPTIONS)
def advance(p_, table, initial, times, tolerance, out, stop):
    end = times[-1]
    # Sums of times stay exact while steps are multiples of the spacing of numbers next to this one.
    grid = 2.0 ** np.ceil(np.log2(end)) if end > 0.0 else 1.0
    keen = min(tolerance / FINE, 1.0)
    # Changes are sums over eight stages.
    enough, noise = 8 * SHARE * max(tolerance, ROUNDOFF / 4) * keen**10, 8 * NOISE * ROUNDOFF
    exactly = tolerance < EXACT
    quickest = SURE if tolerance < SURE_BELOW else SURER
    taken = 0
    for n in range(initial.shape[0]):
        k = constants((PARAMETERS))
        t, sample, attempts, stiff, reason = 0.0, 0, 0, 0, 0
        low% = 0.0
        y, low = (<|initial[n, %], |>), (<|low%, |>)
        g = {slope}
        f@ = lanes(lane(lanes(g[@]), 0))
        size@ = abs(lane(f@, 0))
        furthest, largest, fastest = 0.0, 0.0, 0.0
        furthest = max(furthest, abs(y[@]))
        largest = max(largest, abs({rate}))
        fastest = max(fastest, size@)
        h = min({first}, end)
        last, rejected, calm, room, patience, usual, rate = h, False, 0, GROW_MOST, FIRST_CALM, 0, 0.0
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
            # So few bits that products with the nodes' high parts and the square are exact.
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
            # At an equilibrium slopes are small against the terms that cancel in them, and round-off is what remains.
            blur, weakest = {blur}, np.inf
            least = max(step * largest * max(LEAST, 16 * ROUNDOFF / tolerance), step * blur)
            scale@ = max(max(max(abs({rate}), step * size@), least), TINY)
            fine@ = step / scale@
            coarse@ = COARSER * size@
            weakest = min(weakest, scale@)
            cloud = noise * max(1.0, step * (blur / weakest) / (4 * ROUNDOFF))
            if step == last:
                # The guesses themselves are needed only where their first change is looked at.
                ahead = (<|old@, |>)
                if usual == 0 or CORRECTED:
                    ahead = products(table, AHEAD, (<|old@, |>))
                p, v = sums((<|old@, |>), table, CARRIED, ONCE_CARRIED)
            else:
                ratios = powers(step / last)
                m = products(table, MONOMIALS, (<|old@, |>))
                ahead = products(table, POWERS, (<|m[@] * ratios, |>))
                p, v = sums((<|m[@] * ratios, |>), table, POWERED, ONCE_POWERED)
            sure = quickest if t > 0.0 else 1.0
            rounds, seen_rate, f, square = stages(
                t, step, y, low, ahead, p, v, k, table, (<|fine@, |>), enough, cloud, sure, 0.0, usual, exactly
            )
            COUNT abs(rounds)
            rate = seen_rate if seen_rate > 0.0 else min(rate, FAST)
            if rounds < 0:
                h, usual = 0.3 * step, 0
                {shorter}
                rejected = True
                continue
            f@ = lanes(f[@])
            size@ = total(size(f@)) / 8
            worst = lanes(0.0)
            {legendre}
            c@ = larger(size(legendre[@]) - lanes(blur), lanes(0.0))
            worst = fma(c@ * lanes(1.0 / max(size@, TINY)), c@ * lanes(1.0 / scale@), worst)
            error = lane(worst, 7) + LESS * lane(worst, 6)
            if lane(worst, 7) + lane(worst, 6) > STAGNANT * (lane(worst, 5) + lane(worst, 4)):
                worst = lanes(0.0)
                worst = fma(c@ / lanes(scale@), c@ / lanes(scale@), worst)
                high, lower = lane(worst, 7) + lane(worst, 6), lane(worst, 5) + lane(worst, 4)
                decay = high / max(high + lower, TINY)
                error += STALE * max(math.sqrt(high) - NOISE * ROUNDOFF / step, 0.0) * decay * decay
            error *= ERRS * step / (tolerance * keen**4)
            grow = SAFETY / root_15(max(error, TINY))
            if not error <= SLACK:
                h = step * max(SHRINK_MOST, grow) if error < np.inf else step * SHRINK_MOST
                {shorter}
                rejected = True
                continue
            if exactly:
                there, left = moved_exactly(step, y, low, f, (<|coarse@, |>), table)
            else:
                there, left = moved(step, y, low, f, table)
            finite = 0.0
            finite += there[%] - there[%]
            if finite != 0.0:
                reason = NOT_FINITE
                break
            {crossed}
            missed = False
            if times[sample] <= after:
                m = products(table, MONOMIALS, f)
                while sample < times.size and times[sample] <= after:
                    part = times[sample] - t
                    if times[sample] == after:
                        out[n, sample, %] = there[%]
                    else:
                        x = fma(lanes(part / step), row(table, NODES), lanes(-1.0))
                        near = (<|at(m[@], x), |>)
                        missed = True
                        for _ in range(TRIES):
                            # The step has converged, so this does, though a change may be above the one before it.
                            p, v = sums(near, table, STAGES, ONCE)
                            again, _rate, near, _square = aside(
                                t, part, y, low, near, p, v, k, table, (<|fine@, |>), enough / ASIDE, cloud, 1e-3,
                                max(rate, 1e-3), 0, exactly
                            )
                            COUNT abs(again)
                            missed = again <= 0
                            if not missed:
                                break
                        if missed:
                            break
                        place, _left = moved(part, y, low, near, table)
                        out[n, sample, %] = place[%]
                    FROZEN
                    sample += 1
            if missed:
                # A sample for which no stages are found is taken within a shorter step.
                h, usual, rejected = 0.3 * step, 0, True
                {shorter}
                continue
            old@ = f@
            taken += 1
            t = after
            y, low = there, left
            last = step
            if rate > FAST and rounds > 2:
                grow = min(grow, max(0.5, FAST / rate))
            calm, room = (calm + 1, min(room, grow)) if grow >= ENOUGH and not rejected else (0, GROW_MOST)
            more = 1.0
            if calm == patience:
                more, calm, room, patience = room if room >= 1.1 else 1.0, 0, GROW_MOST, CALM
            {control}
            usual = max(rounds - 3, 0)
            if rate > FAST / 4:
                # What has died away goes on dying as fast as ever.
                most, moves = 0.0, 0.0
                most = max(most, abs({rate}))
                moves = max(moves, step * size@ / max(abs({rate}) + FAINT * most, TINY))
                stiff = stiff + 1 if moves < SLOWLY else max(stiff - 1, 0)
            rejected = False
        if reason != 0 and stop[0] == 0:
            stop[0] = reason
            stop[1] = n
            stop[2] = sample
    return taken
"""
