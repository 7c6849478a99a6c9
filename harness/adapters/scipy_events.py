"""SciPy's solve_ivp with its event location, on hybrid problems: one call from each event to the next."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder, Hybrid, Mode, Transition
from gnomon.harness.adapters import scipy_ivp
from gnomon.harness.adapters.scipy_ivp import Function, SolveIvp, record_options
from gnomon.harness.contract.accumulation import MOST_RAPID, accumulation
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solution, Solver
from gnomon.harness.kernels.equations import function_kernel
from gnomon.harness.kernels.straight_line import derivatives_if_traced

ROOT = 4 * float(np.finfo(float).eps)
"""Seconds: SciPy's absolute tolerance for the time of an event."""
RAPID = 8 * ROOT
"""Seconds, at times up to 1 s: SciPy cannot distinguish the times of events that are closer."""
LONGEST = 0.25
"""The option `max_step` where no tolerance bounds a step and a transition can end the mode, in time scales."""
PROBE = 1e-9
"""Fraction of a time scale after which a guard that is zero at the start of the motion is evaluated again."""


class SolveIvpEvents(SolveIvp):
    """A method of `scipy.integrate.solve_ivp` with terminal events.

    SciPy detects a sign change of a guard between the ends of a step: "if multiple zero crossings occur within one step,
    events may be missed", says its manual. Where forces do not depend on the state, no tolerance bounds a step: without
    `max_step` all trials of `chattering_ball` missed its release, and 13 of 30 of `oblique_impact` the impact. One limit holds
    in all such modes: a quarter of the time in which the motion changes by its own size, with which none was missed. DOP853
    takes 1.19 times as long with it (geometric mean of 39 cases at 1e-7; the largest ratio is 3.6).

    Right after an event the guard is zero at the restart and would fire at once, so its value there is replaced by a
    number with the sign of the side from which it comes. SciPy tests the states, but brackets the root on its interpolant. If round-off gives the two different signs,
    it raises `f(a) and f(b) must have different signs`, an error of SciPy that stays `crashed` (Radau, two starts of
    forty from rest), unless events accumulate there.
    """

    accepts = (Hybrid,)
    policy = "events"
    takes: ClassVar[tuple[str, ...]] = ("max_step",)  # a first step would hold after each event

    def prepare(self, problem: Problem, setting: float) -> Solver:
        form, options, span = problem.form, self.options_of(setting), float(problem.elapsed[-1])
        assert isinstance(form, Hybrid)
        if setting * span < ROOT:
            raise Refused(
                f"SciPy locates events to {ROOT:.1e} s, which is coarser than rtol = {setting:g} of a span of {span:g} s:"
                " state the times in a smaller unit"
            )
        sides = {mode.name: Side(self, problem, form, mode) for mode in form.modes}

        def solve(initial_states: Floats) -> Solution:
            states = np.full((len(initial_states), len(problem.times), problem.dimension), np.nan)
            runs = [
                trajectory(problem, form, sides, options, *pair) for pair in zip(initial_states, states, strict=True)
            ]
            for side in sides.values():
                problem.buffer[-1] += side.counted()
            return Solution(states, stopped=next((why for why, _ in runs if why), None), events=tuple(runs[0][1]))

        settings = {
            option if option == "max_step" else f"{option} in {name}": value
            for name, side in sides.items()
            for option, value in record_options(side.options).items()
        }
        return Solver(solve, record_options(options) | settings)


class Side:
    """A mode as SciPy calls it: right-hand side, Jacobian if the method uses it, the guards of its transitions."""

    def __init__(self, method: SolveIvp, problem: Problem, form: Hybrid, mode: Mode) -> None:
        dimension, numbers = problem.dimension, len(problem.parameters)
        self.buffer = np.array([*problem.parameters, *mode.constants, 0.0])
        kernel = function_kernel(mode.equations, dimension, len(self.buffer) - 1, dimension, problem.counted)
        self.equations, jacobian = method.given(kernel, FirstOrder(mode.equations), dimension, self.buffer)
        self.options: dict[str, Any] = {**jacobian}
        self.transitions = tuple(transition for transition in form.transitions if transition.mode == mode.name)
        if self.transitions and is_free(mode, problem, self.buffer):
            self.options["max_step"] = min(method.max_step, LONGEST * problem.time_scale)
        self.guards = []
        for transition in self.transitions:
            guard = function_kernel(transition.guard, dimension, numbers, 1)
            self.guards.append(Guard(transition, guard.bound(problem.buffer)))

    def counted(self) -> float:
        """The number of right-hand sides since the last call of this function."""
        calls, self.buffer[-1] = float(self.buffer[-1]), 0.0
        return calls


def is_free(mode: Mode, problem: Problem, buffer: Floats) -> bool:
    """Whether no tolerance bounds a step: forces do not depend on the state, or their equations cannot be traced.

    The Jacobian of such equations has only q' = v: it is constant, and its square is 0.
    """
    kernel = derivatives_if_traced(FirstOrder(mode.equations), problem.dimension, len(buffer) - 1)
    if kernel is None:
        return True
    states = np.random.default_rng(0).normal(size=(2, problem.dimension))
    first, second = (kernel.array(problem.t0, y, buffer).reshape(2 * (problem.dimension,)) for y in states)
    return np.array_equal(first, second) and not (first @ first).any()


class Guard:
    """A guard as a terminal event of SciPy, with its value at the start of a segment replaced by -1 or 1 (latched)."""

    terminal = True

    def __init__(self, transition: Transition, function: Function) -> None:
        self.direction = float(transition.direction)
        self.function = function
        self.start, self.latched = 0.0, 0.0

    def value(self, t: float, y: Floats) -> float:
        return float(self.function(t, y)[0])

    def __call__(self, t: float, y: Floats) -> float:
        return self.latched if self.latched and t == self.start else self.value(t, y)

    def latch(self, t: float, armed: bool) -> None:
        """Replace the guard's value at t: not yet crossed if `armed`, else already crossed."""
        self.start, self.latched = t, -self.direction if armed else self.direction

    def unlatch(self) -> None:
        self.latched = 0.0


def trajectory(
    problem: Problem, form: Hybrid, sides: Mapping[str, Side], options: Mapping[str, Any], start: Floats, out: Floats
) -> tuple[str | None, list[tuple[float, str]]]:
    """Fill `out` (64, dim) from one start; returns the reason for an early end, or None, and the located events."""
    from scipy.integrate import solve_ivp  # slow to load: only the trials of this library wait

    times, parameters = problem.times, tuple(problem.parameters.tolist())
    limits = {name: (mode, settled) for name, mode, settled in form.limits}
    t, y, sample = problem.t0, start, 0
    fired: Transition | None = None
    mode = form.start(t, tuple(start.tolist()), parameters)
    last: dict[str, float] = {}
    rapid = 0
    events: list[tuple[float, str]] = []
    while sample < len(times) and t < times[-1]:
        side = sides[mode]
        for transition, guard in zip(side.transitions, side.guards, strict=True):
            set_latch(guard, side, t, y, transition is fired, bool(events), PROBE * problem.time_scale)
        try:
            stretch = solve_ivp(
                side.equations,
                (t, times[-1]),
                y,
                t_eval=times[sample:],
                events=side.guards,
                **{**options, **side.options},
            )
        except ValueError:
            if fired is None or not rapid:
                raise
            return accumulation(form, fired, t), events  # by round-off: see the class
        reached = len(stretch.t)
        if reached:  # else stretch.y is an empty list
            out[sample : sample + reached] = stretch.y.T
        sample += reached
        if stretch.status < 0:
            return str(stretch.message), events
        if stretch.status == 0:
            break
        which = next(i for i, when in enumerate(stretch.t_events) if len(when))
        fired = side.transitions[which]
        t, there = float(stretch.t_events[which][0]), tuple(stretch.y_events[which][0].tolist())
        since = t - last.get(fired.name, -np.inf)
        rapid = rapid + 1 if since <= form.settle or since <= RAPID * max(1.0, abs(t)) else 0
        if rapid > MOST_RAPID // 10:  # each is a call of SciPy
            return accumulation(form, fired, t), events
        if fired.name in limits and since <= form.settle:
            mode, settled = limits[fired.name]
            after = settled(t, there, parameters)
            events.append((t, "limit"))
        else:
            after = fired.reset(t, there, parameters)
            mode = fired.lands(t, after, parameters)
            events.append((t, fired.name))
        last[fired.name] = t
        y = np.array(after, dtype=np.float64)
    return None, events


def set_latch(guard: Guard, side: Side, t: float, y: Floats, fired: bool, after_event: bool, probe: float) -> None:
    """Replace the value of a guard that is zero at the start of a segment.

    After an event the guard counts as not yet crossed; at the start of the motion only if it first increases from zero.
    """
    guard.unlatch()
    value = guard.value(t, y) * -guard.direction
    if after_event and (value == 0 or (fired and value < 0)):
        guard.latch(t, armed=True)
    elif value == 0:
        ahead = guard.value(t + probe, y + probe * side.equations(t, y)) * -guard.direction
        guard.latch(t, armed=ahead > 0)


class RK45(SolveIvpEvents, scipy_ivp.RK45):
    """Dormand and Prince's 5(4) pair, events on its interpolant. J. Comput. Appl. Math. 6 (1980) 19."""


class DOP853(SolveIvpEvents, scipy_ivp.DOP853):
    """Dormand and Prince's 8(5,3) pair, events on its interpolant. Hairer, Norsett, Wanner (1993), II.10."""


class Radau(SolveIvpEvents, scipy_ivp.Radau):
    """Implicit Runge-Kutta of the Radau IIA family, events on its interpolant. Hairer, Wanner (1996), IV.8."""


class LSODA(SolveIvpEvents, scipy_ivp.LSODA):
    """ODEPACK's Adams and BDF methods, switched automatically. Petzold, SIAM J. Sci. Stat. Comput. 4 (1983) 136."""


INTEGRATORS: tuple[type[Integrator], ...] = (RK45, DOP853, Radau, LSODA)
