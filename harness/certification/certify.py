"""Certificates: the number of confirmed digits of each exact motion, and the independent ways that confirm them.

- `residual`: the equations of motion at random times, with the derivative of the exact motion by central differences in
  more than twice the precision; and the initial state.
- `taylor`: a Taylor integration of the equations from the initial state in high precision, which shares no formula with
  the exact motion. A hybrid motion is integrated flight by flight, and guard and reset are verified at each event.
- for long spans `windows`: Taylor integrations from the exact states at 0 and at random times, over ten of the fastest
  times; `group`: x(2t) equals the motion over t from x(t), for t from half the span down to the width of a window;
  `seams`: the residual across the places where formulas change their branch.
- `extrapolation`: for motions that are Taylor integrations themselves, the extrapolated midpoint rule of Gragg.
- `ball`: elliptic motions enclosed in ball arithmetic by other formulas, which proves the digits.
- `invariants`: the conserved quantities at random times.
- `rounding`: the digits against an evaluation in three times the precision, which shows that guard digits suffice.

Digits are relative to the size of the motion.
"""

import math
import random
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import Equations
from gnomon.harness.certification import agreement
from gnomon.harness.certification.certify_hybrid import flight_ways
from gnomon.harness.certification.certify_long import long_ways
from gnomon.harness.certification.enclosures import enclosure
from gnomon.harness.registry import environment
from gnomon.harness.results import study_file
from gnomon.reference.numerics.certified import CertifiedMotion
from gnomon.reference.numerics.extrapolation import extrapolate
from gnomon.reference.numerics.precision import exact, working
from gnomon.reference.numerics.taylor import integrate

RANDOM_TIMES = 5
TAYLOR_STOPS = 4
BALL_DIGITS = agreement.DIGITS + 5
INTEGRATED_SCALES = 300
"""Spans of up to this many fastest times are integrated from start to end."""


@dataclass(frozen=True)
class Certificate:
    """The confirmed digits of one case. `ways` holds the digits of each way; `worst` is the way with the fewest.

    `note` gives the limit of the digits, or the reason for a missing way or missing digits; `seconds` is the processor
    time of the certificate.
    """

    case: str
    variant: str
    ways: dict[str, float]
    required: int = agreement.REQUIRED
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
        """Whether the evaluation itself and two independent ways confirm at least the required digits."""
        return self.digits >= self.required and len(self.ways) >= 3


def certify(case: Case) -> Certificate:
    """Certify a case's exact motion, with the parameters and initial state of the case unrounded."""
    times = _random_times(case)
    ways = {"rounding": rounding(case, times)}
    if case.hybrid is not None:
        flights = flight_ways(case, case.hybrid)
        ways |= flights | {"residual": min(start(case), flights["residual"])}
        return Certificate(case.name, case.variant or "default", ways, case.certified_digits)
    equations = agreement.first_order_equations(case)
    ways["residual"] = min(start(case), *(agreement.residual(case, equations, t) for t in times))
    short = case.span <= INTEGRATED_SCALES * exact(case.fastest_time)
    ways |= _integrate(case) if short or case.certified_digits < agreement.REQUIRED else long_ways(case, times)
    enclosed = ball_digits(case, times[1::2])
    if enclosed is not None:
        ways["ball"] = enclosed
    if any(invariant.law == "constant" for invariant in case.invariants.values()):
        ways["invariants"] = invariants(case, times)
    return Certificate(case.name, case.variant or "default", ways, case.certified_digits, _note(case, ways))


def _note(case: Case, ways: dict[str, float]) -> str:
    """The growth of errors of a motion by integration, or the reason why a long span has no way `group`."""
    motion = case.motion()
    if isinstance(motion, CertifiedMotion):
        return f"integrated: errors grow by 1e{motion.growth(case.span):.0f} over the span"
    if "windows" in ways and "group" not in ways:
        return "not chained: " + (
            "rounded states leave the domain" if case.autonomous else "the equations hold the time"
        )
    return ""


def write(certificates: Iterable[Certificate], path: Path) -> None:
    """Write the certificates as JSON for the report: one row for each, with the revision of the sources."""
    made_by = environment.record()
    rows = [asdict(c) | {"passed": c.passed, "revision": made_by.get("revision")} for c in certificates]
    study_file.write({"environment": made_by, "rows": rows}, path)


def _random_times(case: Case) -> list[Fraction]:
    """Random times over the span, the same in every run, one in each of RANDOM_TIMES equal parts."""
    source = random.Random(case.id)
    return [case.span * (k + Fraction(source.random())) / RANDOM_TIMES for k in range(RANDOM_TIMES)]


def rounding(case: Case, times: Sequence[Fraction]) -> float:
    many = (
        3 * agreement.DIGITS if case.certified_digits >= agreement.REQUIRED else 2 * agreement.find_asked_digits(case)
    )
    return agreement.count_agreed_in_states(
        case, ((case.exact(t, agreement.find_asked_digits(case)), case.exact(t, many)) for t in times)
    )


def start(case: Case) -> float:
    """The digits of the initial state in the motion itself: `case.exact` takes it from the declaration."""
    state = case.motion().state if type(case).exact is Case.exact else case.exact
    return agreement.count_agreed_in_states(
        case, [(state(0, 2 * agreement.find_asked_digits(case)), case.initial_state)]
    )


def _integrate(case: Case) -> dict[str, float]:
    """`taylor`, or `extrapolation` for a motion that is a Taylor integration itself, at TAYLOR_STOPS times."""
    times = [case.span * k / TAYLOR_STOPS for k in range(1, TAYLOR_STOPS + 1)]
    field = agreement.series_field(agreement.first_order_equations(case), case.parameter_values())
    if case.certified_digits >= agreement.REQUIRED:
        way, states = "taylor", integrate(field, case.initial_state, times, agreement.DIGITS + 20)
    else:
        step = exact(case.fastest_time / 4).limit_denominator(10**6)
        motion = case.motion()
        # Each step's error grows as any other does: a chaotic motion would keep half of the digits.
        lost = 1 + math.ceil(motion.growth(case.span)) if isinstance(motion, CertifiedMotion) else 0
        way, states = (
            "extrapolation",
            extrapolate(field, case.initial_state, times, agreement.find_asked_digits(case) + lost, step),
        )
    return {way: agreement.against(case, dict(zip(times, states, strict=True)))}


def ball_digits(case: Case, times: Sequence[Fraction]) -> float | None:
    """Digits that an enclosure proves, from distance to its midpoint plus its radius; None if there is no enclosure."""
    pairs = []
    for t in times:
        enclosed = enclosure(case.motion(), t, BALL_DIGITS)
        if enclosed is None:
            return None
        with working(2 * agreement.DIGITS) as mp:
            for value, (middle, radius), size in zip(
                case.exact(t, agreement.find_asked_digits(case)), enclosed, agreement.sizes(case), strict=True
            ):
                pairs.append((abs(mp.mpf(value) - mp.mpf(middle)) + mp.mpf(radius), size))
    return agreement.count_agreed_digits(pairs)


def invariants(case: Case, times: Sequence[Fraction]) -> float:
    """Digits to which the constant invariants keep their initial value.

    Drift is relative to the larger of the invariant and its change for a change of one coordinate by its size: an
    invariant that is zero has no size of its own.
    """
    pairs = []
    with working(2 * agreement.DIGITS) as mp:
        parameters = tuple(map(mp.mpf, case.parameter_values()))
        start = tuple(map(mp.mpf, case.initial_state))
        for invariant in case.invariants.values():
            if invariant.law != "constant":
                continue
            function = rebind(invariant.function, mpmath_arithmetic(mp))
            first = function(mp.mpf(0), start, parameters)[0]
            for t in times:
                state = tuple(map(mp.mpf, case.exact(t, agreement.find_asked_digits(case) + 10)))
                value = function(mp.mpf(t), state, parameters)[0]
                size = max(abs(first), *_changes(mp, case, function, t, state, parameters))
                pairs.append((value - first, float(size) or 1.0))
    return agreement.count_agreed_digits(pairs)


def _changes(mp: Any, case: Case, function: Equations, t: Fraction, state: Any, parameters: Any) -> Iterable[Any]:
    """The change of an invariant for a change of each coordinate by its size, to first order."""
    small = mp.mpf(10) ** -agreement.DIGITS
    here = function(mp.mpf(t), state, parameters)[0]
    for index, size in enumerate(agreement.sizes(case)):
        changed = (*state[:index], state[index] + small * size, *state[index + 1 :])
        yield abs(function(mp.mpf(t), changed, parameters)[0] - here) / small
