"""Andrews' squeezing mechanism against the published reference solution of the Test Set for IVP Solvers."""

from collections.abc import Callable
from typing import Any

import mpmath
import pytest
from gnomon.cases import get
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.elimination import index_one
from gnomon.cases.mechanisms.andrews_squeezer import FORM, MULTIPLIERS
from gnomon.cases.mechanisms.squeezer_equations import closures, squeezer_energy
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.taylor import flint_arithmetic, integrate

ANGLES = (
    "15.81077119629904", "-15.75637105984298", "0.04082224013073101", "-0.5347301163226948", "0.5244099658805304",
    "0.5347301163226948", "1.048080741042263",
)  # fmt: skip
RATES = (
    "1139.920302151208", "-1424.379294994111", "11.03291221937134", "19.29337464421385", "0.5735699284790808",
    "-19.29337464421385", "0.3231791658026955",
)  # fmt: skip
FORCES = (
    "199.1753333731910", "-29.75531228015052", "23.06654119098399", "31.45271365475927", "22.64249232082739",
    "11.61740700019673",
)  # fmt: skip
"""y(1) to y(14) and y(22) to y(27) at t = 0.03 s: computed with PSIDE on a Cray C90 at the tolerance 1e-14, from the problem
andrews of the Test Set for IVP Solvers (CWI, later Bari), as they stand in its Fortran and Matlab drivers."""
START = ("98.5668703962410896057654982170", "-6.12268834425566265503114393122")
"""y(22) and y(23) at the start, by the same source."""
PIVOTS = ("-0.03635", "0.03273", "-0.06934", "-0.00227", "-0.06934", "-0.00227")
"""xb, yb, xa, ya, xa, ya of the same source."""


def evaluated(function: Callable[..., Any], state: Any) -> Any:
    values = [mpmath.mpf(x.numerator) / x.denominator for x in get("andrews_squeezer").parameter_values()]
    return rebind(function, mpmath_arithmetic(mpmath.mp))(mpmath.mpf(0), tuple(map(mpmath.mpf, state)), tuple(values))


@pytest.fixture(scope="module")
def end() -> Any:
    """The exact motion to 22 digits: an integration of its equations, a fraction of the cost of 30."""
    case = get("andrews_squeezer")
    equations, values = rebind(case.equations_of_motion, flint_arithmetic()), case.parameter_values()
    (found,) = integrate(
        lambda t, state: equations(t, state, tuple(map(ball, values))), case.initial_state, [case.span], 22
    )
    with mpmath.workdps(40):
        return [mpmath.mpf(x.numerator) / x.denominator for x in found]


def start() -> list[Any]:
    return [mpmath.mpf(x.numerator) / x.denominator for x in get("andrews_squeezer").initial_state]


def test_published_start_closes_and_its_multipliers_are_met() -> None:
    with mpmath.workdps(40):
        assert all(
            abs(x - mpmath.mpf(y)) < 5e-28 for x, y in zip(evaluated(closures, start()[:7]), PIVOTS, strict=True)
        )
        found = evaluated(MULTIPLIERS, start())
        assert all(abs(x - mpmath.mpf(y)) < 1e-28 for x, y in zip(found, (*START, 0, 0, 0, 0), strict=True))


def test_published_state_is_met_as_far_as_its_own_energy_is_kept(end: Any) -> None:
    """The published state closes to 1e-16 m, but its energy has changed by 2.2e-10 J, that of the exact motion by less than
    1e-19 J. So the published angles and rates hold to about ten digits, and the multipliers to seven."""
    with mpmath.workdps(40):
        apart = [abs(x - mpmath.mpf(y)) for x, y in zip(end, (*ANGLES, *RATES), strict=True)]
        assert max(apart[:7]) < 2e-10 * max(map(abs, end[:7]))
        assert max(apart[7:]) < 6e-10 * max(map(abs, end[7:]))
        for x, y in zip(evaluated(MULTIPLIERS, end), FORCES, strict=True):
            assert abs(x - mpmath.mpf(y)) < 2e-6 * abs(x)
        ((before,), (after,), (published,)) = (evaluated(squeezer_energy, s) for s in (start(), end, (*ANGLES, *RATES)))
        assert abs(after - before) < 1e-19
        assert 2.2e-10 < before - published < 2.3e-10
        assert all(abs(x - mpmath.mpf(y)) < 1e-15 for x, y in zip(evaluated(closures, ANGLES), PIVOTS, strict=True))


def test_joints_eliminate_the_multipliers_as_the_full_matrix_does(end: Any) -> None:
    """The equations use the chains' structure; the system of 13 equations of masses and constraints has the same solution."""

    def curvature(t: Any, state: Any, parameters: Any) -> Any:
        """The second derivatives of the closures along the straight line of constant rates, by differences."""
        step = mpmath.mpf(10) ** -12
        places = [[q + k * step * v for q, v in zip(state[:7], state[7:], strict=True)] for k in (1, 0, -1)]
        after, now, before = (evaluated(closures, place) for place in places)
        return tuple((a - 2 * b + c) / step**2 for a, b, c in zip(after, now, before, strict=True))

    with mpmath.workdps(40):
        assert FORM.velocity_force is not None
        full = index_one(
            force=rebound(FORM.force), gradient=rebound(FORM.gradient), curvature=curvature, mass=rebound(FORM.mass),
            velocity_force=rebound(FORM.velocity_force),
        )  # fmt: skip
        for x, y in zip(full(0, tuple(end), ()), evaluated(FORM.equations, end), strict=True):
            assert abs(x - y) < 1e-12 * abs(x)


def rebound(function: Any) -> Callable[..., Any]:
    return lambda t, state, parameters: evaluated(function, state)
