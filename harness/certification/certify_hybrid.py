"""Certificates of hybrid motions: each flight between two events, and guard and reset at each event."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.case import Case, Event
from gnomon.cases.core.forms import Hybrid, Mode, Transition
from gnomon.harness.certification.agreement import (
    DIGITS,
    against,
    count_agreed_digits,
    count_agreed_in_states,
    residual,
    series_field,
    sizes,
)
from gnomon.reference.numerics.precision import exact, working
from gnomon.reference.numerics.taylor import integrate


def flight_ways(case: Case, hybrid: Hybrid) -> dict[str, float]:
    """`residual` in the middle of flights; `taylor` over flights, with guards and resets."""
    flights = _flights(case, hybrid)
    return {
        "residual": min(
            residual(case, flight.mode.equations, (flight.begin + flight.end) / 2, flight.mode.constants)
            for flight in flights
        ),
        "taylor": min(_flight_taylor(case, flight) for flight in flights),
    }


@dataclass(frozen=True)
class _Flight:
    """A smooth part of a hybrid motion: from the state after an event to the next event, or to the end of the span."""

    mode: Mode
    begin: Fraction
    start: tuple[Any, ...]
    end: Fraction
    ended: tuple[Event, Transition] | None = None


def _flights(case: Case, hybrid: Hybrid) -> list[_Flight]:
    """The flights up to the end of the span, at equal strides if there are many; the last of an accumulation are left out."""
    parameters = tuple(float(v) for v in case.parameter_values())
    mode = hybrid.start(0.0, tuple(map(float, case.initial_state)), parameters)
    begin, start = Fraction(0), tuple(case.initial_state)
    flights, last = [], ""
    for event in case.events(3 * DIGITS):
        if event.name == "limit":
            mode = next(target for name, target, _ in hybrid.limits if name == last)
            begin, start = exact(event.time), tuple(event.after)
            continue
        transition = next(t for t in hybrid.transitions if t.name == event.name and t.mode == mode)
        flights.append(_Flight(hybrid.mode(mode), begin, start, exact(event.time), (event, transition)))
        begin, start = exact(event.time), tuple(event.after)
        mode, last = transition.lands(float(event.time), tuple(map(float, event.after)), parameters), event.name
    if begin < case.span:
        flights.append(_Flight(hybrid.mode(mode), begin, start, case.span))
    return flights[:: max(1, len(flights) // 12)]


def _flight_taylor(case: Case, flight: _Flight) -> float:
    """Digits of the state at the end of a flight, by integration, of the guard's zero and of the state after reset."""
    start = [exact(x) for x in flight.start]
    values = (*case.parameter_values(), *map(Fraction, flight.mode.constants))
    field = series_field(flight.mode.equations, values, flight.begin)
    landing = integrate(field, start, [flight.end - flight.begin], DIGITS + 20)[0]
    if flight.ended is None:
        return against(case, {flight.end: landing})
    event, transition = flight.ended
    with working(3 * DIGITS) as mp:
        at = mp.mpf(flight.end), tuple(map(mp.mpf, event.before)), tuple(map(mp.mpf, case.parameter_values()))
        guard, reset = (rebind(f, mpmath_arithmetic(mp))(*at) for f in (transition.guard, transition.reset))
        states = count_agreed_in_states(case, [(event.before, landing), (reset, event.after)])
        return min(states, count_agreed_digits([(guard[0], max(sizes(case)))]))
