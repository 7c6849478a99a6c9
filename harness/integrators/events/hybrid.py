"""Methods for hybrid problems: impact, stick and slip are events, located to round-off."""

from typing import ClassVar

import numpy as np
from gnomon.cases.core.forms import Hybrid
from gnomon.harness.contract.accumulation import accumulation
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solution, Solver, Steps, Tolerance
from gnomon.harness.integrators.base.fixed_step import substeps_of
from gnomon.harness.integrators.base.step_control import check_tolerance, tabulate
from gnomon.harness.integrators.base.stepping import blank
from gnomon.harness.integrators.base.tableau import ButcherTableau
from gnomon.harness.integrators.events import event_functions, event_stepping
from gnomon.harness.integrators.runge_kutta.dop853 import Dop853
from gnomon.harness.integrators.runge_kutta.explicit import RK4, ExplicitEuler
from numpy.typing import NDArray

MOST_EVENTS = 1_000_000
"""A few seconds: with more events the span is too long for the time between events."""

REASONS = {
    event_stepping.NOT_FINITE: "the state or a guard was not finite",
    event_stepping.STEP_TOO_SMALL: "the step size fell below the spacing of times",
    event_stepping.FULL: f"more than {MOST_EVENTS} events",
    event_stepping.TOO_MANY_STEPS: f"more than {event_stepping.MOST_STEPS} steps (stiff, or too small a tolerance for so"
    " long a span)",
}


class EventRungeKutta(Integrator):
    """An explicit Runge-Kutta method whose step ends where a guard crosses zero.

    The event is located by root finding on the step length, and the next step ends at the next grid point. A guard that
    falls at the start of a step and rises at its end is evaluated in between, so that grazing is detected; this costs a
    right-hand side in each step in which the guard falls. When a transition fires twice within `settle`, the motion
    enters its limit mode. Samples are ends of steps.
    """

    accepts = (Hybrid,)
    sampling = "stops at samples"
    policy = "events"
    tableau: ClassVar[ButcherTableau]

    def prepare(self, problem: Problem, setting: float) -> Solver:
        t0, problem = problem.t0, problem.since_start()
        form, times, buffer = problem.form, problem.times, problem.buffer
        assert isinstance(form, Hybrid)
        fixed = isinstance(self.sweep, Steps)
        if fixed:
            substeps_of(problem, setting)
        else:
            check_tolerance(setting)
        run = event_stepping.compile_run()
        parts = event_functions.compile_parts(form, problem.dimension, len(problem.parameters))
        h, tolerance = (setting, 0.0) if fixed else (0.1 * problem.time_scale, setting)
        modes, transitions, names = Modes(form), form.transitions, event_names(form)
        parameters = tuple(problem.parameters.tolist())
        ends = modes.source, modes.target, modes.limit
        machine = event_stepping.Machine(parts, buffer, len(form.modes), *ends, form.settle, problem.grouping)
        method = event_stepping.Method(tabulate(self.tableau.rows), len(self.tableau.a), h, tolerance)

        def trajectory(start: Floats, out: Floats) -> tuple[int, str | None, list[tuple[float, str]]]:
            y, since = start.copy(), np.full(len(transitions), np.inf)
            clock = np.zeros(event_stepping.NUMBERS)
            clock[event_stepping.NEXT], clock[event_stepping.MOST] = self.first_step or h, self.max_step
            where = np.zeros(event_stepping.FIELDS, dtype=np.int64)
            where[event_stepping.STATE] = event_stepping.START
            where[event_stepping.MODE] = modes.of(form.start(0.0, tuple(y.tolist()), parameters))
            point = event_stepping.Point(y, clock, where, since, np.zeros(problem.dimension))
            event_times, kinds = np.empty(64), np.empty(64, dtype=np.int64)
            while True:
                state = run(machine, method, point, event_stepping.Samples(times, out, event_times, kinds))
                if state == event_stepping.ASK:
                    transition = transitions[where[event_stepping.FIRED]]
                    t = float(event_times[where[event_stepping.COUNT] - 1])
                    lands = transition.lands(t, tuple(y.tolist()), parameters)
                    where[event_stepping.MODE] = modes.of(lands)
                elif state == event_stepping.FULL and len(event_times) < MOST_EVENTS:
                    event_times, kinds = np.resize(event_times, 4 * len(event_times)), np.resize(kinds, 4 * len(kinds))
                else:
                    break
            count = where[event_stepping.COUNT]
            events = zip(event_times[:count].tolist(), kinds[:count].tolist(), strict=True)
            sample, steps = where[event_stepping.SAMPLE], int(where[event_stepping.STEPS])
            stopped = None
            if state == event_stepping.ACCUMULATED:
                stopped = accumulation(
                    form, transitions[where[event_stepping.FIRED]], t0 + float(event_times[count - 1])
                )
            elif state != event_stepping.DONE:
                stopped = f"{REASONS[state]} before sample {sample + 1}"
            return steps, stopped, [(t0 + time, names[kind]) for time, kind in events]

        def solve(initial: Floats) -> Solution:
            states = blank(problem, initial)
            runs = [trajectory(start, out) for start, out in zip(initial, states, strict=True)]
            stopped = next((why for _, why, _ in runs if why), None)
            return Solution(states, sum(steps for steps, _, _ in runs), stopped, tuple(runs[0][2]))

        return Solver(solve)


class Modes:
    """The modes of a hybrid form as numbers; for each transition the mode before it, after it, and its limit mode."""

    def __init__(self, form: Hybrid) -> None:
        self.number = {mode.name: i for i, mode in enumerate(form.modes)}
        limits = {transition: mode for transition, mode, _ in form.limits}
        targets = [g.target if isinstance(g.target, str) else None for g in form.transitions]
        self.source = self._numbers([g.mode for g in form.transitions])
        self.target = self._numbers(targets)
        self.limit = self._numbers([limits.get(g.name) for g in form.transitions])

    def of(self, name: str) -> int:
        """The number of a mode. Raises ValueError for one that the form does not have."""
        if name not in self.number:
            raise ValueError(f"there is no mode {name!r}; the form has {', '.join(self.number)}")
        return self.number[name]

    def _numbers(self, names: list[str | None] | list[str]) -> NDArray[np.int64]:
        return np.array([-1 if name is None else self.of(name) for name in names], dtype=np.int64)


def event_names(form: Hybrid) -> list[str]:
    """The names of events by kind: the name of each transition, then `limit` for each transition."""
    return [g.name for g in form.transitions] + ["limit"] * len(form.transitions)


class EulerEvents(EventRungeKutta):
    """Euler's method with events located on its step length. Order 1."""

    name, order = "Explicit Euler", 1
    sweep = Steps()
    tableau = ExplicitEuler.tableau


class RK4Events(EventRungeKutta):
    """The classical Runge-Kutta method (Kutta 1901) with events located on its step length. Order 4."""

    name, order = "RK4", 4
    sweep = Steps()
    tableau = RK4.tableau


class Dop853Events(EventRungeKutta):
    """Dormand and Prince's 8(5,3) pair with error control and events located on its step length. Order 8."""

    name, order = "DOP853", 8
    sweep = Tolerance(1e-3, 1e-14)
    takes = ("max_step", "first_step")
    tableau = Dop853.tableau


INTEGRATORS: tuple[type[Integrator], ...] = (EulerEvents, RK4Events, Dop853Events)
