"""The block on a spring: both phases' equations, events at y = 0, the book's compression."""

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.oscillators.work_energy_spring_block import SpringBlock


def made(k, y, v):
    return SpringBlock(*map(exact, ("9.81", 1, k, y, v)))


MOTIONS = [made(500, "0.5", 0), made(10**9, "0.5", 1), made(500, "-0.2", 0), made(500, 0, "-2")]


@pytest.mark.parametrize("motion", MOTIONS)
def test_each_phase_satisfies_its_equation(motion, residual):
    touch, lift = exact(motion.touch_time(2, 30)), exact(motion.lift_time(2, 30))
    flight = touch - exact("1e-3")
    contact = touch + exact(motion.contact_time(30)) / 3
    assert lift > 0
    g = mpmath.mpf("9.81")
    with mpmath.workdps(110):
        g = mpmath.mpf(981) / 100
        k = motion.k.numerator
        assert residual(motion, lambda mp, y: (y[1], -g), flight) < mpmath.mpf(10) ** -40
        assert residual(motion, lambda mp, y: (y[1], -g - k * y[0]), contact) < mpmath.mpf(10) ** -40


@pytest.mark.parametrize("motion", MOTIONS)
def test_events_are_at_the_free_end_of_the_spring(motion):
    with mpmath.workdps(60):
        for time, sign in ((motion.touch_time(3, 60), -1), (motion.lift_time(3, 60), 1)):
            y, v = motion.state(exact(time), 50)
            assert abs(y) < mpmath.mpf(10) ** -48
            assert abs(v - sign * motion.speed(50)) < mpmath.mpf(10) ** -44


def test_largest_compression():
    """(m g/k)(1 + sqrt(1 + 2 k h/(m g)))."""
    with mpmath.workdps(40):
        rest = mpmath.mpf("9.81") / 500
        assert abs(MOTIONS[0].compression(35) - rest * (1 + mpmath.sqrt(1 + 1 / rest))) < mpmath.mpf(10) ** -33
