"""Digits of agreement, relative to the size of a motion, and the two computations that all certificates use.

These are the residual of the equations, and the comparison with states computed in another way.
"""

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import Equations, FirstOrder
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact, working
from gnomon.reference.numerics.taylor import Field, flint_arithmetic

DIGITS = 50
"""Digits to which a motion is evaluated; the maximum of a count of agreeing digits."""
REQUIRED = 45
"""Required digits of a closed form; a motion by integration declares fewer."""
SPARE = 3
"""Digits beyond the required ones to which a motion by integration is evaluated; each of them takes time."""
SIZE_TIMES = 8
RESIDUAL_DIGITS = 120
"""Digits of the states in a residual: after 40 for the step, 80 are left, which stiff equations may need."""


def find_asked_digits(case: Case) -> int:
    """Number of digits to which the case's motion is evaluated."""
    return DIGITS if case.certified_digits >= REQUIRED else case.certified_digits + SPARE


@lru_cache(maxsize=8)
def sizes(case: Case) -> tuple[float, ...]:
    """The size of each coordinate: the largest norm of its group at nine times of the motion."""
    states = np.array([[float(x) for x in case.exact(case.span * k / SIZE_TIMES)] for k in range(SIZE_TIMES + 1)])
    largest = {}
    for name in {coordinate.group for coordinate in case.state}:
        members = [i for i, coordinate in enumerate(case.state) if coordinate.group == name]
        norm = float(np.max(np.linalg.norm(states[:, members], axis=1)))
        largest[name] = norm or case.natural_sizes.get(name, 1.0)
    return tuple(largest[coordinate.group] for coordinate in case.state)


def count_agreed_digits(differences: Iterable[tuple[Any, Any]]) -> float:
    """The smallest number of decimal digits in which pairs (difference, size) agree, at most DIGITS."""
    worst = max((abs(difference) / size for difference, size in differences), default=0)
    with working(20) as mp:
        return float(DIGITS) if worst == 0 else min(float(DIGITS), -float(mp.log10(mp.mpf(worst))))


def first_order_equations(case: Case) -> Equations:
    """The case's equations as y' = f(t, y, parameters)."""
    form = next(form for form in case.all_forms() if isinstance(form, FirstOrder))
    return form.equations


def series_field(equations: Equations, values: Sequence[Fraction], offset: Fraction = Fraction(0)) -> Field:
    """The equations for power series, with exact parameters; the series' time starts at `offset`."""
    rebound = rebind(equations, flint_arithmetic())

    def field(t: Any, state: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(rebound(t + ball(offset), state, tuple(map(ball, values))))

    return field


def residual(case: Case, equations: Equations, t: Fraction, constants: tuple[float, ...] = ()) -> float:
    """Number of digits to which x'(t) = f(t, x), relative to size over time scale.

    A central difference over h time scales loses log10(1/h) digits by cancellation and has an error of h^2, so
    log10(1/h) is a third of the digits.
    """
    digits = RESIDUAL_DIGITS if case.certified_digits >= REQUIRED else 2 * find_asked_digits(case)
    h = exact(case.time_scale) / 10 ** (digits // 3)
    before, here, after = (case.exact(s, digits) for s in (t - h, t, t + h))
    with working(digits) as mp:
        rebound = rebind(equations, mpmath_arithmetic(mp))
        parameters = tuple(mp.mpf(v) for v in (*case.parameter_values(), *map(Fraction, constants)))
        rates = rebound(mp.mpf(t), tuple(map(mp.mpf, here)), parameters)
        return count_agreed_digits(
            (((mp.mpf(b) - mp.mpf(a)) / (2 * mp.mpf(h)) - rate) * case.time_scale, size)
            for a, b, rate, size in zip(before, after, rates, sizes(case), strict=True)
        )


def count_agreed_in_states(case: Case, pairs: Iterable[tuple[Sequence[Any], Sequence[Any]]]) -> float:
    """Digits in which the two states of each pair agree."""
    with working(4 * DIGITS) as mp:
        return count_agreed_digits(
            (mp.mpf(a) - mp.mpf(b), size)
            for first, second in pairs
            for a, b, size in zip(first, second, sizes(case), strict=True)
        )


def against(case: Case, states: dict[Fraction, tuple[Fraction, ...]]) -> float:
    """Digits in which the exact motion agrees with `states`, by time, computed in another way."""
    return count_agreed_in_states(
        case, ((case.exact(t, find_asked_digits(case)), state) for t, state in states.items())
    )
