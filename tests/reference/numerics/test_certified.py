"""Certified integrations against closed forms, and against extrapolation, which shares no code with them."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from gnomon.reference.numerics.certified import CertifiedMotion
from gnomon.reference.numerics.extrapolation import extrapolate
from gnomon.reference.numerics.precision import nearest_double
from gnomon.reference.pendulums.pendulum_simple import Pendulum

START = (Fraction(2), Fraction(1, 3))


def swing(t, state):
    theta, omega = state
    return omega, -theta.sin()


MOTION = CertifiedMotion("swing", START, Fraction(10), swing)
RIGHT = Pendulum(Fraction(1), Fraction(1), *START)


@pytest.mark.parametrize("t", ["0", "1e-20", "-1e-20", "0.3", "9.7", "-4", "11"])
@pytest.mark.parametrize("digits", [15, 40, 80])
def test_pendulum_to_the_requested_digits(t, digits):
    with mpmath.workdps(100):
        for a, b in zip(MOTION.state(t, digits), RIGHT.state(t, 95), strict=True):
            assert abs(a - b) < mpmath.mpf(10) ** -(digits - 1)


def test_samples_are_the_nearest_doubles():
    times = np.linspace(0, 10, 41)
    right = [[nearest_double(x) for x in RIGHT.state(float(t), 40)] for t in times]
    assert np.array_equal(MOTION.sample(times), right)


def test_growth_is_that_of_the_saddle():
    """Released 1e-6 off the top, errors grow as e^t for the 14 s until it falls: by six digits, with a margin."""
    fall = CertifiedMotion("fall", (Fraction(3141592, 10**6), Fraction(0)), Fraction(14), swing)
    assert 2 < fall.growth(Fraction(14)) < 7
    assert MOTION.growth(Fraction(10)) < 1


def test_a_motion_that_loses_all_digits_is_refused():
    """On the separatrix the distance from the top falls by e^160."""
    level = CertifiedMotion("level", (Fraction(0), Fraction(2)), Fraction(80), swing)
    with pytest.raises(ArithmeticError, match="shorten the span"):
        level.state(80)


def test_extrapolation_agrees_with_the_closed_form():
    times = [Fraction(1, 3), Fraction(7)]
    for t, state in zip(times, extrapolate(swing, START, times, 36, Fraction(1, 4)), strict=True):
        with mpmath.workdps(50):
            for a, b in zip(state, RIGHT.state(t, 45), strict=True):
                assert abs(mpmath.mpf(a.numerator) / a.denominator - b) < mpmath.mpf(10) ** -34


def test_extrapolation_stops_at_a_singularity():
    with pytest.raises(ArithmeticError, match="does not pass"):
        extrapolate(lambda t, y: (y[0] * y[0],), [Fraction(1)], [Fraction(2)], 30, Fraction(1, 4))
