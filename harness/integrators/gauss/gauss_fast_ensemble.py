"""The fast Gauss method for ensembles, as text: the lanes of a vector are eight trajectories.

Guesses, rounds, error and compensated sums are as in `gauss_fast_stepping`. The differences:

- The eight trajectories of a vector share t and the step, and a whole number of steps fills the interval between two
  samples, so that samples are ends of steps.
- The stages lie in memory, in the rows of `work`. One loop computes their states and the next one the slopes: the
  processor has too few registers for both.
- Sharp turns between two stages are not detected.

Here too, no operation rounds in the same way in every step: at the finest tolerance the error of energy is a random
walk.

`left_over` records a vector that cannot go on or that passes a pole. The method for single trajectories integrates
these trajectories again, and gives the reason if it stops too. See `lane_text` for the notation.
"""

from __future__ import annotations

import itertools

from gnomon.harness.integrators.gauss.gauss_fast_stages import CommonText


class EnsembleText(CommonText):
    """The text of the function `advance_eight` and of the functions that it calls."""

    def ensemble(self) -> str:
        """The functions of the module."""
        return """
            {constants}
            {rows_of_work}
            {eight_stages}
            {carry_on}
            {advance_eight}
        """

    def places_of_work(self) -> dict[str, int]:
        """First rows of the parts of `work`, and the number of rows as ROWS.

        AFTER: the matrix that gives the guesses; ONWARD: both stage matrices times AFTER; FRESH: both stage matrices;
        SLOPES and SLOPES_TOO: the slopes of the last step and of this one; GUESS: the last guess; POINTS: places and
        velocities of the stages; APART: their rounding residuals; FOUND: slopes before correction; FIRST_DERIVATIVE:
        derivatives.
        """
        count, derivatives = self.layout.count, len(self.layout.derivatives)
        names = "AFTER ONWARD FRESH SLOPES SLOPES_TOO GUESS POINTS APART FOUND FIRST_DERIVATIVE ROWS"
        sizes = 8, 16, 16, 8 * count, 8 * count, count, 16 * count, 16 * count, 8 * count, 8 * derivatives
        return dict(zip(names.split(), itertools.accumulate(sizes, initial=0), strict=True))

    def rows_of_work(self) -> str:
        places = self.places_of_work() | {"DERIVATIVES": len(self.layout.derivatives)}
        return "\n".join(f"{name} = {row}" for name, row in places.items())

    def advance_eight(self) -> str:
        """Integrate all trajectories, eight at a time.

        `left_over`: for each eight whether they failed, then the number of right-hand sides.
        """
        return """
            @njit("int64({signature}, float64[:, ::1])", {options}, nogil=True)
            def advance_eight(p_, table, initial, times, tolerance, out, left_over, work):
                {limits}
                taken, evaluations, many = 0, 0, initial.shape[0]
                for first in range(0, many, 8):
                    some = min(8, many - first)
                    {start}
                    while sample < times.size and not failed:
                        {length}
                        {guess}
                        {scales}
                        {solve}
                        {sums}
                        {error}
                        {end_of_step}
                        {sample}
                        {stiffness}
                        {next_step}
                    left_over[first // 8] = failed
                left_over[-1] += 64 * evaluations
                return taken
        """

    def limits(self) -> str:
        """Numbers that depend on the tolerance, and the stage matrices at their places in `work`."""
        return """
            p = ({parameters})
            k = constants(p)
            end = times[-1]
            fine_ratio = min(tolerance / FINE, 1.0)
            allowed_change, noise = (
                8 * ITERATION_SHARE_OF_ENSEMBLE * max(tolerance, ROUNDOFF / 4) * fine_ratio**10, 8 * NOISE * ROUNDOFF
            )
            for j in range(8):
                put(work, FRESH + j, row(table, STAGES + j))
                put(work, FRESH + 8 + j, row(table, ONCE + j))
        """

    def start(self) -> str:
        """Start eight trajectories; if there are fewer, the last one fills the other lanes."""
        return """
            y% = lanes(0.0)
            compensation% = lanes(0.0)
            for i in range(8):
                y% = with_lane(y%, i, initial[first + min(i, some - 1), %])
            y, compensation = (<|y%, |>), (<|compensation%, |>)
            g = slopes((<|y[@], |>), forcing(lanes(0.0), k), k)  #? not with_velocity
            g = slopes((<|y[%], |>), forcing(lanes(0.0), k), k)  #? with_velocity
            furthest, largest, fastest = 0.0, 0.0, 0.0
            size@ = size(lanes(g[@]))
            furthest = max(furthest, highest(size(y[@])))
            largest = max(largest, highest(size({rate})))
            fastest = max(fastest, highest(size@))
            slope_at_start@ = lanes(g[@])
            sides = poles((<|y[%], |>), forcing(lanes(0.0), k), k)  #? poles
            {first_step}
            old, new, wanted_step = SLOPES, SLOPES_TOO, first_step
            t, sample, attempts, stiff, steps_left, last, ratio = 0.0, 0, 0, 0, 0.0, 0.0, 0.0
            failed, rejected, equal_steps, common_growth = False, False, 0, GROW_MOST
            reach, extent = lanes(0.0), lanes(0.0)
            reach = larger(reach, size(y[@]))
            extent = larger(extent, size(y[%]))
            for i in range(some):
                failed = failed or lane(extent, i) > LARGEST or 0.0 < lane(extent, i) < SMALLEST
        """

    def length(self) -> str:
        """The number of equal steps to the next sample, and their length; the last one ends there."""
        return """
            if steps_left < 1.0:
                steps_left = np.ceil((times[sample] - t) / (wanted_step * ROUNDING_OF_STEPS))
            h = (times[sample] - t) / steps_left if steps_left < 1e15 else 0.0
            h = few_bits(h) if steps_left > 1.0 else h
            attempts += 1
            if not (t + h / 4 > t and h < np.inf) or attempts > MOST_ATTEMPTS:
                failed = True
                break
        """

    def guess(self) -> str:
        """Prepare the guesses: one matrix gives the states of the stages directly from the slopes of the last step.

        Only the guess for the last stage is computed, to measure the error of the guesses.
        """
        return """
            if last > 0.0:
                if not abs(h / last - ratio) < EQUAL_WITHIN:
                    ratio = h / last
                    carry_on(table, work, ratio)
                x@ = lanes(work[AFTER, 7]) * row(work, old + @)
                x@ = fma(lanes(work[AFTER + $, 7]), row(work, old + N * $ + @), x@)
                put(work, GUESS + @, x@)
            else:
                put(work, GUESS + @, slope_at_start@)
                for j in range(8):
                    put(work, old + N * j + @, slope_at_start@)
        """

    def carry_on(self) -> str:
        """The matrix that extrapolates the stage polynomial into a step `ratio` times as long, and its integrals."""
        return """
            @njit({inner})
            def carry_on(table, work, ratio):
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
        """

    def scales(self) -> str:
        return """
            scale_floor = lanes(0.0)
            scale_floor = larger(scale_floor, size@)
            slope_roundoff = lanes(0.0)  #? first_order
            slope_roundoff = lanes(SLOPE_ROUNDINGS * ROUNDOFF / (h * h)) * reach  #? second_order
            least_share = h * max(LEAST_SHARE, SCALE_ROUNDINGS * ROUNDOFF / tolerance)
            scale_floor = larger(lanes(least_share) * scale_floor, lanes(h) * slope_roundoff)
            scale@ = larger(larger(larger(size({rate}), lanes(h) * size@), scale_floor), lanes(TINY))
            change_weight@ = lanes(h) / scale@
            largest_inverse_scale = lanes(0.0)
            largest_inverse_scale = larger(largest_inverse_scale, lanes(1.0) / scale@)
            step_noise = noise * max(1.0, h * highest(slope_roundoff * largest_inverse_scale) / (SLOPE_ROUNDINGS * ROUNDOFF))
        """

    def solve(self) -> str:
        return """
            assumed_rate, matrix = (BEST_RATE_FINEST, ONWARD) if last > 0.0 else (1.0, FRESH)
            rounds, rate = eight_stages(
                t, h, y, compensation, k, table, work, (<|change_weight@, |>), allowed_change, step_noise, assumed_rate, old,
                matrix, new
            )
            evaluations += abs(rounds)
            if rounds < 0:
                wanted_step, steps_left, rejected = SHRINK * h, 0.0, True
                continue
        """

    def eight_stages(self) -> str:
        """The iteration for eight trajectories (see `gauss_fast_stages`).

        First rows in `work`: `source`, the slopes of the round before, or of the last step in the first round;
        `matrix`, the matrix that gives places from these slopes; `new`, the result.
        """
        return """
            @njit(forceinline=True, {inner})
            def eight_stages(
                t, h, y, compensation, k, table, work, change_weight, allowed_change, noise, assumed_rate, source, matrix, new
            ):
                hh = lanes(h)
                before, rate, rounds = 0.0, 0.0, 0
                while True:
                    r@_0 = row(work, source + @)
                    r@_$ = row(work, source + N * $ + @)
                    for j in range(8):
                        {places}
                    {plain_round}  #? not derivatives
                    {corrected_round}  #? derivatives
                    if rounds == 0:
                        off = lanes(0.0)
                        off = fma(size(row(work, new + 7 * N + @) - row(work, GUESS + @)), change_weight[@], off)
                    change = highest(off)
                    rounds += 1
                    if rounds > 1:
                        rate = change / before if before > 0.0 else 0.0
                        expected = change * max(rate * rate, assumed_rate)  #? derivatives
                        if expected <= allowed_change and rate < SLOW and highest(rest) <= allowed_change:  #? derivatives
                            break
                        {convergence}
                    before, source, matrix = change, new, FRESH
                return rounds, rate
        """

    def places(self) -> str:
        """The places and velocities of a stage and, for corrections, their rounding residuals."""
        return """
            b@ = y[@]  #? first_order
            m, n = lanes(h * table[NODES_HIGH, j]), lanes(h * table[NODES_LOW, j])  #? second_order
            b@ = fma(m, y[&], fma(n, y[&], y[@]))  #? second_order
            x@ = lanes(work[matrix, j]) * r@_0
            x@ = fma(lanes(work[matrix + $, j]), r@_$, x@)
            x@ = fma(hh, x@, b@)  #? first_order
            x@ = fma(hh * hh, x@, b@)  #? second_order
            u@ = lanes(work[matrix + 8, j]) * r@_0  #? with_velocity
            u@ = fma(lanes(work[matrix + 8 + $, j]), r@_$, u@)  #? with_velocity
            u@ = fma(hh, u@, y[&])  #? with_velocity
            put(work, POINTS + N * j + @, x@)
            put(work, POINTS + N * (8 + j) + @, u@)  #? with_velocity
            l@ = compensation[@]  #? derivatives and first_order
            l@ = fma(n, y[&], fma(m, y[&], y[@] - b@)) + compensation[@]  #? derivatives and second_order
            put(work, APART + N * j + @, (b@ - x@) + l@)  #? derivatives
            put(work, APART + N * (8 + j) + @, (y[&] - u@) + compensation[&])  #? derivatives and with_velocity
        """

    def slopes_of_stage(self) -> str:
        return """
            x@ = row(work, POINTS + N * j + @)
            u@ = row(work, POINTS + N * (8 + j) + @)  #? with_velocity
            w = forcing(lanes(t + h * table[NODES, j]), k)
            g = slopes(({placed}), w, k)
        """

    def plain_round(self) -> str:
        """A round without derivatives: the new slopes g."""
        return """
            off = lanes(0.0)
            for j in range(8):
                {slopes_of_stage}
                off = fma(size(lanes(g[@]) - row(work, new + N * j + @)), change_weight[@], off)
                put(work, new + N * j + @, lanes(g[@]))
        """

    def corrected_round(self) -> str:
        """A round with derivatives J, which correct the new slopes twice.

        The first correction is J times the change of the places that the new slopes cause, the second one J times the
        change that the corrected slopes cause.

        If the corrections have converged (`rest`), the error after the round is proportional to the square of the error
        before it. So the next change is expected with the square of the rate: two rounds are usual at fine tolerances.
        """
        return """
            for j in range(8):
                {slopes_of_stage}
                put(work, FOUND + N * j + @, lanes(g[@]))
                for e in range(DERIVATIVES):
                    put(work, FIRST_DERIVATIVE + DERIVATIVES * j + e, lanes(g[N + e]))
            r@_0 = row(work, FOUND + @)
            r@_$ = row(work, FOUND + N * $ + @)
            for j in range(8):
                {corrections}
                put(work, POINTS + N * j + @, row(work, FOUND + N * j + @) + c@)
            r@_0 = row(work, POINTS + @)
            r@_$ = row(work, POINTS + N * $ + @)
            off, rest = lanes(0.0), lanes(0.0)
            for j in range(8):
                {corrections}
                f@ = row(work, FOUND + N * j + @) + c@
                off = fma(size(f@ - row(work, new + N * j + @)), change_weight[@], off)
                rest = fma(size(f@ - row(work, POINTS + N * j + @)), change_weight[@], rest)
                put(work, new + N * j + @, f@)
        """

    def corrections(self) -> str:
        """The changes s of the places and w of the velocities of a stage, and the change c of its slopes."""
        return """
            s@ = lanes(table[STAGES, j]) * r@_0
            s@ = fma(lanes(table[STAGES + $, j]), r@_$, s@)
            s@ = fma(hh, s@, row(work, APART + N * j + @))  #? first_order
            s@ = fma(hh * hh, s@, row(work, APART + N * j + @))  #? second_order
            w@ = lanes(table[ONCE, j]) * r@_0  #? with_velocity
            w@ = fma(lanes(table[ONCE + $, j]), r@_$, w@)  #? with_velocity
            w@ = fma(hh, w@, row(work, APART + N * (8 + j) + @))  #? with_velocity
            c@ = lanes(0.0)
            {corrections_by_derivatives}
        """

    def corrections_by_derivatives(self) -> str:
        count, found = self.layout.count, []
        for n, (i, j, _) in enumerate(self.layout.derivatives):
            shift = f"{'s' if j < count else 'w'}{j % count}"
            found.append(f"c{i} = fma(row(work, FIRST_DERIVATIVE + DERIVATIVES * j + {n}), {shift}, c{i})")
        return "\n".join(found)

    def sums(self) -> str:
        """Sums over the stages.

        They give the changes of velocities and positions, with the residuals of their weights, the Legendre
        coefficients c and d of degree 6 and 7, and the mean size of the slopes.
        """
        return """
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
        """

    def error(self) -> str:
        """The error of the worst trajectory, estimated as in `gauss_fast_stepping` but without sharp turns."""
        return """
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
        """

    def end_of_step(self) -> str:
        """The compensated update of the state."""
        return """
            change = (<|fma(lanes(h), a@, fma(lanes(h), e@, compensation[@])), |>)  #? first_order
            speed@ = fma(lanes(h), a@, fma(lanes(h), e@, compensation[&]))  #? second_order
            place@ = fma(lanes(h * h), i@, fma(lanes(h), compensation[&], compensation[@]))  #? second_order
            place@ = fma(lanes(h), y[&], fma(lanes(h * h), b@, place@))  #? second_order
            change = (<|place@, |><|speed@, |>)  #? second_order
            end%, compensation% = summed(y[%], change[%])
            beyond = poles((<|end%, |>), forcing(lanes(t + h), k), k)  #? poles
            failed = failed or {sign_changed}  #? poles
            y, compensation = (<|end%, |>), (<|compensation%, |>)
            old, new = new, old
            last, taken, steps_left = h, taken + some, steps_left - 1.0
            t = times[sample] if steps_left < 1.0 else t + h
        """

    def sign_changed(self) -> str:
        return " or ".join(f"highest(-(beyond[{i}] * sides[{i}])) > 0.0" for i in range(len(self.layout.poles)))

    def sample(self) -> str:
        return """
            if steps_left < 1.0:
                finite = lanes(0.0)
                finite = finite + size(y[%] - y[%])
                failed = failed or not highest(finite) == 0.0
                for i in range(some):
                    out[first + i, sample, %] = lane(y[%], i)
                sample += 1
        """

    def stiffness(self) -> str:
        return """
            if rate > STIFF_RATE_OF_ENSEMBLE:
                most, moves = lanes(TINY), lanes(0.0)
                most = larger(most, size({rate}))
                moves = larger(moves, lanes(h) * size@ / larger(size({rate}) + lanes(LEAST_MOVING) * most, lanes(TINY)))
                stiff = stiff + 1 if highest(moves) < SLOW_MOTION else max(stiff - 1, 0)
                failed = failed or stiff > MOST_STIFF
        """

    def next_step(self) -> str:
        """Choose the next step: steps stay equal as long as possible.

        They change if their error is too large, if one could grow HOLD_OF_ENSEMBLE times, or if each of
        EQUAL_STEPS_NEEDED steps could have grown by LEAST_GROWTH.
        """
        return """
            grow = min(1 / shrink_factor, 1.0 if rejected else GROW_MOST)
            if rate > FAST and rounds > SETTLING:
                grow = min(grow, max(SHRINK_BY_RATE, FAST / rate))
            equal_steps, common_growth = equal_steps + 1, min(common_growth, grow)
            if HOLD_FROM <= grow <= HOLD_OF_ENSEMBLE:
                grow = common_growth if equal_steps == EQUAL_STEPS_NEEDED and common_growth > LEAST_GROWTH else 1.0
            elif grow > HOLD_OF_ENSEMBLE:
                grow /= LEAP
            if grow != 1.0:
                wanted_step, steps_left = h * grow, 0.0
            if grow != 1.0 or equal_steps == EQUAL_STEPS_NEEDED or rejected:
                equal_steps, common_growth = 0, GROW_MOST
            rejected = False
        """
