from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.flight.projectile_stokes_drag import StokesDrag
from mpmath import mpf


def thrown(nu="0.5", vx=20, vy=15):
    return StokesDrag(
        Fraction(nu), (Fraction(0), Fraction("-9.81")), (Fraction(1), Fraction(2)), (Fraction(vx), Fraction(vy))
    )


@pytest.mark.parametrize(("nu", "t"), [("0.5", 3), ("1e-10", 3), (0, 3), ("1e5", 10), ("1e5", "1e-6"), (2, -1)])
def test_against_the_formula_of_the_book_and_a_taylor_integration(nu, t, taylor):
    motion, n = thrown(nu), Fraction(nu)
    found = motion.state(t, 50)
    with mpmath.workdps(120):
        k, time, g = mpf(n.numerator) / n.denominator, mpf(str(t)), mpf("9.81")
        if k == 0:
            expected = [1 + 20 * time, 2 + 15 * time - g * time**2 / 2, 20, 15 - g * time]
        else:
            e = mpmath.exp(-k * time)
            expected = [
                1 + 20 * (1 - e) / k,
                2 + (15 + g / k) * (1 - e) / k - g * time / k,
                20 * e,
                (15 + g / k) * e - g / k,
            ]
        for a, b in zip(found, expected, strict=True):
            assert abs(a - b) <= mpf("1e-49") * abs(b)
    if 0 < n * Fraction(t) < 20:
        for a, b in zip(found, taylor(rates(n), (1, 2, 20, 15), t), strict=True):
            assert abs(a - b) < mpf("1e-48") * max(map(abs, found))


def rates(nu):
    def field(m, y):
        k, g = m.mpf(nu), m.mpf(Fraction("9.81"))
        return y[2], y[3], -k * y[2], -g - k * y[3]

    return field


@pytest.mark.parametrize("nu", ["0.5", "1e-10", "1e-30", 0, "1e5"])
def test_the_flight_ends_at_the_height_where_it_began(nu):
    motion = thrown(nu)
    time = motion.flight_time(1, 60)
    assert time > 0
    height = motion.state(time, 50)[1] - 2
    # An error of 1e-60 in the time, at no more than the launch speed.
    assert abs(height) < mpf("1e-58") * 15 * time + mpf("1e-49") * abs(motion.state(time, 15)[0])
    with mpmath.workdps(60):
        assert mpmath.almosteq(motion.range(1, 0, 50), motion.state(time, 60)[0] - 1, rel_eps=mpf("1e-49"))


def test_a_throw_downward_has_no_flight():
    assert thrown(vy=-1).flight_time(1) is None
    assert thrown(vy=0).range(1, 0) is None
