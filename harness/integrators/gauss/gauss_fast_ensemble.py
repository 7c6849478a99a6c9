"""The fast Gauss method for ensembles, as source text: the lanes of a vector are eight trajectories.

The method is that of `gauss_fast_text`: guesses, rounds, error, compensated sums. What differs:

- The eight trajectories of a vector share t and the step, and steps divide the interval between two samples, so that
  samples are ends of steps. Steps are kept equal until they err too much, could grow HOLDABLE times, or CALM of them
  could all have been a tenth longer.
- The stages lie in memory, in the rows of `work`. They are placed in one loop and the equations evaluated in the next:
  the processor's registers are too few for both.
- Of the guesses only one is made, to see how far off they are: one matrix takes the last step's slopes to the places
  that the guesses would give.
- Where derivatives are known a round corrects its slopes with them twice. What is then left goes with the square of the
  error before the round, so after this round with the square of the rate, where the corrections have settled (`rest`):
  two rounds are the rule at fine tolerances.
- Sharp turns between two stages are not looked for.

PORTION of the tolerance is left to the iteration. Nothing is rounded the same way in every step, as there: the error of
energy is a random walk at the finest tolerance.

A vector that cannot go on, or passes over a pole, is left over, for the method for single trajectories, which tells why.

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
    """Lines for a row of a matrix times the eight vectors r."""
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
    "apart": "put(work, APART + N * j + @, (b@ - x@) + low[@])",
    "point": "x@ = row(work, POINTS + N * j + @)",
    "shift": summed("s@", "table", "STAGES", "s@ = fma(hh, s@, row(work, APART + N * j + @))"),
    "left": "low[@]",
    "together": "<|fma(lanes(h), a@, fma(lanes(h), e@, low[@])), |>",
    "blur": "lanes(0.0)",
}
SECOND_ORDER = FIRST_ORDER | {
    "base": "m, n = lanes(h * table[NODES_HIGH, j]), lanes(h * table[NODES_LOW, j])"
    + BEGIN
    + "b@ = fma(m, y[N + @], fma(n, y[N + @], y[@]))",
    "place": summed("x@", "work", "matrix", "x@ = fma(hh * hh, x@, b@)"),
    "apart": "l@ = fma(n, y[N + @], fma(m, y[N + @], y[@] - b@)) + low[@]"
    + BEGIN
    + "put(work, APART + N * j + @, (b@ - x@) + l@)",
    "shift": summed("s@", "table", "STAGES", "s@ = fma(hh * hh, s@, row(work, APART + N * j + @))"),
    "left": "fma(lanes(h * h), i@, fma(lanes(h), low[N + @], low[@]))",
    "together": "<|fma(lanes(h), y[N + @], fma(lanes(h * h), b@, left@)), |>"
    "<|fma(lanes(h), a@, fma(lanes(h), e@, low[N + @])), |>",
    "blur": "lanes(4 * ROUNDOFF / (h * h)) * reach",
}
WITH_VELOCITY = SECOND_ORDER | {
    "place": SECOND_ORDER["place"] + BEGIN + summed("u@", "work", "matrix + 8", "u@ = fma(hh, u@, y[N + @])"),
    "keep": SECOND_ORDER["keep"] + BEGIN + "put(work, POINTS + N * (8 + j) + @, u@)",
    "apart": SECOND_ORDER["apart"] + BEGIN + "put(work, APART + N * (8 + j) + @, (y[N + @] - u@) + low[N + @])",
    "point": SECOND_ORDER["point"] + BEGIN + "u@ = row(work, POINTS + N * (8 + j) + @)",
    "shift": SECOND_ORDER["shift"]
    + BEGIN
    + summed("w@", "table", "ONCE", "w@ = fma(hh, w@, row(work, APART + N * (8 + j) + @))"),
}

PLAIN = """off = lanes(0.0)
        for j in range(8):
            {point}
            w = forcing(lanes(t + h * table[NODES, j]), k)
            g = slopes(({placed}), w, k)
            off = fma(size(lanes(g[@]) - row(work, new + N * j + @)), fine[@], off)
            put(work, new + N * j + @, lanes(g[@]))
"""
FORESEEING = """for j in range(8):
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
            off = fma(size(f@ - row(work, new + N * j + @)), fine[@], off)
            rest = fma(size(f@ - row(work, POINTS + N * j + @)), fine[@], rest)
            put(work, new + N * j + @, f@)
"""
NEARLY_SETTLED = """if change * max(rate * rate, sure) <= enough and rate < SLOW and highest(rest) <= enough:
                break
            """

SIDES = "sides = poles((<|y[%], |>), forcing(lanes(0.0), k), k)"
CROSSED = """beyond = poles((<|end%, |>), forcing(lanes(t + h), k), k)
            failed = failed or CHANGED"""

TEXT = """
@njit(forceinline=True, OPTIONS)
def eight_stages(t, h, y, low, k, table, work, fine, enough, noise, sure, source, matrix, new):
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
            off = fma(size(row(work, new + 7 * N + @) - row(work, GUESS + @)), fine[@], off)
        change = highest(off)
        rounds += 1
        if rounds > 1:
            rate = change / before if before > 0.0 else 0.0
            {verdict}
        before, source, matrix = change, new, FRESH
    return rounds, rate


@njit(OPTIONS)
def carry_on(table, work, ratio):
    # The matrix that carries the polynomial of the stages on to a step `ratio` times as long, and its integrals.
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
    keen = min(tolerance / FINE, 1.0)
    # Changes are sums over eight stages.
    enough, noise = 8 * PORTION * max(tolerance, ROUNDOFF / 4) * keen**10, 8 * NOISE * ROUNDOFF
    taken, many, end = 0, initial.shape[0], times[-1]
    # Rows are lines of the cache.
    lead = (-np.int64(work.ctypes.data) & 63) // 8
    work = work.reshape(work.size)[lead : lead + 8 * ROWS].reshape(ROWS, 8)
    for j in range(8):
        put(work, FRESH + j, row(table, STAGES + j))
        put(work, FRESH + 8 + j, row(table, ONCE + j))
    for first in range(0, many, 8):
        some = min(8, many - first)
        y% = lanes(0.0)
        low% = lanes(0.0)
        for i in range(8):
            y% = with_lane(y%, i, initial[first + min(i, some - 1), %])
        y, low = (<|y%, |>), (<|low%, |>)
        g = slopes(({placed_at_start}), forcing(lanes(0.0), k), k)
        furthest, largest, fastest = 0.0, 0.0, 0.0
        size@ = size(lanes(g[@]))
        furthest = max(furthest, highest(size(y[@])))
        largest = max(largest, highest(size({rate})))
        fastest = max(fastest, highest(size@))
        at_start@ = lanes(g[@])
        {sides}
        old, new = SLOPES, SLOPES_TOO
        wish = min({first}, end)
        t, sample, attempts, stiff, left, last, ratio = 0.0, 0, 0, 0, 0.0, 0.0, 0.0
        failed, rejected, calm, lowest = False, False, 0, GROW_MOST
        reach, extent = lanes(0.0), lanes(0.0)
        reach = larger(reach, size(y[@]))
        extent = larger(extent, size(y[%]))
        for i in range(some):
            failed = failed or lane(extent, i) > LARGEST or 0.0 < lane(extent, i) < SMALLEST
        while sample < times.size and not failed:
            # Equal steps to the next sample: so many are left.
            if left < 1.0:
                left = np.ceil((times[sample] - t) / (wish * 1.000001))
            h = (times[sample] - t) / left if left < 1e15 else 0.0
            # So few bits that products with the high parts of the nodes and the square are exact.
            h = double(bits(h) & -(1 << 27)) if left > 1.0 else h
            attempts += 1
            if not (t + h / 4 > t and h < np.inf) or attempts > MOST_ATTEMPTS:
                failed = True
                break
            if last > 0.0:
                if not abs(h / last - ratio) < 1e-7:
                    ratio = h / last
                    carry_on(table, work, ratio)
                # Of the guesses themselves one is enough to see how far off they are.
                x@ = lanes(work[AFTER, 7]) * row(work, old + @)
                x@ = fma(lanes(work[AFTER + $, 7]), row(work, old + N * $ + @), x@)
                put(work, GUESS + @, x@)
            else:
                put(work, GUESS + @, at_start@)
                for j in range(8):
                    put(work, old + N * j + @, at_start@)
            least = lanes(0.0)
            least = larger(least, size@)
            blur = {blur}
            least = larger(lanes(h * max(LEAST, 16 * ROUNDOFF / tolerance)) * least, lanes(h) * blur)
            scale@ = larger(larger(larger(size({rate}), lanes(h) * size@), least), lanes(TINY))
            fine@ = lanes(h) / scale@
            weakest = lanes(0.0)
            weakest = larger(weakest, lanes(1.0) / scale@)
            cloud = noise * max(1.0, h * highest(blur * weakest) / (4 * ROUNDOFF))
            sure, matrix = (SURE, ONWARD) if last > 0.0 else (1.0, FRESH)
            rounds, rate = eight_stages(t, h, y, low, k, table, work, (<|fine@, |>), enough, cloud, sure, old, matrix, new)
            COUNT 8 * abs(rounds)
            if rounds < 0:
                wish, left, rejected = 0.3 * h, 0.0, True
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
            c@ = larger(size(c@) - blur, lanes(0.0))
            d@ = larger(size(d@) - blur, lanes(0.0))
            error = lanes(0.0)
            m@, n@ = lanes(1.0) / larger(size@, lanes(TINY)), lanes(1.0) / scale@
            error = error + ((d@ * m@) * (d@ * n@) + lanes(LESS) * (c@ * m@) * (c@ * n@))
            worst = highest(error) * ERRS * h / (tolerance * keen**4)
            wanted = root_15(max(worst, TINY)) / SAFETY
            if not worst <= SLACK:
                wish, left, rejected = h * max(SHRINK_MOST, 1 / wanted), 0.0, True
                continue
            left@ = {left}
            change = ({together})
            end% = y[%] + change[%]
            back% = end% - y[%]
            low% = (y[%] - (end% - back%)) + (change[%] - back%)
            {crossed}
            y, low = (<|end%, |>), (<|low%, |>)
            old, new = new, old
            last, taken, left = h, taken + some, left - 1.0
            t = times[sample] if left < 1.0 else t + h
            if left < 1.0:
                finite = lanes(0.0)
                finite = finite + size(y[%] - y[%])
                failed = failed or not highest(finite) == 0.0
                for i in range(some):
                    out[first + i, sample, %] = lane(y[%], i)
                sample += 1
            if rate > FAST / 2:
                most, moves = lanes(TINY), lanes(0.0)
                most = larger(most, size({rate}))
                moves = larger(moves, lanes(h) * size@ / larger(size({rate}) + lanes(FAINT) * most, lanes(TINY)))
                stiff = stiff + 1 if highest(moves) < SLOWLY else max(stiff - 1, 0)
                failed = failed or stiff > MOST_STIFF
            grow = min(1 / wanted, 1.0 if rejected else GROW_MOST)
            if rate > FAST and rounds > 2:
                grow = min(grow, max(0.5, FAST / rate))
            calm, lowest = calm + 1, min(lowest, grow)
            if HELD <= grow <= HOLDABLE:
                # What all of so many steps could have.
                grow = lowest if calm == CALM and lowest > 1.1 else 1.0
            elif grow > HOLDABLE:
                grow /= LEAP
            if grow != 1.0:
                wish, left = h * grow, 0.0
            if grow != 1.0 or calm == CALM or rejected:
                calm, lowest = 0, GROW_MOST
            rejected = False
        left_over[first // 8] = failed
    return taken
"""


def text(words: Mapping[str, str], entries: list[tuple[int, int]], count: int, poles: int) -> tuple[str, int]:
    """The text, to be expanded for components, and the rows that `work` must have.

    `entries`: slope and component of the state of each derivative that `slopes` returns after the slopes. `poles`: how
    many there are.
    """
    changed = " or ".join(f"highest(-(beyond[{i}] * sides[{i}])) > 0.0" for i in range(poles))
    words = {**words, "sides": SIDES if poles else "", "crossed": CROSSED.replace("CHANGED", changed) if poles else ""}
    lines = [f"c{i} = lanes(0.0)" for i in range(count)]
    for n, (i, j) in enumerate(entries):
        shift = f"{'s' if j < count else 'w'}{j % count}"
        lines.append(f"c{i} = fma(row(work, FIRST_DERIVATIVE + DERIVATIVES * j + {n}), {shift}, c{i})")
    body = TEXT.replace("{round}", FORESEEING if entries else PLAIN)
    body = body.replace("{keep}", "{keep}" + BEGIN + "{apart}" if entries else "{keep}")
    body = body.replace("CORRECTIONS", BEGIN.join(lines))
    body = body.replace("{verdict}", (NEARLY_SETTLED if entries else "") + settled(12))
    for word, meaning in words.items():
        body = body.replace("{" + word + "}", meaning)
    size = 8 * count
    sizes = {
        "AFTER": 8, "ONWARD": 16, "FRESH": 16, "SLOPES": size, "SLOPES_TOO": size, "GUESS": count, "POINTS": 2 * size,
        "APART": 2 * size, "FOUND": size, "FIRST_DERIVATIVE": 8 * len(entries),
    }  # fmt: skip
    rows = 0
    head = f"N, DERIVATIVES, MOST_ATTEMPTS = {count}, {len(entries)}, {10**7}\n"
    head += "PORTION, HELD, HOLDABLE = 0.1, 0.9, 2.2\n"
    for name, many in sizes.items():
        head += f"{name} = {rows}\n"
        rows += many
    return head + f"ROWS = {rows}\n" + body, rows + 1


def over_stages(source: str) -> str:
    """The text with each line that has a `$` repeated for the stages 1 to 7."""
    return re.sub(r"^.*\$.*\n", lambda x: "".join(x[0].replace("$", str(j)) for j in range(1, 8)), source, flags=re.M)
