"""Event location: the length of an explicit Runge-Kutta step at which a guard crosses zero, by root finding."""

from math import sqrt
from typing import Any, NamedTuple

from gnomon.harness.contract.integrator import Floats
from gnomon.harness.integrators.base.stepping import call

MOST_TRIALS = 30
DEEP = 0.5
"""For a guard that falls and rises again within a step: the largest number of evaluations in search of its minimum. The
search goes on only while interpolation predicts a minimum below DEEP times the smaller value at the ends."""

ERROR_5, ERROR_3 = 16, 17
"""Rows of the table of DOP853 with the weights of its error estimates."""


class EventData(NamedTuple):
    """The equations, numbers and arrays of a step that may end at an event."""

    parts: Any
    """The address of the functions of the hybrid form, see `compile_parts`."""
    y: Floats
    """The state at the start of the step."""
    p: Floats
    table: Floats
    """Rows: c_j, a_j1, ... for each stage, then 1, b_1, ..."""
    stages: int
    x: Floats
    """The arguments or the result of a function of the form."""
    k: Floats
    """The slopes of the stages."""
    end: Floats
    """The state at the end of the step."""
    there: Floats
    slope: Floats
    """The state, and its slope, within the step."""


def part(s: EventData, k: int, t: float, y: Floats, out: Floats) -> None:
    """Evaluate function k of a hybrid form into `out`."""
    out[0] = k
    call(s.parts, t, y, s.p, out)


def one_step(s: EventData, mode: int, t: float, h: float, out: Floats) -> None:
    """One explicit Runge-Kutta step; the state at its end goes to `out`."""
    table, stages, y, x, k = s.table, s.stages, s.y, s.x, s.k
    for j in range(stages):
        for i in range(y.size):
            total = 0.0
            for n in range(j):
                total += table[j, n + 1] * k[n, i]
            x[i] = y[i] + h * total
        part(s, mode, t + table[j, 0] * h, x, k[j])
    for i in range(y.size):
        total = 0.0
        for n in range(stages):
            total += table[stages, n + 1] * k[n, i]
        out[i] = y[i] + h * total


def guard_after(s: EventData, guard: int, mode: int, t: float, h: float, out: Floats) -> float:
    """A guard's value at the end of a step; the state there goes to `out`."""
    one_step(s, mode, t, h, out)
    part(s, guard, t + h, out, s.x)
    return float(s.x[0])


def step_error(s: EventData, h: float, inverse: Floats) -> float:
    """The norm of the estimated error of a step, relative to `sizes` (Hairer, Norsett, Wanner II.10.17)."""
    table, stages, k = s.table, s.stages, s.k
    fifth, third = 0.0, 0.0
    for i in range(inverse.size):
        a, b = 0.0, 0.0
        for n in range(stages):
            a += table[ERROR_5, n + 1] * k[n, i]
            b += table[ERROR_3, n + 1] * k[n, i]
        fifth += (a * inverse[i]) ** 2
        third += (b * inverse[i]) ** 2
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return float(h * fifth / sqrt((fifth + 0.01 * third) * inverse.size))


def locate(s: EventData, guard: int, mode: int, t: float, h: float, before: float, after: float) -> float:
    """The step length in (0, h] at which a guard crosses zero, to round-off (Chandrupatla 1997).

    `before` >= 0 and `after` <= 0 are the guard's values at the steps 0 and h. A guard that is zero at 0 rises first: the
    bracket is halved until the guard is positive at its lower end. The state at the last step that was tried is left in
    `s.end`.
    """
    low, high = 0.0, h
    while before <= 0.0:
        middle = 0.5 * (low + high)
        value = guard_after(s, guard, mode, t, middle, s.end)
        if value > 0.0:
            low, before = middle, value
        else:
            high, after = middle, value
            if high < 1e-18 * h:
                return high
    a, fa, b, fb = high, after, low, before
    c, fc = a, fa
    fraction = 0.5
    for _ in range(200):
        now = a + fraction * (b - a)
        value = guard_after(s, guard, mode, t, now, s.end)
        if (value > 0.0) == (fa > 0.0):
            c, fc = a, fa
        else:
            c, fc = b, fb
            b, fb = a, fa
        a, fa = now, value
        best = a if abs(fa) < abs(fb) else b
        if fa == 0.0 or fb == 0.0:
            return best
        least = 2.0**-52 * best / abs(b - a)
        if not least < 0.5:
            return best
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
        if phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi:
            fraction = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        else:
            fraction = 0.5
        fraction = min(1.0 - least, max(least, fraction))
    return a


def dip(s: EventData, guard: int, mode: int, t: float, h: float, before: float, after: float) -> float:
    """A step length in (0, h) at which a guard that is positive at both ends is not positive; 0 if there is none.

    A guard that falls at the start of a step and rises at its end has a minimum in between, which cubic interpolation
    brackets. Steps are evaluated only while the cubic falls below DEEP times the smaller value at the ends, and until a
    value is within a tenth of the one predicted.
    """
    there, slope = s.there, s.slope
    low, low_value, low_slope = 0.0, before, guard_slope(s, guard, t, h, s.y, before, s.k[0], there)
    if not low_slope < 0.0:
        return 0.0
    part(s, mode, t + h, s.end, slope)
    high, high_value, high_slope = h, after, guard_slope(s, guard, t + h, h, s.end, after, slope, there)
    if not high_slope > 0.0:
        return 0.0
    for _ in range(MOST_TRIALS):
        width = high - low
        bend = low_slope + high_slope - 3.0 * (high_value - low_value) / width
        root = sqrt(bend * bend - low_slope * high_slope)
        u = 1.0 - (high_slope + root - bend) / (high_slope - low_slope + 2.0 * root)
        lowest = (1.0 - u) ** 2 * ((1.0 + 2.0 * u) * low_value + u * width * low_slope)
        lowest += u * u * ((3.0 - 2.0 * u) * high_value - (1.0 - u) * width * high_slope)
        now = low + u * width
        if not (lowest <= DEEP * min(low_value, high_value) and low < now < high):
            return 0.0
        value = guard_after(s, guard, mode, t, now, there)
        if value <= 0.0:
            return now
        if abs(value - lowest) <= 0.1 * value:
            return 0.0
        part(s, mode, t + now, there, slope)
        rate = guard_slope(s, guard, t + now, h, there, value, slope, slope)
        if rate < 0.0:
            low, low_value, low_slope = now, value, rate
        else:
            high, high_value, high_slope = now, value, rate
    return 0.0


def guard_slope(
    s: EventData, guard: int, t: float, h: float, y: Floats, value: float, slope: Floats, there: Floats
) -> float:
    """The rate of a guard along the motion, by a difference over a millionth of a step. `there` may be `slope`."""
    small = h * 2.0**-20
    for i in range(y.size):
        there[i] = y[i] + small * slope[i]
    part(s, guard, t + small, there, s.x)
    return float(s.x[0] - value) / small
