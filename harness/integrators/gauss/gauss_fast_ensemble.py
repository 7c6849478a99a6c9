"""The fast Gauss method for ensembles, as source text: the lanes of a vector are eight trajectories.

The method is that of `gauss_fast_text`: guesses, rounds, error, compensated sums. The differences:

- The eight trajectories of a vector share t and the step, and a whole number of steps fills the interval between two
  samples, so that samples are ends of steps. Steps are kept equal until they err too much, could grow HOLDABLE times, or
  EQUAL_STEPS_NEEDED of them could all have been a tenth longer.
- The stages lie in memory, in the rows of `work`. One loop computes their states and the next one the slopes: the
  processor has too few registers for both.
- Only one of the guesses is computed, to measure its error: one matrix gives the states of the stages directly from the
  last step's slopes.
- Where derivatives are known a round corrects its slopes with them twice. The error that is left goes with the square of
  the error before the round, so after this round with the square of the rate, where the corrections have converged
  (`rest`): two rounds are usual at fine tolerances.
- Sharp turns between two stages are not looked for.

ITERATION_PORTION of the tolerance may remain of the iteration. As there, nothing is rounded the same way in every step:
the error of energy is a random walk at the finest tolerance.

A vector that cannot go on, or passes a pole, is recorded in `left_over`: the method for single trajectories integrates it
again, and gives the reason where it stops too.

A line with a `$` is repeated for the stages 1 to 7, which a sum over all stages adds to stage 0.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from gnomon.harness.integrators.gauss.gauss_fast_text import settled

SIGNATURE = (
    '"int64(float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64[:, :, ::1], int64[::1], '
    'float64[:, ::1])"'
)


def summed(name: str, of: str, matrix: str, line: str) -> str:
    """Lines that compute a row of a matrix times the eight vectors r."""
    return (
        f"{name} = lanes({of}[{matrix}, j]) * r@_0\n"
        f"            {name} = fma(lanes({of}[{matrix} + $, j]), r@_$, {name})\n"
        f"            {line}"
    )


BEGIN = "\n            "

FIRST_ORDER = {
    "base": "b@ = y[@]",
    "place": summed("x@", "work", "matrix", "x@ = fma(hh, x@, b@)"),
    "keep": "put(work, POINTS + N * j + @, x@)",
    "apart": "put(work, APART + N * j + @, (b@ - x@) + compensation[@])",
    "point": "x@ = row(work, POINTS + N * j + @)",
    "shift": summed("s@", "table", "STAGES", "s@ = fma(hh, s@, row(work, APART + N * j + @))"),
    "residual": "compensation[@]",
    "together": "<|fma(lanes(h), a@, fma(lanes(h), e@, compensation[@])), |>",
    "slope_roundoff": "lanes(0.0)",
}
SECOND_ORDER = FIRST_ORDER | {
    "base": "m, n = lanes(h * table[NODES_HIGH, j]), lanes(h * table[NODES_LOW, j])"
    + BEGIN
    + "b@ = fma(m, y[N + @], fma(n, y[N + @], y[@]))",
    "place": summed("x@", "work", "matrix", "x@ = fma(hh * hh, x@, b@)"),
    "apart": "l@ = fma(n, y[N + @], fma(m, y[N + @], y[@] - b@)) + compensation[@]"
    + BEGIN
    + "put(work, APART + N * j + @, (b@ - x@) + l@)",
    "shift": summed("s@", "table", "STAGES", "s@ = fma(hh * hh, s@, row(work, APART + N * j + @))"),
    "residual": "fma(lanes(h * h), i@, fma(lanes(h), compensation[N + @], compensation[@]))",
    "together": "<|fma(lanes(h), y[N + @], fma(lanes(h * h), b@, residual@)), |>"
    "<|fma(lanes(h), a@, fma(lanes(h), e@, compensation[N + @])), |>",
    "slope_roundoff": "lanes(4 * ROUNDOFF / (h * h)) * reach",
}
WITH_VELOCITY = SECOND_ORDER | {
    "place": SECOND_ORDER["place"] + BEGIN + summed("u@", "work", "matrix + 8", "u@ = fma(hh, u@, y[N + @])"),
    "keep": SECOND_ORDER["keep"] + BEGIN + "put(work, POINTS + N * (8 + j) + @, u@)",
    "apart": SECOND_ORDER["apart"]
    + BEGIN
    + "put(work, APART + N * (8 + j) + @, (y[N + @] - u@) + compensation[N + @])",
    "point": SECOND_ORDER["point"] + BEGIN + "u@ = row(work, POINTS + N * (8 + j) + @)",
    "shift": SECOND_ORDER["shift"]
    + BEGIN
    + summed("w@", "table", "ONCE", "w@ = fma(hh, w@, row(work, APART + N * (8 + j) + @))"),
}

PLAIN_ROUND = """off = lanes(0.0)
        for j in range(8):
            {point}
            w = forcing(lanes(t + h * table[NODES, j]), k)
            g = slopes(({placed}), w, k)
            off = fma(size(lanes(g[@]) - row(work, new + N * j + @)), change_weight[@], off)
            put(work, new + N * j + @, lanes(g[@]))
"""
ROUND_WITH_DERIVATIVES = """for j in range(8):
            {point}
            w = forcing(lanes(t + h * table[NODES, j]), k)
            g = slopes(({placed}), w, k)
            put(work, FOUND + N * j + @, lanes(g[@]))
            for e in range(DERIVATIVES):
                put(work, FIRST_DERIVATIVE + DERIVATIVES * j + e, lanes(g[N + e]))
        r@_0 = row(work, FOUND + @)
        r@_$ = row(work, FOUND + N * $ + @)
        for j in range(8):
            {shift}
            CORRECTIONS
            put(work, POINTS + N * j + @, row(work, FOUND + N * j + @) + c@)
        r@_0 = row(work, POINTS + @)
        r@_$ = row(work, POINTS + N * $ + @)
        off, rest = lanes(0.0), lanes(0.0)
        for j in range(8):
            {shift}
            CORRECTIONS
            f@ = row(work, FOUND + N * j + @) + c@
            off = fma(size(f@ - row(work, new + N * j + @)), change_weight[@], off)
            rest = fma(size(f@ - row(work, POINTS + N * j + @)), change_weight[@], rest)
            put(work, new + N * j + @, f@)
"""
NEARLY_SETTLED = """if change * max(rate * rate, assumed_rate) <= allowed_change and rate < SLOW and highest(rest) <= allowed_change:
                break
            """

SIDES = "sides = poles((<|y[%], |>), forcing(lanes(0.0), k), k)"
CROSSED = """beyond = poles((<|end%, |>), forcing(lanes(t + h), k), k)
            failed = failed or CHANGED"""

TEXT = """
@njit(forceinline=True, INNER)
def eight_stages(
    t, h, y, compensation, k, table, work, change_weight, allowed_change, noise, assumed_rate, source, matrix, new
):
    hh = lanes(h)
    before, rate, rounds = 0.0, 0.0, 0
    while True:
        r@_0 = row(work, source + @)
        r@_$ = row(work, source + N * $ + @)
        for j in range(8):
            {base}
            {place}
            {keep}
        {round}
        if rounds == 0:
            off = lanes(0.0)
            off = fma(size(row(work, new + 7 * N + @) - row(work, GUESS + @)), change_weight[@], off)
        change = highest(off)
        rounds += 1
        if rounds > 1:
            rate = change / before if before > 0.0 else 0.0
            {convergence_test}
        before, source, matrix = change, new, FRESH
    return rounds, rate


@njit(INNER)
def carry_on(table, work, ratio):
    # The matrix that continues the stage polynomial into a step `ratio` times as long, and its integrals.
    for k in range(8):
        for j in range(8):
            value, power = 0.0, 1.0
            for m in range(8):
                value += table[POWERS + m, j] * power * table[MONOMIALS + k, m]
                power *= ratio
            work[AFTER + k, j] = value
    for k in range(8):
        for j in range(8):
            once, value = 0.0, 0.0
            for m in range(8):
                value += table[STAGES + m, j] * work[AFTER + k, m]
                once += table[ONCE + m, j] * work[AFTER + k, m]
            work[ONWARD + k, j] = value
            work[ONWARD + 8 + k, j] = once


@njit(TOGETHER, OPTIONS, nogil=True)
def advance_eight(p_, table, initial, times, tolerance, out, left_over, work):
    p = (PARAMETERS)
    k = constants(p)
    fine_ratio = min(tolerance / FINE, 1.0)
    # Changes are sums over eight stages.
    allowed_change, noise = (
        8 * ITERATION_PORTION * max(tolerance, ROUNDOFF / 4) * fine_ratio**10, 8 * NOISE * ROUNDOFF
    )
    taken, many, end = 0, initial.shape[0], times[-1]
    # Each row is one cache line.
    lead = (-np.int64(work.ctypes.data) & 63) // 8
    work = work.reshape(work.size)[lead : lead + 8 * ROWS].reshape(ROWS, 8)
    for j in range(8):
        put(work, FRESH + j, row(table, STAGES + j))
        put(work, FRESH + 8 + j, row(table, ONCE + j))
    for first in range(0, many, 8):
        some = min(8, many - first)
        y% = lanes(0.0)
        compensation% = lanes(0.0)
        for i in range(8):
            y% = with_lane(y%, i, initial[first + min(i, some - 1), %])
        y, compensation = (<|y%, |>), (<|compensation%, |>)
        g = slopes(({placed_at_start}), forcing(lanes(0.0), k), k)
        furthest, largest, fastest = 0.0, 0.0, 0.0
        size@ = size(lanes(g[@]))
        furthest = max(furthest, highest(size(y[@])))
        largest = max(largest, highest(size({rate})))
        fastest = max(fastest, highest(size@))
        slope_at_start@ = lanes(g[@])
        {sides}
        old, new = SLOPES, SLOPES_TOO
        wanted_step = min({first}, end)
        t, sample, attempts, stiff, steps_left, last, ratio = 0.0, 0, 0, 0, 0.0, 0.0, 0.0
        failed, rejected, equal_steps, common_growth = False, False, 0, GROW_MOST
        reach, extent = lanes(0.0), lanes(0.0)
        reach = larger(reach, size(y[@]))
        extent = larger(extent, size(y[%]))
        for i in range(some):
            failed = failed or lane(extent, i) > LARGEST or 0.0 < lane(extent, i) < SMALLEST
        while sample < times.size and not failed:
            # The number of equal steps to the next sample.
            if steps_left < 1.0:
                steps_left = np.ceil((times[sample] - t) / (wanted_step * 1.000001))
            h = (times[sample] - t) / steps_left if steps_left < 1e15 else 0.0
            # Few bits: products with the high parts of the nodes, and the square, are then exact.
            h = double(bits(h) & -(1 << 27)) if steps_left > 1.0 else h
            attempts += 1
            if not (t + h / 4 > t and h < np.inf) or attempts > MOST_ATTEMPTS:
                failed = True
                break
            if last > 0.0:
                if not abs(h / last - ratio) < 1e-7:
                    ratio = h / last
                    carry_on(table, work, ratio)
                # One of the guesses is enough to measure their error.
                x@ = lanes(work[AFTER, 7]) * row(work, old + @)
                x@ = fma(lanes(work[AFTER + $, 7]), row(work, old + N * $ + @), x@)
                put(work, GUESS + @, x@)
            else:
                put(work, GUESS + @, slope_at_start@)
                for j in range(8):
                    put(work, old + N * j + @, slope_at_start@)
            scale_floor = lanes(0.0)
            scale_floor = larger(scale_floor, size@)
            slope_roundoff = {slope_roundoff}
            scale_floor = larger(lanes(h * max(LEAST_SHARE, 16 * ROUNDOFF / tolerance)) * scale_floor, lanes(h) * slope_roundoff)
            scale@ = larger(larger(larger(size({rate}), lanes(h) * size@), scale_floor), lanes(TINY))
            change_weight@ = lanes(h) / scale@
            largest_inverse_scale = lanes(0.0)
            largest_inverse_scale = larger(largest_inverse_scale, lanes(1.0) / scale@)
            step_noise = noise * max(1.0, h * highest(slope_roundoff * largest_inverse_scale) / (4 * ROUNDOFF))
            assumed_rate, matrix = (BEST_RATE_FINEST, ONWARD) if last > 0.0 else (1.0, FRESH)
            rounds, rate = eight_stages(
                t, h, y, compensation, k, table, work, (<|change_weight@, |>), allowed_change, step_noise, assumed_rate, old,
                matrix, new
            )
            COUNT 8 * abs(rounds)
            if rounds < 0:
                wanted_step, steps_left, rejected = 0.3 * h, 0.0, True
                continue
            a@ = lanes(0.0)
            b@ = lanes(0.0)
            c@ = lanes(0.0)
            d@ = lanes(0.0)
            e@ = lanes(0.0)
            i@ = lanes(0.0)
            s@ = lanes(0.0)
            for j in range(8):
                f@ = row(work, new + N * j + @)
                a@ = fma(lanes(table[WEIGHTS, j]), f@, a@)
                b@ = fma(lanes(table[POSITIONS, j]), f@, b@)
                e@ = fma(lanes(table[WEIGHTS + LOW, j]), f@, e@)
                i@ = fma(lanes(table[POSITIONS + LOW, j]), f@, i@)
                c@ = fma(lanes(table[HIGHEST + 2, j]), f@, c@)
                d@ = fma(lanes(table[HIGHEST + 3, j]), f@, d@)
                s@ = s@ + size(f@)
            size@ = s@ * lanes(0.125)
            c@ = larger(size(c@) - slope_roundoff, lanes(0.0))
            d@ = larger(size(d@) - slope_roundoff, lanes(0.0))
            error = lanes(0.0)
            m@, n@ = lanes(1.0) / larger(size@, lanes(TINY)), lanes(1.0) / scale@
            error = error + ((d@ * m@) * (d@ * n@) + lanes(LOWER_WEIGHT) * (c@ * m@) * (c@ * n@))
            worst = highest(error) * ERROR_FACTOR * h / (tolerance * fine_ratio**4)
            shrink_factor = root_15(max(worst, TINY)) / SAFETY
            if not worst <= MOST_ERROR:
                wanted_step, steps_left, rejected = h * max(SHRINK_MOST, 1 / shrink_factor), 0.0, True
                continue
            residual@ = {residual}
            change = ({together})
            end% = y[%] + change[%]
            back% = end% - y[%]
            compensation% = (y[%] - (end% - back%)) + (change[%] - back%)
            {crossed}
            y, compensation = (<|end%, |>), (<|compensation%, |>)
            old, new = new, old
            last, taken, steps_left = h, taken + some, steps_left - 1.0
            t = times[sample] if steps_left < 1.0 else t + h
            if steps_left < 1.0:
                finite = lanes(0.0)
                finite = finite + size(y[%] - y[%])
                failed = failed or not highest(finite) == 0.0
                for i in range(some):
                    out[first + i, sample, %] = lane(y[%], i)
                sample += 1
            if rate > FAST / 2:
                most, moves = lanes(TINY), lanes(0.0)
                most = larger(most, size({rate}))
                moves = larger(moves, lanes(h) * size@ / larger(size({rate}) + lanes(LEAST_MOVING) * most, lanes(TINY)))
                stiff = stiff + 1 if highest(moves) < SLOW_MOTION else max(stiff - 1, 0)
                failed = failed or stiff > MOST_STIFF
            grow = min(1 / shrink_factor, 1.0 if rejected else GROW_MOST)
            if rate > FAST and rounds > 2:
                grow = min(grow, max(0.5, FAST / rate))
            equal_steps, common_growth = equal_steps + 1, min(common_growth, grow)
            if HELD <= grow <= HOLDABLE:
                # The growth that all of these steps allowed.
                grow = common_growth if equal_steps == EQUAL_STEPS_NEEDED and common_growth > 1.1 else 1.0
            elif grow > HOLDABLE:
                grow /= LEAP
            if grow != 1.0:
                wanted_step, steps_left = h * grow, 0.0
            if grow != 1.0 or equal_steps == EQUAL_STEPS_NEEDED or rejected:
                equal_steps, common_growth = 0, GROW_MOST
            rejected = False
        left_over[first // 8] = failed
    return taken
"""


def text(words: Mapping[str, str], entries: list[tuple[int, int]], count: int, poles: int) -> tuple[str, int]:
    """The text, to be expanded for `count` components, and the number of rows of `work`.

    `entries`: (slope, component of the state) of each derivative that `slopes` returns after the slopes. `poles`: their
    number.
    """
    changed = " or ".join(f"highest(-(beyond[{i}] * sides[{i}])) > 0.0" for i in range(poles))
    words = {**words, "sides": SIDES if poles else "", "crossed": CROSSED.replace("CHANGED", changed) if poles else ""}
    lines = [f"c{i} = lanes(0.0)" for i in range(count)]
    for n, (i, j) in enumerate(entries):
        shift = f"{'s' if j < count else 'w'}{j % count}"
        lines.append(f"c{i} = fma(row(work, FIRST_DERIVATIVE + DERIVATIVES * j + {n}), {shift}, c{i})")
    body = TEXT.replace("{round}", ROUND_WITH_DERIVATIVES if entries else PLAIN_ROUND)
    body = body.replace("{keep}", "{keep}" + BEGIN + "{apart}" if entries else "{keep}")
    body = body.replace("CORRECTIONS", BEGIN.join(lines))
    body = body.replace("{convergence_test}", (NEARLY_SETTLED if entries else "") + settled(12))
    for word, meaning in words.items():
        body = body.replace("{" + word + "}", meaning)
    size = 8 * count
    sizes = {
        "AFTER": 8, "ONWARD": 16, "FRESH": 16, "SLOPES": size, "SLOPES_TOO": size, "GUESS": count, "POINTS": 2 * size,
        "APART": 2 * size, "FOUND": size, "FIRST_DERIVATIVE": 8 * len(entries),
    }  # fmt: skip
    rows = 0
    head = f"N, DERIVATIVES, MOST_ATTEMPTS = {count}, {len(entries)}, {10**7}\n"
    head += "ITERATION_PORTION, HELD, HOLDABLE = 0.1, 0.9, 2.2\n"
    for name, many in sizes.items():
        head += f"{name} = {rows}\n"
        rows += many
    return head + f"ROWS = {rows}\n" + body, rows + 1


def over_stages(source: str) -> str:
    """The text with each line that has a `$` repeated for the stages 1 to 7."""
    return re.sub(r"^.*\$.*\n", lambda x: "".join(x[0].replace("$", str(j)) for j in range(1, 8)), source, flags=re.M)
