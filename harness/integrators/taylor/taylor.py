"""Taylor's method: order and step size from the tolerance, coefficients from the case's own equations."""

import math
from math import exp, log
from typing import Any

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solver, Tolerance
from gnomon.harness.integrators.base.step_control import (
    MOST,
    MOST_STEPS,
    NOT_FINITE,
    SCALE,
    STEP_TOO_SMALL,
    TOO_MANY_STEPS,
    check_tolerance,
    limits_of,
    solving,
)
from gnomon.harness.integrators.base.stepping import call, compile_whole
from gnomon.harness.integrators.taylor.recurrences import STRIDE, recurrences_kernel
from numpy.typing import NDArray

LEAST_TOLERANCE = 1e-16
"""The unit round-off."""


class Taylor(Integrator):
    """Taylor's method, order and step from the tolerance (Jorba and Zou, Experimental Mathematics 14, 2005). Order 20.

    The order is 1 + ln(1/tolerance)/2, rounded up; the declared order is the order at 1e-16. Coefficients come from
    recurrences (automatic differentiation) made from the equations. The remainder is relative to the largest size
    that each component has had. Sums are compensated. Right-hand sides are not called one by one, so they are not
    counted.
    """

    name, order = "Taylor", 20
    accepts = (FirstOrder,)
    sampling = "dense output"
    sweep = Tolerance(1e-3, 1e-16)
    takes = ("max_step",)
    counts_rhs = False

    def prepare(self, problem: Problem, setting: float) -> Solver:
        check_tolerance(setting, LEAST_TOLERANCE)
        problem = problem.since_start()
        assert isinstance(problem.form, FirstOrder)
        try:
            kernel = recurrences_kernel(problem.form, problem.dimension, len(problem.parameters))
        except ValueError as error:
            raise Refused(str(error)) from None
        address, length = kernel.address, kernel.sizes[2]
        run = compile_whole(integrate, SIGNATURE)
        order, limits = order_for(setting), limits_of(self, problem)
        parameters, times = problem.parameters, problem.times

        def loop(initial: Floats, out: Floats, stop: NDArray[np.int64]) -> int:
            return run(address, parameters, initial, times, order, length, limits, out, stop)

        return solving(problem, loop, MOST_STEPS)


def order_for(tolerance: float) -> int:
    """The order p of least work for a tolerance (Jorba and Zou, equation 10): the remainder is then e^-2p."""
    return max(3, math.ceil(1 - math.log(tolerance) / 2))


SIGNATURE = "int float[1] float[2] float[1] int int float[1] float[3] int[1]"


def integrate(
    f: Any, p: Floats, initial: Floats, times: Floats, order: int, length: int, limits: Floats, out: Floats,
    stop: NDArray[np.int64],
) -> int:  # fmt: skip
    """Integrate from each of `initial` (n, dim) to all `times`, into `out` (n, len(times), dim): the number of steps.

    `f` is the address of the recurrences. From `x`, the state and the order, they compute the Taylor coefficients `w`
    (length,): w[STRIDE * i + k] is the coefficient of order k of component i. `stop` gets the reason and the sample of the
    first early end.

    The loop of `step_control` does not fit: the coefficients of a step give its size before it is taken, so no error is
    estimated after a step, and no step is rejected.
    """
    dimension = initial.shape[1]
    y, compensation, sizes = np.empty(dimension), np.empty(dimension), np.empty(dimension)
    x, w = np.empty(dimension + 1), np.zeros(length)
    # The step over the radius of convergence: e^-2 leaves a remainder of e^-2p; the rest is Jorba and Zou's safety factor.
    safety = exp(-2.0 - 0.7 / (order - 1))
    taken = 0
    for n in range(initial.shape[0]):
        y[:] = initial[n]
        compensation[:] = 0.0
        t, sample, steps, reason = 0.0, 0, 0, 0
        while sample < times.size:
            for i in range(dimension):
                x[i] = y[i]
            x[dimension] = order
            call(f, t, x, p, w)
            if steps == 0:
                start_sizes(w, order, limits[SCALE], y, sizes)
            enlarge_sizes(w, order, limits[SCALE], y, sizes)
            h = min(times[-1] - t, step_size(w, order, safety, t, limits, sizes))
            # The step is h, rounded so that t + step is exact; the last step ends at the last sample.
            step = times[-1] - t if t + h >= times[-1] else (t + h) - t
            reason = find_reason(w, order, dimension, step, steps)
            if reason != 0:
                break
            end = times[-1] if t + h >= times[-1] else t + step
            while sample < times.size and times[sample] <= end:
                for i in range(dimension):
                    out[n, sample, i] = y[i] + (compensation[i] + polynomial(w, STRIDE * i, order, times[sample] - t))
                sample += 1
            for i in range(dimension):
                change = compensation[i] + polynomial(w, STRIDE * i, order, step)
                updated = y[i] + change
                compensation[i] = change - (updated - y[i])
                y[i] = updated
            steps += 1
            t = end
        taken += steps
        if reason != 0 and stop[0] == 0:
            stop[0], stop[1] = reason, sample
    return taken


def step_size(w: Floats, order: int, safety: float, t: float, limits: Floats, sizes: Floats) -> Any:
    """The step size from the radii of convergence, estimated by the coefficients of the last two orders over the sizes.

    A component at zero whose coefficients are all 0 may still move later, or as a power of time above the order. Until it
    does, a step is at most the time so far, or `safety` times a time scale if this is longer.
    """
    lower, upper, is_at_rest = 0.0, 0.0, False
    for i in range(sizes.size):
        is_at_rest = is_at_rest or sizes[i] == 0.0
        if sizes[i] > 0.0:
            lower = max(lower, abs(w[STRIDE * i + order - 1]) / sizes[i])
            upper = max(upper, abs(w[STRIDE * i + order]) / sizes[i])
    h = min(limits[MOST], safety * min(radius(lower, order - 1), radius(upper, order)))
    if is_at_rest:
        h = min(h, max(t, safety * limits[SCALE]))
    return h


def find_reason(w: Floats, order: int, dimension: int, step: float, steps: int) -> int:
    """The reason to end a trajectory before a step, after `steps` steps; 0 if there is none."""
    reason = 0
    for i in range(dimension):
        if not (abs(w[STRIDE * i + order]) < np.inf and abs(w[STRIDE * i + order - 1]) < np.inf):
            reason = NOT_FINITE
    if steps >= MOST_STEPS:
        reason = TOO_MANY_STEPS
    if step <= 0.0:
        reason = STEP_TOO_SMALL
    return reason


def enlarge_sizes(w: Floats, order: int, time_scale: float, y: Floats, sizes: Floats) -> None:
    """Raise `sizes` (dim,) to the largest values of the components so far; 0 only for components that never moved."""
    for i in range(y.size):
        sizes[i] = max(sizes[i], abs(y[i]))
        if sizes[i] == 0.0:
            sizes[i] = size_from_zero(w, STRIDE * i, order, time_scale)


def start_sizes(w: Floats, order: int, time_scale: float, y: Floats, sizes: Floats) -> None:
    """Set the first `sizes` (dim,): the change of each component within the radius of convergence, for starts at zero.

    The radius is estimated from the components that do not start at zero, and is at most a time scale. At the
    pericentre of a long ellipse the radius is far shorter: the acceleration there times a time scale would exceed every
    velocity. If all components start at zero, they have no first sizes.
    """
    upper, elsewhere = 0.0, False
    for i in range(y.size):
        if y[i] != 0.0:
            upper, elsewhere = max(upper, abs(w[STRIDE * i + order] / y[i])), True
    reach = min(time_scale, radius(upper, order)) if elsewhere else 0.0
    for i in range(y.size):
        sizes[i] = reach * abs(w[STRIDE * i + 1])


def size_from_zero(w: Floats, first: int, order: int, time_scale: float) -> float:
    """The size of a component at zero: its leading term at the time at which a later term is as large.

    This time is at most a time scale. The size is 0 if all coefficients are 0.
    """
    lowest = 1
    while lowest < order and w[first + lowest] == 0.0:
        lowest += 1
    leading, reach = abs(w[first + lowest]), time_scale
    if leading == 0.0:
        return 0.0
    for k in range(lowest + 1, order + 1):
        ratio = abs(w[first + k]) / leading
        if 0.0 < ratio < np.inf:
            reach = min(reach, radius(ratio, k - lowest))
    return float(leading * reach**lowest)


def radius(coefficient: float, power: int) -> float:
    """coefficient ** (-1 / power), infinite for 0.

    The binary exponent is treated first, so that the result scales exactly with a unit of time that is a power of two.
    """
    if not 0.0 < coefficient < np.inf:
        return float(np.inf if coefficient == 0.0 else np.nan)
    whole = np.floor(np.log2(coefficient) / power)
    return float(exp(-log(coefficient * 2.0 ** (-whole * power)) / power) * 2.0**-whole)


def polynomial(w: Floats, first: int, order: int, h: float) -> float:
    """The sum of w[first + k] h^k over k = 1 to `order`: the change of a component over h."""
    total = 0.0
    for k in range(order, 0, -1):
        total = (total + w[first + k]) * h
    return total


INTEGRATORS: tuple[type[Integrator], ...] = (Taylor,)
