"""The loop of steps for hybrid problems: explicit Runge-Kutta steps that end where a guard crosses zero.

An event is located by root finding on the length of the method's own step, so the method keeps its order and needs no
dense output. The loop is a state machine. Each of its sections leads out of the state that stands above it here:

    START, SMOOTH, EVENT    between steps
       | choose a length              -> DONE, FULL, STEP_TOO_SMALL, TOO_MANY_STEPS
    CHOSEN                  the step has a length
       | evaluate the guards          -> NOT_FINITE
    ARMED                   the guards at its start are known
       | attempt the step             -> NOT_FINITE; with too large an error the state before: START, SMOOTH, EVENT
    STEPPED                 it is accurate enough
       | search for a guard           -> NOT_FINITE
    LOCATED                 it ends at the first guard that it crosses, if there is one
       | move to its end              -> SMOOTH without guard
    CROSSED                 the motion is on a guard
       | change state and mode        -> EVENT; ASK, ACCUMULATED

The loop is compiled once, for all cases; the modes and transitions of a case are one compiled function, called by
address. The loop returns to Python in the final states. Python calls it again after two of these: at ASK Python gives
the target of a transition whose target is a Python function, at FULL it enlarges the arrays of events.
"""

from collections.abc import Callable
from functools import cache
from itertools import chain
from typing import NamedTuple

import numpy as np
from gnomon.harness.contract.accumulation import MOST_RAPID
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.integrators.base.sizes import (
    SHORTEST,
    YOUNG,
    enlarge,
    first_sizes,
    forget,
    invert,
    size_by_end,
    size_by_power,
)
from gnomon.harness.integrators.base.stepping import compile_whole
from gnomon.harness.integrators.events.event_location import (
    EventData,
    dip,
    guard_after,
    locate,
    one_step,
    part,
    step_error,
)
from numpy.typing import NDArray

Integers = NDArray[np.int64]

START, SMOOTH, EVENT, CHOSEN, ARMED, STEPPED, LOCATED, CROSSED = 0, 1, 2, 3, 4, 5, 6, 7
"""States. START: the start of the motion. EVENT: right after an event. SMOOTH: between other steps."""

DONE, ASK, FULL, NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, ACCUMULATED = 8, 9, 10, 11, 12, 13, 14
"""Final states. DONE: finished; ASK: Python must give the target of where[FIRED]; FULL: the arrays of events are full;
the other states are failures."""

STATE, MODE, SAMPLE, SUBSTEP, STEPS, COUNT, FIRED, REFUSED, RAPID, FIELDS = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9
"""Fields of `where`. STATE: the last state between steps. SAMPLE, SUBSTEP, STEPS, COUNT: the numbers of samples, of
substeps towards the next sample, of steps and of events so far. FIRED: the transition of the last event. REFUSED: the
number of rejected steps. RAPID: the number of consecutive
rapid events without limit mode (see `accumulation`)."""

PAST, REST, NEXT, MOST, NUMBERS = 0, 1, 2, 3, 4
"""Fields of `clock`. PAST + REST: the time since the last sample, as a sum of two doubles. NEXT: the step size of the
controller. MOST: the longest step."""

MOST_STEPS = 5_000_000
"""With error control: with more steps the tolerance is too small for the span, or the equations are stiff."""


class Machine(NamedTuple):
    """A hybrid form: its compiled functions, modes and transitions."""

    parts: int
    """Address of the compiled functions of the form; the first `modes` of them are its right-hand sides."""
    p: Floats
    modes: int
    source: Integers
    """For each transition the mode before it."""
    target: Integers
    """For each transition the mode after it; -1 if Python must give it."""
    limit: Integers
    """For each transition its limit mode; -1 if it has none."""
    settle: float
    groups: Integers
    """See `sizes`."""


class Method(NamedTuple):
    """An explicit Runge-Kutta method, and its step size or tolerance."""

    table: Floats
    stages: int
    h: float
    tolerance: float
    """0: fixed steps, the nearest to h that divide the sampling interval; else the step size is controlled."""


class Point(NamedTuple):
    """The point that a motion has reached."""

    y: Floats
    clock: Floats
    where: Integers
    since: Floats
    """The time since each transition last fired."""
    sizes: Floats


class Samples(NamedTuple):
    """The times of samples, at which steps end, and arrays for states and events."""

    times: Floats
    out: Floats
    event_times: Floats
    event_kinds: Integers


def run(machine: Machine, method: Method, point: Point, samples: Samples) -> int:
    """Integrate one trajectory from a point; returns the final state."""
    parts, p, modes, source, target, limit, settle, groups = machine
    table, stages, h, tolerance = method
    y, clock, where, since, sizes = point
    times, out, event_times, event_kinds = samples
    x, end, k = np.empty(y.size), np.empty(y.size), np.empty((stages, y.size))
    there, slope, inverse = np.empty(y.size), np.empty(y.size), np.empty(y.size)
    s = EventData(parts, y, p, table, stages, x, k, end, there, slope)
    young = np.zeros((YOUNG, y.size))
    moved, fresh = False, where[STEPS] == 0
    invert(groups, sizes, inverse)
    transitions = source.size
    guards, resets, limits = modes, modes + transitions, modes + 2 * transitions
    before = np.zeros(transitions)
    t = base = length = goal = first = 0.0
    reaches, substeps, fired = True, 1, -1
    state = int(where[STATE])
    while True:
        mode = where[MODE]
        if state <= EVENT:  # START, SMOOTH, EVENT: choose the step's length, at most to the next sample or substep
            if where[SAMPLE] >= times.size:
                return DONE
            if where[COUNT] >= event_times.size:
                return FULL
            base = times[where[SAMPLE] - 1] if where[SAMPLE] > 0 else 0.0
            interval = times[where[SAMPLE]] - base
            t = base + clock[PAST]
            goal, substeps = interval, 1
            if tolerance == 0.0:
                substeps = max(1, round(interval / h))
                if where[SUBSTEP] + 1 < substeps:
                    goal = (where[SUBSTEP] + 1) * (interval / substeps)
            length = (goal - clock[PAST]) - clock[REST]
            reaches = True
            if tolerance > 0.0 and min(clock[NEXT], clock[MOST]) < length:
                length = min(clock[NEXT], clock[MOST])
                reaches = False
                if t + length <= t:
                    return STEP_TOO_SMALL
            if tolerance > 0.0 and where[STEPS] + where[REFUSED] >= MOST_STEPS:
                return TOO_MANY_STEPS
            state = CHOSEN
        if state == CHOSEN:  # evaluate the guards of the mode at the start of the step; -1: ignored in this step
            for g in range(transitions):
                if source[g] == mode:
                    part(s, guards + g, t, y, x)
                    value = x[0]
                    if np.isnan(value):
                        return NOT_FINITE
                    if where[STATE] == EVENT and (value == 0.0 or (g == where[FIRED] and value < 0.0)):
                        value = 0.0  # on the guard, up to the round-off of the event just located
                    elif where[STATE] == START and value == 0.0:
                        # At the start of the motion a guard that is zero counts only if it first increases.
                        one_step(s, mode, t, length * 2.0**-20, end)
                        part(s, guards + g, t, end, x)
                        value = 0.0 if x[0] > 0.0 else -1.0
                    elif value == 0.0:
                        value = -1.0
                    before[g] = value
            state = ARMED
        if state == ARMED:  # attempt the step; with too large an error return to the state before it
            one_step(s, mode, t, length, end)
            if tolerance > 0.0:
                if fresh:
                    for i in range(y.size):
                        slope[i] = length * k[0, i]
                    first_sizes(y, slope, groups, sizes, inverse)
                elif moved:
                    invert(groups, sizes, inverse)
                moved = size_by_end(length, end, groups, inverse, young)
                error = step_error(s, length, inverse) / tolerance
                if not error <= 1.0:
                    clock[NEXT] = length * (max(0.2, 0.9 * error ** (-1 / 8)) if error < np.inf else 0.1)
                    if moved:
                        clock[NEXT] = 0.2 * length
                        if clock[NEXT] < SHORTEST * h:
                            clock[NEXT], fresh = size_by_power(groups, sizes, young), False
                    if not clock[NEXT] > 0.0:
                        return NOT_FINITE
                    where[REFUSED] += 1
                    state = int(where[STATE])
                    continue
                clock[NEXT] = max(clock[NEXT], length) if reaches else length
                clock[NEXT] *= min(6.0, 0.9 * max(error, 1e-10) ** (-1 / 8))
                forget(young)
                moved = fresh = False
            for i in range(y.size):
                if not abs(end[i]) < np.inf:
                    return NOT_FINITE
            state = STEPPED
        if state == STEPPED:  # shorten the step to the first zero of a guard that counts
            fired, first = -1, length
            for g in range(transitions):
                if source[g] == mode and before[g] >= 0.0:
                    part(s, guards + g, t + length, end, x)
                    after, last = x[0], length
                    if np.isnan(after):
                        return NOT_FINITE
                    if after > 0.0 and before[g] > 0.0:
                        last = dip(s, guards + g, mode, t, length, before[g], after)
                        if last > 0.0:
                            after = guard_after(s, guards + g, mode, t, last, end)
                    if after < 0.0 or (after == 0.0 and before[g] > 0.0):
                        root = locate(s, guards + g, mode, t, last, before[g], after)
                        if fired < 0 or root < first:
                            fired, first = g, root
                        one_step(s, mode, t, length, end)
            if fired >= 0:
                one_step(s, mode, t, first, end)
            state = LOCATED
        if state == LOCATED:  # move state and clock to the end of the step
            for i in range(y.size):
                y[i] = end[i]
            if enlarge(y, groups, sizes) or where[STEPS] == 0:
                invert(groups, sizes, inverse)
            for g in range(transitions):
                since[g] += first
            where[STEPS] += 1
            if fired >= 0 or not reaches:
                updated = clock[PAST] + first
                clock[REST] += (
                    first - (updated - clock[PAST]) if clock[PAST] > first else clock[PAST] - (updated - first)
                )
                clock[PAST] = updated
            else:
                clock[PAST] = goal
                clock[REST] = 0.0
                where[SUBSTEP] += 1
                if where[SUBSTEP] >= substeps:
                    for i in range(y.size):
                        out[where[SAMPLE], i] = y[i]
                    where[SAMPLE] += 1
                    where[SUBSTEP] = 0
                    clock[PAST] = 0.0
            where[STATE] = SMOOTH
            state = CROSSED if fired >= 0 else SMOOTH
        if state == CROSSED:  # the transition, or the map into its limit mode, changes state and mode
            t = base + (clock[PAST] + clock[REST])
            event_times[where[COUNT]] = t
            where[FIRED] = fired
            if since[fired] <= settle and limit[fired] >= 0:
                event_kinds[where[COUNT]] = transitions + fired
                part(s, limits + fired, t, end, y)
                where[MODE] = limit[fired]
            else:
                event_kinds[where[COUNT]] = fired
                rapid = since[fired] <= settle or since[fired] <= 2.0**-52 * t  # settle may be nan
                where[RAPID] = where[RAPID] + 1 if rapid else 0
                part(s, resets + fired, t, end, y)
                where[MODE] = target[fired]
            since[fired] = 0.0
            where[COUNT] += 1
            where[STATE] = EVENT
            if where[RAPID] > MOST_RAPID:
                return ACCUMULATED
            if where[MODE] < 0:
                return ASK
            state = EVENT


SIGNATURE = " ".join((
    "int float[1] int int[1] int[1] int[1] float int[1]",
    "float[2] int float float",
    "float[1] float[1] int[1] float[1] float[1]",
    "float[1] float[2] float[1] int[1]",
))  # fmt: skip
"""The fields of the records that `run` takes."""


@cache
def compile_run() -> Callable[..., int]:
    """The compiled `run`, one function for all cases."""
    compiled = compile_whole(run, SIGNATURE)
    return lambda *records: compiled(*chain.from_iterable(records))
