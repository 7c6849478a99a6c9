"""The thin tube: its equation, a Taylor integration, isochronism and the sharp turn."""

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.oscillators.rubber_tube_thin import Pinney

MOTIONS = [Pinney(exact(2), exact(x), exact(v)) for x, v in (("0.5", 0), (3, "-1"), ("1e-4", 0), (1, "1e-9"))]


def rates(mp, y):
    return y[1], 4 / (y[0] * y[0] * y[0]) - 4 * y[0]


@pytest.mark.parametrize("motion", MOTIONS)
def test_equation_of_motion_is_satisfied(motion, residual):
    assert residual(motion, rates, "0.7") < mpmath.mpf(10) ** -45


@pytest.mark.parametrize("motion", MOTIONS[:2])
def test_taylor_integration_arrives_at_the_same_state(motion, taylor):
    there = taylor(rates, (motion.x0, motion.v0), "1.1")
    with mpmath.workdps(60):
        for found, right in zip(motion.state("1.1", 50), there, strict=True):
            assert abs(found - right) < mpmath.mpf(10) ** -46


@pytest.mark.parametrize("motion", MOTIONS)
def test_returns_after_a_period_and_keeps_its_energy(motion):
    period = exact(motion.period(120))
    with mpmath.workdps(60):
        x, v = motion.state(1000 * period, 60)
        size = mpmath.sqrt(exact_to_mpf(motion.energy))
        assert abs(x - exact_to_mpf(motion.x0)) < mpmath.mpf(10) ** -45 * size
        assert abs(v - exact_to_mpf(motion.v0)) < mpmath.mpf(10) ** -30 * size


def exact_to_mpf(value):
    return mpmath.mpf(value.numerator) / value.denominator
