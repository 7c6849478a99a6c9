"""The fast Gauss method for ensembles, as source text: the lanes of a vector are eight trajectories.

The method is that of `gauss_fast_text`: guesses, rounds, error, compensated sums. What differs: the eight trajectories of
a vector share t and the step, and steps divide the interval between two samples, so that samples are ends of steps. The
stages lie in memory, in the rows of `work`. A vector that cannot go on is left over, for the method for single
trajectories, which tells why.

A line with a `$` is repeated for the stages 1 to 7, which a sum over all stages adds to stage 0.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from gnomon.harness.integrators.gauss_fast_text import settled

SIGNATURE = (
    '"int64(float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64[:, :, ::1], int64[::1], '
    'float64[:, ::1])"'
)


def summed(name: str, matrix: str, factor: str) -> str:
    """Lines for a row of a matrix times the eight vectors r."""
    return (
        f"{name} = lanes(table[{matrix}, j]) * r@_0\n"
        f"            {name} = fma(lanes(table[{matrix} + $, j]), r@_$, {name})\n"
        f"            {name} = {factor}\n"
    )


FIRST_ORDER = {
    "place": summed("x@", "STAGES", "fma(hh, x@, y[@])"),
    "shift": summed("s@", "STAGES", "hh * s@"),
    "together": "<|fma(lanes(h), a@, low[@]), |>",
    "blur": "0.0",
}
SECOND_ORDER = {
    "place": summed("x@", "STAGES", "fma(hh * hh, x@, fma(hh * lanes(table[NODES, j]), y[N + @], y[@]))"),
    "shift": summed("s@", "STAGES", "hh * hh * s@"),
    "together": "<|fma(lanes(h), y[N + @], fma(lanes(h * h), b@, fma(lanes(h), low[N + @], low[@]))), |>"
    "<|fma(lanes(h), a@, low[N + @]), |>",
    "blur": "4 * ROUNDOFF * furthest / (h * h)",
}
WITH_VELOCITY = SECOND_ORDER | {
    "place": SECOND_ORDER["place"] + "            " + summed("u@", "ONCE", "fma(hh, u@, y[N + @])"),
    "shift": SECOND_ORDER["shift"] + "            " + summed("w@", "ONCE", "hh * w@"),
}

KEEP = """d@ = lanes(g[@]) - row(work, SLOPES + N * j + @)
            off = fma(size(d@), fine[@], off)
            put(work, NEW + N * j + @, lanes(g[@]))
"""
FINISH = """for j in range(8):
            put(work, SLOPES + N * j + @, row(work, NEW + N * j + @))
"""
KEEP_WITH_DERIVATIVES = """put(work, CHANGES + N * j + @, lanes(g[@]) - row(work, SLOPES + N * j + @))
            put(work, NEW + N * j + @, lanes(g[@]))
            for e in range(DERIVATIVES):
                put(work, FIRST_DERIVATIVE + DERIVATIVES * j + e, lanes(g[N + e]))
"""
FORESEE = """r@_0 = row(work, CHANGES + @)
        r@_$ = row(work, CHANGES + N * $ + @)
        for j in range(8):
            {shift}
            CORRECTIONS
            off = fma(size(row(work, CHANGES + N * j + @) + c@), fine[@], off)
            put(work, SLOPES + N * j + @, row(work, NEW + N * j + @) + c@)
"""

TEXT = """
@njit(forceinline=True, OPTIONS)
def eight_stages(t, h, y, k, table, work, fine, noise, sure):
    hh = lanes(h)
    before, rate, rounds = 0.0, 0.0, 0
    while True:
        r@_0 = row(work, SLOPES + @)
        r@_$ = row(work, SLOPES + N * $ + @)
        off = lanes(0.0)
        for j in range(8):
            {place}
            w = forcing(lanes(t + h * table[NODES, j]), k)
            g = slopes(({placed}), w, k)
            {keep}
        {finish}
        change = highest(off)
        rounds += 1
        if rounds > 1:
            rate = change / before if before > 0.0 else 0.0
            {verdict}
        before = change
    return rounds, rate


@njit(OPTIONS)
def carry_on(table, work, ratio):
    # The matrix that carries the polynomial of the stages on to a step `ratio` times as long.
    for k in range(8):
        for j in range(8):
            value, power = 0.0, 1.0
            for m in range(8):
                value += table[POWERS + m, j] * power * table[MONOMIALS + k, m]
                power *= ratio
            work[AFTER + k, j] = value


@njit(TOGETHER, OPTIONS, nogil=True)
def advance_eight(p_, table, initial, times, tolerance, out, left_over, work):
    p = (PARAMETERS)
    k = constants(p)
    share = SHARE * max(tolerance, ROUNDOFF / 4)
    noise = NOISE * ROUNDOFF / share
    taken, many, end = 0, initial.shape[0], times[-1]
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
        for j in range(8):
            put(work, SLOPES + N * j + @, lanes(g[@]))
        wish = min({first}, end)
        t, sample, attempts, stiff, left, last, ratio = 0.0, 0, 0, 0, 0.0, 0.0, 0.0
        failed, rejected = False, False
        while sample < times.size and not failed:
            # Equal steps to the next sample: so many are left.
            if left < 1.0:
                left = np.ceil((times[sample] - t) / (wish * 1.000001))
            h = (times[sample] - t) / left if left < 1e15 else 0.0
            attempts += 1
            if not (t + h / 4 > t and h < np.inf) or attempts > MOST_ATTEMPTS:
                failed = True
                break
            if last > 0.0:
                if not abs(h / last - ratio) < 1e-9:
                    ratio = h / last
                    carry_on(table, work, ratio)
                r@_0 = row(work, OLD + @)
                r@_$ = row(work, OLD + N * $ + @)
                for j in range(8):
                    x@ = lanes(work[AFTER, j]) * r@_0
                    x@ = fma(lanes(work[AFTER + $, j]), r@_$, x@)
                    put(work, SLOPES + N * j + @, x@)
            least = lanes(0.0)
            least = larger(least, size@)
            blur = {blur}
            least = larger(lanes(h * max(LEAST, 16 * ROUNDOFF / tolerance)) * least, lanes(h * blur))
            scale@ = larger(larger(size({rate}), lanes(h) * size@), least) + lanes(TINY)
            fine@ = lanes(h / (8 * share)) / scale@
            weakest = lanes(0.0)
            weakest = larger(weakest, lanes(1.0) / scale@)
            cloud = noise * max(1.0, h * blur * highest(weakest) / (4 * ROUNDOFF))
            sure = SURE if last > 0.0 else 1.0
            rounds, rate = eight_stages(t, h, y, k, table, work, (<|fine@, |>), cloud, sure)
            COUNT 8 * abs(rounds)
            if rounds < 0:
                wish, left, rejected = 0.3 * h, 0.0, True
                continue
            a@ = lanes(0.0)
            b@ = lanes(0.0)
            c@ = lanes(0.0)
            d@ = lanes(0.0)
            s@ = lanes(0.0)
            for j in range(8):
                f@ = row(work, SLOPES + N * j + @)
                a@ = fma(lanes(table[WEIGHTS, j]), f@, a@)
                b@ = fma(lanes(table[POSITIONS, j]), f@, b@)
                c@ = fma(lanes(table[SIXTH, j]), f@, c@)
                d@ = fma(lanes(table[SEVENTH, j]), f@, d@)
                s@ = s@ + size(f@)
            size@ = s@ * lanes(0.125)
            c@ = larger(size(c@) - lanes(blur), lanes(0.0))
            d@ = larger(size(d@) - lanes(blur), lanes(0.0))
            error = lanes(0.0)
            error = error + (d@ * d@ + lanes(LESS) * c@ * c@) / ((size@ + lanes(TINY)) * scale@)
            worst = highest(error) * ERRS * h / tolerance
            wanted = root_15(max(worst, TINY)) / SAFETY
            if not worst <= SLACK:
                wish, left, rejected = h * max(SHRINK_MOST, 1 / wanted), 0.0, True
                continue
            change = ({together})
            end% = y[%] + change[%]
            back% = end% - y[%]
            low% = (y[%] - (end% - back%)) + (change[%] - back%)
            y, low = (<|end%, |>), (<|low%, |>)
            for j in range(8):
                put(work, OLD + N * j + @, row(work, SLOPES + N * j + @))
            last, taken, left = h, taken + some, left - 1.0
            t = times[sample] if left < 1.0 else t + h
            if left < 1.0:
                finite = lanes(0.0)
                finite = finite + size(y[%] - y[%])
                failed = not highest(finite) == 0.0
                for i in range(some):
                    out[first + i, sample, %] = lane(y[%], i)
                sample += 1
            if rate > FAST / 2:
                most, moves = lanes(TINY), lanes(0.0)
                most = larger(most, size({rate}))
                moves = larger(moves, lanes(h) * size@ / (size({rate}) + lanes(FAINT) * most))
                stiff = stiff + 1 if highest(moves) < SLOWLY else max(stiff - 1, 0)
                failed = failed or stiff > MOST_STIFF
            grow = min(1 / wanted, 1.0 if rejected else GROW_MOST)
            if rate > FAST and rounds > 2:
                grow = min(grow, max(0.5, FAST / rate))
            rejected = False
            if grow < 1.0 or left < 1.0 or grow > HOLD:
                wish = h * grow
                left = 0.0
        left_over[first // 8] = failed
    return taken
"""


def text(words: Mapping[str, str], entries: list[tuple[int, int]], count: int) -> tuple[str, int]:
    """The text, to be expanded for components, and the rows that `work` must have.

    `entries`: slope and component of the state of each derivative that `slopes` returns after the slopes.
    """
    lines = [f"c{i} = lanes(0.0)" for i in range(count)]
    for n, (i, j) in enumerate(entries):
        shift = f"{'s' if j < count else 'w'}{j % count}"
        lines.append(f"c{i} = fma(row(work, FIRST_DERIVATIVE + DERIVATIVES * j + {n}), {shift}, c{i})")
    foresee = FORESEE.replace("CORRECTIONS", "\n            ".join(lines))
    body = TEXT.replace("{keep}", KEEP_WITH_DERIVATIVES if entries else KEEP)
    body = body.replace("{finish}", foresee if entries else FINISH).replace("{verdict}", settled(12))
    for word, meaning in words.items():
        body = body.replace("{" + word + "}", meaning)
    size = 8 * count
    head = f"N, DERIVATIVES, SLOPES, NEW, CHANGES, OLD = {count}, {len(entries)}, 0, {size}, {2 * size}, {3 * size}\n"
    head += f"AFTER, FIRST_DERIVATIVE, MOST_ATTEMPTS = {4 * size}, {4 * size + 8}, {10**7}\n"
    return head + body, 4 * size + 8 + 8 * len(entries)


def over_stages(source: str) -> str:
    """The text with each line that has a `$` repeated for the stages 1 to 7."""
    return re.sub(r"^.*\$.*\n", lambda x: "".join(x[0].replace("$", str(j)) for j in range(1, 8)), source, flags=re.M)
