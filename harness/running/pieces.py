"""The motion of one call of `solve`, integrated piece by piece: no step crosses a jump of the input."""

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, Self

import numpy as np
from gnomon.cases.core.forms import FirstOrder, Form, NBody, first_order
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solution, Steps
from gnomon.harness.contract.problem import first_taken
from gnomon.harness.contract.validation import Unusable, short
from gnomon.harness.integrators.base.fixed_step import FixedStep
from gnomon.harness.kernels.derived_forms import derive_forms, of_bodies
from gnomon.harness.kernels.kept_code import show
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.running.call_watch import place
from gnomon.harness.running.clock import Clock
from gnomon.harness.running.own_functions import (
    IN_PARTS,
    Arguments,
    CaseEquations,
    OwnEquations,
    at_rest,
    is_counted,
    most_occurrences,
    with_events,
)

SAMPLES = 64
EVEN = 1e-9
"""Times count as evenly spaced if they are so within this share of the spacing, because decimal times have round-off."""
USUAL_SPANS = 2.0**-3, 2.0**30
"""Shortest and longest span, in the user's unit of time, that is not scaled. Other spans are scaled to about 1, because
libraries have absolute limits, such as 9e-16 s for the time of an event in SciPy."""


@dataclass(frozen=True)
class Times:
    """The times of a piece: `wanted` by the user, and `sampled` by the problem, counted from the start and with the end."""

    clock: Clock
    wanted: Floats
    sampled: Floats
    first: int
    """1 if the first wanted time is the start, else 0."""

    @classmethod
    def of(
        cls, t_span: Sequence[float], t_eval: Sequence[float] | Floats | None, rates: int, scale: float | None = None
    ) -> Self:
        """The times of a span; `rates`: the number of the last coordinates that are rates.

        `scale`: see `Clock`; by default from the span.
        """
        try:
            t0, end = map(float, t_span)
        except (TypeError, ValueError):
            raise ValueError(f"t_span={t_span!r}: give the first and the last time") from None
        if not (math.isfinite(t0) and math.isfinite(end)) or t0 == end:
            raise ValueError(f"t_span={t_span!r}: give two different finite times")
        span = abs(end - t0)
        if scale is None:
            low, high = USUAL_SPANS
            scale = 1.0 if low <= span <= high else 2.0 ** round(math.log2(span))
        clock = Clock(t0, math.copysign(1.0, end - t0), rates, scale, min(t0, end), max(t0, end))
        wanted = np.linspace(t0, end, SAMPLES) if t_eval is None else array(t_eval, "t_eval")
        elapsed = clock.elapsed(wanted)
        if not np.all(np.diff(elapsed) > 0) or elapsed[0] < 0 or elapsed[-1] > span / scale:
            raise ValueError(f"t_eval={short(t_eval)}: give times in order, from {t0:g} to {end:g}")
        first = int(elapsed[0] == 0)
        sampled = elapsed[first:]
        if not len(sampled) or sampled[-1] < span / scale:
            sampled = np.append(sampled, span / scale)
        return cls(clock, wanted, sampled, first)

    def problem(
        self, form: Form, dimension: int, parameters: Sequence[float], integrator: Integrator, by_own_clock: bool
    ) -> Problem:
        """The problem, which begins at t = 0, or `by_own_clock` at the user's time: equations of a form may read the time.

        For fixed steps, times that are evenly spaced within EVEN become exactly so, so that steps end at them.
        """
        times, count = self.sampled, len(self.sampled)
        even = np.arange(1, count + 1) * (times[-1] / count)
        if isinstance(integrator.sweep, Steps) and np.allclose(times, even, rtol=0, atol=EVEN * even[0]):
            times = even
        t0 = self.clock.t0 if by_own_clock else 0.0
        numbers = np.array(parameters, dtype=np.float64)
        return Problem(form, dimension, numbers, t0 + times, times[-1] / count, integrator.counts_rhs, t0=t0)


def piece_clock(whole: Clock, bounds: Sequence[float], begin: float, end: float) -> Clock:
    """The clock of a piece from `begin` to `end`.

    The input jumps at each end of a piece except at the ends of the whole motion. Functions of Python see only times between
    two jumps, so that it does not matter whether the input has its old or its new value at the time of the jump.
    """
    first = begin if begin == bounds[0] else math.nextafter(begin, end)
    last = end if end == bounds[-1] else math.nextafter(end, begin)
    return replace(whole, t0=begin, first=min(first, last), last=max(first, last))


def array(values: Any, name: str) -> Floats:
    """A sequence of finite numbers as an array (n,). Raises ValueError with the name for other values."""
    try:
        numbers = np.array(values)
        if numbers.dtype.kind != "c":
            numbers = numbers.astype(np.float64)
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if numbers.dtype.kind == "c":
        raise ValueError(f"{name}={short(values)} is complex: {IN_PARTS}")
    if numbers.ndim != 1 or not len(numbers) or not np.isfinite(numbers).all():
        raise ValueError(f"{name}={short(values)}: give a sequence of finite numbers")
    return numbers


@dataclass(frozen=True)
class Stated:
    """The equations of a call, as `fun`, `args` and `events` state them: a form, or a function of the user's."""

    fun: Callable[..., Any] | Form | CaseEquations
    arguments: Arguments
    events: Sequence[Callable[..., Any]] = ()
    accelerations: bool = False
    jac: Any = None
    derived: bool = False
    """Whether forms that the function does not state are derived by tracing."""

    def by(self, clock: Clock, start: Floats, before: Sequence[int] = ()) -> "Equations":
        """The equations by a clock; `before`: the number of each event before this start. Raises ValueError."""
        if isinstance(self.fun, CaseEquations):
            return Equations(self.fun.forms, list(self.fun.parameters.values()))
        if isinstance(self.fun, Form):
            numbers = self.arguments.numbers
            implied = (
                of_bodies(self.fun, len(start), len(numbers)) if isinstance(self.fun, NBody) else first_order(self.fun)
            )
            return Equations((self.fun, *(x for x in (implied,) if x not in (None, self.fun))), numbers)
        own = OwnEquations(self.fun, clock, self.arguments, start, self.accelerations)
        if self.jac is not None:
            own.with_jacobian(self.jac)
        if self.events:
            return Equations((with_events(own, self.events, before),), own.parameters, own)
        if not self.derived or own.called is not None:
            return Equations(own.forms, own.parameters, own)
        first = next(form for form in own.forms if isinstance(form, FirstOrder))
        derived = derive_forms(first, len(start), len(own.parameters))
        forms = (*own.forms, *(form for form in derived.forms if type(form) is not FirstOrder))
        if derived.order != tuple(range(len(start))):
            forms = derived.forms
        factors = None if derived.factors is None else np.array(derived.factors(tuple(own.parameters)))
        forms = derived.forms if factors is not None else forms
        return Equations(forms, own.parameters, own, derived.order, factors, derived.lacking)


@dataclass(frozen=True)
class Equations:
    """The equations of a piece, the most structured form first; `own` if they are a function of the user's."""

    forms: tuple[Form, ...]
    parameters: list[float]
    own: OwnEquations | None = None
    order: tuple[int, ...] | None = None
    """The place of each component of the forms' state in the user's state; None if the places are equal."""
    factors: Floats | None = None
    """The velocity over the user's coordinate of each component, by the user's sequence; None if all are 1."""
    lacking: str = ""
    """The reason why no accelerations that depend only on positions were derived; "" if there are some."""

    def given(self, clock: Clock, state: Floats) -> Floats:
        """A state in the form of the user, changed into a state of the forms."""
        form_state: Floats = state if self.own is None else clock.given(state)
        form_state = form_state if self.factors is None else form_state * self.factors
        return form_state if self.order is None else form_state[list(self.order)]

    def back(self, clock: Clock, states: Floats) -> Floats:
        """States (n, dim) of the forms, changed into states in the form of the user."""
        own_states: Floats = clock.own(states)
        own_states = own_states if self.order is None else own_states[:, np.argsort(self.order)]
        return own_states if self.factors is None else own_states / self.factors


@dataclass
class Course:
    """The states at the wanted times, nan where the method did not arrive, and the events, by the user's clock."""

    states: Floats
    calls: int = 0
    stopped: str | None = None
    step: float | None = None
    """The size of fixed steps, the longest of all pieces."""
    exact: bool = True
    """Whether all steps have the size `step`, except shorter steps that end at a sample."""
    t_events: list[list[float]] = field(default_factory=list)
    end: float | None = None
    """The time of a terminal event."""
    changes: list[float] = field(default_factory=list)
    """The times of events of a form, which may change the state."""


@dataclass
class Motion:
    """The motion from a start, over pieces that begin and end at `bounds`, by the user's clock."""

    stated: Stated
    integrator: Integrator
    setting: float
    start: Floats
    whole: Times
    bounds: Sequence[float]
    pieces: dict[float, Equations] = field(default_factory=dict)
    """The equations of each piece, by its first time, for a second integration."""
    scales: dict[float, float] = field(default_factory=dict)
    """The time scale of each piece, by its first time: a second integration then has equal first steps."""
    is_repeated: bool = False
    """Whether the motion has been integrated already."""

    def at(self, wanted: Floats, to_end: bool = True) -> Course:
        """Integrate to the `wanted` times, which begin after the start, and with `to_end` further to the end of the span."""
        course = Course(np.full((len(wanted), len(self.start)), np.nan), t_events=[[] for _ in self.stated.events])
        state, direction = self.start, self.whole.clock.direction
        passed = 0
        for begin, end in pairwise(self.bounds):
            here = wanted[passed : np.searchsorted(direction * wanted, direction * end, "right")]
            last = not to_end and passed + len(here) == len(wanted)
            ends = here if last or (len(here) and here[-1] == end) else np.append(here, end)
            if len(ends):
                state = self._piece(course, begin, end, ends, state, passed, len(here))
            passed += len(here)
            if last or course.stopped is not None or course.end is not None:
                break
        self.is_repeated = True
        return course

    def _piece(
        self, course: Course, begin: float, end: float, ends: Floats, state: Floats, passed: int, count: int
    ) -> Floats:
        """Integrate a piece from `begin` to the times `ends`, and return the last state; the first `count` times are wanted."""
        whole = self.whole.clock
        times = Times.of((begin, ends[-1]), ends, whole.mirrored, whole.scale)
        times = replace(times, clock=piece_clock(whole, self.bounds, begin, end))
        if begin not in self.pieces:
            self.pieces[begin] = self.stated.by(times.clock, state, [len(each) for each in course.t_events])
        equations, clock = self.pieces[begin], times.clock
        own = equations.own
        called = None if own is None else own.called
        if called is not None and (self.is_repeated or isinstance(self.integrator.sweep, Steps)):
            called.watch = None  # fixed steps have the size that was asked for
        form = first_taken(self.integrator, equations.forms)
        problem = times.problem(form, len(state), equations.parameters, self.integrator, own is None)
        problem = replace(problem, time_scale=self.scales.setdefault(begin, problem.time_scale))
        integrator, step, exact = self.with_step(problem)
        solution, calls = _run(integrator, problem, step, equations.given(clock, state), own)
        course.calls += calls
        if isinstance(self.integrator.sweep, Steps):
            course.step, course.exact = max(course.step or 0.0, step * clock.scale), course.exact and exact
        states = equations.back(clock, solution.states[0])
        course.states[passed : passed + count] = states[:count]
        course.stopped = solution.stopped
        self._add_events(course, solution, clock)
        return np.array(states[-1])

    def with_step(self, problem: Problem) -> tuple[Integrator, float, bool]:
        """(integrator, setting, exact); `exact` is False if steps may have other sizes than the setting.

        Steps end at evenly spaced times. For other times, or times closer than a step, a one-step method of gnomon computes
        a sample by a shorter step, and goes on from the full step. Any other method takes steps of at most the mean distance
        of the times.
        """
        if not isinstance(self.integrator.sweep, Steps):
            return self.integrator, self.setting, True
        setting = min(self.setting / self.whole.clock.scale, float(problem.elapsed[-1]))
        aside = isinstance(self.integrator, FixedStep) and self.integrator.may_stop_aside
        if problem.uniform and (setting <= problem.interval or not aside):
            return self.integrator, problem.interval / math.ceil(problem.interval / setting * (1 - EVEN)), True
        if not aside:
            return self.integrator, min(setting, problem.interval), False
        integrator = copy.copy(self.integrator)
        integrator.stops_aside = True  # type: ignore[attr-defined]
        return integrator, setting, True

    def _add_events(self, course: Course, solution: Solution, clock: Clock) -> None:
        if not self.stated.events:
            course.changes += [time for time, _ in solution.events or ()]
        for number, event in enumerate(self.stated.events):
            most = most_occurrences(event)
            for time, name in solution.events or ():
                which, way = name.split()
                if int(which) == number and is_counted(event, 1 if way == "up" else -1):
                    course.t_events[number].append(float(clock.time(time)))
            if most and len(course.t_events[number]) >= most:
                course.end = course.t_events[number][-1]


def _run(
    integrator: Integrator, problem: Problem, setting: float, start: Floats, own: OwnEquations | None
) -> tuple[Solution, int]:
    """The solution, and the number of right-hand sides, if they are counted."""
    with show(integrator.id):
        try:
            prepared = Prepared(integrator, problem, setting)
        except Exception as error:
            if own is None or own.called is None:
                raise
            with Prepared(integrator, replace(problem, form=FirstOrder(at_rest)), setting):
                pass  # raises if the method declines more than these equations
            why = f"{place(own.own.function)} has none: {own.reason[:160]}"
            raise Refused(f"{integrator.id} needs the equations as formulas, and {why}") from error
        with prepared:
            try:
                return prepared.counted(start[None])
            except Unusable as error:
                raise ValueError(f"{integrator.id} {error}") from None
            finally:
                if own is not None:
                    own.raise_failure()
