"""The steps of Gauss-Legendre methods: stages by fixed-point iteration, or by Newton's if that does not converge."""

from typing import Any

from gnomon.harness.integrators.base.linear import factor, substitute
from gnomon.harness.integrators.base.stepping import StepData, evaluate

MOST_ITERATIONS = 100


def gauss_step(s: StepData, t: Any, h: Any) -> bool:
    """One step for y' = f(t, y), with its stages solved by fixed-point iteration.

    Rows of `table`: for each stage c_j, a_j1 / b_1 ... a_js / b_s; for each stage 0 and the coefficients that
    extrapolate weighted slopes of the last steps; the unit round-off, b_1 ... b_s. `store` holds a flag, the weighted
    slopes b_j k_j, and the weighted slopes of the last steps, the latest first.

    The iteration ends when its next change would be far below round-off, or when round-off stops the changes from
    shrinking. If it ended earlier, it would leave an equal error in every step, and the energy would drift as t
    (Hairer, McLachlan, Razakarivony, BIT 48, 2008).
    """
    table, y, x, slope, store, increment = s.table, s.y, s.x, s.slope, s.store, s.increment
    stages = (table.shape[0] - 1) // 2
    weights = 2 * stages
    width = x.size
    second = width < y.size
    start_stages(s, t, stages)
    before, least, stalled, accepted, beyond = 0.0, 0.0, 0, 0, store[0, 0]
    for iteration in range(MOST_ITERATIONS):
        change = 0.0
        for j in range(stages):
            for i in range(width):
                total = sum_weighted(table, j, store, 1, i, stages)
                if second:
                    total = table[j, 0] * y[width + i] + h * total
                x[i] = y[i] + h * total
            evaluate(s, t + table[j, 0] * h)
            weight = table[weights, j + 1]
            for i in range(width):
                weighted_slope = weight * slope[i]
                difference = weighted_slope - store[j + 1, i]
                distance = abs(difference)
                if not distance <= LARGEST:
                    return False
                size = weight * abs(y[y.size - width + i]) + h * abs(weighted_slope)
                if h * distance > SMALLEST and h * distance > change * size:  # divides at each new maximum only
                    change = h * distance / size
                store[j + 1, i] = weighted_slope + beyond * difference
        beyond = 0.0
        stalled = stalled + 1 if change >= least else 0
        accepted = (
            accepted + 1 if accepted > 0 or has_settled(iteration, change, least, stalled, table[weights, 0]) else 0
        )
        if change == 0.0 or accepted > MORE_ROUNDS:
            for i in range(width):
                total = 0.0
                for j in range(stages):
                    total += store[j + 1, i]
                increment[y.size - width + i] = h * total
                if second:
                    increment[i] = h * (h * sum_weighted(table, weights + 1, store, 1, i, stages)) + h * y[width + i]
            return True
        if iteration > 1 and change > before and change > FAR:
            return False
        if iteration == 1:
            store[0, 0] = -store[0, 0]
        elif iteration == 2:
            store[0, 0] = as_far(store[0, 0], change / before)
        least = change if iteration == 0 else min(least, change)
        before = change
    return False


def start_stages(s: Any, t: Any, stages: int) -> None:
    """First guesses of the weighted slopes: the extrapolated polynomial through the weighted slopes of the last steps.

    In the first step the slope at t stands for the guesses and for all slopes of earlier steps. For the rows of `table` and
    `store` see `gauss_step`; `back` is the number of weighted slopes that are kept.
    """
    table, y, x, slope, store = s.table, s.y, s.x, s.slope, s.store
    width, back = x.size, table.shape[1] - 1
    if store[0, 0] == 0.0:
        store[0, 0] = FIRST_SIDE
        for i in range(width):
            x[i] = y[i]
        evaluate(s, t)
        for k in range(0, back + stages, stages):
            for j in range(stages):
                for i in range(width):
                    store[k + j + 1, i] = table[2 * stages, j + 1] * slope[i]
    else:
        for k in range(back + stages, stages, -1):
            for i in range(width):
                store[k, i] = store[k - stages, i]
        for j in range(stages):
            for i in range(width):
                store[j + 1, i] = sum_weighted(table, stages + j, store, stages + 1, i, back)


def as_far(beyond: Any, rate: Any) -> Any:
    """The share of its first change by which the iteration of the next step overshoots, with the sign of `beyond`.

    It is three times the remaining part of the change, so that the iteration converges from the other side.
    """
    share = max(3.0 * min(rate, 0.1), 1e-6)
    return share if beyond > 0.0 else -share


def sum_weighted(table: Any, row: int, k: Any, first: int, i: int, stages: int) -> Any:
    """The sum over the stages of the weights in a row of the table times column i of k, from row `first` on."""
    total = 0.0
    for m in range(stages):
        total += table[row, m + 1] * k[first + m, i]
    return total


def newton_step(s: StepData, t: Any, h: Any) -> bool:
    """One step for y' = f(t, y) or q'' = f(t, q), with its stages solved by Newton's iteration: for stiff equations.

    `call` computes the equations and, row by row, their derivatives. The unknowns are the differences z_j of the stages
    from the start, not the slopes, whose round-off stiffness magnifies (Hairer, Wanner, Solving Ordinary Differential
    Equations II, 1996, IV.8).

    Rows of `table`: for each stage c_j, a_j1 ... a_js, with the squared matrix for q'' = f(t, q); the unit round-off
    and the weights of the z_j in the change of the state; the rounding residuals of these weights; the factor of the
    velocity and the weights of the z_j / h in the change of the velocity; the rounding residuals of these weights; the
    residuals of the sums of a_j, or of c.

    `store` holds a flag, the z_j, slopes, right sides, pivots and factors of the whole system I - h a (x) df/dy. Steps
    keep the factors until the iteration converges slowly; then each stage evaluates its own derivatives. A third or
    later change larger than the state ends the iteration, which would usually converge to a solution far from the
    start.
    """
    table, y, x, slope, store, increment = s.table, s.y, s.x, s.slope, s.store, s.increment
    stages = table.shape[0] - 5
    width = x.size
    second = width < y.size
    size = stages * width
    flat = store.reshape(store.size)
    z, slopes, right = flat[1 : 1 + size], flat[1 + size : 1 + 2 * size], flat[1 + 2 * size : 1 + 3 * size]
    pivots = flat[1 + 3 * size : 1 + 4 * size]
    matrix = flat[1 + 4 * size : 1 + (4 + size) * size].reshape((size, size))
    length = h * h if second else h
    for k in range(size):
        z[k] = 0.0
    before, least, stalled = 0.0, 0.0, 0
    for iteration in range(MOST_ITERATIONS):
        renewed = flat[0] == 0.0
        for m in range(stages):
            for i in range(width):
                x[i] = y[i] + z[m * width + i]
            evaluate(s, t + table[m, 0] * h)
            for i in range(width):
                slopes[m * width + i] = slope[i]
                if renewed:
                    for j in range(stages):
                        for k in range(width):
                            partial = slope[width + i * width + k]
                            matrix[j * width + i, m * width + k] = -length * table[j, m + 1] * partial
        if renewed:
            for k in range(size):
                matrix[k, k] += 1.0
            if not factor(matrix, pivots):
                return False
            flat[0] = 1.0
        for j in range(stages):
            for i in range(width):
                total = 0.0
                for m in range(stages):
                    total += table[j, m + 1] * slopes[m * width + i]
                if second:
                    velocity = y[width + i]
                    total = table[j, 0] * velocity + (table[stages + 4, j] * velocity + h * total)
                else:
                    total += table[stages + 4, j] * slopes[j * width + i]
                right[j * width + i] = h * total - z[j * width + i]
        substitute(matrix, pivots, right)
        change = 0.0
        for j in range(stages):
            for i in range(width):
                n = j * width + i
                difference = abs(right[n])
                if not difference <= LARGEST:
                    return False
                z[n] += right[n]
                if difference > SMALLEST:
                    change = max(change, difference / (abs(y[i]) + abs(z[n])))
        stuck = iteration > 0 and renewed and before <= change < NOISE * table[stages, 0]
        stalled = stalled + 1 if change >= least else 0
        if has_settled(iteration, change, least, stalled, table[stages, 0]) or stuck:
            for i in range(width):
                total, weighted = 0.0, 0.0
                for j in range(stages):
                    total += table[stages + 1, j + 1] * z[j * width + i]
                    weighted += table[stages + 3, j + 1] * z[j * width + i]
                for j in range(stages):
                    total += table[stages, j + 1] * z[j * width + i]
                    weighted += table[stages + 2, j + 1] * z[j * width + i]
                increment[i] = total
                if second:
                    increment[width + i] = table[stages + 2, 0] * y[width + i] + weighted / h
            return True
        if iteration > 1 and change > 1.0:
            return False
        if iteration > 0 and change > SLOW * before:
            flat[0] = 0.0
        least = change if iteration == 0 else min(least, change)
        before = change
    return False


def newton_numbers(stages: int, width: int) -> int:
    """The number of doubles in the `store` of `newton_step`."""
    size = stages * width
    return 1 + (4 + size) * size


def has_settled(iteration: int, change: Any, least: Any, stalled: int, roundoff: Any) -> bool:
    """Whether the stages are as accurate as the arithmetic allows.

    `change` is the change of the last round, relative to the state, which is the residual of the stages before the
    round. `least` is the smallest earlier change; no change of the last `stalled` rounds was smaller. The stages are
    accepted if

    - the change is 0, or the next change would be far below round-off;
    - or the change is below CLOSE units of round-off and no longer shrinks;
    - or the change is below NOISE units and has not shrunk for STALLED_ROUNDS rounds: it is round-off of the equations,
      in which large terms cancel.

    A single round that shrinks little does not suffice: changes of an oscillation rise and fall.
    """
    if change == 0.0:
        return True
    if iteration == 0 or not change < NOISE * roundoff:
        return False
    if stalled > 0:
        return bool(change < CLOSE * roundoff or stalled >= STALLED_ROUNDS)
    return bool(change * change / least < FAR_BELOW * roundoff)


FAR_BELOW = 2e-6
"""The largest next change, in units of round-off, at which the iteration ends. The error that the iteration leaves is
biased: over 1e6 steps it must stay below the random walk of round-off. To end at a change of one unit does not suffice:
implicit midpoint lost or gained 0.025 units in each step of the oscillator."""

MORE_ROUNDS = 2
"""Rounds after acceptance. If rounding stops the changes from shrinking, the round in which this is detected depends on
the rounding itself, which biases the error of the stages. After this number of further rounds the error is not
biased."""

LARGEST = 1e300
"""The iteration ends if a slope, or a change of a stage, is larger than this or not a number."""

CLOSE, NOISE, STALLED_ROUNDS = 16.0, 1e6, 20
"""Limits in `has_settled`. Changes that shrink by a fifth in each round, the slowest that converge within MOST_ITERATIONS,
may pause for half of STALLED_ROUNDS."""

SMALLEST = 2.0**-1022
"""The smallest normal number: changes of the state up to it count as 0, so that a decaying motion can come to rest."""

FIRST_SIDE = 0.1
"""The share of its first change by which the first iteration overshoots. From step to step the iteration alternately
overshoots its first change and falls short of it: rounding stops an iteration on the side from which it comes, and this
side must differ between steps."""

FAR = 0.1
"""A third or later change ends the fixed-point iteration if it is larger than the change before it and than this part
of the state: the iteration does not contract, and could converge to a solution far from the start."""

SLOW = 0.1
"""Newton's iteration computes new factors if a change is more than this part of the change before it."""
