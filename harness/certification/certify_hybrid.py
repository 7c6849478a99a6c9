"""Certificates of hybrid motions: each flight between two events, and guard and reset at each event."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.case import Case, Event
from gnomon.cases.core.forms import Equations, Hybrid
from gnomon.harness.certification.agreement import DIGITS, against, agreed, residual, series_field, sizes
from gnomon.reference.numerics.precision import exact, working
from gnomon.reference.numerics.taylor import integrate


def flight_ways(case: Case, hybrid: Hybrid) -> dict[str, float]:
    """`residual` in the middle of flights; `taylor` over flights, with guards and resets."""
    flights = list(_flights(case, hybrid))
    return {
        "residual": min(_flight_residual(case, flight) for flight in flights),
        "taylor": min(_flight_taylor(case, flight) for flight in flights),
    }


@dataclass(frozen=True)
class _Flight:
    """One smooth part of a hybrid motion, from the state after an event to the state before the next one."""

    equations: Equations
    constants: tuple[float, ...]
    begin: Fraction
    start: tuple[Any, ...]
    end: Fraction
    final: Event | None
    guard: Equations | None
    reset: Equations | None


def _flights(case: Case, hybrid: Hybrid) -> Iterable[_Flight]:
    """The flights up to the first `limit` event or the end of the span, at equal strides if there are many."""
    parameters = tuple(float(v) for v in case.parameter_values())
    mode = hybrid.start(0.0, tuple(map(float, case.initial_state)), parameters)
    begin, start = Fraction(0), tuple(case.initial_state)
    stretches = []
    for event in case.events(3 * DIGITS):
        if event.name == "limit":
            break
        transition = next(t for t in hybrid.transitions if t.name == event.name and t.mode == mode)
        here = hybrid.mode(mode)
        stretches.append(
            _Flight(
                here.equations,
                here.constants,
                begin,
                start,
                exact(event.time),
                event,
                transition.guard,
                transition.reset,
            )
        )
        begin, start = exact(event.time), tuple(event.after)
        mode = transition.lands(float(event.time), tuple(map(float, event.after)), parameters)
    else:
        if begin < case.span:
            here = hybrid.mode(mode)
            stretches.append(_Flight(here.equations, here.constants, begin, start, case.span, None, None, None))
    stride = max(1, len(stretches) // 12)
    return stretches[::stride]


def _flight_residual(case: Case, flight: _Flight) -> float:
    middle = (flight.begin + flight.end) / 2
    return residual(case, flight.equations, middle, flight.constants)


def _flight_taylor(case: Case, flight: _Flight) -> float:
    """Digits of the state at the end of a flight, by integration, of the guard's zero and of the state after reset."""
    start = [exact(x) for x in flight.start]
    values = (*case.parameter_values(), *map(Fraction, flight.constants))
    field = series_field(flight.equations, values, flight.begin)
    found = integrate(field, start, [flight.end - flight.begin], DIGITS + 20)[0]
    if flight.final is None:
        return against(case, {flight.end: found})
    with working(3 * DIGITS) as mp:
        parameters = tuple(map(mp.mpf, case.parameter_values()))
        before = tuple(map(mp.mpf, flight.final.before))
        pairs = [(b - mp.mpf(f), size) for b, f, size in zip(before, found, sizes(case), strict=True)]
        assert flight.guard is not None
        assert flight.reset is not None
        arithmetic = mpmath_arithmetic(mp)
        guard = rebind(flight.guard, arithmetic)(mp.mpf(flight.end), before, parameters)[0]
        pairs.append((guard, max(sizes(case))))
        image = rebind(flight.reset, arithmetic)(mp.mpf(flight.end), before, parameters)
        pairs += [(i - mp.mpf(a), size) for i, a, size in zip(image, flight.final.after, sizes(case), strict=True)]
    return agreed(pairs)
