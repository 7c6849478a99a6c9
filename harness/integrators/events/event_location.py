"""Event location: the length of an explicit Runge-Kutta step at which a guard crosses zero, by root finding."""

from math import sqrt

from gnomon.harness.contract.integrator import Floats
from gnomon.harness.integrators.base.stepping import call

MOST_TRIALS = 30
DEEP = 0.5
"""For a guard that falls and rises again within a step: the largest number of evaluations in search of its minimum. The
search goes on only while interpolation predicts a minimum below DEEP times the values at the ends."""

ERROR_5, ERROR_3 = 16, 17
"""Rows of the table of DOP853 with the weights of its error estimates."""


def part(parts: int, k: int, t: float, y: Floats, p: Floats, out: Floats) -> None:
    """Evaluate function k of a hybrid form into `out`; `parts`: the address of its functions (see `compile_parts`)."""
    out[0] = k
    call(parts, t, y, p, out)


def one_step(
    parts: int, mode: int, t: float, h: float, y: Floats, p: Floats, table: Floats, stages: int, x: Floats, k: Floats,
    out: Floats,
) -> None:  # fmt: skip
    """One explicit Runge-Kutta step. Rows of `table`: c_j, a_j1, ... for each stage, then 1, b_1, ..."""
    for j in range(stages):
        for i in range(y.size):
            total = 0.0
            for n in range(j):
                total += table[j, n + 1] * k[n, i]
            x[i] = y[i] + h * total
        part(parts, mode, t + table[j, 0] * h, x, p, k[j])
    for i in range(y.size):
        total = 0.0
        for n in range(stages):
            total += table[stages, n + 1] * k[n, i]
        out[i] = y[i] + h * total


def guard_after(
    parts: int, guard: int, mode: int, t: float, h: float, y: Floats, p: Floats, table: Floats, stages: int,
    x: Floats, k: Floats, out: Floats,
) -> float:  # fmt: skip
    """A guard's value at the end of a step; the state there goes to `out`."""
    one_step(parts, mode, t, h, y, p, table, stages, x, k, out)
    part(parts, guard, t + h, out, p, x)
    return float(x[0])


def step_error(h: float, table: Floats, stages: int, k: Floats, inverse: Floats) -> float:
    """The norm of the estimated error of a step, relative to `sizes` (Hairer, Norsett, Wanner II.10.17)."""
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


def locate(
    parts: int, guard: int, mode: int, t: float, h: float, before: float, after: float, y: Floats, p: Floats,
    table: Floats, stages: int, x: Floats, k: Floats, out: Floats,
) -> float:  # fmt: skip
    """The step length in (0, h] at which a guard crosses zero, to round-off (Chandrupatla 1997).

    `before` >= 0 and `after` <= 0 are the guard's values at the steps 0 and h. A guard that is zero at 0 rises first: the
    bracket is halved until the guard is positive at its lower end. `one_step` computes the states in between from y; the
    state at the last step that was tried is left in `out`.
    """
    low, high = 0.0, h
    while before <= 0.0:
        middle = 0.5 * (low + high)
        value = guard_after(parts, guard, mode, t, middle, y, p, table, stages, x, k, out)
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
        value = guard_after(parts, guard, mode, t, now, y, p, table, stages, x, k, out)
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


def dip(
    parts: int, guard: int, mode: int, t: float, h: float, before: float, after: float, y: Floats, end: Floats,
    p: Floats, table: Floats, stages: int, x: Floats, k: Floats, there: Floats, slope: Floats,
) -> float:  # fmt: skip
    """A step length in (0, h) at which a guard that is positive at both ends is not positive; 0 if there is none.

    A guard that falls at the start of a step and rises at its end has a minimum in between, which cubic interpolation
    brackets. Steps are evaluated only while the cubic falls below DEEP times its values at the ends.
    """
    low, low_value, low_slope = 0.0, before, guard_slope(parts, guard, t, h, y, before, k[0], p, x, there)
    if not low_slope < 0.0:
        return 0.0
    part(parts, mode, t + h, end, p, slope)
    high, high_value, high_slope = h, after, guard_slope(parts, guard, t + h, h, end, after, slope, p, x, there)
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
        value = guard_after(parts, guard, mode, t, now, y, p, table, stages, x, k, there)
        if value <= 0.0:
            return now
        if abs(value - lowest) <= 0.1 * value:
            return 0.0
        part(parts, mode, t + now, there, p, slope)
        found = guard_slope(parts, guard, t + now, h, there, value, slope, p, x, slope)
        if found < 0.0:
            low, low_value, low_slope = now, value, found
        else:
            high, high_value, high_slope = now, value, found
    return 0.0


def guard_slope(
    parts: int, guard: int, t: float, h: float, y: Floats, value: float, slope: Floats, p: Floats, x: Floats,
    there: Floats,
) -> float:  # fmt: skip
    """The rate of a guard along the motion, by a difference over a millionth of a step. `there` may be `slope`."""
    small = h * 2.0**-20
    for i in range(y.size):
        there[i] = y[i] + small * slope[i]
    part(parts, guard, t + small, there, p, x)
    return float(x[0] - value) / small
