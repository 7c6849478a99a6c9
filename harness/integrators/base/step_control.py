"""The step-size controller of adaptive one-step methods, its limits, and the loop that embedded pairs share.

Extrapolation, Taylor's method and Radau IIA 5 use its limits, its reasons to stop and `solving`. They have their own
loops, for reasons that their modules give.

A family (`embedded`, `nystrom`) defines the parts of a step as plain functions. For each method the loop is compiled
around them once, with numbers of the method, such as its number of stages, as constants:

    attempt(s, t, h) -> whether the step has an end
    error_norm(s, h) -> norm of the estimated error
    open_step(s, t, h)                once in a step that contains samples
    between(s, t, h, ahead, out)      for each sample, at t + ahead

`s` is an `AttemptData`. For `groups` see `sizes`.
"""

import math
from abc import abstractmethod
from collections.abc import Callable
from decimal import Context, Decimal, localcontext
from functools import cache
from typing import Any, ClassVar, NamedTuple

import numpy as np
from gnomon.cases.core.forms import SecondOrder
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solution, Solver, Tolerance
from gnomon.harness.integrators.base.fixed_step import DIGITS, Loop, Table, round_table
from gnomon.harness.integrators.base.sizes import (
    SHORTEST,
    YOUNG,
    enlarge,
    enlarge_roundoff,
    first_sizes,
    forget,
    invert,
    limit_by_roundoff,
    perturb_by_roundoff,
    size_by_end,
    size_by_power,
    trial_step,
    turning_time,
)
from gnomon.harness.integrators.base.stepping import blank, call, compile_whole, evaluate
from gnomon.harness.integrators.base.tableau import ButcherTableau, NystromTableau
from gnomon.harness.kernels.equations import Kernel, acceleration, right_hand_side
from numpy.typing import NDArray

LEAST_TOLERANCE = 1e-15
"""About four units of round-off: no step can have a smaller error."""

MOST_STEPS = 5_000_000
"""A few seconds: with more steps the tolerance is too small for the span, or the equations are stiff."""

NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, NOT_SOLVED = 1, 2, 3, 4
REASONS = {
    NOT_FINITE: "the equations gave a value that is not finite",
    STEP_TOO_SMALL: "the step size fell below the spacing of times",
    TOO_MANY_STEPS: "more than {most} steps (stiff, or too small a tolerance for so long a span)",
    NOT_SOLVED: "the stages of a step did not converge",
}

SHRINK_MOST, GROW_MOST = 3.0, 6.0

SAFETY, BETA = 0.9, 0.04
"""Safety factor and integral part of the PI controller (Hairer, Norsett, Wanner, Solving Ordinary Differential
Equations I, II.4)."""

PREDICTIVE_ORDER, PREDICTIVE_SAFETY = 8, 0.8
"""From this order of the error on, steps are so long that on an eccentric orbit each step must be much shorter than the
last one: a controller that uses only the last error has a quarter of its steps rejected. So the change of the step size
that the last two errors require is extrapolated if it shrinks the step (Gustafsson's predictive controller, as in
RADAU5: Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8). At equal error this saves DOP853 and
Verner's 9(8) a fifth of their right-hand sides on Kepler's orbits, RKN 12(10) an eighth; the pendulum takes as many as
before. Methods of lower order have few rejected steps."""

ORDER = ERROR_ORDER = WIDTHS = STAGES = LAST = ENDS = BESIDE = 0
"""Set when a method is compiled. ORDER: its order; ERROR_ORDER: the power of the step size that its estimated error
follows; WIDTHS: the length of the state over the length of a slope; STAGES: the number of its stages; LAST: the number
of rows of `k`, in which k[STAGES] is the slope at the end of the step, the first of the next step; ENDS: 1 if the step
itself uses that slope; BESIDE: see `Adaptive.beside`."""


class Adaptive(Integrator):
    """A one-step method whose step size keeps the estimated error below the tolerance; sums are compensated.

    The error of each component is relative to the largest size that its group has had (`Problem.groups`, see `sizes`),
    so results do not depend on units. With `absolute` it is relative to 1 + |y| in SI units, as in most libraries: a
    motion of a millimetre then has, relative to its size, a thousand times the error. The norm of the error is the root
    mean square over the components. A subclass declares its tableau, the constants for its compilation, and the
    functions of its family.
    """

    sampling = "dense output"
    sweep = Tolerance(1e-3, 1e-14)
    takes = ("max_step", "first_step")
    absolute: ClassVar[bool] = False
    most_steps: ClassVar[int] = MOST_STEPS
    loop: ClassVar[Callable[..., int]]
    pieces: ClassVar[tuple[Callable[..., Any], ...]]
    tableau: ClassVar[ButcherTableau | NystromTableau]

    @classmethod
    def rows(cls, mp: Any) -> Table:
        """The table of coefficients, in the numbers of an mpmath context `mp` or of `Decimals`."""
        return cls.tableau.rows(mp)

    @classmethod
    @abstractmethod
    def constants(cls) -> dict[str, int]:
        """The names that the family's functions read as constants, with their values for this method."""

    def kernel(self, problem: Problem) -> Kernel:
        """The compiled equations, which give slopes and, after them, `beside` further numbers."""
        second = isinstance(problem.form, SecondOrder)
        return acceleration(problem) if second else right_hand_side(problem)

    def beside(self, problem: Problem) -> int:
        """The number of further numbers that the equations give after the slopes, for the functions of the family."""
        return 0

    def prepare(self, problem: Problem, setting: float) -> Solver:
        check_tolerance(setting)
        problem = problem.since_start()
        kernel = self.kernel(problem)
        numbers = ("MOST_STEPS", self.most_steps), ("ABSOLUTE", int(self.absolute)), ("BESIDE", self.beside(problem))
        run = compile_whole(
            type(self).loop, SIGNATURE, (*self.constants().items(), *numbers), self.pieces, unrolled=False
        )
        table = _table(type(self))
        address, buffer, times = kernel.address, problem.buffer, problem.times
        groups, limits = problem.grouping, limits_of(self, problem)

        def loop(initial: Floats, out: Floats, stop: NDArray[np.int64]) -> int:
            return run(address, buffer, table, initial, times, setting, groups, limits, out, stop)

        return solving(problem, loop, self.most_steps)


@cache
def _table(method: type[Adaptive]) -> Floats:
    return tabulate(method.rows)


class Decimals:
    """Stands for an mpmath context in tables of decimals and fractions, with Decimal numbers: a tenth of the time."""

    mpf, zero, fsum = Decimal, Decimal(0), sum


def tabulate(rows: Callable[[Any], Table]) -> Floats:
    """The coefficients in binary64, rounded once from `DIGITS` digits."""
    with localcontext(Context(prec=DIGITS)):
        return round_table(rows(Decimals), float)


def check_tolerance(setting: float, least: float = LEAST_TOLERANCE) -> None:
    """Raise Refused for a tolerance that is not a number from `least` to below 1."""
    if not (math.isfinite(setting) and least <= setting < 1):
        raise Refused(f"tolerance {setting} is not between {least:g} and 1")


def solving(problem: Problem, loop: Loop, most_steps: int) -> Solver:
    """The solver of an adaptive method, around its loop of steps.

    The loop writes the reason and the sample of the first early end into `stop`.
    """

    def solve(initial: Floats) -> Solution:
        out = blank(problem, initial)
        stop = np.zeros(2, dtype=np.int64)
        steps = loop(initial, out, stop)
        why = f"{REASONS[int(stop[0])].format(most=most_steps)}, before sample {stop[1] + 1}" if stop[0] else None
        return Solution(out, int(steps), why)

    return Solver(solve)


SIGNATURE = "int float[1] float[2] float[2] float[1] float int[1] float[1] float[3] int[1]"

SCALE, MOST, FIRST = 0, 1, 2
"""Fields of `limits`: the time scale of the problem, the longest step, the first step (0: the method chooses it)."""


def limits_of(integrator: Integrator, problem: Problem) -> Floats:
    """The array `limits` of a loop of steps."""
    return np.array([problem.time_scale, integrator.max_step, integrator.first_step or 0.0])


class AttemptData(NamedTuple):
    """The equations, numbers and arrays of an attempt at a step. For those that are not explained here see `StepData`.

    The order of the fields is the order of arguments in the emitted code: in another order some pairs took a tenth longer.
    """

    f: Any
    y: Floats
    compensation: Floats
    """The part of the sums up to `y` that round-off removed."""
    p: Floats
    table: Floats
    x: Floats
    slope: Floats
    k: Floats
    """The slopes of the stages; k[STAGES] at the end of the step."""
    change: Floats
    """The change of the state in the step, with `compensation`."""
    end: Floats
    """The state at the end of the step."""
    spare: Floats
    """As long as the state, for the functions of the family."""
    inverse: Floats
    """What errors are multiplied by, see `sizes`."""


def of_the_family(*_: Any) -> Any:
    """A placeholder, which compilation of a method replaces by a function of the family."""
    raise NotImplementedError


attempt = error_norm = open_step = between = of_the_family


def integrate(
    f: Any, p: Floats, table: Floats, initial: Floats, times: Floats, tolerance: float, groups: NDArray[np.int64],
    limits: Floats, out: Floats, stop: NDArray[np.int64],
) -> int:  # fmt: skip
    """Integrate each of `initial` (n, dim) into `out` (n, len(times), dim); returns the number of steps accepted.

    `stop` gets the reason and the sample of the first early end.
    """
    dimension = initial.shape[1]
    width = dimension // WIDTHS
    y, compensation, end = np.empty(dimension), np.empty(dimension), np.empty(dimension)
    change, spare = np.empty(dimension), np.empty(dimension)
    x, slope, k = np.empty(width), np.empty(width + BESIDE), np.empty((LAST, width))
    sizes, inverse, rough = np.empty(dimension), np.empty(dimension), np.zeros(dimension)
    s = AttemptData(f, y, compensation, p, table, x, slope, k, change, end, spare, inverse)
    young = np.zeros((YOUNG, dimension))
    taken, shortest = 0, SHORTEST * min(times[-1], limits[SCALE])
    for n in range(initial.shape[0]):
        y[:] = initial[n]
        compensation[:] = 0.0
        t, sample, attempts = 0.0, 0, 0
        h = first_step(s, k, tolerance, min(times[-1], limits[SCALE]), groups)
        if limits[FIRST] > 0.0 and h > 0.0:
            h = limits[FIRST]
        before, last = 1e-4, 0.0
        rejected, noisy, moved, fresh = False, False, False, True
        forget(young)
        rough[:] = 0.0
        reason = 0
        while sample < times.size:
            attempts += 1
            reason = obstacle(t, h, attempts)
            if reason != 0:
                break
            # The step is h, rounded so that t + step is exact; the last step ends at the last sample.
            h = min(h, limits[MOST])
            step = times[-1] - t if t + h >= times[-1] else (t + h) - t
            if fresh:
                for i in range(dimension):
                    change[i] = step * (k[0, i - dimension + width] if i >= dimension - width else y[width + i])
                first_sizes(y, change, groups, sizes, inverse)
            elif noisy or moved:
                invert(groups, sizes, inverse)
            ready = attempt(s, t, step)
            moved = size_by_end(step, end, groups, inverse, young)
            if noisy:
                limit_by_roundoff(step / tolerance, groups, rough, inverse)
            error = error_norm(s, step) / tolerance if ready else np.inf
            if not error < np.inf:
                h = min(h, step) / 10
                rejected = True
                continue
            if error > 1.0:
                perturb_by_roundoff(y, x)
                evaluate(s, t)
                enlarge_roundoff(k[0], slope, dimension - width, groups, rough)
                noisy = limit_by_roundoff(step / tolerance, groups, rough, inverse) or noisy
                h = min(h, step) * (1 / SHRINK_MOST if moved else max(1 / SHRINK_MOST, shorten(error)))
                if moved and h < shortest:
                    h, fresh = size_by_power(groups, sizes, young), False
                rejected = True
                continue
            if not arrive(s, t + step):
                reason = NOT_FINITE
                break
            if times[sample] <= t + step:
                open_step(s, t, step)
                while sample < times.size and times[sample] <= t + step:
                    between(s, t, step, times[sample] - t, out[n, sample])
                    sample += 1
            if enlarge(end, groups, sizes) or t == 0.0:
                invert(groups, sizes, inverse)
            forget(young)
            moved = fresh = False
            taken += 1
            t += step
            for i in range(dimension):
                compensation[i] = change[i] - (end[i] - y[i])
                y[i] = end[i]
            for i in range(width):
                k[0, i] = k[STAGES, i]
            factor = max(1 / SHRINK_MOST, min(GROW_MOST, lengthen(error, before, step, last)))
            h = step * (min(1.0, factor) if rejected else factor)
            before, last = max(error, 1e-4), step
            rejected = False
        if reason != 0 and stop[0] == 0:
            stop[0] = reason
            stop[1] = sample
    return taken


def obstacle(t: float, h: float, attempts: int) -> int:
    """The reason that forbids a step of about h from t; 0 if the step is possible."""
    if not (h > 0.0 and h < np.inf):
        return NOT_FINITE
    if t + h / 4 <= t:
        return STEP_TOO_SMALL
    return TOO_MANY_STEPS if attempts > MOST_STEPS else 0


def first_step(s: Any, k: Floats, tolerance: float, most: float, groups: NDArray[np.int64]) -> float:
    """The first step size, at which the error (step / time)^ORDER is a hundredth of the tolerance.

    `time` is the time in which the motion leaves its tangent. Sets k[0]; gives nan if the slope at the start is not
    finite.
    """
    y, x, slope = s.y, s.x, s.slope
    first = y.size - x.size
    rates, later = np.empty(y.size), np.empty(y.size)
    call(s.f, 0.0, y, s.p, slope)
    for i in range(x.size):
        k[0, i] = slope[i]
        if not abs(slope[i]) < np.inf:
            return np.nan
    for i in range(y.size):
        rates[i] = y[x.size + i] if i < first else slope[i - first]
    h = trial_step(y, rates, groups, most)
    for i in range(x.size):
        x[i] = y[i] + h * rates[i]
    evaluate(s, h)
    for i in range(y.size):
        later[i] = rates[i] + h * k[0, i] if i < first else slope[i - first]
    time = turning_time(y, rates, later, h, groups, most)
    return time * (0.01 * tolerance) ** (1 / ORDER) if time > 0.0 else h


def end_slope(s: AttemptData, t: float) -> None:
    """Compute the slope at the end of a step.

    The equations are called at a copy of `end`: with a call at `end` itself RKN 6(4) takes 40 % longer, Dormand and
    Prince's 5(4) 5 to 20 %.
    """
    for i in range(s.x.size):
        s.x[i] = s.end[i]
    evaluate(s, t)
    for i in range(s.x.size):
        s.k[STAGES, i] = s.slope[i]


def arrive(s: AttemptData, t: float) -> bool:
    """Compute the slope at the end of an accepted step, if the step has not; returns whether the slope is finite."""
    if ENDS == 0:
        end_slope(s, t)
    finite = True
    for i in range(s.x.size):
        if not abs(s.k[STAGES, i]) < np.inf:
            finite = False
    return finite


def shorten(error: float) -> float:
    """The factor from a rejected step to the next attempt. `error`: its error over the tolerance, above 1."""
    if ERROR_ORDER >= PREDICTIVE_ORDER:
        return float(PREDICTIVE_SAFETY * error ** (-1 / ERROR_ORDER))
    return float(SAFETY * error ** (0.2 * BETA - 1 / ERROR_ORDER))


def lengthen(error: float, before: float, step: float, last: float) -> float:
    """The factor from an accepted `step` to the next step.

    `error`, `before`: the errors of this and the last step over the tolerance; `last`: the size of the last step, 0 if
    there is none.
    """
    if ERROR_ORDER < PREDICTIVE_ORDER:
        return float(SAFETY * error ** (0.2 * BETA - 1 / ERROR_ORDER) * before**BETA)
    least = max(error, 1e-4)
    factor = PREDICTIVE_SAFETY * least ** (-1 / ERROR_ORDER)
    if last > 0.0:
        factor *= max(0.5, min(1.0, step / last * (before / least) ** (1 / ERROR_ORDER)))
    return float(factor)


Adaptive.loop = integrate
