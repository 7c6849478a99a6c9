"""The loop of steps for hybrid problems: explicit Runge-Kutta steps that end where a guard crosses zero.

An event is located by root finding on the length of the method's own step, so the method keeps its order and needs no
dense output. The loop is a state machine. Each function that `run` calls leads from the states above it to those below:

    START, SMOOTH, EVENT                       between steps
       | choose_step        -> DONE, FULL, STEP_TOO_SMALL, TOO_MANY_STEPS
    CHOSEN                                     the step has a length
       | arm_guards         -> NOT_FINITE
    ARMED                                      guards are evaluated at its start
       | attempt            -> NOT_FINITE; with too large an error back to START, SMOOTH or EVENT
    STEPPED                                    it is accurate enough
       | search             -> NOT_FINITE
    LOCATED                                    it ends at the first guard that it crosses, if there is one
       | advance            -> SMOOTH, without guard
    CROSSED                                    the motion is on a guard
       | jump               -> EVENT; ASK, ACCUMULATED

The loop is compiled once, for all cases; the modes and transitions of a case are one compiled function, called by address.
It returns to Python in the final states, and is called again after two: at ASK Python gives the target of a transition
that is a Python function, at FULL it enlarges the arrays of events.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from gnomon.harness.integrators.base.sizes import enlarge, first_sizes, invert
from gnomon.harness.integrators.base.stepping import compiled_whole
from gnomon.harness.integrators.events.event_location import (
    Formula,
    dip,
    guard_after,
    locate,
    one_step,
    part,
    step_error,
)
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

START, SMOOTH, EVENT, CHOSEN, ARMED, STEPPED, LOCATED, CROSSED = 0, 1, 2, 3, 4, 5, 6, 7
"""States. START: of the motion. EVENT: right after an event. SMOOTH: neither."""

DONE, ASK, FULL, NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, ACCUMULATED = 8, 9, 10, 11, 12, 13, 14
"""Final states: finished; Python must give the target of where[FIRED]; the arrays of events are full; failures."""

STATE, MODE, SAMPLE, SUBSTEP, STEPS, COUNT, FIRED, ENDS, REFUSED, RAPID, FIELDS = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10
"""Fields of `where`. STATE: the last one between steps. SAMPLE, SUBSTEP, STEPS, COUNT: the numbers of samples, of substeps
towards the next one, of steps and of events so far. FIRED: the transition of the last event. ENDS: where the step ends.
REFUSED: the number of rejected steps. RAPID: the number of consecutive events of transitions that had fired within `settle`
before, without limit mode."""

FREE, AT_SUBSTEP, AT_SAMPLE, AT_EVENT = 0, 1, 2, 3
"""Ends of a step. FREE: where the error control puts it."""

BASE, PAST, REST, NEXT, TIME, LENGTH, GOAL, NUMBERS = 0, 1, 2, 3, 4, 5, 6, 7
"""Fields of `clock`. BASE: the time of the last sample. PAST + REST: the time since then, as a sum of two doubles. NEXT:
the step size of the controller. TIME, LENGTH: of the step. GOAL: the value of PAST at the next sample or substep."""

MOST_RAPID = 1000
"""More consecutive ones count as a Zeno sequence."""

MOST_STEPS = 5_000_000
"""For methods with error control: beyond it the tolerance is too small for the span, or the equations are stiff."""


class Transitions(NamedTuple):
    """Of a form: the mode before each, after it, and its limit mode, -1 where Python must give it or where there is
    none. `modes`: the number of modes. `settle` (s): a transition that fires again within it leads to the limit mode."""

    modes: int
    source: Integers
    target: Integers
    limit: Integers
    settle: float


class Motion(NamedTuple):
    """One trajectory: the point that it has reached, its record at `times`, and room for a step.

    `since`: the time since each transition last fired. `groups`, `sizes`, `inverse`: see `sizes`. `before`: the guards at
    the start of the step. `end`: the state at its end. `there`, `slope`: a state and a rate elsewhere.
    """

    y: Floats
    clock: Floats
    where: Integers
    since: Floats
    groups: Integers
    sizes: Floats
    times: Floats
    out: Floats
    event_times: Floats
    event_kinds: Integers
    inverse: Floats
    before: Floats
    end: Floats
    there: Floats
    slope: Floats


def run(
    parts: int, p: Floats, table: Floats, stages: int, h: float, tolerance: float,
    modes: int, source: Integers, target: Integers, limit: Integers, settle: float,
    y: Floats, clock: Floats, where: Integers, since: Floats, groups: Integers, sizes: Floats,
    times: Floats, out: Floats, event_times: Floats, event_kinds: Integers,
) -> int:  # fmt: skip
    """Integrate one trajectory from the point that it has reached; returns the final state.

    `tolerance` 0: fixed steps, the nearest to h that divide the sampling interval; else the step size is controlled, and
    steps end at the samples. The other arguments are the fields of `Formula`, `Transitions` and `Motion`: compiled code takes only
    numbers and arrays from Python.
    """
    n = y.size
    formula = Formula(parts, p, table, stages, np.empty(n), np.empty((stages, n)))
    transitions = Transitions(modes, source, target, limit, settle)
    motion = Motion(
        y, clock, where, since, groups, sizes, times, out, event_times, event_kinds,
        np.empty(n), np.zeros(source.size), np.empty(n), np.empty(n), np.empty(n),
    )  # fmt: skip
    invert(groups, sizes, motion.inverse)
    state = int(where[STATE])
    while state < DONE:
        state = choose_step(motion, h, tolerance)
        if state == CHOSEN:
            state = arm_guards(formula, transitions, motion)
        if state == ARMED:
            state = attempt(formula, motion, tolerance)
        if state == STEPPED:
            state = search(formula, transitions, motion)
        if state == LOCATED:
            state = advance(motion)
        if state == CROSSED:
            state = jump(formula, transitions, motion)
    return state


def choose_step(motion: Motion, h: float, tolerance: float) -> int:
    """START, SMOOTH, EVENT -> CHOSEN: the step's length, at most to the next sample or substep."""
    clock, where, times = motion.clock, motion.where, motion.times
    if where[SAMPLE] >= times.size:
        return DONE
    if where[COUNT] >= motion.event_times.size:
        return FULL
    interval = times[where[SAMPLE]] - clock[BASE]
    t = clock[BASE] + clock[PAST]
    goal, ends = interval, AT_SAMPLE
    if tolerance == 0.0:
        substeps = max(1, round(interval / h))
        if where[SUBSTEP] + 1 < substeps:
            goal, ends = (where[SUBSTEP] + 1) * (interval / substeps), AT_SUBSTEP
    length = (goal - clock[PAST]) - clock[REST]
    if tolerance > 0.0 and clock[NEXT] < length:
        length, ends = clock[NEXT], FREE
        if t + length <= t:
            return STEP_TOO_SMALL
    if tolerance > 0.0 and where[STEPS] + where[REFUSED] >= MOST_STEPS:
        return TOO_MANY_STEPS
    clock[TIME], clock[LENGTH], clock[GOAL], where[ENDS] = t, length, goal, ends
    return CHOSEN


def arm_guards(formula: Formula, transitions: Transitions, motion: Motion) -> int:
    """CHOSEN -> ARMED: the guards of the mode at the start of the step; -1 for one that does not count in it."""
    where, t = motion.where, motion.clock[TIME]
    for g in range(transitions.source.size):
        if transitions.source[g] != where[MODE]:
            continue
        part(formula.parts, transitions.modes + g, t, motion.y, formula.p, formula.x)
        value = formula.x[0]
        if np.isnan(value):
            return NOT_FINITE
        if where[STATE] == EVENT and (value == 0.0 or (g == where[FIRED] and value < 0.0)):
            value = 0.0  # on the guard, up to the round-off of the event just located
        elif where[STATE] == START and value == 0.0:
            # At the start of the motion a guard that is zero counts only where it first increases.
            small = motion.clock[LENGTH] * 2.0**-20
            ahead = guard_after(formula, transitions.modes + g, where[MODE], t, small, motion.y, motion.end)
            value = 0.0 if ahead > 0.0 else -1.0
        elif value == 0.0:
            value = -1.0
        motion.before[g] = value
    return ARMED


def attempt(formula: Formula, motion: Motion, tolerance: float) -> int:
    """ARMED -> STEPPED, or back to the state before the step, with a shorter one, if the error is too large."""
    y, clock, where, end = motion.y, motion.clock, motion.where, motion.end
    length = clock[LENGTH]
    one_step(formula, where[MODE], clock[TIME], length, y, end)
    if tolerance > 0.0:
        if where[STEPS] == 0:
            for i in range(y.size):
                motion.slope[i] = length * formula.k[0, i]
            first_sizes(y, motion.slope, motion.groups, motion.sizes, motion.inverse)
        error = step_error(length, formula.table, formula.stages, formula.k, motion.inverse) / tolerance
        if not error <= 1.0:
            clock[NEXT] = length * (max(0.2, 0.9 * error ** (-1 / 8)) if error < np.inf else 0.1)
            where[REFUSED] += 1
            return int(where[STATE]) if clock[NEXT] > 0.0 else NOT_FINITE
        clock[NEXT] = length if where[ENDS] == FREE else max(clock[NEXT], length)
        clock[NEXT] *= min(6.0, 0.9 * max(error, 1e-10) ** (-1 / 8))
    for i in range(y.size):
        if not abs(end[i]) < np.inf:
            return NOT_FINITE
    return STEPPED


def search(formula: Formula, transitions: Transitions, motion: Motion) -> int:
    """STEPPED -> LOCATED: the step is shortened to the first zero of a guard that counts."""
    y, where, before, end = motion.y, motion.where, motion.before, motion.end
    mode, t, length = where[MODE], motion.clock[TIME], motion.clock[LENGTH]
    fired, first = -1, length
    for g in range(transitions.source.size):
        if transitions.source[g] != mode or not before[g] >= 0.0:
            continue
        guard = transitions.modes + g
        part(formula.parts, guard, t + length, end, formula.p, formula.x)
        after, last = formula.x[0], length
        if np.isnan(after):
            return NOT_FINITE
        if after > 0.0 and before[g] > 0.0:
            last = dip(formula, guard, mode, t, length, before[g], after, y, end, motion.there, motion.slope)
            if last > 0.0:
                after = guard_after(formula, guard, mode, t, last, y, end)
        if after < 0.0 or (after == 0.0 and before[g] > 0.0):
            found = locate(formula, guard, mode, t, last, before[g], after, y, end)
            if fired < 0 or found < first:
                fired, first = g, found
            one_step(formula, mode, t, length, y, end)
    if fired >= 0:
        one_step(formula, mode, t, first, y, end)
        motion.clock[LENGTH], where[FIRED], where[ENDS] = first, fired, AT_EVENT
    return LOCATED


def advance(motion: Motion) -> int:
    """LOCATED -> SMOOTH, or CROSSED where a guard is zero: state and clock move to the end of the step."""
    y, clock, where, length = motion.y, motion.clock, motion.where, motion.clock[LENGTH]
    for i in range(y.size):
        y[i] = motion.end[i]
    if enlarge(y, motion.groups, motion.sizes) or where[STEPS] == 0:
        invert(motion.groups, motion.sizes, motion.inverse)
    for g in range(motion.since.size):
        motion.since[g] += length
    where[STEPS] += 1
    if where[ENDS] == FREE or where[ENDS] == AT_EVENT:
        updated = clock[PAST] + length
        clock[REST] += length - (updated - clock[PAST]) if clock[PAST] > length else clock[PAST] - (updated - length)
        clock[PAST] = updated
    else:
        clock[PAST], clock[REST] = clock[GOAL], 0.0
        where[SUBSTEP] += 1
    if where[ENDS] == AT_SAMPLE:
        for i in range(y.size):
            motion.out[where[SAMPLE], i] = y[i]
        clock[BASE], clock[PAST] = motion.times[where[SAMPLE]], 0.0
        where[SAMPLE] += 1
        where[SUBSTEP] = 0
    if where[ENDS] == AT_EVENT:
        return CROSSED
    where[STATE] = SMOOTH
    return SMOOTH


def jump(formula: Formula, transitions: Transitions, motion: Motion) -> int:
    """CROSSED -> EVENT: the transition, or the map into its limit mode, changes state and mode."""
    clock, where, since = motion.clock, motion.where, motion.since
    t, fired, count = clock[BASE] + (clock[PAST] + clock[REST]), where[FIRED], transitions.source.size
    motion.event_times[where[COUNT]] = t
    if since[fired] <= transitions.settle and transitions.limit[fired] >= 0:
        motion.event_kinds[where[COUNT]] = count + fired
        part(formula.parts, transitions.modes + 2 * count + fired, t, motion.end, formula.p, motion.y)
        where[MODE] = transitions.limit[fired]
    else:
        motion.event_kinds[where[COUNT]] = fired
        where[RAPID] = where[RAPID] + 1 if since[fired] <= transitions.settle else 0
        part(formula.parts, transitions.modes + count + fired, t, motion.end, formula.p, motion.y)
        where[MODE] = transitions.target[fired]
    since[fired] = 0.0
    where[COUNT] += 1
    where[STATE] = EVENT
    if where[RAPID] > MOST_RAPID:
        return ACCUMULATED
    return ASK if where[MODE] < 0 else EVENT


SIGNATURE = (
    "int64(intp, float64[::1], float64[:, ::1], int64, float64, float64, int64, int64[::1], int64[::1], int64[::1], "
    "float64, float64[::1], float64[::1], int64[::1], float64[::1], int64[::1], float64[::1], float64[::1], "
    "float64[:, ::1], float64[::1], int64[::1])"
)


@cache
def compiled() -> Callable[..., int]:
    """`run`, the same for every case. What it calls is inlined before its types are inferred, so that each is compiled once:
    a fifth less time than for one long function, three tenths less than with LLVM's inlining."""
    pieces = (choose_step, arm_guards, attempt, search, advance, jump)
    return compiled_whole(run, SIGNATURE, pieces=pieces, inline='inline="always"')
