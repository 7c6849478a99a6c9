"""Particles on surfaces of revolution against motions that share no formula with them."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.cases import get
from gnomon.reference.guided.particles_on_surfaces import OnCone, OnParaboloid, OnTorus
from gnomon.reference.numerics.precision import exact
from gnomon.reference.pendulums.pendulum_simple import Pendulum


def test_without_turn_the_tube_holds_a_pendulum():
    """theta + pi/2 is the angle of a pendulum whose length is the radius of the tube."""
    start = exact(-mpmath.mpf("0.1"))
    motion = OnTorus(exact("9.81"), start, Fraction(0), Fraction(0), Fraction(0), Fraction(2), exact("0.5"))
    with mpmath.workdps(60):
        angle = exact(mpmath.mpf(start.numerator) / start.denominator + mpmath.pi / 2)
    same = Pendulum(exact("9.81"), exact("0.5"), angle, Fraction(0))
    assert abs(motion.period(40) - same.period(40)) < mpmath.mpf(10) ** -38
    with mpmath.workdps(45):
        theta = same.state("1.3", 40)[0]
        assert abs(motion.state("1.3", 40)[0] + mpmath.pi / 2 - theta) < mpmath.mpf(10) ** -38


def test_a_narrow_circle_of_the_cone_vibrates_at_its_small_frequency():
    """2 pi/sqrt(3) sin(alpha) circle rate: an amplitude of 1e-12 shifts it by 1e-24."""
    alpha, g = exact("0.5"), exact("9.81")
    with mpmath.workdps(60):
        rate = mpmath.sqrt(mpmath.mpf("9.81") * mpmath.cos("0.5")) / mpmath.sin("0.5")
        wanted = 2 * mpmath.pi / (mpmath.sqrt(3) * mpmath.sin("0.5") * rate)
        motion = OnCone(g, Fraction(1), Fraction(0), Fraction(1, 10**12), exact(rate), alpha)
        assert abs(motion.period(40) / wanted - 1) < mpmath.mpf(10) ** -23


def test_the_parallel_circle_of_the_paraboloid_is_recognised():
    assert OnParaboloid(Fraction(9), Fraction(2), Fraction(0), Fraction(0), Fraction(-3), Fraction(1)).rests
    assert not OnParaboloid(
        Fraction(9), Fraction(2), Fraction(0), Fraction(0), exact(3.0000000000000004), Fraction(1)
    ).rests


@pytest.mark.parametrize(
    ("name", "numbers", "rule"),
    [
        ("ignorable_coordinates", {"initial_state": (1, 0, 0, 0)}, "w is not 0"),
        ("particle_on_paraboloid", {"initial_state": (1, 0, 1, 0)}, "w is not 0"),
        ("particle_on_torus", {"a": 2}, "a < R"),
        ("particle_on_torus", {"initial_state": ("-0.6", 0, 8, 1)}, "too slow to pass the top"),
        ("particle_on_torus", {"initial_state": ("1.6", 0, 0, 1)}, "theta"),
    ],
)
def test_motions_outside_the_well_are_refused(name, numbers, rule):
    with pytest.raises(ValueError, match=rule):
        get(name, **numbers)
