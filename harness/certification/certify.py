"""Certificates: how many digits of each exact motion are confirmed, and by which independent ways.

- `residual`: the equations of motion, with the derivative of the exact motion taken by central differences in more
  than twice the precision, at random times; and the initial state.
- `taylor`: a high-precision Taylor integration of the equations, which shares no formula with the exact motion, from
  the initial state. A hybrid motion is integrated flight by flight, and the guard and the reset are checked at each
  event.
- on long spans `windows`: the same from the exact state at 0 and at random times, over ten of the fastest times;
  `group`: x(2t) is x(t) from x(t), from half the span down to the first window; `seams`: the residual across the places
  where formulas change their branch.
- `extrapolation`: for motions that are Taylor integrations themselves, by Gragg's midpoint rule extrapolated.
- `ball`: elliptic motions enclosed in ball arithmetic by other formulas; the digits are proved.
- `invariants`: the conserved quantities, at random times.
- `rounding`: the published digits against an evaluation in three times the precision (guard digits are enough).

Digits are relative to the size of the motion.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import Equations
from gnomon.harness.certification.agreement import (
    DIGITS,
    REQUIRED,
    against,
    agreed,
    asked,
    first_order_equations,
    residual,
    series_field,
    sizes,
)
from gnomon.harness.certification.certify_hybrid import flight_ways
from gnomon.harness.certification.certify_long import long_ways
from gnomon.harness.certification.enclosures import enclosure
from gnomon.harness.contract import environment
from gnomon.harness.results import measured_rows
from gnomon.reference.numerics.certified import CertifiedMotion
from gnomon.reference.numerics.extrapolation import extrapolate
from gnomon.reference.numerics.precision import exact, working
from gnomon.reference.numerics.taylor import integrate

RANDOM_TIMES = 5
TAYLOR_STOPS = 4
BALL_DIGITS = DIGITS + 5
INTEGRATED_SCALES = 300
"""Spans up to so many of the fastest times are integrated from start to end."""


@dataclass(frozen=True)
class Certificate:
    """Digits agreed for one case. `ways` holds the digits of each way; `worst` is the way with the fewest.

    `note` says what bounds the digits, or why there are none; `seconds` is the processor time that it took.
    """

    case: str
    variant: str
    ways: dict[str, float]
    required: int = REQUIRED
    note: str = ""
    seconds: float = 0.0
    digits: float = field(init=False)
    worst: str = field(init=False)

    def __post_init__(self) -> None:
        worst = min(self.ways, key=lambda way: self.ways[way], default="")
        object.__setattr__(self, "worst", worst)
        object.__setattr__(self, "digits", self.ways.get(worst, 0.0))

    @property
    def passed(self) -> bool:
        """At least the required digits, by the evaluation itself and two independent ways."""
        return self.digits >= self.required and len(self.ways) >= 3


def certify(case: Case) -> Certificate:
    """Confirm a case's exact motion; the numbers are taken as the case has them."""
    times = _random_times(case)
    ways = {"rounding": rounding(case, times)}
    if case.hybrid is not None:
        found = flight_ways(case, case.hybrid)
        ways |= found | {"residual": min(start(case), found["residual"])}
        return Certificate(case.name, case.variant or "default", ways, case.certified_digits)
    equations = first_order_equations(case)
    ways["residual"] = min(start(case), *(residual(case, equations, t) for t in times))
    if case.certified_digits < REQUIRED:
        ways["extrapolation"] = _extrapolation(case)
    elif case.span <= INTEGRATED_SCALES * exact(case.fastest_time):
        ways["taylor"] = _taylor(case)
    else:
        ways |= long_ways(case, times)
    enclosed = _ball(case, times[1::2])
    if enclosed is not None:
        ways["ball"] = enclosed
    if any(invariant.law == "constant" for invariant in case.invariants.values()):
        ways["invariants"] = invariants(case, times)
    return Certificate(case.name, case.variant or "default", ways, case.certified_digits, _note(case, ways))


def _note(case: Case, ways: dict[str, float]) -> str:
    """The conditioning of a motion without a closed form; why a long span is not chained."""
    motion = case.motion()
    if isinstance(motion, CertifiedMotion):
        return f"integrated: errors grow by 1e{motion.growth(case.span):.0f} over the span"
    if "windows" in ways and "group" not in ways:
        return "not chained: " + (
            "rounded states leave the domain" if case.autonomous else "the equations hold the time"
        )
    return ""


def write(certificates: Iterable[Certificate], path: Path) -> None:
    """The certificates as JSON, one object each with the revision that made it, for the report."""
    revision = environment.describe().get("revision")
    measured_rows.write([asdict(c) | {"passed": c.passed, "revision": revision} for c in certificates], path)


def _random_times(case: Case) -> list[Fraction]:
    """Repeatable times spread over the span, none of them special."""
    source = random.Random(case.id)
    return [case.span * (k + Fraction(source.random())) / RANDOM_TIMES for k in range(RANDOM_TIMES)]


def rounding(case: Case, times: Sequence[Fraction]) -> float:
    pairs = []
    many = 3 * DIGITS if case.certified_digits >= REQUIRED else 2 * asked(case)
    for t in times:
        short, long = case.exact(t, asked(case)), case.exact(t, many)
        with working(4 * DIGITS) as mp:
            pairs += [(mp.mpf(a) - mp.mpf(b), size) for a, b, size in zip(short, long, sizes(case), strict=True)]
    return agreed(pairs)


def start(case: Case) -> float:
    with working(4 * DIGITS) as mp:
        start = case.exact(0, 2 * asked(case))
        return agreed(
            (mp.mpf(a) - mp.mpf(b), size) for a, b, size in zip(start, case.initial_state, sizes(case), strict=True)
        )


def _taylor(case: Case) -> float:
    times = [case.span * k / TAYLOR_STOPS for k in range(1, TAYLOR_STOPS + 1)]
    found = integrate(
        series_field(first_order_equations(case), case.parameter_values()), case.initial_state, times, DIGITS + 20
    )
    return against(case, dict(zip(times, found, strict=True)))


def _extrapolation(case: Case) -> float:
    times = [case.span * k / TAYLOR_STOPS for k in range(1, TAYLOR_STOPS + 1)]
    field = series_field(first_order_equations(case), case.parameter_values())
    step = exact(case.fastest_time / 4).limit_denominator(10**6)
    found = extrapolate(field, case.initial_state, times, asked(case), step)
    return against(case, dict(zip(times, found, strict=True)))


def _ball(case: Case, times: Sequence[Fraction]) -> float | None:
    """Digits that an enclosure proves: distance to its midpoint plus its radius; None where there is none."""
    pairs = []
    for t in times:
        enclosed = enclosure(case.motion(), t, BALL_DIGITS)
        if enclosed is None:
            return None
        with working(2 * DIGITS) as mp:
            for value, (middle, radius), size in zip(case.exact(t, asked(case)), enclosed, sizes(case), strict=True):
                pairs.append((abs(mp.mpf(value) - mp.mpf(middle)) + mp.mpf(radius), size))
    return agreed(pairs)


def invariants(case: Case, times: Sequence[Fraction]) -> float:
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
    return agreed(pairs)


def _changes(mp: Any, case: Case, function: Equations, t: Fraction, state: Any, parameters: Any) -> Iterable[Any]:
    """What a change of each coordinate by its size does to an invariant, to first order."""
    small = mp.mpf(10) ** -DIGITS
    here = function(mp.mpf(t), state, parameters)[0]
    for index, size in enumerate(sizes(case)):
        moved = (*state[:index], state[index] + small * size, *state[index + 1 :])
        yield abs(function(mp.mpf(t), moved, parameters)[0] - here) / small
