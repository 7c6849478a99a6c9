"""The step sizes of the fast Gauss method: equal steps, or steps from the frequency.

Steps stay equal as long as possible: guesses are then better, and the energy does not drift. For motions with quick and
slow parts (a pericentre) equal steps would be too short for most of the orbit, and with steps that follow only the
error the energy drifts. If the derivatives J of the acceleration are known, the frequency |J|^(1/2) can choose the step
size: the mean of 1/h before and after a point is the frequency at the point over a constant stride. This rule is
symmetric in time, so that the motion away from a pericentre loses the energy that it gained on the way in (Huang,
Leimkuhler, SIAM Journal on Scientific Computing 18, 1997).

The rule is tried if the wanted step varies by more than a factor `hold` within a window of `few_steps` steps. It is kept
while the wanted stride varies by less than `hold` and by less than the wanted step did.
"""

from __future__ import annotations

import math

from gnomon.harness.integrators.gauss.constants import TUNING
from gnomon.harness.integrators.gauss.lanes import bits, double

ONE = 0x3FF0000000000000
"""The bits of 1.0."""

Equal = tuple[int, float, int]
"""The number of equal steps, the least factor that each of them allowed, and the number after which they grow."""

Frequency = tuple[bool, float, float, float, float, int, int, float, float, float, float]
"""Whether steps follow the frequency; stride, frequency that gave the step, fourth power of the frequency at the start,
variation of the wanted steps, windows to wait; of the window the steps seen, least and largest wanted step, eighth powers
of the least and largest wanted stride."""


def few_bits(h: float) -> float:
    """The step rounded to so few bits that its square and its products with the high parts of the nodes are exact."""
    return double(bits(h) & -(1 << 27))


def root_15(x: float) -> float:
    """x^(1/15) within 1 %: the bits of a double, read as an integer, are nearly its logarithm."""
    return double(ONE + (bits(x) - ONE) // 15)


def first_length(second_order: bool, end: float, furthest: float, largest: float, fastest: float) -> float:
    """The first step: a share of the time |y| / |y'|, or |v| / |a| + |q / a|^(1/2).

    `furthest`, `largest`, `fastest`: sizes of positions, of the quantity whose derivatives the slopes are, of slopes.
    """
    length = TUNING.first_share * end
    if second_order:
        if fastest > 0.0 and furthest + largest > 0.0:
            length = TUNING.first_share * (largest / fastest + math.sqrt(furthest / fastest))
    elif fastest > 0.0 and largest > 0.0:
        length = TUNING.first_share * largest / fastest
    return min(length, end)


def limit_growth(grow: float, rate: float, rounds: int) -> float:
    """The factor that the error allows, limited by the rate of convergence, which the first two rounds do not show."""
    return min(grow, TUNING.fast / rate) if rate > TUNING.fast and rounds > 2 else grow


def growth(grow: float, rejected: bool, equal: Equal) -> tuple[float, Equal]:
    """The factor by which equal steps grow, 1 for most.

    After the wanted number of equal steps they grow by the least factor that each of these allowed.
    """
    equal_steps, common_growth, wanted = equal
    more = 1.0
    if grow < TUNING.safety or rejected:
        equal_steps, common_growth = 0, TUNING.grow_most
    else:
        equal_steps, common_growth = equal_steps + 1, min(common_growth, grow)
    if equal_steps == wanted:
        more = common_growth if common_growth >= TUNING.least_growth else 1.0
        equal_steps, common_growth, wanted = 0, TUNING.grow_most, TUNING.many_steps
    return more, (equal_steps, common_growth, wanted)


def equal_length(step: float, grow: float, more: float, rejected: bool, equal: Equal) -> tuple[float, Equal]:
    """The next step: equal to this one as long as the error allows it and no step `hold` times as long.

    Then the step grows at once, by grow / `leap`. The usual case has its own branch, so that the step can start before `grow` is known.
    """
    if TUNING.safety <= grow < TUNING.hold:
        h = step * more
    elif grow >= TUNING.hold and rejected:
        h = step
    elif grow >= TUNING.hold:
        h, equal = step * min(grow / TUNING.leap, TUNING.grow_most), (0, TUNING.grow_most, equal[2])
    else:
        h = step * grow
    return h, equal


def no_frequency() -> Frequency:
    return False, 0.0, 0.0, 0.0, 1.0, 0, 0, math.inf, 0.0, math.inf, 0.0


def choose_frequency(
    step: float, grow: float, more: float, square: float, equal: Equal, seen: Frequency
) -> tuple[float, Equal, Frequency]:
    """Note the steps and strides that the error wants, and begin or end steps by frequency.

    After each failure the next trial waits for more windows. It fails if the frequency does not predict which steps
    must be short. Eighth powers of strides need no root. A step that is far too short gives no good estimate of the
    fitting step. `square`: the fourth power of the frequency at the end of the step.
    """
    by_frequency, stride, step_frequency, before, step_variation, windows_to_wait, steps, *ranges = seen
    shortest, longest, least_stride_8, largest_stride_8 = ranges
    if before > 0.0 and grow < TUNING.grow_most:
        fitting_step = step * grow
        fourth = (fitting_step * fitting_step) * (fitting_step * fitting_step)
        stride_8 = (fourth * before) * (fourth * square)
        shortest, longest = min(shortest, fitting_step), max(longest, fitting_step)
        least_stride_8, largest_stride_8 = min(least_stride_8, stride_8), max(largest_stride_8, stride_8)
        steps += 1
    whole = steps == TUNING.few_steps
    strides_vary = largest_stride_8 > min(step_variation, TUNING.hold) ** 8 * least_stride_8
    if by_frequency and (grow >= TUNING.grow_most or (whole and strides_vary)):
        by_frequency, windows_to_wait, whole = False, 2 * windows_to_wait + 1, True
    elif whole and not by_frequency and windows_to_wait > 0:
        windows_to_wait -= 1
    elif (
        whole
        and not by_frequency
        and longest > TUNING.hold * shortest
        and largest_stride_8 < (2 * longest / shortest) ** 8 * least_stride_8
    ):
        by_frequency, step_variation = True, longest / shortest
        stride, step_frequency = TUNING.stride_share * least_stride_8**0.125, math.sqrt(math.sqrt(square))
        equal, more = (0, TUNING.grow_most, equal[2]), 1.0
    if whole:
        steps, shortest, longest, least_stride_8, largest_stride_8 = 0, math.inf, 0.0, math.inf, 0.0
    by_now = by_frequency, stride, step_frequency, square, step_variation, windows_to_wait, steps
    return more, equal, (*by_now, shortest, longest, least_stride_8, largest_stride_8)


def length_by_frequency(step: float, grow: float, more: float, seen: Frequency) -> tuple[float, Frequency]:
    """The next step by frequency: the mean of 1/h before and after this point is its frequency over the stride."""
    by_frequency, stride, step_frequency, norm, *rest = seen
    frequency = math.sqrt(math.sqrt(norm))
    if grow < TUNING.safety:
        stride, step_frequency = stride * grow, frequency
    elif more > 1.0:
        stride, step_frequency = stride * more, frequency
    else:
        most = TUNING.most_frequency_change
        step_frequency = min(max(2 * frequency - step_frequency, frequency / most), most * frequency)
    seen = by_frequency, stride, step_frequency, norm, *rest  # type: ignore[assignment]
    return min(stride / step_frequency, TUNING.grow_most * step), seen


def restart(h: float, seen: Frequency) -> Frequency:
    """The strides after a step is repeated with the size h."""
    by_frequency, _, step_frequency, *rest = seen
    return (by_frequency, h * step_frequency, step_frequency, *rest)  # type: ignore[return-value]
