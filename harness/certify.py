"""Certificates: how many digits of each exact motion are confirmed, and by which independent ways.

- `residual`: the equations of motion, with the derivative of the exact motion taken by central differences in three
  times the precision, at random times; and the initial state.
- `taylor`: a high-precision Taylor integration of the equations, which shares no formula with the exact motion, from
  the initial state; on long spans `windows`: the same from the exact state at 0 and at random times, over ten of the
  fastest times. A hybrid motion is integrated flight by flight, and the guard and the reset are checked at each event.
- `extrapolation`: for motions that are Taylor integrations themselves, by Gragg's midpoint rule extrapolated.
- `invariants`: the conserved quantities, at random times.
- `rounding`: the published digits against an evaluation in three times the precision (guard digits are enough).

Digits are relative to the size of the motion.
"""

from __future__ import annotations

import json
import random
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.cases.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.case import Case, Event
from gnomon.cases.forms import Equations, FirstOrder, Hybrid
from gnomon.reference.extrapolation import extrapolate
from gnomon.reference.precision import exact, working
from gnomon.reference.taylor import Field, ball, flint_arithmetic, integrate

DIGITS = 50
"""Digits to which a motion is evaluated, and beyond which agreement is not counted."""
REQUIRED = 45
"""Of a closed form; an integration states fewer."""
SPARE = 3
"""Digits beyond the required ones to which an integration is evaluated: each of them costs time."""
RANDOM_TIMES = 5
TAYLOR_STOPS = 4
SIZE_TIMES = 8
INTEGRATED_SCALES = 300
"""Spans up to so many of the fastest times are integrated from start to end."""
WINDOW_SCALES = 10


@dataclass(frozen=True)
class Certificate:
    """Digits agreed for one case. `ways` holds the digits of each way; `note` says why a way is missing."""

    case: str
    variant: str
    ways: dict[str, float]
    note: str = ""
    required: int = REQUIRED
    digits: float = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "digits", min(self.ways.values(), default=0.0))

    @property
    def passed(self) -> bool:
        """At least the required digits, by the evaluation itself and two independent ways."""
        return self.digits >= self.required and len(self.ways) >= 3


def certify(case: Case) -> Certificate:
    """Confirm a case's exact motion; the numbers are taken as the case has them."""
    times = _random_times(case)
    ways = {"rounding": _rounding(case, times)}
    hybrid = case.hybrid
    if hybrid is None:
        ways["residual"] = min(_start(case), *(_residual(case, _equations(case), t) for t in times))
        if case.certified_digits < REQUIRED:
            ways["extrapolation"] = _extrapolation(case)
        elif case.span <= INTEGRATED_SCALES * exact(case.fastest_time):
            ways["taylor"] = _taylor(case)
        else:
            ways["windows"] = min(_window(case, t) for t in (Fraction(0), *times))
        if any(invariant.law == "constant" for invariant in case.invariants.values()):
            ways["invariants"] = _invariants(case, times)
    else:
        flights = list(_flights(case, hybrid))
        ways["residual"] = min(_start(case), *(_flight_residual(case, flight) for flight in flights))
        ways["taylor"] = min(_flight_taylor(case, flight) for flight in flights)
    return Certificate(case.name, case.variant or "default", ways, required=case.certified_digits)


def write(certificates: Iterable[Certificate], path: Path) -> None:
    """The certificates as JSON, one object each, for the report."""
    path.write_text(json.dumps([asdict(c) | {"passed": c.passed} for c in certificates], indent=1) + "\n")


def _random_times(case: Case) -> list[Fraction]:
    """Repeatable times spread over the span, none of them special."""
    source = random.Random(case.id)
    return [case.span * (k + Fraction(source.random())) / RANDOM_TIMES for k in range(RANDOM_TIMES)]


@lru_cache(maxsize=8)
def _sizes(case: Case) -> tuple[float, ...]:
    """The size of each coordinate: the largest norm of its group at a few times of the motion."""
    states = np.array([[float(x) for x in case.exact(case.span * k / SIZE_TIMES)] for k in range(SIZE_TIMES + 1)])
    largest = {}
    for name in {coordinate.group for coordinate in case.state}:
        members = [i for i, coordinate in enumerate(case.state) if coordinate.group == name]
        norm = float(np.max(np.linalg.norm(states[:, members], axis=1)))
        largest[name] = norm or case.natural_sizes.get(name, 1.0)
    return tuple(largest[coordinate.group] for coordinate in case.state)


def _agreed(differences: Iterable[tuple[Any, float]]) -> float:
    """Decimal digits in which pairs (difference, size) agree, the worst, at most DIGITS."""
    worst = max((abs(difference) / size for difference, size in differences), default=0)
    return float(DIGITS) if worst == 0 else min(float(DIGITS), -float(_log10(worst)))


def _log10(x: Any) -> float:
    with working(20) as mp:
        return float(mp.log10(mp.mpf(x)))


def _equations(case: Case) -> Equations:
    form = next(form for form in case.all_forms() if isinstance(form, FirstOrder))
    return form.equations


def asked(case: Case) -> int:
    """Digits to which the case's motion is evaluated."""
    return DIGITS if case.certified_digits >= REQUIRED else case.certified_digits + SPARE


def _rounding(case: Case, times: Sequence[Fraction]) -> float:
    pairs = []
    many = 3 * DIGITS if case.certified_digits >= REQUIRED else 2 * asked(case)
    for t in times:
        short, long = case.exact(t, asked(case)), case.exact(t, many)
        with working(4 * DIGITS) as mp:
            pairs += [(mp.mpf(a) - mp.mpf(b), size) for a, b, size in zip(short, long, _sizes(case), strict=True)]
    return _agreed(pairs)


def _start(case: Case) -> float:
    with working(4 * DIGITS) as mp:
        start = case.exact(0, 2 * asked(case))
        return _agreed(
            (mp.mpf(a) - mp.mpf(b), size) for a, b, size in zip(start, case.initial_state, _sizes(case), strict=True)
        )


def _residual(case: Case, equations: Equations, t: Fraction, constants: tuple[float, ...] = ()) -> float:
    """Digits of x'(t) - f(t, x), relative to size over time scale; the difference step costs a third of the digits."""
    if case.certified_digits >= REQUIRED:
        digits, h = 4 * DIGITS, exact(case.time_scale) / 10**DIGITS
    else:
        digits, h = 2 * asked(case), exact(case.time_scale) / 10 ** (2 * asked(case) // 3)
    before, here, after = (case.exact(s, digits) for s in (t - h, t, t + h))
    with working(digits) as mp:
        rebound = rebind(equations, mpmath_arithmetic(mp))
        parameters = tuple(mp.mpf(v) for v in (*case.parameter_values(), *map(Fraction, constants)))
        rates = rebound(mp.mpf(t), tuple(map(mp.mpf, here)), parameters)
        return _agreed(
            (((mp.mpf(b) - mp.mpf(a)) / (2 * mp.mpf(h)) - rate) * case.time_scale, size)
            for a, b, rate, size in zip(before, after, rates, _sizes(case), strict=True)
        )


def _field(equations: Equations, values: Sequence[Fraction], offset: Fraction = Fraction(0)) -> Field:
    """The equations over power series, from the exact parameters; the series' time starts at `offset`."""
    rebound = rebind(equations, flint_arithmetic())

    def field(t: Any, state: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(rebound(t + ball(offset), state, tuple(map(ball, values))))

    return field


def _taylor(case: Case) -> float:
    times = [case.span * k / TAYLOR_STOPS for k in range(1, TAYLOR_STOPS + 1)]
    found = integrate(_field(_equations(case), case.parameter_values()), case.initial_state, times, DIGITS + 20)
    return _against(case, dict(zip(times, found, strict=True)))


def _extrapolation(case: Case) -> float:
    times = [case.span * k / TAYLOR_STOPS for k in range(1, TAYLOR_STOPS + 1)]
    field = _field(_equations(case), case.parameter_values())
    step = exact(case.fastest_time / 4).limit_denominator(10**6)
    found = extrapolate(field, case.initial_state, times, asked(case), step)
    return _against(case, dict(zip(times, found, strict=True)))


def _window(case: Case, begin: Fraction) -> float:
    """From the exact state at `begin` over a stretch that ends within the span."""
    width = min(WINDOW_SCALES * exact(case.fastest_time), case.span / 10)
    begin = min(begin, case.span - width)
    start = [exact(x) for x in case.exact(begin, 2 * DIGITS)]
    found = integrate(_field(_equations(case), case.parameter_values(), begin), start, [width], DIGITS + 20)
    return _against(case, {begin + width: found[0]})


def _against(case: Case, states: dict[Fraction, tuple[Fraction, ...]]) -> float:
    pairs = []
    for t, state in states.items():
        with working(2 * DIGITS) as mp:
            pairs += [
                (mp.mpf(a) - mp.mpf(b), size)
                for a, b, size in zip(case.exact(t, asked(case)), state, _sizes(case), strict=True)
            ]
    return _agreed(pairs)


def _invariants(case: Case, times: Sequence[Fraction]) -> float:
    """Drift of the constant invariants from their value at the start.

    Relative to the invariant, or to its change when one coordinate is off by its own size, whichever is larger: an
    invariant that happens to be zero has no size of its own.
    """
    pairs = []
    with working(2 * DIGITS) as mp:
        parameters = tuple(map(mp.mpf, case.parameter_values()))
        start = tuple(map(mp.mpf, case.initial_state))
        for invariant in case.invariants.values():
            if invariant.law != "constant":
                continue
            function = rebind(invariant.function, mpmath_arithmetic(mp))
            first = function(mp.mpf(0), start, parameters)[0]
            for t in times:
                state = tuple(map(mp.mpf, case.exact(t, asked(case) + 10)))
                value = function(mp.mpf(t), state, parameters)[0]
                size = max(abs(first), *_changes(mp, case, function, t, state, parameters))
                pairs.append((value - first, float(size) or 1.0))
    return _agreed(pairs)


def _changes(mp: Any, case: Case, function: Equations, t: Fraction, state: Any, parameters: Any) -> Iterable[Any]:
    """What a change of each coordinate by its size does to an invariant, to first order."""
    small = mp.mpf(10) ** -DIGITS
    here = function(mp.mpf(t), state, parameters)[0]
    for index, size in enumerate(_sizes(case)):
        moved = (*state[:index], state[index] + small * size, *state[index + 1 :])
        yield abs(function(mp.mpf(t), moved, parameters)[0] - here) / small


@dataclass(frozen=True)
class _Flight:
    """One smooth stretch of a hybrid motion, from an event's state after to the next event's state before."""

    equations: Equations
    constants: tuple[float, ...]
    begin: Fraction
    start: tuple[Any, ...]
    end: Fraction
    final: Event | None
    guard: Equations | None
    reset: Equations | None


def _flights(case: Case, hybrid: Hybrid) -> Iterable[_Flight]:
    """The stretches up to the first `limit` event or the span's end, at most 12 of them, spread over the list."""
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
    return _residual(case, flight.equations, middle, flight.constants)


def _flight_taylor(case: Case, flight: _Flight) -> float:
    """The flight integrated to its end: the state there, the guard's zero and the reset's image."""
    start = [exact(x) for x in flight.start]
    values = (*case.parameter_values(), *map(Fraction, flight.constants))
    field = _field(flight.equations, values, flight.begin)
    found = integrate(field, start, [flight.end - flight.begin], DIGITS + 20)[0]
    sizes = _sizes(case)
    if flight.final is None:
        return _against(case, {flight.end: found})
    with working(3 * DIGITS) as mp:
        parameters = tuple(map(mp.mpf, case.parameter_values()))
        before = tuple(map(mp.mpf, flight.final.before))
        pairs = [(b - mp.mpf(f), size) for b, f, size in zip(before, found, sizes, strict=True)]
        assert flight.guard is not None
        assert flight.reset is not None
        arithmetic = mpmath_arithmetic(mp)
        guard = rebind(flight.guard, arithmetic)(mp.mpf(flight.end), before, parameters)[0]
        pairs.append((guard, max(sizes)))
        image = rebind(flight.reset, arithmetic)(mp.mpf(flight.end), before, parameters)
        pairs += [(i - mp.mpf(a), size) for i, a, size in zip(image, flight.final.after, sizes, strict=True)]
    return _agreed(pairs)
