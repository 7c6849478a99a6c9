"""Certificates of long spans: integrations over parts, the group property that connects them, and continuity.

A span of many periods is not integrated from start to end. Instead, the motion is shown to be a flow: x(2t) equals the
motion over t from x(t), for t from half the span down to a part that is integrated. It is also shown to have no jump
where its formulas change their branch, that is where a coordinate or its rate passes zero, or an angle a quarter turn.
"""

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.case import Case
from gnomon.harness.certification import agreement
from gnomon.reference.numerics.precision import exact, working
from gnomon.reference.numerics.taylor import integrate

WINDOW_SCALES = 10
SEAMS = 6
"""Number of places at which continuity is verified, the last ones of the span."""
GRID = 48


def long_ways(case: Case, times: Sequence[Fraction]) -> dict[str, float]:
    """Digits by way: `windows`, `group` (of an autonomous case) and `seams` (if there are any)."""
    ways = {
        "windows": min(window(case, t) for t in (Fraction(0), *times)),
        "group": group(case) if case.autonomous else None,
        "seams": seams(case),
    }
    return {way: digits for way, digits in ways.items() if digits is not None}


def _width(case: Case) -> Fraction:
    return min(WINDOW_SCALES * exact(case.fastest_time), case.span / 10)


def window(case: Case, begin: Fraction) -> float:
    """Digits of an integration from the exact state at `begin`, or earlier, so that it ends within the span."""
    width = _width(case)
    begin = min(begin, case.span - width)
    start = [exact(x) for x in case.exact(begin, 2 * agreement.DIGITS)]
    field = agreement.series_field(agreement.first_order_equations(case), case.parameter_values(), begin)
    return agreement.against(case, {begin + width: integrate(field, start, [width], agreement.DIGITS + 20)[0]})


def group(case: Case) -> float | None:
    """Digits of x(2t) against the motion over t from x(t), for t = span/2, span/4, ... down to a window's width.

    None if a rounded state is outside the domain: the motion is then on its edge.
    """
    pairs = []
    for halvings in range(1, math.ceil(math.log2(case.span / _width(case))) + 1):
        t = case.span / 2**halvings
        try:
            rest = case.with_numbers([exact(x) for x in case.exact(t, 3 * agreement.DIGITS)], case.parameters)
        except ValueError:
            return None
        pairs.append(
            (rest.exact(t, agreement.find_asked_digits(case)), case.exact(2 * t, agreement.find_asked_digits(case)))
        )
    return agreement.count_agreed_in_states(case, pairs)


def seams(case: Case) -> float | None:
    """Digits of the residual across the last places of the span where formulas may change their branch.

    None without such places.
    """
    width = _width(case)
    times = [case.span - width * k / GRID for k in range(GRID + 1, 0, -1)]
    marks = [_marks(case, t, 20) for t in times]
    crossings = []
    for index in range(GRID, 0, -1):
        changed = [k for k, (a, b) in enumerate(zip(marks[index - 1], marks[index], strict=True)) if a * b < 0]
        crossings += [_crossing(case, times[index - 1], times[index], k) for k in changed]
        if len(crossings) >= SEAMS:
            break
    equations = agreement.first_order_equations(case)
    return min((agreement.residual(case, equations, t) for t in crossings), default=None)


def _marks(case: Case, t: Fraction, digits: int) -> list[Any]:
    """The values that change sign at a seam: coordinates, their rates, and the sine of twice an angle."""
    with working(digits + 10) as mp:
        state = tuple(map(mp.mpf, case.exact(t, digits + 10)))
        parameters = tuple(mp.mpf(v) for v in case.parameter_values())
        rates = rebind(agreement.first_order_equations(case), mpmath_arithmetic(mp))(mp.mpf(t), state, parameters)
        angles = [mp.sin(2 * x) for x, c in zip(state, case.state, strict=True) if c.unit == "rad"]
        return [*state, *map(mp.mpf, rates), *angles]


def _crossing(case: Case, low: Fraction, high: Fraction, index: int) -> Fraction:
    """The time of a change of sign, with an error far below the step of the residual, by the Illinois method."""
    near = exact(case.time_scale) / 10**agreement.DIGITS
    f, g = (_marks(case, t, agreement.DIGITS)[index] for t in (low, high))
    for _ in range(200):
        if abs(high - low) <= near or not g:
            break
        middle = (high - (high - low) * exact(g) / (exact(g) - exact(f))).limit_denominator(
            10 ** (2 * agreement.DIGITS)
        )
        if middle in (low, high):
            break
        value = _marks(case, middle, agreement.DIGITS)[index]
        if value * g < 0:
            low, f = high, g
        else:
            f = f / 2
        high, g = middle, value
    return high
