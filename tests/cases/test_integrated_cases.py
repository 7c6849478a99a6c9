"""Integrated cases with special numbers for which a closed form is known: small swings, a second integral."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from gnomon.cases import get
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate


def as_mpf(number):
    value = exact(number)
    return mpmath.mpf(value.numerator) / value.denominator


def test_small_double_pendulum_is_a_sum_of_two_modes():
    """Equal masses and rods: w^2 = (2 -+ sqrt 2) g/l, shapes (1, +-sqrt 2); errors are of order amplitude squared."""
    amplitude = Fraction(1, 10**8)
    case = get("double_pendulum", initial_state=(amplitude, -amplitude, 0, 0), span=2)
    with mpmath.workdps(40):
        root, g, a = mpmath.sqrt(2), as_mpf("9.81"), as_mpf(amplitude)
        slow, fast = mpmath.sqrt((2 - root) * g), mpmath.sqrt((2 + root) * g)
        with_slow, with_fast = a * (1 - 1 / root) / 2, a * (1 + 1 / root) / 2
        t = mpmath.mpf("1.7")
        right = with_slow * mpmath.cos(slow * t) + with_fast * mpmath.cos(fast * t)
        below = root * (with_slow * mpmath.cos(slow * t) - with_fast * mpmath.cos(fast * t))
        th1, th2, _, _ = case.exact("1.7", 30)
        assert abs(th1 - right) < 100 * a**3
        assert abs(th2 - below) < 100 * a**3
        frequencies = case.quantities(25)
        assert abs(frequencies["slow_frequency"] - slow) < mpmath.mpf(10) ** -23
        assert abs(frequencies["fast_frequency"] - fast) < mpmath.mpf(10) ** -23


def test_spring_pendulum_along_its_spring_is_a_harmonic_oscillator():
    case = get("spring_pendulum", "vertical")
    x, y, vx, vy = case.exact("3.1", 30)
    with mpmath.workdps(40):
        rest, w = -1 - as_mpf("9.81") / 40, mpmath.sqrt(40)
        t = as_mpf("3.1")
        assert (x, vx) == (0, 0)
        assert abs(y - rest - (-1 - rest) * mpmath.cos(w * t)) < mpmath.mpf(10) ** -29
        assert abs(vy - (1 + rest) * w * mpmath.sin(w * t)) < mpmath.mpf(10) ** -28


def test_swinging_atwood_has_a_second_integral_at_three():
    """Tufillaro (1986): r^2 theta' (r' c - r theta' s/2) + g r^2 s c^2, c and s of theta/2."""
    case = get("swinging_atwood", "integrable")

    def integral(state):
        r, theta, vr, w = state
        c, s = mpmath.cos(theta / 2), mpmath.sin(theta / 2)
        return r * r * w * (vr * c - r * w * s / 2) + as_mpf("9.81") * r * r * s * c * c

    with mpmath.workdps(40):
        first = integral(tuple(map(as_mpf, case.initial_state)))
        for t in ("0.4", "1.1", "1.5"):
            assert abs(integral(case.exact(t, 32)) - first) < mpmath.mpf(10) ** -28


@pytest.mark.parametrize("t", ["0.5", "2.9"])
def test_cone_unrolls_to_a_plane_with_a_constant_pull(t):
    """Another integration: Cartesian equations in the unrolled plane, where the azimuth is phi sin(alpha)."""
    case = get("ignorable_coordinates", alpha="0.5")
    s, phi, _, _ = case.exact(t, 32)
    with mpmath.workdps(60):
        flat = exact(mpmath.sin(mpmath.mpf("0.5")))
        pull = exact(mpmath.cos(mpmath.mpf("0.5")) * as_mpf("9.81"))

    def rates(_, state):
        x, y, vx, vy = state
        over = ball(pull) / (x * x + y * y).sqrt()
        return vx, vy, -over * x, -over * y

    start = (Fraction(1), Fraction(0), Fraction(0), 5 * flat)
    with mpmath.workdps(40):
        x, y, _, _ = map(as_mpf, integrate(rates, start, [exact(t)], 45)[0])
        azimuth = phi * as_mpf(flat)
        assert abs(s * mpmath.cos(azimuth) - x) < mpmath.mpf(10) ** -29
        assert abs(s * mpmath.sin(azimuth) - y) < mpmath.mpf(10) ** -29


def test_parallel_circles_of_the_paraboloid_share_one_rate():
    case = get("particle_on_paraboloid", "circle")
    assert case.quantities()["circle_rate"] == 3
    assert case.exact(5, 25) == (2, 15, 0, 3)


def test_a_stiff_spring_swings_as_a_rod_does():
    """The spring stretches by m g/k, 1e-3 of its length; its vibration changes the speed by sqrt(k/m) times that, 2 %."""
    case = get("spring_pendulum", "stiff").rounded()
    motion = case.sample(case.times)
    lengths = np.hypot(motion[:, 0], motion[:, 1])
    assert 5e-4 < np.abs(lengths - 1).max() < 4e-3
    small, rod = (
        case.metric.distance(level.project(level.case.sample(case.times)), motion, case.times).max()
        for level in case.hierarchy
    )
    assert rod < 0.05 < small
