"""The step sizes of the fast Gauss method for single trajectories, as text: equal steps, or steps from the frequency.

Steps stay equal as long as possible: guesses are then better, and the energy does not drift. For motions with quick and
slow parts (a pericentre) equal steps would be too short for most of the orbit, and with steps that follow only the
error the energy drifts. If the derivatives J of the acceleration are known, the frequency |J|^(1/2) can choose the step
size: the mean of 1/h before and after a point is the frequency at the point over a constant stride. This rule is
symmetric in time, so that the motion away from a pericentre loses the energy that it gained on the way in (Huang,
Leimkuhler, SIAM Journal on Scientific Computing 18, 1997).

The rule is tried if the wanted step varies by more than a factor HOLD within WINDOW steps. It is kept while the wanted
stride varies by less than HOLD and by less than STEADIER times the variation that the wanted step had. See `lane_text`
for the notation.
"""

from __future__ import annotations

from gnomon.harness.integrators.gauss.gauss_fast_stages import CommonText


class ControlText(CommonText):
    """The text that chooses the next step after an accepted step."""

    def next_step(self) -> str:
        """Choose the next step: steps stay equal as long as the error and the rate of convergence allow it.

        After EQUAL_STEPS_NEEDED equal steps the step grows by `common_growth`, the factor that each of these allowed.
        If the error allows a factor `grow` of HOLD or more, the step grows at once, by grow / LEAP.
        """
        return """
            if rate > FAST and rounds > SETTLING:
                grow = min(grow, max(SHRINK_BY_RATE, FAST / rate))
            equal_steps, common_growth = (
                (equal_steps + 1, min(common_growth, grow)) if grow >= HOLD_FROM and not rejected else (0, GROW_MOST)
            )
            more = 1.0
            if equal_steps == equal_steps_needed:
                more, equal_steps, common_growth, equal_steps_needed = (
                    common_growth if common_growth >= LEAST_GROWTH else 1.0, 0, GROW_MOST, EQUAL_STEPS_NEEDED
                )
            {equal_steps}  #? not by_position
            {wanted_strides}  #? by_position
            {choice_of_frequency}  #? by_position
            if by_frequency:  #? by_position
                {step_by_frequency}
            else:  #? by_position
                {equal_steps}
            unmonitored = max(rounds - UNMONITORED, 0)
        """

    def equal_steps(self) -> str:
        """The next step h. The usual case has its own branch, so that the step can start before `grow` is known."""
        return """
            if HOLD_FROM <= grow < HOLD:
                h = step * more
            elif grow >= HOLD and rejected:
                h = step
            elif grow >= HOLD:
                h = step * min(grow / LEAP, GROW_MOST)
                equal_steps, common_growth = 0, GROW_MOST
            else:
                h = step * grow
        """

    def no_frequency_yet(self) -> str:
        return """
            by_frequency, stride, step_frequency, norm, step_variation, windows_to_wait = False, 0.0, 0.0, 0.0, 1.0, 0
            window, steps_seen, shortest, longest, least_stride_8, largest_stride_8 = FIRST_WINDOW, 0, np.inf, 0.0, np.inf, 0.0
        """

    def wanted_strides(self) -> str:
        """The ranges of the step that the error allows and of the stride, its product with the frequency.

        Eighth powers of strides need no root. A step that is far too short gives no good estimate of the fitting step.
        """
        return """
            before, norm = norm, square
            if 0.0 < before and grow < GROW_MOST:
                fitting_step = step * grow
                fourth = (fitting_step * fitting_step) * (fitting_step * fitting_step)
                stride_8 = (fourth * before) * (fourth * norm)
                shortest, longest, least_stride_8, largest_stride_8 = (
                    min(shortest, fitting_step), max(longest, fitting_step),
                    min(least_stride_8, stride_8), max(largest_stride_8, stride_8),
                )
                steps_seen += 1
        """

    def choice_of_frequency(self) -> str:
        """Begin or end steps by frequency; after each failure the next trial waits for more windows.

        It fails if the frequency does not predict which steps must be short.
        """
        return """
            if by_frequency and (
                grow >= GROW_MOST
                or steps_seen == window and largest_stride_8 > min(STEADIER * step_variation, HOLD) ** 8 * least_stride_8
            ):
                by_frequency, windows_to_wait, steps_seen = False, 2 * windows_to_wait + WINDOWS_TO_WAIT, window
            elif steps_seen == window and not by_frequency and windows_to_wait > 0:
                windows_to_wait -= 1
            elif (
                steps_seen == window and not by_frequency and longest > HOLD * shortest
                and largest_stride_8 < (2 * longest / shortest) ** 8 * least_stride_8
            ):
                by_frequency, step_variation, stride, step_frequency = (
                    True, longest / shortest, STRIDE_SHARE * least_stride_8**0.125, math.sqrt(math.sqrt(norm))
                )
                equal_steps, common_growth, more = 0, GROW_MOST, 1.0
            if steps_seen == window:
                window, steps_seen, shortest, longest, least_stride_8, largest_stride_8 = WINDOW, 0, np.inf, 0.0, np.inf, 0.0
        """

    def step_by_frequency(self) -> str:
        """The next step by frequency: the mean of 1/h before and after this point is its frequency over the stride."""
        return """
            frequency = math.sqrt(math.sqrt(norm))
            if grow < HOLD_FROM:
                stride, step_frequency = stride * grow, frequency
            elif more > 1.0:
                stride, step_frequency = stride * more, frequency
            else:
                step_frequency = min(
                    max(2 * frequency - step_frequency, frequency / MOST_FREQUENCY_CHANGE), MOST_FREQUENCY_CHANGE * frequency
                )
            h = min(stride / step_frequency, GROW_MOST * step)
        """

    def stiffness(self) -> str:
        """Count the steps of a slow motion that convergence limits.

        LEAST_MOVING excludes decayed components, whose relative rate of change stays large.
        """
        return """
            if rate > STIFF_RATE:
                most, moves = 0.0, 0.0
                most = max(most, abs({rate}))
                moves = max(moves, step * size@ / max(abs({rate}) + LEAST_MOVING * most, TINY))
                stiff = stiff + 1 if moves < SLOW_MOTION else max(stiff - 1, 0)
        """
