"""The events in a trajectory of a hybrid case, found between its rows, beside the exact events."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.case import Event
from gnomon.cases.core.forms import Hybrid, Transition
from gnomon.cases.core.metric import Metric
from gnomon.harness.contract.integrator import Floats

State = tuple[float, ...]
SUBSTEPS, SUBSTEP = 16, 0.02
"""Most Runge-Kutta steps between two rows, and their length in time scales, with errors of some 1e-9."""
MOST_IN_A_GAP = 2
"""With more events between two rows, events are not told from there on."""
LEAST_JUMP, CLEARLY = 0.05, 20.0
"""A jump is an event if it is larger, of the size of the motion, and so many times larger than the usual distance from a
row to the motion from the row before."""
BISECTIONS = 60


@dataclass(frozen=True)
class EventErrors:
    """The events of a trajectory: exact times of the missed ones, times of the extra ones, and (exact time, seconds by
    which it is late, name) of the others. `until`: the time up to which events were told."""

    missed: tuple[tuple[float, str], ...]
    extra: tuple[tuple[float, str], ...]
    late: tuple[tuple[float, float, str], ...]
    until: float

    @property
    def latest(self) -> tuple[float, float, str] | None:
        return max(self.late, key=lambda each: abs(each[1]), default=None)


def compare_events(case: Case, times: Floats, states: Floats, metric: Metric) -> EventErrors:
    """Find the events of a trajectory from the equations of each mode between its rows, and match the exact ones."""
    moments = [float(event.time) for event in case.events()]
    crowded = np.flatnonzero(np.histogram(moments, times)[0] > MOST_IN_A_GAP)
    rows = int(crowded[0]) + 1 if len(crowded) else len(times)
    located, until = _locate(case, times[:rows], states[:rows], metric)
    exact = [event for event in case.events() if event.time <= until and event.name != "limit"]
    return _match(located, exact, float(times[0]), until, float(np.max(np.diff(times))))


def _match(
    located: Sequence[tuple[float, str]], exact: Sequence[Event], first: float, until: float, gap: float
) -> EventErrors:
    """Match each exact event with the nearest one found of its name, nearer than the half of the time to its neighbours."""
    late, missed, left = [], [], list(located)
    moments = [float(event.time) for event in exact]
    for place, event in enumerate(exact):
        time = moments[place]
        if time < first:
            continue
        same = [t for t, each in zip(moments, exact, strict=True) if each.name == event.name and t != time]
        reach = max(min((abs(t - time) for t in same), default=np.inf) / 2, 0.0)
        near = min((pair for pair in left if pair[1] == event.name), key=lambda pair: abs(pair[0] - time), default=None)
        if near is not None and abs(near[0] - time) <= reach:
            left.remove(near)
            late.append((time, near[0] - time, event.name))
        elif time < until - gap:  # one that is late may lie behind the last row
            missed.append((time, event.name))
    extra = [pair for pair in left if pair[0] < until - gap]
    return EventErrors(tuple(missed), tuple(extra), tuple(late), until)


def _locate(case: Case, times: Floats, states: Floats, metric: Metric) -> tuple[list[tuple[float, str]], float]:
    """(time, name) of the events of a trajectory, and the time up to which they were told."""
    hybrid = case.hybrid
    assert hybrid is not None
    parameters = tuple(float(value) for value in case.parameter_values())
    longest = float(np.max(np.diff(times), initial=0.0)) / case.time_scale
    substeps = max(1, min(SUBSTEPS, math.ceil(longest / SUBSTEP)))
    rows = [tuple(row) for row in states.tolist()]
    events: list[tuple[float, str]] = []
    reached, usual = float(times[0]), list[float]()
    try:
        mode = hybrid.start(float(times[0]), rows[0], parameters)
        for place in range(len(rows) - 1):
            t, after = float(times[place]), float(times[place + 1])
            if after == t:
                continue
            walk = _Walk(hybrid, parameters, t, after, substeps)
            smooth = walk.smooth(mode, rows[place])
            fired, ended, new_mode = walk.with_events(mode, rows[place])
            if fired is None:
                return events, reached
            row = np.array(rows[place + 1])
            without = _distance(metric, smooth, row)
            if fired and _distance(metric, ended, row) <= without:
                events += fired
                mode = new_mode
            elif not fired:
                extra = _find_unexpected(hybrid, mode, without, usual)
                usual.append(without)
                if extra is not None:
                    events.append(((t + after) / 2, extra.name))
                    mode = extra.lands(after, rows[place + 1], parameters)
            reached = after
    except (ArithmeticError, ValueError):  # a wrong state, for which the equations have no value
        pass
    return events, reached


def _distance(metric: Metric, a: State | None, b: Floats) -> float:
    if a is None:
        return np.inf
    largest = max(float(each) for each in metric.by_group(np.array(a), b).values())
    return largest if np.isfinite(largest) else np.inf


def _find_unexpected(hybrid: Hybrid, mode: str, jump: float, usual: Sequence[float]) -> Transition | None:
    """The transition of a jump of the state that the equations do not have; None for a distance as between other rows."""
    if jump < LEAST_JUMP or jump < CLEARLY * float(np.median(usual or [0.0])):
        return None
    return next((each for each in hybrid.transitions if each.mode == mode and each.onto is not None), None)


class _Walk:
    """The motion from one row to the next by the classical Runge-Kutta method."""

    def __init__(self, hybrid: Hybrid, parameters: State, start: float, end: float, substeps: int) -> None:
        self.hybrid, self.parameters, self.start, self.end, self.substeps = hybrid, parameters, start, end, substeps

    def smooth(self, mode: str, state: State) -> State:
        """The state at the end without any event."""
        t, h = self.start, (self.end - self.start) / self.substeps
        for _ in range(self.substeps):
            state = self._step(mode, t, state, h)
            t += h
        return state

    def with_events(self, mode: str, state: State) -> tuple[list[tuple[float, str]] | None, State | None, str]:
        """The events, the state at the end, and its mode; None for more events than can be told."""
        t, h = self.start, (self.end - self.start) / self.substeps
        events: list[tuple[float, str]] = []
        while t < self.end - 1e-12 * (self.end - self.start):
            step = min(h, self.end - t)
            ahead = self._step(mode, t, state, step)
            fired = self._first_fired(mode, t, state, ahead, step)
            if fired is None:
                t, state = t + step, ahead
                continue
            transition, step = fired
            if len(events) == MOST_IN_A_GAP:
                return None, None, mode
            t, state = t + step, self._step(mode, t, state, step)
            if transition.onto is not None:
                state = tuple(transition.onto(t, state, self.parameters))
            events.append((t, transition.name))
            mode = transition.lands(t, state, self.parameters)
            state = tuple(float(x) for x in transition.reset(t, state, self.parameters))
        return events, state, mode

    def _first_fired(
        self, mode: str, t: float, state: State, ahead: State, step: float
    ) -> tuple[Transition, float] | None:
        """The transition that ends a mode first within a step, and the length of the step up to it."""
        first: tuple[Transition, float] | None = None
        for transition in self.hybrid.transitions:
            if transition.mode != mode:
                continue
            before, after = (
                transition.direction * float(transition.guard(time, each, self.parameters)[0])
                for time, each in ((t, state), (t + step, ahead))
            )
            if not (before < 0 <= after):
                continue
            low, high = 0.0, step
            for _ in range(BISECTIONS):
                middle = (low + high) / 2
                there = self._step(mode, t, state, middle)
                is_past = transition.direction * float(transition.guard(t + middle, there, self.parameters)[0]) >= 0
                low, high = (low, middle) if is_past else (middle, high)
            if first is None or high < first[1]:
                first = transition, high
        return first

    def _step(self, mode: str, t: float, state: State, h: float) -> State:
        chosen = self.hybrid.mode(mode)
        numbers = self.parameters + chosen.constants

        def rates(time: float, of: State) -> State:
            return tuple(float(x) for x in chosen.equations(time, of, numbers))

        def ahead(share: float, k: State) -> State:
            return tuple(a + share * h * b for a, b in zip(state, k, strict=True))

        k1 = rates(t, state)
        k2 = rates(t + h / 2, ahead(0.5, k1))
        k3 = rates(t + h / 2, ahead(0.5, k2))
        k4 = rates(t + h, ahead(1.0, k3))
        return tuple(a + h / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(state, k1, k2, k3, k4, strict=True))
