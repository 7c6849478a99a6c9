from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.contact.torpedo_firing_pin import FiringPin
from mpmath import mpf


def pin(a=2000, gap="0.01", x=0, v=0, m="0.05", k=2000, d0="0.03", mu="0.2"):
    return FiringPin(*map(Fraction, (m, k, d0, mu, a, gap, x, v)))


@pytest.mark.parametrize("a", [0, 2000, "5999"])
def test_from_rest_it_strikes_by_the_formula_of_the_model(a):
    motion = pin(a, gap="1e-6")
    with mpmath.workdps(60):
        w = mpmath.sqrt(40000)
        xe, gap = mpf("0.03") - mpf("0.01") * mpf(a) / 2000, mpf("1e-6")
        assert mpmath.almosteq(motion.end_time(50), mpmath.acos(1 - gap / xe) / w, mpf("1e-44"))
        assert mpmath.almosteq(motion.strike_speed(50), w * mpmath.sqrt(gap * (2 * xe - gap)), mpf("1e-48"))
        t = motion.end_time(50) / 2
        x, v = motion.state(t, 50)
        assert mpmath.almosteq(x, xe * (1 - mpmath.cos(w * t)), mpf("1e-40"))
        assert mpmath.almosteq(v, xe * w * mpmath.sin(w * t), mpf("1e-44"))
        assert motion.state(3 * t, 50) == (motion.end_position(50), 0)


def test_the_equation_holds_before_the_end(residual):
    motion = pin("0.5", 9, x=1, v=2, m=2, k=3, d0=5, mu="0.5")

    def rates(m, y):
        return y[1], m.mpf(3) / 2 * (5 - y[0]) - m.mpf("0.25")

    assert residual(motion, rates, Fraction("0.7")) < mpf("1e-55")


def test_a_gap_at_twice_the_centre_is_reached_without_speed():
    motion = pin(8, 2, m=1, k=4, d0=2, mu="0.5")
    assert motion.fires
    assert motion.strike_speed() == 0
    with mpmath.workdps(60):
        assert mpmath.almosteq(motion.end_time(50), mpmath.pi / 2, mpf("1e-49"))
    assert not pin(8, Fraction(2) + Fraction(1, 10**40), m=1, k=4, d0=2, mu="0.5").fires


def test_it_stops_short_or_is_held():
    short = pin(gap="0.04001")
    assert short.moves
    assert not short.fires
    assert float(short.end_position()) == pytest.approx(0.04, rel=1e-15)
    assert not pin(6000).moves
    assert pin(Fraction(6000) - Fraction(1, 10**40)).moves
    assert float(pin().holding_deceleration()) == 6000
