from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.contact.stick_slip_belt import StickSlip
from mpmath import mpf


def block(mu_s="0.5", mu_k="0.3", V="0.5", x=0, v="0.5"):
    return StickSlip(*map(Fraction, (1, 20, "9.81", mu_s, mu_k, V, x, v)))


@pytest.mark.parametrize("V", ["0.5", "1e-3", 1000])
def test_the_limit_cycle_of_the_book(V):
    motion = block(V=V, v=V)
    with mpmath.workdps(70):
        w, xs, xk = mpmath.sqrt(20), mpf("9.81") / 40, mpf("9.81") * 3 / 200
        xk = mpf("9.81") * mpf("0.3") / 20
        slip = 2 / w * (mpmath.pi - mpmath.atan(w * (xs - xk) / mpf(V)))
        assert mpmath.almosteq(motion.slip_time(50), slip, mpf("1e-48"))
        assert mpmath.almosteq(motion.stick_time(50), 2 * (xs - xk) / mpf(V), mpf("1e-48"))
        released = motion.release_time(60)
        assert mpmath.almosteq(released, xs / mpf(V), mpf("1e-48"))
        # Within a slip and at its end, by the formula of the book.
        tau = slip / 3
        x, v = motion.state(released + tau, 50)
        assert abs(x - (xk + (xs - xk) * mpmath.cos(w * tau) + mpf(V) / w * mpmath.sin(w * tau))) < mpf("1e-46") * mpf(
            V
        ) + mpf("1e-48")
        x, v = motion.state(released + slip, 50)
        assert abs(x - (2 * xk - xs)) < mpf("1e-47") * (1 + mpf(V))
        assert abs(v - mpf(V)) < mpf("1e-46") * (1 + mpf(V))
        # A whole cycle later the state returns.
        a, b = motion.state(released + tau, 50), motion.state(released + tau + 7 * motion.period(60), 50)
        assert abs(a[0] - b[0]) < mpf("1e-46") * (1 + mpf(V))


def test_a_start_at_rest_on_the_belt_slips_first(residual):
    motion = block(v=0)
    time, place = motion.first_catch(60)
    x, v = motion.state(time, 50)
    assert abs(x - place) < mpf("1e-14")
    assert abs(v - mpf("0.5")) < mpf("1e-14")

    def rates(m, y):
        return y[1], m.mpf("9.81") * m.mpf("0.3") - 20 * y[0]

    assert residual(motion, rates, Fraction(float(time)) / 2) < mpf("1e-55")
    assert motion.state(Fraction(float(time)) + Fraction("0.01"), 40)[1] == mpf("0.5")


def test_with_equal_coefficients_it_slips_for_ever():
    motion = block(mu_s="0.3")
    assert not motion.repeats
    with mpmath.workdps(60):
        released, w = motion.release_time(60), mpmath.sqrt(20)
        x, v = motion.state(released + 5, 50)
        assert abs(v - mpmath.cos(5 * w) / 2) < mpf("1e-48")
        assert abs(x - mpf("9.81") * mpf("0.3") / 20 - mpmath.sin(5 * w) / (2 * w)) < mpf("1e-48")


def test_a_slip_slower_than_the_belt_never_sticks():
    motion = block(x="0.14715", v="0.1")
    assert motion.slips_for_good
    assert motion.first_catch() is None
