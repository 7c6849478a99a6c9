"""The pulse: its impulse, its lag behind an instantaneous one, and its motion by quadrature of the force."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.flight.impulse_instantaneous import Pulse
from gnomon.reference.numerics.precision import exact


def made(length):
    return Pulse(*map(exact, (2, 3, "0.7", length, 0, "0.5")))


@pytest.mark.parametrize("length", ["0.1", "1e-9", 0])
def test_impulse_and_lag(length):
    """The error of the instantaneous impulse is T J/(2m): first order in T."""
    late, instantaneous = made(length), made(0)
    with mpmath.workdps(40):
        (x, v), (x0, v0) = late.state(2, 40), instantaneous.state(2, 40)
        assert v == v0 == 2
        lag = mpmath.mpf(3 * exact(length).numerator) / (4 * exact(length).denominator)
        assert abs(x0 - x - lag) < mpmath.mpf("1e-38")
        assert abs(late.lag(40) - lag) <= mpmath.mpf("1e-40") * (1 + lag)


def test_the_motion_in_the_pulse_is_the_integral_of_the_force():
    motion = made("0.1")
    with mpmath.workdps(40):
        rate = mpmath.pi * 10

        def force(s):
            return 3 * rate / 2 * mpmath.sin(rate * s)

        x, v = motion.state("0.73", 40)
        s = mpmath.mpf("0.03")
        assert abs(mpmath.quad(force, [0, s]) / 2 + 0.5 - v) < mpmath.mpf("1e-35")
        way = mpmath.quad(lambda u: (s - u) * force(u), [0, s]) / 2
        assert abs(way + mpmath.mpf("0.365") - x) < mpmath.mpf("1e-35")
        assert abs(mpmath.quad(force, [0, mpmath.mpf("0.1")]) - 3) < mpmath.mpf("1e-35")


def test_the_velocity_jumps_at_an_instantaneous_impulse():
    motion = made(0)
    assert motion.before_the_impulse() == (pytest.approx(0.35, rel=1e-15), 0.5)
    assert motion.state(Fraction(7, 10)) == (pytest.approx(0.35, rel=1e-15), 2)
    assert motion.state(Fraction(699, 1000))[1] == 0.5
