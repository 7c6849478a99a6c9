from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.sliding_can import SlidingCan
from mpmath import mpf


def can(alpha="0.1", lift="0.17", mu_k="0.25"):
    return SlidingCan(*map(Fraction, ("0.02", "9.81", alpha, "0.3", mu_k, lift, 5, 1, 0)))


def test_it_sets_off_where_friction_yields():
    motion = can()
    with mpmath.workdps(60):
        t, a = motion.onset(50), mpf("0.1")
        weight = mpf("0.02") * mpf("9.81")
        normal = weight * mpmath.cos(a) - mpf("0.17") * (1 - mpmath.exp(-t / 5))
        assert mpmath.almosteq(weight * mpmath.sin(a), mpf("0.3") * normal, mpf("1e-48"))
        assert motion.state(t - mpf("1e-30"), 40) == (1, 0)


@pytest.mark.parametrize(("alpha", "t"), [("0.1", 11), ("0.4", 2)])
def test_the_equation_holds(alpha, t, residual):
    def rates(m, y):
        a = m.mpf(alpha)
        lift = m.mpf("0.17") * (1 - m.exp(-m.mpf(t) / 5)) / m.mpf("0.02")
        return y[1], m.mpf("9.81") * m.sin(a) - (m.mpf("9.81") * m.cos(a) - lift) / 4

    assert residual(can(alpha), rates, t) < mpf("1e-55")


def test_the_place_is_the_integral_of_the_velocity():
    motion = can()
    with mpmath.workdps(40):
        begin = motion.onset(40)
        way = mpmath.quad(lambda t: motion.state(t, 35)[1], [begin, 11])
        assert mpmath.almosteq(motion.state(11, 40)[0] - 1, way, mpf("1e-28"))


def test_it_holds_or_slides_at_once():
    assert can(lift="0.12").holds
    assert can("0.4").slides_first
    assert can("0.4").onset() == 0
