"""Taylor integration against closed forms."""

from fractions import Fraction
from typing import Any

import flint
import mpmath
import pytest
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.taylor import flint_arithmetic, integrate


def number(x: Fraction) -> Any:
    return mpmath.mpf(x.numerator) / x.denominator


def oscillator(t: Any, state: tuple[Any, ...]) -> tuple[Any, ...]:
    x, v = state
    return v, -x


@pytest.mark.parametrize("digits", [20, 50, 90])
def test_oscillator_has_the_requested_digits(digits: int) -> None:
    ((x, v),) = integrate(oscillator, (Fraction(1), Fraction(0)), [Fraction(20)], digits)
    with mpmath.workdps(digits + 20):
        # 20 radians of unit rate: the error of a step is not amplified, steps number about 20
        tolerance = mpmath.mpf(10) ** (2 - digits)
        assert abs(number(x) - mpmath.cos(20)) < tolerance
        assert abs(number(v) + mpmath.sin(20)) < tolerance


def test_a_time_dependent_force_and_several_output_times() -> None:
    def forced(t: Any, state: tuple[Any, ...]) -> tuple[Any, ...]:
        return (3 * t * t,)

    times = [Fraction(1), Fraction(2), Fraction(7, 2)]
    states = integrate(forced, (Fraction(1, 3),), times, 40)
    for time, (x,) in zip(times, states, strict=True):
        assert abs(x - (Fraction(1, 3) + time**3)) < Fraction(1, 10**38)


def test_a_constant_rate_is_integrated_exactly() -> None:
    ((x,),) = integrate(lambda t, state: (ball(Fraction(1, 4)),), (Fraction(0),), [Fraction(8)], 30)
    assert x == 2


def test_a_pole_is_reported_and_not_stepped_over() -> None:
    with pytest.raises(ArithmeticError):
        integrate(lambda t, state: (state[0] * state[0],), (Fraction(1),), [Fraction(2)], 20)


@pytest.mark.parametrize("name", sorted(set(flint_arithmetic()) - {"hypot"}))
def test_functions_of_series_have_the_derivatives_of_mpmath(name: str) -> None:
    """Equations may use each of them, and second derivations differentiate equations by series."""
    found = flint_arithmetic()[name](flint.arb_series([0.25, 1], 4))
    for k, wanted in enumerate(mpmath.taylor(getattr(mpmath, name), 0.25, 3)):
        assert abs(float(found[k]) - float(wanted)) < 1e-12
