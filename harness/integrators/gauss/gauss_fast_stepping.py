"""The fast Gauss method for single trajectories, as text: first guesses, error of a step, update, samples.

The eight stages are the eight lanes of one vector. See `lane_text` for the notation, `gauss_fast_stages` for the
stages, `gauss_fast_control` for step sizes.

The energy drifts if an operation rounds in the same way in every step (Hairer, McLachlan, Razakarivony, BIT 48, 2008).
So weights and nodes have rounding residuals, each row of the stage matrix is rounded but keeps its sum, and step sizes
have so few bits that their products are exact. Biased errors of truncation and iteration must not remain either: below
FINE, a tolerance makes both smaller, and the error of energy is then the random walk of round-off (Brouwer's law). With
sums in binary64 (the pendulum, 23 steps a period) four fifths of this error come from the sums of a step, and one fifth
from the slopes. So for tolerances below EXACT the rounding residual of every sum and product is carried too.
"""

from __future__ import annotations

from gnomon.harness.integrators.gauss.gauss_fast_control import ControlText
from gnomon.harness.integrators.gauss.gauss_fast_stages import StagesText


class SingleText(StagesText, ControlText):
    """The text of the function `advance` and of the functions that it calls."""

    def single(self) -> str:
        """The functions of the module."""
        return """
            {constants}
            {sums}
            {stages}
            {aside}
            {next_state}
            {advance}
        """

    def advance(self) -> str:
        """Integrate all trajectories, one after the other.

        `stop`: reason, trajectory, sample, and the number of right-hand sides.
        """
        return """
            @njit("int64({signature})", {options})
            def advance(p_, table, initial, times, tolerance, out, stop):
                {limits}
                taken, evaluations = 0, 0
                for n in range(initial.shape[0]):
                    {start}
                    while reason == 0 and sample < times.size:
                        {length}
                        {scales}
                        {guesses}
                        {solve}
                        {error}
                        {end_of_step}
                        {over_a_pole}  #? poles
                        {samples}
                        old@ = f@
                        y, compensation, t, last = end_state, residual, after, step
                        taken += 1
                        {next_step}
                        {stiffness}
                        rejected = False
                    if reason != 0 and stop[0] == 0:
                        stop[0] = reason
                        stop[1] = n
                        stop[2] = sample
                stop[3] += 8 * evaluations
                return taken
        """

    def limits(self) -> str:
        """Numbers that depend on the tolerance and the span. Changes are sums over eight stages.

        `grid`, a power of two, is at least the span: steps that are multiples of its spacing keep sums of times exact.
        """
        return """
            end = times[-1]
            grid = 2.0 ** np.ceil(np.log2(end)) if end > 0.0 else 1.0
            fine_ratio = min(tolerance / FINE, 1.0)
            allowed_change, noise = 8 * ITERATION_SHARE * max(tolerance, ROUNDOFF / 4) * fine_ratio**10, 8 * NOISE * ROUNDOFF
            exactly = tolerance < EXACT
            best_rate = BEST_RATE_FINEST if tolerance < FINEST else BEST_RATE
        """

    def start(self) -> str:
        """The start of a trajectory."""
        return """
            k = constants(({parameters}))
            t, sample, attempts, stiff, reason = 0.0, 0, 0, 0, 0
            compensation% = 0.0
            y, compensation = (<|initial[n, ~], |>), (<|compensation%, |>)
            g = slopes((<|lanes(y[%]), |>), forcing(lanes(0.0), k), k)
            f@ = lanes(lane(lanes(g[@]), 0))
            size@ = abs(lane(f@, 0))
            furthest, largest, fastest = 0.0, 0.0, 0.0
            furthest = max(furthest, abs(y[@]))
            largest = max(largest, abs({rate}))
            fastest = max(fastest, size@)
            {first_step}
            h, last, rejected, equal_steps, common_growth, equal_steps_needed, unmonitored, rate = (
                first_step, first_step, False, 0, GROW_MOST, FIRST_EQUAL_STEPS_NEEDED, 0, 0.0
            )
            {no_frequency_yet}  #? by_position
            beyond = poles((<|lanes(y[%]), |>), forcing(lanes(0.0), k), k)  #? poles
            sides = ({signs})  #? poles
            old@ = f@
            extent = 0.0
            extent = max(extent, abs(y[%]))
            if extent > LARGEST or 0.0 < extent < SMALLEST:
                reason = OUT_OF_RANGE
        """

    def length(self) -> str:
        """The step: h, rounded so that t + step is exact. The last step ends at the last sample."""
        return """
            if not (h > 0.0 and h < np.inf):
                reason = NOT_FINITE
                break
            if t + h / 4 <= t:
                reason = STIFF if stiff > 0 else STEP_TOO_SMALL
                break
            h = few_bits(h)
            if h > COARSE * grid:
                h = (h + grid) - grid
            step = end - t if t + h >= end else (t + h) - t
            after = end if t + h >= end else t + step
            attempts += 1
            if attempts > MOST_STEPS:
                reason = TOO_MANY_STEPS
                break
            if stiff > MOST_STIFF:
                reason = STIFF
                break
        """

    def scales(self) -> str:
        """The scale of each component, which divides its error: its size or its change in a step, whichever is larger.

        At an equilibrium the terms of the slopes cancel, and their round-off remains.
        """
        return """
            largest = 0.0
            largest = max(largest, size@)
            slope_roundoff, least_scale = 0.0, np.inf
            slope_roundoff = SLOPE_ROUNDINGS * ROUNDOFF * furthest / (step * step)  #? second_order
            scale_floor = max(step * largest * max(LEAST_SHARE, SCALE_ROUNDINGS * ROUNDOFF / tolerance), step * slope_roundoff)
            scale@ = max(max(max(abs({rate}), step * size@), scale_floor), TINY)
            change_weight@ = step / scale@
            splitter@ = SPLITTER * size@
            least_scale = min(least_scale, scale@)
            step_noise = noise * max(1.0, step * (slope_roundoff / least_scale) / (SLOPE_ROUNDINGS * ROUNDOFF))
        """

    def guesses(self) -> str:
        """First guesses of the slopes.

        After a step of equal length they are the best linear estimate for functions as smooth as the tolerance implies
        (`gauss_fast.extrapolation_weights`). Otherwise they extrapolate the last stage polynomial: its monomials times
        the powers of the ratio of the steps.

        The sums p and v of the guesses are always needed, the guesses only if their first change is computed or
        multiplied by derivatives.
        """
        return """
            if step == last:
                ahead = (<|old@, |>)  #? not derivatives
                if unmonitored == 0:  #? not derivatives
                    ahead = products(table, AHEAD, (<|old@, |>))
                ahead = products(table, AHEAD, (<|old@, |>))  #? derivatives
                p, v = sums((<|old@, |>), table, CARRIED, ONCE_CARRIED)
            else:
                ratios = powers(step / last)
                m = products(table, MONOMIALS, (<|old@, |>))
                ahead = products(table, POWERS, (<|m[@] * ratios, |>))
                p, v = sums((<|m[@] * ratios, |>), table, POWERED, ONCE_POWERED)
        """

    def solve(self) -> str:
        """The slopes of the step. If the iteration does not converge, the step is repeated with a smaller size."""
        return """
            assumed_rate = best_rate if t > 0.0 else 1.0
            rounds, seen_rate, f, square = stages(
                t, step, y, compensation, ahead, p, v, k, table, (<|change_weight@, |>), allowed_change, step_noise,
                assumed_rate, 0.0, unmonitored, exactly
            )
            evaluations += abs(rounds)
            rate = seen_rate if seen_rate > 0.0 else min(rate, FAST)
            if rounds < 0:
                {repeat}
        """

    def repeat(self) -> str:
        return """
            h, unmonitored, rejected = SHRINK * step, 0, True
            stride = h * step_frequency  #? by_position
            continue
        """

    def error(self) -> str:
        """The error of the step in tolerances, from the decay of the Legendre coefficients of the stage polynomial.

        Let a be the size of the two highest coefficients and F the size of the derivative. Coefficient 8, the first
        missing one, is about a. Collocation at the Gauss nodes squares it (exactly so for a linear equation), so the
        error of a step is about h a^2 / F as long as the coefficients fall. After a sharp turn between two nodes they
        are all equally large: then a d^2 is added, with d the share of the two highest coefficients in the squares of
        the last four.

        For one component only the last four coefficients are computed, as sums: eight columns would not fit into the
        processor's registers.
        """
        return """
            f@ = lanes(f[@])
            size@ = total(size(f@)) / 8
            worst = lanes(0.0)
            legendre = products(table, LEGENDRE, f)  #? many
            legendre = (legendre_of_one(f0, table),)  #? not many
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
                stride = h * step_frequency  #? by_position
                rejected = True
                continue
        """

    def end_of_step(self) -> str:
        """The compensated update of the state."""
        return """
            if exactly:
                end_state, residual = next_state_exactly(step, y, compensation, f, (<|splitter@, |>), table)
            else:
                end_state, residual = next_state(step, y, compensation, f, table)
            finite = 0.0
            finite += end_state[%] - end_state[%]
            if finite != 0.0:
                reason = NOT_FINITE
                break
        """

    def next_state(self) -> str:
        """The state after a step, y + h b f, or q + h v + h^2 b (1 - c) a and v + h b a; the residual of the last sum.

        `next_state_exactly` includes the rounding residuals of all sums and products.
        """
        return """
            @njit({inner})
            def next_state(h, y, compensation, f, table):
                <|f@, |> = f
                s@ = h * total(weighted(f@, table, WEIGHTS))
                change = (<|s@ + compensation[@], |>)  #? first_order
                p@ = h * (h * total(weighted(f@, table, POSITIONS)) + compensation[&])  #? second_order
                change = (<|h * y[&] + (p@ + compensation[@]), |><|s@ + compensation[&], |>)  #? second_order
                end%, residual% = summed(y[%], change[%])
                return (<|end%, |>), (<|residual%, |>)


            @njit({inner})
            def next_state_exactly(h, y, compensation, f, splitter, table):
                <|f@, |> = f
                high@, rest@ = weighted_exactly(f@, splitter[@], table, WEIGHTS)  #? first_order
                end@, residual@ = added(y[@], fused(h, rest@, compensation[@]), h, high@)  #? first_order
                return (<|end@, |>), (<|residual@, |>)  #? first_order
                place@, place_residual@ = added(y[@], fused(h, compensation[&], compensation[@]), h, y[&])  #? second_order
                high@, rest@ = weighted_exactly(f@, splitter[@], table, POSITIONS)  #? second_order
                end@, residual@ = added(place@, fused(h * h, rest@, place_residual@), h * h, high@)  #? second_order
                high@, rest@ = weighted_exactly(f@, splitter[@], table, WEIGHTS)  #? second_order
                speed@, speed_residual@ = added(y[&], fused(h, rest@, compensation[&]), h, high@)  #? second_order
                return (<|end@, |><|speed@, |>), (<|residual@, |><|speed_residual@, |>)  #? second_order
        """

    def signs(self) -> str:
        return "".join(f"lane(beyond[{i}], 0), " for i in range(len(self.layout.poles)))

    def other_signs(self) -> str:
        return " or ".join(f"(lane(beyond[{i}], 0) < 0.0) != (sides[{i}] < 0.0)" for i in range(len(self.layout.poles)))

    def over_a_pole(self) -> str:
        """Repeat a step in which a divisor changes its sign with a smaller size.

        A divisor of the equations keeps its sign on a smooth motion, as its zero is a pole of the equations. If a wall
        reverses the motion within 1e-8 of a step, no stage meets the wall: the step looks right but ends beyond the
        pole. Steps shorter than SHORTEST_AT_POLE of the span are not repeated: the divisor of sin(x) / x passes 0
        without a pole.
        """
        return """
            beyond = poles((<|lanes(end_state[%]), |>), forcing(lanes(after), k), k)
            if step > SHORTEST_AT_POLE * end and ({other_signs}):
                {repeat}
            sides = ({signs})
        """

    def samples(self) -> str:
        """Compute each sample by a separate step from the start of the step in which it lies.

        The stage polynomial of the whole step gives the first guess. A sample has the order of the end of a step, and
        the steps do not depend on the samples.

        As the step has converged, its samples usually converge too, though a change may exceed the change before it. If
        a sample does not converge, the step is repeated with a smaller size.
        """
        return """
            unsolved = False
            if times[sample] <= after:
                m = products(table, MONOMIALS, f)
                while sample < times.size and times[sample] <= after:
                    part = times[sample] - t
                    if times[sample] == after:
                        out[n, sample, ~] = end_state[%]
                    else:
                        x = fma(lanes(part / step), row(table, NODES), lanes(-1.0))
                        near = (<|at(m[@], x), |>)
                        unsolved = True
                        for _ in range(TRIES):
                            p, v = sums(near, table, STAGES, ONCE)
                            again, _rate, near, _square = aside(
                                t, part, y, compensation, near, p, v, k, table, (<|change_weight@, |>),
                                allowed_change / SAMPLE_FACTOR, step_noise, BEST_RATE_OF_SAMPLE,
                                max(rate, BEST_RATE_OF_SAMPLE), 0, exactly
                            )
                            evaluations += abs(again)
                            unsolved = again <= 0
                            if not unsolved:
                                break
                        if unsolved:
                            break
                        place, _residual = next_state(part, y, compensation, near, table)
                        out[n, sample, ~] = place[%]
                    {constant_components}
                    sample += 1
            if unsolved:
                {repeat}
        """

    def constant_components(self) -> str:
        return "\n".join(f"out[n, sample, {i}] = initial[n, {i}]" for i in self.layout.frozen)
