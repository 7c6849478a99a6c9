"""The shortened string: moment of momentum, and the work of the tension along its way by an independent sum."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.cases import get
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.central_force_shortened_string import ShortenedString


def made(c="0.05"):
    return ShortenedString(*map(exact, (2, "1.5", c, "0.25", 3)))


@pytest.mark.parametrize("c", ["0.05", "-0.4", 0])
def test_moment_of_momentum_is_kept(c):
    motion = made(c)
    for t in (Fraction(0), Fraction(3), Fraction(17, 2)):
        assert motion.radius(t) ** 2 * motion.at(t)[1] == Fraction(9, 4) * 3


def test_the_angle_is_the_integral_of_the_rate():
    motion = made()
    with mpmath.workdps(40):
        turned = mpmath.quad(lambda t: mpmath.mpf("6.75") / (1.5 - t / 20) ** 2, [0, 2, 4])
        assert abs(mpmath.mpf("0.25") + turned - motion.state(4, 40)[0]) < mpmath.mpf("1e-35")


def test_the_tension_does_the_work_along_the_way_in():
    motion = made()
    with mpmath.workdps(40):
        done = mpmath.quad(lambda t: 2 * mpmath.mpf("6.75") ** 2 / (1.5 - t / 20) ** 3 / 20, [0, 2, 4])
        assert abs(done - mpmath.mpf(motion.work(Fraction(4)))) < mpmath.mpf("1e-35")
        assert abs(motion.tension(Fraction(0)) - 2 * Fraction(3, 2) * 9) == 0


def test_the_hole_is_not_reached():
    with pytest.raises(ValueError, match="reaches the hole; give a span that ends before 20 s"):
        get("central_force_shortened_string", span=20)
    assert get("central_force_shortened_string", span="19.99").quantities()["rate_end"] > 1e6
    assert get("central_force_shortened_string", c=-1, span=20).quantities()["work"] < 0
