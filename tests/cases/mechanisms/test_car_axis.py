"""The car axis against the published reference solution of the Test Set for IVP Solvers."""

from collections.abc import Sequence
from fractions import Fraction
from functools import cache

import mpmath
from gnomon.cases import get
from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.mechanisms.car_axis import MULTIPLIERS
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.taylor import flint_arithmetic, integrate

PUBLISHED = (
    "0.4934557842755629e-1", "0.4969894602303324", "1.041742524885400", "0.3739110272652214",
    "-0.7705836840321485e-1", "0.7446866596327776e-2", "0.1755681574942899e-1", "0.7703410437794031",
)  # fmt: skip
MULTIPLIED = ("-0.4736886750784630e-2", "-0.1104680411345730e-2")
"""y(1) to y(10) at t = 3, subroutine `soln` of the problem car axis in the Test Set for IVP Solvers (CWI, later Bari), as it
stands in its Fortran driver for MEBDFI: computed in double precision."""
PLACES, VELOCITIES, MULTIPLIER = 1e-12, 1e-11, 1e-9
"""The published digits are those of an integration of index 3 at a finite tolerance: the exact motion departs from them by
up to 3.3e-13 m, 4.3e-12 m/s and, in the multipliers, 1.6e-10."""


@cache
def at_three_seconds() -> Sequence[Fraction]:
    """The exact motion to 20 digits: the span of the case ends earlier."""
    case = get("car_axis")
    equations, values = rebind(case.equations_of_motion, flint_arithmetic()), case.parameter_values()
    (found,) = integrate(
        lambda t, state: equations(t, state, tuple(map(ball, values))), case.initial_state, [Fraction(3)], 20
    )
    return found


def test_published_state_at_three_seconds_is_met() -> None:
    apart = [abs(float(x - Fraction(y))) for x, y in zip(at_three_seconds(), PUBLISHED, strict=True)]
    assert max(apart[:4]) < PLACES
    assert max(apart[4:]) < VELOCITIES


def test_published_multipliers_at_three_seconds_are_met() -> None:
    """The test set multiplies the equations by m eps^2/2, and its multipliers push where those of the form pull."""
    values = tuple(map(float, get("car_axis").parameter_values()))
    found = MULTIPLIERS(3.0, tuple(map(float, at_three_seconds())), values)
    for x, y in zip(found, MULTIPLIED, strict=True):
        assert abs(-x * values[0] / (2 * values[1]) - float(y)) < MULTIPLIER


def test_the_axle_neither_stretches_nor_leaves_its_shaft() -> None:
    """The exact motion keeps the constraints, whose second derivatives alone are in the equations."""
    with mpmath.workdps(25):
        xl, yl, xr, yr, *_ = (mpmath.mpf(x.numerator) / x.denominator for x in at_three_seconds())
        yb = mpmath.sin(30) / 10
        assert abs((xl - xr) ** 2 + (yl - yr) ** 2 - 1) < 1e-19
        assert abs(mpmath.sqrt(1 - yb * yb) * xl + yb * yl) < 1e-19
