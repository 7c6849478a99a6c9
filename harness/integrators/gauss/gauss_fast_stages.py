"""The stages of one step of the fast Gauss method: fixed-point iteration, accelerated by derivatives.

The iteration solves f = f(t + c h, y + h A f), or a = a(t + c h, q + h c v + h^2 A^2 a). Each component has one vector,
with the eight stages in its eight lanes. The functions run on arrays of NumPy; `gauss_fast_kernel` compiles them.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar

from gnomon.harness.integrators.gauss import constants
from gnomon.harness.integrators.gauss.constants import TUNING
from gnomon.harness.integrators.gauss.gauss_fast_layout import Equations
from gnomon.harness.integrators.gauss.lanes import (
    Lanes,
    Table,
    fma,
    fuse,
    lane,
    lanes,
    minus,
    products,
    row,
    total,
    totals,
    with_lane,
)

Vectors = tuple[Lanes, ...]
Numbers = tuple[float, ...]
T = TypeVar("T", float, Lanes)


class Start(NamedTuple):
    """The start of a step of length h. Vectors in place of numbers: eight trajectories."""

    t: float
    h: float
    y: Any
    compensation: Any
    """The part of the sums up to `y` that round-off removed."""


class Accuracy(NamedTuple):
    """The accuracy of the stages of a step. Changes are sums over all stages and components."""

    change_weight: Any
    """The weight of each component in a change."""
    allowed_change: float
    noise: float
    """The changes that round-off makes."""
    assumed_rate: float
    """The least rate of convergence of the next round."""
    exactly: bool
    """Whether the residuals of all sums are carried."""


def rates(equations: Equations, y: tuple[T, ...]) -> tuple[T, ...]:
    """The quantity whose time derivatives the slopes are: the velocity, or the state of first-order equations."""
    return y[equations.count :] if equations.second_order else y


# Sums over the stages --------------------------------------------------------------------------------------------------


def sums(equations: Equations, f: Vectors, table: Table, first: int, once: int) -> tuple[Vectors, Vectors]:
    """A f, or A^2 a, and A a if the equations need velocities. `first` and `once`: first rows of the matrices."""
    p = products(table, first, f)
    return p, products(table, once, f) if equations.with_velocity else p


def weight(f: Lanes, table: Table, weights: int) -> Lanes:
    """Slopes times weights, with the rounding residuals of the weights."""
    return fma(f, row(table, weights), f * row(table, weights + constants.LOW))


def weight_exactly(f: Lanes, splitter: float, table: Table, weights: int) -> tuple[float, float]:
    """The sum of slopes times weights in two parts.

    Adding and subtracting the much larger splitter leaves so few bits of each lane that the sum of the lanes is exact.
    """
    w = row(table, weights)
    parts = f * w
    high = minus(parts + lanes(splitter), lanes(splitter))
    return total(high), total(minus(parts, high) + fma(f, row(table, weights + constants.LOW), fma(f, w, -parts)))


def add_exactly(y: T, change: T) -> tuple[T, T]:
    """The sum of two numbers or lanes, and its rounding residual."""
    end = y + change
    back = end - y
    return end, (y - (end - back)) + (change - back)


def add_slope(y: float, compensation: float, h: float, rate: float) -> tuple[float, float]:
    """y + compensation + h * rate, and its rounding residual."""
    change = fuse(h, rate, compensation)
    end, residual = add_exactly(y, change)
    return end, residual + (fuse(h, rate, -change) + compensation)


def powers(r: float) -> Lanes:
    """1, r, ..., r^7."""
    r2, v = r * r, lanes(1.0)
    r4 = r2 * r2
    v = with_lane(with_lane(with_lane(v, 1, r), 2, r2), 3, r2 * r)
    return with_lane(with_lane(with_lane(with_lane(v, 4, r4), 5, r4 * r), 6, r4 * r2), 7, r4 * r2 * r)


def at(m: Lanes, x: Lanes) -> Lanes:
    """The value at x of the polynomial with the coefficients m."""
    v = lanes(lane(m, 7))
    for k in range(6, -1, -1):
        v = fma(v, x, lanes(lane(m, k)))
    return v


def legendre_of_one(f: Lanes, table: Table) -> Lanes:
    """The Legendre coefficients 4 to 7 of one slope in their lanes."""
    return totals(
        f * row(table, constants.HIGHEST),
        f * row(table, constants.HIGHEST + 1),
        f * row(table, constants.HIGHEST + 2),
        f * row(table, constants.HIGHEST + 3),
    )


# Iteration -------------------------------------------------------------------------------------------------------------


def stages(
    equations: Equations, start: Start, k: Numbers, table: Table, guess: tuple[Vectors, Vectors, Vectors], accuracy: Accuracy,
    expected: float, unmonitored: int,
) -> tuple[int, float, Vectors, float]:  # fmt: skip
    """Repeat rounds until the expected change of the next round is allowed.

    k: the numbers of a run. `guess`: slopes and their sums p and v. `unmonitored`: number of the first rounds, whose
    changes are not computed; `expected`: the rate of the round after them, 0 if unknown.

    Gives rounds (negative if the iteration does not converge), rate of convergence, slopes, and `frequency`. The rate is
    0 if the changes are round-off. All rounds use b = q + h c v, with c in two parts, and its rounding residual e.
    """
    t, h, y, compensation = start
    f, p, v = guess
    exactly = accuracy.exactly
    n = equations.count
    hh = lanes(h)
    w = equations.forcing(fma(hh, row(table, constants.NODES), lanes(t)), k)
    b, e = tuple(lanes(y[i]) for i in range(n)), tuple(lanes(0.0) for i in range(n))
    if equations.second_order:
        high, low = hh * row(table, constants.NODES_HIGH), hh * row(table, constants.NODES_LOW)
        speeds = tuple(lanes(y[n + i]) for i in range(n))
        b = tuple(fma(high, speeds[i], fma(low, speeds[i], lanes(y[i]))) for i in range(n))
        if exactly:
            e = tuple(
                fma(low, speeds[i], fma(high, speeds[i], lanes(y[i]) - b[i])) + lanes(compensation[i]) for i in range(n)
            )
    before, rate, rounds = 0.0, expected, 0
    if equations.groups:
        x = places(equations, hh, b, p)
    while True:
        if equations.groups:
            g, x = round_by_groups(equations, hh, b, x, w, k, table)
        else:
            x = places(equations, hh, b, p)
            u = velocities(equations, hh, y, v)
            if not equations.turns:
                g = equations.slopes((*x, *u), w, k)
            elif rounds == 0:
                g, near = equations.slopes_first((*x, *u), w, k)
            else:
                g, near = equations.slopes_again((*x, *u), w, k, near)
        new = correct(equations, hh, g, f, p, b, x, e, table, exactly)
        rounds += 1
        done = False
        if rounds > unmonitored:
            off = lanes(0.0)
            for i in equations.components:
                off = fma(abs(new[i] - f[i]), lanes(accuracy.change_weight[i]), off)
            change = total(off)
            if rounds > unmonitored + 1:
                rate = change / before if before > 0.0 else 0.0
            if rounds > unmonitored + 1 or expected > 0.0 or (unmonitored > 0 and change <= accuracy.allowed_change):
                done, rounds = convergence(change, rate, rounds, accuracy)
            if not done:
                before = change
        f = new
        if done:
            break
        if equations.groups:
            x = move_places(equations, equations.groups[-1], hh, b, x, new, table)
        else:
            p, v = sums(equations, f, table, constants.STAGES, constants.ONCE)
    return rounds, rate if before > accuracy.noise else 0.0, f, frequency(equations, g, table)


def places(equations: Equations, hh: Lanes, b: Vectors, p: Vectors) -> Vectors:
    """The states of the stages, or their positions."""
    step = hh * hh if equations.second_order else hh
    return tuple(fma(step, p[i], b[i]) for i in range(equations.count))


def velocities(equations: Equations, hh: Lanes, y: Numbers, v: Vectors) -> Vectors:
    """The velocities of the stages, where the equations read them."""
    n = equations.count
    return tuple(fma(hh, v[i], lanes(y[n + i])) for i in range(n)) if equations.with_velocity else ()


def convergence(change: float, rate: float, rounds: int, accuracy: Accuracy) -> tuple[bool, int]:
    """Decide whether the rounds end. A change d at the rate r leaves an error of d r / (1 - r), here taken as d r.

    The next round may converge far more slowly than this one, so r is at least `assumed_rate`. Changes at the level of
    round-off do not shrink. `rounds` becomes negative if the iteration does not converge.
    """
    done = False
    if (change * max(rate, accuracy.assumed_rate) <= accuracy.allowed_change and rate < TUNING.slow) or (
        change < accuracy.noise and (rate > TUNING.slow or rounds == constants.MOST_ROUNDS)
    ):
        done = True
    elif not change < constants.MOST_CHANGE or rounds == constants.MOST_ROUNDS or (rounds > 2 and rate > TUNING.slow):
        done, rounds = True, -rounds
    return done, rounds


def correct(
    equations: Equations, hh: Lanes, g: Vectors, f: Vectors, p: Vectors, b: Vectors, x: Vectors, e: Vectors,
    table: Table, exactly: bool,
) -> Vectors:  # fmt: skip
    """The new slopes, with the change that the derivatives J predict: g + J h A (g - f), as the changes of the round do.

    With `exactly`, J s is added for the rounding residuals s of the places. Terms without products come first, so that
    little waits for the products.
    """
    n = equations.count
    new = g[:n]
    if not equations.derivatives:
        return new
    changes = tuple(g[i] - f[i] for i in range(n))
    moves = products(table, constants.STAGES, changes)
    turns = products(table, constants.ONCE, changes) if equations.with_velocity else moves
    if equations.second_order and exactly:
        s = tuple(fma(hh * hh, p[i], b[i] - x[i]) + e[i] for i in range(n))
        for m, i, j in equations.derivatives:
            if m in equations.by_position:
                new = replace_vectors(new, i, fma(g[m], s[j], new[i]))
    for m, i, j in equations.derivatives:
        if m in equations.by_position:
            new = replace_vectors(new, i, fma(g[m] * (hh * hh), moves[j], new[i]))
        else:
            new = replace_vectors(new, i, fma(g[m] * hh, turns[j % n], new[i]))
    return new


def replace_vectors(vectors: Vectors, i: int, new: Lanes) -> Vectors:
    """The vectors with number i replaced."""
    return (*vectors[:i], new, *vectors[i + 1 :])


def round_by_groups(
    equations: Equations, hh: Lanes, b: Vectors, x: Vectors, w: Numbers, k: Numbers, table: Table
) -> tuple[Vectors, Vectors]:
    """A round by groups, for many first-order equations: each group uses the new slopes of the groups before it.

    This is Gauss-Seidel iteration: a pair x' = v, v' = -x converges with the square of the rate. Gives the new slopes,
    and the places with the moves of all groups but the last.
    """
    new = x
    for group in equations.groups:
        g = equations.slopes(x, w, k, group)
        for i, slope in zip(group, g, strict=True):
            new = replace_vectors(new, i, slope)
        if group is not equations.groups[-1]:
            x = move_places(equations, group, hh, b, x, new, table)
    return new, x


def move_places(
    equations: Equations, group: tuple[int, ...], hh: Lanes, b: Vectors, x: Vectors, new: Vectors, table: Table
) -> Vectors:
    """The stages `x` in which the components of a group are computed from its `new` slopes, if a slope reads them."""
    read = tuple(i for i in group if i in equations.read)
    p = products(table, constants.STAGES, tuple(new[i] for i in read)) if read else ()
    for i, change in zip(read, p, strict=True):
        x = replace_vectors(x, i, fma(hh, change, b[i]))
    return x


def frequency(equations: Equations, g: Vectors, table: Table) -> float:
    """The fourth power of the frequency at the end of the step; 0 if no derivatives by positions are known.

    This is the square of the Frobenius norm of J, the derivatives of accelerations by positions. The stage polynomial
    extrapolates it to the end of the step. As that may be inaccurate, the value at the last stage limits it.
    """
    if not equations.by_position:
        return 0.0
    squares = lanes(0.0)
    for m in equations.by_position:
        squares = squares + g[m] * g[m]
    at_end = max(total(row(table, constants.ENDS) * squares), lane(squares, 7) / TUNING.grow_most)
    return min(at_end, TUNING.grow_most * lane(squares, 7))


# The end of a step -----------------------------------------------------------------------------------------------------


def next_state(
    equations: Equations, h: float, y: Numbers, compensation: Numbers, f: Vectors, table: Table
) -> tuple[Numbers, Numbers]:
    """The state after a step, y + h b f, or q + h v + h^2 b (1 - c) a and v + h b a; the residual of the last sum."""
    n = equations.count
    s = tuple(h * total(weight(f[i], table, constants.WEIGHTS)) for i in range(n))
    if equations.second_order:
        p = tuple(h * (h * total(weight(f[i], table, constants.POSITIONS)) + compensation[n + i]) for i in range(n))
        change = (
            *(h * y[n + i] + (p[i] + compensation[i]) for i in range(n)),
            *(s[i] + compensation[n + i] for i in range(n)),
        )
    else:
        change = tuple(s[i] + compensation[i] for i in range(n))
    both = tuple(add_exactly(y[i], change[i]) for i in range(len(y)))
    return tuple(end for end, _ in both), tuple(residual for _, residual in both)


def next_state_exactly(
    equations: Equations, h: float, y: Numbers, compensation: Numbers, f: Vectors, splitter: Numbers, table: Table
) -> tuple[Numbers, Numbers]:
    """`next_state` with the rounding residuals of all sums and products."""
    n = equations.count
    rates = tuple(weight_exactly(f[i], splitter[i], table, constants.WEIGHTS) for i in range(n))
    if equations.second_order:
        starts = tuple(add_slope(y[i], fuse(h, compensation[n + i], compensation[i]), h, y[n + i]) for i in range(n))
        means = tuple(weight_exactly(f[i], splitter[i], table, constants.POSITIONS) for i in range(n))
        both = tuple(
            add_slope(starts[i][0], fuse(h * h, means[i][1], starts[i][1]), h * h, means[i][0]) for i in range(n)
        ) + tuple(add_slope(y[n + i], fuse(h, rates[i][1], compensation[n + i]), h, rates[i][0]) for i in range(n))
    else:
        both = tuple(add_slope(y[i], fuse(h, rates[i][1], compensation[i]), h, rates[i][0]) for i in range(n))
    return tuple(end for end, _ in both), tuple(residual for _, residual in both)
