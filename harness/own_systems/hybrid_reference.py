"""The reference of motions with events, in high precision: Taylor series with roots of the guards, and extrapolation.

The second way takes from the first only the sequence of events and where to look for each: it integrates from event to event
by the extrapolated midpoint rule and finds the zero of the guard by its own values.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import flint
import numpy as np
from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.case import Event
from gnomon.cases.core.forms import Hybrid, Transition
from gnomon.harness.contract.integrator import Floats, Solution
from gnomon.harness.measuring.rounding_effect import RoughMotion
from gnomon.harness.own_systems.smooth_reference import MARGIN, Reference, solve_tightly
from gnomon.harness.system.supervisor import calls
from gnomon.reference.integration.taylor_events import Exit, Happened, Limit, ModesPath
from gnomon.reference.numerics.balls import ball, precision
from gnomon.reference.numerics.extrapolation import extrapolate
from gnomon.reference.numerics.taylor import _fraction, flint_arithmetic
from mpmath import mpf

DIGITS, SPARE, ROUGH_DIGITS = 21, 3, 22
SETTLED = 1e-4
"""The reference settles after this share of the form's `settle`: the limit mode is entered that much closer to the limit."""
SECANT = 8
GRID = 257
METHODS = ("Taylor series with roots of the guards", "the extrapolated midpoint rule")


class HybridMotion:
    """A hybrid form from a start over a span, in high precision."""

    def __init__(self, form: Hybrid, start: Sequence[Fraction], parameters: Sequence[Fraction], span: float) -> None:
        self.form, self.start, self.parameters, self.span = form, tuple(start), tuple(parameters), Fraction(span)
        self._numbers = tuple(map(float, parameters))

    @cached_property
    def path(self) -> ModesPath:
        return self._path(DIGITS + SPARE)

    def _path(self, digits: int) -> ModesPath:
        form = self.form
        fields = {mode.name: self.function(mode.equations, mode.constants) for mode in form.modes}
        exits: dict[str, list[Exit]] = {mode.name: [] for mode in form.modes}
        for transition in form.transitions:
            exits[transition.mode].append(self._exit(transition))
        limits = {name: (mode, self.function(reset)) for name, mode, reset in form.limits}
        settle = Fraction(form.settle * SETTLED) if form.settle == form.settle else Fraction(0)
        mode = form.start(0.0, tuple(map(float, self.start)), self._numbers)
        return ModesPath(fields, exits, mode, self.start, self.span, digits, Limit(settle, limits))

    def function(self, function: Callable[..., Any], constants: Sequence[float] = ()) -> Callable[[Any, Any], Any]:
        rebound = rebind(function, flint_arithmetic())
        values = (*self.parameters, *map(Fraction, constants))
        return lambda t, state: tuple(rebound(t, state, tuple(map(ball, values))))

    def _exit(self, transition: Transition) -> Exit:
        guard, sign = self.function(transition.guard), -transition.direction

        def lands(t: Fraction, state: tuple[Fraction, ...]) -> str:
            return transition.lands(float(t), tuple(map(float, state)), self._numbers)

        return Exit(transition.name, lambda t, y: sign * guard(t, y)[0], self.function(transition.reset), lands)

    def by_extrapolation(
        self, times: Sequence[Fraction], sizes: Sequence[Fraction], unit: Fraction
    ) -> tuple[list[Any], list[Fraction]]:
        """The states at times and the times of the events, from event to event."""
        path, states, happened = self.path, list[Any](), list[Fraction]()
        here, now = self.start, Fraction(0)
        for number in range(len(path.modes)):
            mode = self.form.mode(path.modes[number][1])
            end = path.events[number].time if number < len(path.events) else self.span
            field = _Flight(self.function(mode.equations, mode.constants), sizes, unit)
            inside = (
                [t for t in times if now <= t < end] if number < len(path.events) else [t for t in times if t >= now]
            )
            if inside:
                states += field.states(now, here, inside)
            if number == len(path.events):
                break
            event = path.events[number]
            own, before = self._zero(event, field, now, here, mode.name)
            happened.append(own)
            with precision(path.bits):
                reset = self._reset(event, mode.name)
                here = tuple(_exact(x) for x in reset(ball(own), tuple(map(ball, before))))
            now = own
        return states, happened

    def _transition(self, event: Happened, mode: str) -> Transition:
        return next(each for each in self.form.transitions if (each.name, each.mode) == (event.by, mode))

    def _reset(self, event: Happened, mode: str) -> Callable[[Any, Any], Any]:
        to_limits = {name: reset for name, _, reset in self.form.limits}
        return self.function(to_limits[event.by] if event.name == "limit" else self._transition(event, mode).reset)

    def _zero(
        self, event: Happened, flight: _Flight, now: Fraction, here: tuple[Fraction, ...], mode: str
    ) -> tuple[Fraction, tuple[Fraction, ...]]:
        """The time of an event and the state before it, by the secant rule from near to the first way's time."""
        guard = self.function(self._transition(event, mode).guard)

        def value(t: Fraction, state: Sequence[Fraction]) -> Fraction:
            with precision(self.path.bits):
                return _exact(guard(ball(t), tuple(map(ball, state)))[0])

        length = event.time - now
        near = now + length * Fraction(1 - 2**-12) if length > 0 else now
        near = near.limit_denominator(10**40) if near != now else now
        base = flight.states(now, here, [near])[0] if near > now else here
        a, b = event.time - (event.time - near) / 2**10, event.time + (event.time - near) / 2**10
        states = [flight.states(near, base, [t])[0] for t in (a, b)]
        values = [value(t, x) for t, x in zip((a, b), states, strict=True)]
        for _ in range(SECANT):
            if values[1] == values[0]:
                break
            c = b - values[1] * (b - a) / (values[1] - values[0])
            if abs(c - b) <= self.span * Fraction(1, 10 ** (DIGITS + 4)):
                break
            a, b, values = b, c, [values[1], Fraction(0)]
            states = [states[1], flight.states(near, base, [b])[0]]
            values[1] = value(b, states[1])
        return b, states[1]


class _Flight:
    """The equations of a mode over scaled time and states, by the extrapolated midpoint rule."""

    def __init__(self, field: Callable[[Any, Any], Any], sizes: Sequence[Fraction], unit: Fraction) -> None:
        self.field, self.sizes, self.unit = field, sizes, unit

    def states(
        self, begin: Fraction, start: Sequence[Fraction], times: Sequence[Fraction]
    ) -> list[tuple[Fraction, ...]]:
        sizes, length = self.sizes, times[-1] - begin
        if length <= 0:
            return [tuple(start)] * len(times)
        unit = min(self.unit, Fraction(2) ** math.frexp(float(length))[1])

        def scaled(t: Any, state: tuple[Any, ...]) -> tuple[Any, ...]:
            own = tuple(x * ball(s) for x, s in zip(state, sizes, strict=True))
            rates = self.field(t * ball(unit) + ball(begin), own)
            return tuple(x * ball(unit / s) for x, s in zip(rates, sizes, strict=True))

        moments = [(t - begin) / unit for t in times]
        late = [t for t in moments if t > 0]
        first = [x / s for x, s in zip(start, sizes, strict=True)]
        rows = extrapolate(scaled, first, late, DIGITS, Fraction(1, 4))
        every = [tuple(first)] * (len(moments) - len(late)) + rows
        return [tuple(x * s for x, s in zip(row, sizes, strict=True)) for row in every]


def _exact(x: Any) -> Fraction:
    return _fraction(flint.arb(x))


def rough_hybrid(motion: HybridMotion) -> RoughMotion:
    """The motion on a grid of the span, rounded to binary64."""
    times = np.linspace(0, float(motion.span), GRID)
    states = _round_states(motion, times)
    return RoughMotion.of(times, states, np.max(np.abs(_rates(motion, times, states)), axis=0))


def _round_states(motion: HybridMotion, times: Floats) -> Floats:
    return np.array([[float(x) for x in motion.path.value(Fraction(t))] for t in times.tolist()])


def _rates(motion: HybridMotion, times: Floats, states: Floats) -> Floats:
    """The rates (n, dim) of states at times, in the modes that hold there."""
    numbers, rates = tuple(map(float, motion.parameters)), []
    for t, row in zip(times.tolist(), states.tolist(), strict=True):
        mode = motion.form.mode(motion.path.mode_at(Fraction(t)))
        rates.append(mode.equations(t, tuple(row), (*numbers, *mode.constants)))
    return np.array(rates, dtype=np.float64)


def case_events(motion: HybridMotion) -> tuple[Event, ...]:
    """The events as a case lists them."""

    def number(x: Fraction) -> Any:
        return mpf(x.numerator) / mpf(x.denominator)

    return tuple(
        Event(number(e.time), e.name, tuple(map(number, e.before)), tuple(map(number, e.after)))
        for e in motion.path.events
    )


def hybrid_reference(motion: HybridMotion, times: Floats, rough: RoughMotion) -> Reference:
    """The reference at increasing times. Raises ArithmeticError where a way does not reach the end."""
    moments, sizes = [Fraction(t) for t in times.tolist()], rough.sizes.tolist()
    first = [motion.path.value(t) for t in moments]
    powers = [Fraction(2) ** math.frexp(s)[1] for s in sizes]
    second, happened = motion.by_extrapolation(moments, powers, Fraction(2) ** math.frexp(rough.time_scale)[1])
    differences = [
        max(float(abs(a - b)) / s for a, b, s in zip(x, y, sizes, strict=True))
        for x, y in zip(first, second, strict=True)
    ]
    apart = max((float(abs(a - e.time)) for a, e in zip(happened, motion.path.events, strict=True)), default=0.0)
    states = np.array([[float(x) for x in row] for row in first])
    return Reference(states, np.array(differences), METHODS, DIGITS, event_error=MARGIN * apart)


def hybrid_effect(motion: HybridMotion, times: Floats, rough: RoughMotion) -> tuple[Floats, Floats]:
    """The effects of rounding, as `rounding_effect`, from motions that start half an ulp away with the same events."""
    numbers = [*motion.start, *motion.parameters]
    own = len(motion.start)
    moved = [k for k, x in enumerate(numbers) if x]
    moments = [Fraction(t) for t in times.tolist()]

    def neighbour(k: int) -> Floats | None:
        changed = list(numbers)
        changed[k] += Fraction(float(np.spacing(abs(float(numbers[k]))))) / 2
        other = HybridMotion(motion.form, changed[:own], changed[own:], float(motion.span))
        path = other._path(ROUGH_DIGITS)
        if [e.name for e in path.events] != [e.name for e in nominal.events]:
            return None
        rows = [[float(x - y) for x, y in zip(path.value(t), nominal.value(t), strict=True)] for t in moments]
        return np.asarray(np.max(np.abs(np.array(rows)) / rough.sizes, axis=1))

    nominal = motion._path(ROUGH_DIGITS)
    effects = dict(calls(neighbour, moved, 2, "fork"))
    total, start = np.zeros(len(times)), np.zeros(len(times))
    for k, effect in effects.items():
        if isinstance(effect, BaseException):
            raise effect
        if effect is not None:
            total += effect**2
            start += effect**2 if k < own else 0
    rates = _rates(motion, times, _round_states(motion, times))
    ticks = np.max(np.abs(rates) / rough.sizes, axis=1) * np.spacing(times) / 2
    return np.sqrt(start), np.sqrt(total + ticks**2)


TIGHT_METHODS = ("gnomon:DOP853 [events]", "scipy:DOP853 [events]")
"""The two methods in binary64, where the functions of a form are not known in high precision."""


def binary64_events(
    form: Hybrid, start: Floats, parameters: Sequence[float], span: float
) -> tuple[tuple[Event, ...], RoughMotion]:
    """The events as a tight method locates them, and the motion on a grid. Raises ValueError if it does not reach the end."""
    times = np.linspace(0, span, GRID)
    solution = _tight_solution(TIGHT_METHODS[0], form, start, parameters, times[1:])
    states = np.vstack([start, solution.states[0]])
    slopes = np.max(np.abs(np.diff(states, axis=0)), axis=0) / times[1]
    events = tuple(Event(mpf(t), name, (), ()) for t, name in solution.events or ())
    return events, RoughMotion.of(times, states, slopes)


def hybrid_in_binary64(
    form: Hybrid, start: Floats, parameters: Sequence[float], times: Floats, rough: RoughMotion, why: str
) -> Reference:
    """The reference by two tight methods with events. Raises ValueError if one does not reach the end."""
    first, second = (_tight_solution(name, form, start, parameters, times) for name in TIGHT_METHODS)
    differences = np.max(np.abs(first.states[0] - second.states[0]) / rough.sizes, axis=1)
    apart = max(
        (abs(a - b) for (a, _), (b, _) in zip(first.events or (), second.events or (), strict=False)), default=0.0
    )
    return Reference(
        first.states[0], np.maximum(differences, 2.0**-53), TIGHT_METHODS, 16, why, event_error=MARGIN * apart
    )


def _tight_solution(name: str, form: Hybrid, start: Floats, parameters: Sequence[float], times: Floats) -> Solution:
    settled = replace(form, settle=0.0) if math.isnan(form.settle) else form
    return solve_tightly(name, [settled], start, parameters, times, float(times[-1]) / GRID)
