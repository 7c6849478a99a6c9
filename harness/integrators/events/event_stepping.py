"""The loop of steps for hybrid problems: explicit Runge-Kutta steps that end where a guard crosses zero.

An event is located by root finding on the length of the method's own step, so the method keeps its order and needs no
dense output. The loop is compiled once, for all cases; the modes and transitions of a case are one compiled function,
called by address. The loop returns to Python only where a transition's target is a Python function.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from gnomon.cases.core.forms import Equations, Hybrid, Mode, Transition
from gnomon.harness.contract.sources import cached_by_content
from gnomon.harness.integrators.base.sizes import enlarge, first_sizes, invert
from gnomon.harness.integrators.base.stepping import compiled_whole
from gnomon.harness.integrators.events.event_location import dip, guard_after, locate, one_step, part, step_error
from gnomon.harness.kernels.equations import IMPORTS, OPTIONS, address, check_values, gather_into, unpacked
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

DONE, ASK, FULL, NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, ACCUMULATED = 0, 1, 2, 3, 4, 5, 6
"""Why `run` returns: finished; Python must give the target of where[FIRED]; the arrays of events are full; failures."""

MODE, SAMPLE, SUBSTEP, STEPS, COUNT, FIRED, FRESH, REFUSED, RAPID, FIELDS = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9
"""Fields of `where`. FRESH: 1 right after an event, 2 at the start of the motion, else 0. REFUSED: the number of rejected
steps. RAPID: the number of consecutive events of transitions that had fired within `settle` before, without limit mode."""

MOST_RAPID = 1000
"""More consecutive ones count as a Zeno sequence."""

MOST_STEPS = 5_000_000
"""For methods with error control: beyond it the tolerance is too small for the span, or the equations are stiff."""


def run(
    parts: int,
    modes: int,
    y: Floats,
    clock: Floats,
    where: Integers,
    since: Floats,
    event_times: Floats,
    event_kinds: Integers,
    out: Floats,
    p: Floats,
    times: Floats,
    h: float,
    tolerance: float,
    table: Floats,
    stages: int,
    source: Integers,
    target: Integers,
    limit: Integers,
    settle: float,
    groups: Integers,
    sizes: Floats,
) -> int:
    """Integrate one trajectory from the point given by `y`, `clock`, `where`, `since`; returns one of the codes above.

    `parts`: address of the compiled functions of the form, the first `modes` of which are its right-hand sides.
    `clock`: the time within the sampling interval as a sum of two doubles, and the step size of the controller. `since`:
    the time since each transition last fired. `source`, `target`, `limit`: the mode before each transition, after it, and
    its limit mode, -1 where Python must give it or where there is none. `tolerance` 0: fixed steps, the nearest to h that
    divide the sampling interval; else the step size is controlled, and steps end at the samples. `groups`: see `sizes`.
    """
    x, end, k = np.empty(y.size), np.empty(y.size), np.empty((stages, y.size))
    there, slope, inverse = np.empty(y.size), np.empty(y.size), np.empty(y.size)
    invert(groups, sizes, inverse)
    transitions = source.size
    guards, resets, limits = modes, modes + transitions, modes + 2 * transitions
    before = np.zeros(transitions)
    while where[SAMPLE] < times.size:
        if where[COUNT] >= event_times.size:
            return FULL
        mode = where[MODE]
        base = times[where[SAMPLE] - 1] if where[SAMPLE] > 0 else 0.0
        interval = times[where[SAMPLE]] - base
        t = base + clock[0]
        goal, substeps = interval, 1
        if tolerance == 0.0:
            substeps = max(1, round(interval / h))
            if where[SUBSTEP] + 1 < substeps:
                goal = (where[SUBSTEP] + 1) * (interval / substeps)
        length = (goal - clock[0]) - clock[1]
        reaches = True
        if tolerance > 0.0 and clock[2] < length:
            length = clock[2]
            reaches = False
        if tolerance > 0.0 and t + length <= t and not reaches:
            return STEP_TOO_SMALL
        if tolerance > 0.0 and where[STEPS] + where[REFUSED] >= MOST_STEPS:
            return TOO_MANY_STEPS
        for g in range(transitions):
            if source[g] == mode:
                part(parts, guards + g, t, y, p, x)
                value = x[0]
                if np.isnan(value):
                    return NOT_FINITE
                if where[FRESH] == 1 and (value == 0.0 or (g == where[FIRED] and value < 0.0)):
                    value = 0.0  # on the guard, up to the round-off of the event just located
                elif where[FRESH] == 2 and value == 0.0:
                    # At the start of the motion a guard that is zero counts only where it first increases.
                    one_step(parts, mode, t, length * 2.0**-20, y, p, table, stages, x, k, end)
                    part(parts, guards + g, t, end, p, x)
                    value = 0.0 if x[0] > 0.0 else -1.0
                elif value == 0.0:
                    value = -1.0
                before[g] = value
        one_step(parts, mode, t, length, y, p, table, stages, x, k, end)
        if tolerance > 0.0:
            if where[STEPS] == 0:
                for i in range(y.size):
                    slope[i] = length * k[0, i]
                first_sizes(y, slope, groups, sizes, inverse)
            error = step_error(length, table, stages, k, inverse) / tolerance
            if not error <= 1.0:
                clock[2] = length * (max(0.2, 0.9 * error ** (-1 / 8)) if error < np.inf else 0.1)
                if not clock[2] > 0.0:
                    return NOT_FINITE
                where[REFUSED] += 1
                continue
            clock[2] = max(clock[2], length) if reaches else length
            clock[2] *= min(6.0, 0.9 * max(error, 1e-10) ** (-1 / 8))
        for i in range(y.size):
            if not abs(end[i]) < np.inf:
                return NOT_FINITE
        fired, first = -1, length
        for g in range(transitions):
            if source[g] == mode and before[g] >= 0.0:
                part(parts, guards + g, t + length, end, p, x)
                after = x[0]
                if np.isnan(after):
                    return NOT_FINITE
                last = length
                if after > 0.0 and before[g] > 0.0:
                    last = dip(
                        parts, guards + g, mode, t, length, before[g], after, y, end, p, table, stages, x, k, there, slope
                    )  # fmt: skip
                    if last > 0.0:
                        after = guard_after(parts, guards + g, mode, t, last, y, p, table, stages, x, k, end)
                if after < 0.0 or (after == 0.0 and before[g] > 0.0):
                    found = locate(parts, guards + g, mode, t, last, before[g], after, y, p, table, stages, x, k, end)
                    if fired < 0 or found < first:
                        fired, first = g, found
                    one_step(parts, mode, t, length, y, p, table, stages, x, k, end)
        if fired >= 0:
            one_step(parts, mode, t, first, y, p, table, stages, x, k, end)
        for i in range(y.size):
            y[i] = end[i]
        if enlarge(y, groups, sizes) or where[STEPS] == 0:
            invert(groups, sizes, inverse)
        since += first
        where[STEPS] += 1
        where[FRESH] = 0
        if fired >= 0 or not reaches:
            updated = clock[0] + first
            clock[1] += first - (updated - clock[0]) if clock[0] > first else clock[0] - (updated - first)
            clock[0] = updated
        else:
            clock[0] = goal
            clock[1] = 0.0
            where[SUBSTEP] += 1
            if where[SUBSTEP] >= substeps:
                out[where[SAMPLE]] = y
                where[SAMPLE] += 1
                where[SUBSTEP] = 0
                clock[0] = 0.0
        if fired >= 0:
            t = base + (clock[0] + clock[1])
            event_times[where[COUNT]] = t
            where[FRESH], where[FIRED] = 1, fired
            if since[fired] <= settle and limit[fired] >= 0:
                event_kinds[where[COUNT]] = transitions + fired
                part(parts, limits + fired, t, end, p, y)
                where[MODE] = limit[fired]
            else:
                event_kinds[where[COUNT]] = fired
                where[RAPID] = where[RAPID] + 1 if since[fired] <= settle else 0
                part(parts, resets + fired, t, end, p, y)
                where[MODE] = target[fired]
            since[fired] = 0.0
            where[COUNT] += 1
            if where[RAPID] > MOST_RAPID:
                return ACCUMULATED
            if where[MODE] < 0:
                return ASK
    return DONE


SIGNATURE = (
    "int64(intp, int64, float64[::1], float64[::1], int64[::1], float64[::1], float64[::1], int64[::1], "
    "float64[:, ::1], float64[::1], float64[::1], float64, float64, float64[:, ::1], int64, int64[::1], int64[::1], "
    "int64[::1], float64, int64[::1], float64[::1])"
)


@cache
def compiled() -> Callable[..., int]:
    """`run`, the same for every case."""
    return compiled_whole(run, SIGNATURE)


def compiled_parts(form: Hybrid, dimension: int, parameters: int) -> int:
    """Address of the functions of a form, compiled as one: out[0] selects the function, and out[:] gets its values.

    In this sequence: the right-hand side of each mode, which also adds 1 to p[parameters]; the guard of each transition,
    signed so that it is positive before the event; its reset; its map into the limit mode, where it has one.
    """
    plain = tuple(replace(transition, target="") for transition in form.transitions)  # a target is not compiled
    return _parts(form.modes, plain, form.limits, dimension, parameters)


@cached_by_content
def _parts(
    modes: tuple[Mode, ...],
    transitions: tuple[Transition, ...],
    limits: tuple[tuple[str, str, Equations], ...],
    dimension: int,
    parameters: int,
) -> int:
    maps = {name: to_limit for name, _, to_limit in limits}
    write = tuple(f"out[{i}] = r[{i}]" for i in range(dimension))
    functions: list[tuple[Callable[..., Any], str, int, tuple[str, ...]]] = [
        *((m.equations, f"p + {m.constants!r}" if m.constants else "p", dimension, (*write, f"p_[{parameters}] += 1.0"))
          for m in modes),
        *((g.guard, "p", 1, (f"out[0] = {-g.direction} * r[0]",)) for g in transitions),
        *((g.reset, "p", dimension, write) for g in transitions),
        *((maps.get(g.name, g.reset), "p", dimension, write) for g in transitions),
    ]  # fmt: skip
    sources = list(IMPORTS)
    seen: dict[str, Any] = {"np": np}
    lines = [f"@njit({OPTIONS})", "def parts(t, y_, p_, out):"]
    lines += [*(f"    {line}" for line in unpacked(dimension, parameters)), "    k = int(out[0])"]
    for k, (function, arguments, count, ends) in enumerate(functions):
        call = f"{function.__name__}(t, y, {arguments})"
        check_values({function.__name__: function}, call, dimension, parameters, count)
        gather_into(function, seen, sources)
        lines += [f"    if k == {k}:", f"        r = {call}"]
        lines += [f"        {end}" for end in ends] + ["        return"]
    return address("\n".join([*sources, *lines]), "parts")
