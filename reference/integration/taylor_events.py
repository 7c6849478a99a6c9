"""Motions of several modes in high precision, by Taylor series whose steps end where a guard crosses zero.

A guard is evaluated on the series of the state, so that a step has the guard's own polynomial; its first root in the step is
the event. A root at the begin of a flight, where the last event lies, is divided out.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np
from gnomon.reference.numerics.balls import ball, precision
from gnomon.reference.numerics.series import Series, Tape
from gnomon.reference.numerics.taylor import Field, _fraction, _step, _value

MOST_FLIGHTS, MOST_STEPS = 3000, 20_000
NEWTON = 12

Guard = Callable[[Any, tuple[Any, ...]], Any]
"""(t, state) -> a number that is positive before its event."""


@dataclass(frozen=True)
class Exit:
    """A way out of a mode: its guard, and the state and the mode after it."""

    name: str
    guard: Guard
    reset: Field
    after: Callable[[Fraction, tuple[Fraction, ...]], str]


@dataclass(frozen=True)
class Happened:
    """An event: its time, name, the states before and after it, and the name of its way out, also of a limit."""

    time: Fraction
    name: str
    before: tuple[Fraction, ...]
    after: tuple[Fraction, ...]
    by: str


@dataclass(frozen=True)
class Limit:
    """The mode and the state in which events that follow each other within `settle` end, by the name of the event."""

    settle: Fraction
    modes: dict[str, tuple[str, Field]]


class ModesPath:
    """The motion up to `span`: `events`, and the state at any time."""

    def __init__(
        self, fields: dict[str, Field], exits: Mapping[str, Sequence[Exit]], mode: str, start: Sequence[Fraction],
        span: Fraction, digits: int, limit: Limit,
    ) -> None:  # fmt: skip
        self.fields, self.exits, self.limit, self.span = fields, exits, limit, span
        self.bits = math.ceil((digits + 15) * math.log2(10))
        self.order = math.ceil(digits * math.log(10) / 2) + 2
        self.events: list[Happened] = []
        self.modes: list[tuple[Fraction, str, tuple[Fraction, ...]]] = [(Fraction(0), mode, tuple(start))]
        """The begin of each flight, its mode, and the state there."""
        self._begins: list[Fraction] = []
        self._series: list[list[list[Any]]] = []
        with precision(self.bits):
            self._run(mode, [ball(x) for x in start])

    def value(self, t: Fraction) -> tuple[Fraction, ...]:
        """The state at a time; at an event the state after it."""
        with precision(self.bits):
            index = max(bisect.bisect_right(self._begins, t) - 1, 0)
            return tuple(_fraction(_value(c, t - self._begins[index])) for c in self._series[index])

    def mode_at(self, t: Fraction) -> str:
        """The mode at a time."""
        return next(mode for begin, mode, _ in reversed(self.modes) if begin <= t)

    def _run(self, mode: str, here: list[Any]) -> None:
        flows: dict[str, _GuardedFlow] = {}
        now, fired, last = Fraction(0), False, dict[str, Fraction]()
        while now < self.span:
            if mode not in flows:
                flows[mode] = _GuardedFlow(self.fields[mode], [e.guard for e in self.exits[mode]], len(here))
            if len(self.events) > MOST_FLIGHTS or len(self._series) > MOST_STEPS:
                what = (
                    f"{len(self.events)} events"
                    if len(self.events) > MOST_FLIGHTS
                    else f"{len(self._series)} Taylor steps"
                )
                raise ArithmeticError(f"{what} until t = {float(now):.9g}")
            series, guards = flows[mode].series(now, here, self.order)
            step = min(_step(series, self.order), self.span - now)
            self._begins.append(now)
            self._series.append([list(c) for c in series])
            crossing = self._first(guards, step, fired)
            if crossing is None:
                here, now, fired = [_value(c, step) for c in series], now + step, False
                continue
            length, index = crossing
            exit_ = self.exits[mode][index]
            before = [_value(c, length) for c in series]
            now += length
            mode, here = self._pass(exit_, now, before, last)
            fired = True

    def _pass(self, exit_: Exit, now: Fraction, before: list[Any], last: dict[str, Fraction]) -> tuple[str, list[Any]]:
        rapid = exit_.name in self.limit.modes and now - last.get(exit_.name, -self.span) <= self.limit.settle
        target, reset = self.limit.modes[exit_.name] if rapid else ("", exit_.reset)
        here = [flint.arb(x).mid() for x in reset(ball(now), tuple(before))]
        after = tuple(map(_fraction, here))
        name = "limit" if rapid else exit_.name
        self.events.append(Happened(now, name, tuple(map(_fraction, before)), after, exit_.name))
        last[exit_.name] = now
        mode = target or exit_.after(now, after)
        self.modes.append((now, mode, after))
        return mode, here

    def _first(self, guards: Sequence[list[Any]], step: Fraction, fired: bool) -> tuple[Fraction, int] | None:
        """The first crossing in a step, and the number of its guard."""
        crossings = [(root, k) for k, c in enumerate(guards) for root in [_root(c, step, fired)] if root is not None]
        return min(crossings, default=None)


class _GuardedFlow:
    """Taylor coefficients of the solution through any state, and of the guards along it."""

    def __init__(self, field: Field, guards: Sequence[Guard], dimension: int) -> None:
        self.tape = Tape(flint.arb(0))
        self.time = self.tape.variable()
        self.state = tuple(self.tape.variable() for _ in range(dimension))
        self.rates = field(self.time, self.state)
        self.first = len(self.tape.nodes)
        self.guards = [guard(self.time, self.state) for guard in guards]

    def series(self, now: Fraction, here: list[Any], order: int) -> tuple[list[list[Any]], list[list[Any]]]:
        zero = self.tape.zero
        self.tape.clear()
        self.time.c[:] = [ball(now), flint.arb(1)] + [zero] * order
        for y, x in zip(self.state, here, strict=True):
            y.c[:] = [x]
        for k in range(order + 1):
            self.tape.extend(k)
            if k == order:
                break
            for y, rate in zip(self.state, self.rates, strict=True):
                term = rate.c[k] if isinstance(rate, Series) else (flint.arb(rate) if k == 0 else zero)
                y.c.append(term.mid() / (k + 1))
        return [y.c for y in self.state], [self._of(g, order) for g in self.guards]

    def _of(self, guard: Any, order: int) -> list[Any]:
        if not isinstance(guard, Series):
            return [flint.arb(guard)]
        return [flint.arb(x).mid() for x in guard.c[: order + 1]]


def _root(coefficients: list[Any], step: Fraction, after_event: bool) -> Fraction | None:
    """The first time in (0, step] at which a polynomial falls through zero; None if it does not.

    `after_event`: whether a value of about zero at the begin is the last event.
    """
    h = ball(step)
    scaled, power = [], flint.arb(1)
    for c in coefficients:
        scaled.append(c * power)
        power = power * h
    largest = max(abs(float(c)) for c in scaled)
    if largest == 0:
        return None
    values = np.array([float(c) for c in scaled]) / largest
    if after_event and abs(float(scaled[0])) < 1e-12 * largest and _is_rounding(scaled[0], largest):
        scaled, values = scaled[1:], values[1:]
        if not len(values) or not np.any(values):
            return None
    keep = np.flatnonzero(np.abs(values) > 1e-30)
    roots = np.roots(values[: keep[-1] + 1][::-1]) if len(keep) and keep[-1] > 0 else np.array([])
    real = sorted(float(z.real) for z in roots if abs(z.imag) < 1e-5 * abs(z) + 1e-14 and -1e-9 < z.real <= 1 + 1e-9)
    for guess in real:
        x = _refined(scaled, guess)
        if x is not None and 0 < x <= 1 and _falls(scaled, x):
            return _fraction(x) * step
    return None


def _is_rounding(value: Any, largest: float) -> bool:
    return bool(abs(float(value)) < largest * 2.0 ** (-0.6 * flint.ctx.prec))


def _refined(coefficients: list[Any], guess: float) -> Any:
    """Newton's method from a root in binary64; None if it goes away."""
    x = flint.arb(guess)
    for _ in range(NEWTON):
        value, slope = flint.arb(0), flint.arb(0)
        for c in reversed(coefficients):
            slope = slope * x + value
            value = value * x + c
        if slope.mid() == 0:
            return None
        change = (value.mid() / slope.mid()).mid()
        x = (x - change).mid()
        if abs(float(x) - guess) > 1e-4 * max(abs(guess), 1e-3):
            return None
        if change == 0 or abs(float(change)) <= abs(float(x)) * 2.0 ** (8 - flint.ctx.prec):
            break
    return x


def _falls(coefficients: list[Any], x: Any) -> bool:
    """Whether the polynomial goes from above zero to below it at a root."""
    slope = flint.arb(0)
    for k in range(len(coefficients) - 1, 0, -1):
        slope = slope * x + k * coefficients[k]
    return bool(slope.mid() < 0)
