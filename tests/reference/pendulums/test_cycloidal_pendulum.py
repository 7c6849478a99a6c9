"""Huygens' pendulum by its equation in the angle, by a Taylor integration past the cusp, and by its period."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.pendulums.cycloidal_pendulum import CycloidalMotion


def cycloid(phi, rate, a="0.25", g="9.81"):
    return CycloidalMotion(*(exact(value) for value in (a, g, phi, rate)))


MOTIONS = {
    "middling": cycloid(1, 0),
    "small": cycloid("1e-6", 0),
    "launched": cycloid(-0.5, 5),
    "wide": cycloid(3, 0),
    "1e-4 from the cusp": cycloid("3.141492653589793", 0),
    "1e-8 from the cusp": cycloid("3.141592643589793", 0),
    "fast through the bottom": cycloid(0, "6.264183905346329", 0.25, 9.81),
}
CASES = [pytest.param(motion, id=name) for name, motion in MOTIONS.items()]


def equations(motion):
    def rates(arithmetic, state):
        phi, rate = state
        return rate, arithmetic.tan(phi / 2) * (rate * rate - arithmetic.mpf(motion.g / motion.a)) / 2

    return rates


@pytest.mark.parametrize("motion", CASES)
@pytest.mark.parametrize("t", ["0.1", "2.3", "-7.75"])
def test_equation_of_the_angle_is_satisfied(motion, t, residual):
    assert residual(motion, equations(motion), t) < mpmath.mpf(10) ** -45


@pytest.mark.parametrize("name", ["middling", "small", "launched", "wide", "1e-4 from the cusp"])
def test_taylor_integration_of_the_angle_arrives_at_the_same_state(name, taylor):
    """More than half a period, past the bottom and the reversal next to the cusp, which loses 1e4 squared."""
    motion = MOTIONS[name]
    with mpmath.workdps(70):
        there = taylor(equations(motion), (motion.phi0, motion.rate0), Fraction(11, 10))
        for found, right in zip(motion.state(Fraction(11, 10), 50), there, strict=True):
            assert abs(found - right) < mpmath.mpf(10) ** -45


@pytest.mark.parametrize("motion", CASES)
def test_fifty_digits_agree_with_a_hundred(motion):
    quarter = exact(motion.period(20)) / 4
    for t in (Fraction(0), quarter, 2 * quarter, Fraction(20000)):
        with mpmath.workdps(110):
            long = motion.state(t, 100)
            for found, right in zip(motion.state(t, 50), long, strict=True):
                # Next to the cusp the rate reverses within 1e-8 of a period, and t is not rounded.
                assert abs(found - right) < mpmath.mpf(10) ** -48


@pytest.mark.parametrize("motion", CASES)
def test_every_amplitude_has_the_same_period(motion):
    """A period by Huygens' formula, and the state after it; amplitudes from 1e-6 to the cusp."""
    with mpmath.workdps(70):
        ratio = motion.a / motion.g
        period = 4 * mpmath.pi * mpmath.sqrt(mpmath.mpf(ratio.numerator) / ratio.denominator)
        assert mpmath.almosteq(motion.period(60), period, rel_eps=mpmath.mpf(10) ** -59)
        for found, start in zip(motion.state(period, 50), motion.state(0, 50), strict=True):
            assert abs(found - start) < mpmath.mpf(10) ** -45


@pytest.mark.parametrize("motion", CASES)
def test_energy_is_constant(motion):
    with mpmath.workdps(70):
        a, g = (mpmath.mpf(x.numerator) / x.denominator for x in (motion.a, motion.g))
        for t in ("0.3", "1.7", "19"):
            phi, rate = motion.state(t, 60)
            s_rate = 2 * a * mpmath.cos(phi / 2) * rate
            value = s_rate**2 / 2 + g * a * (1 - mpmath.cos(phi))
            assert mpmath.almosteq(value, motion.energy(50), rel_eps=mpmath.mpf(10) ** -44)


def test_arc_length_is_harmonic_up_to_the_cusp():
    motion = MOTIONS["1e-8 from the cusp"]
    with mpmath.workdps(50):
        s0, _ = motion.arc(0, 40)
        w = 2 * mpmath.pi / motion.period(45)
        for t in (1, 3, 14):
            assert mpmath.almosteq(motion.arc(t, 40)[0], s0 * mpmath.cos(w * t), rel_eps=mpmath.mpf(10) ** -37)
        # 4a - s0 = a d^2/2 for a release d from the cusp.
        assert mpmath.almosteq(1 - s0, (mpmath.pi - mpmath.mpf("3.141592643589793")) ** 2 / 8, rel_eps=1e-15)


def test_angle_reaches_its_amplitude():
    motion = MOTIONS["launched"]
    with mpmath.workdps(40):
        largest = motion.angle_amplitude(40)
        released = CycloidalMotion(motion.a, motion.g, exact(largest), Fraction(0))
        assert mpmath.almosteq(released.energy(30), motion.energy(30), rel_eps=mpmath.mpf(10) ** -29)
        assert mpmath.almosteq(released.top_rate(30), motion.top_rate(30), rel_eps=mpmath.mpf(10) ** -29)
