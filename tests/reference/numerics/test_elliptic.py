"""Jacobi's functions against mpmath's own, against Arb and against their differential equations."""

from fractions import Fraction

import flint
import mpmath
import pytest
from gnomon.reference.numerics.elliptic import amplitude, complete_first, incomplete_first, jacobi
from gnomon.reference.numerics.precision import working

PARAMETERS = ("1e-30", "1e-12", "0.01", "0.5", "0.9", "0.999999", "1")
"""Values of mc = 1 - m."""
ARGUMENTS = ("-31.5", "-1e-20", "0", "0.3", "3", "17.25", "40", "1000.5")


def pair(mp, text):
    mc = mp.mpf(text)
    return mc, 1 - mc


@pytest.mark.parametrize("text", PARAMETERS)
@pytest.mark.parametrize("u", ARGUMENTS)
def test_sn_cn_dn_agree_with_theta_functions(text, u):
    """mpmath forms sn, cn, dn from theta functions; both lose the digits of u and 1/mc."""
    with working(100) as mp:
        mc, m = pair(mp, text)
        if m == 0:
            expected = mp.sin(mp.mpf(u)), mp.cos(mp.mpf(u)), mp.one
        else:
            expected = tuple(mp.re(mp.ellipfun(name, mp.mpf(u), m=m)) for name in ("sn", "cn", "dn"))
        for found, right in zip(jacobi(mp, mp.mpf(u), mc, m)[1:], expected, strict=True):
            assert abs(found - right) < mp.mpf(10) ** -60


@pytest.mark.parametrize("text", PARAMETERS)
@pytest.mark.parametrize("phi", ["-20", "-1.5", "0", "1e-9", "0.7", "1.57", "3.2", "100.125"])
def test_amplitude_inverts_the_integral_without_wrapping(text, phi):
    with working(120) as mp:
        mc, m = pair(mp, text)
        u = incomplete_first(mp, mp.mpf(phi), mc, m)
        assert abs(amplitude(mp, u, mc, m) - mp.mpf(phi)) < mp.mpf(10) ** -80


@pytest.mark.parametrize("text", PARAMETERS)
def test_complete_integral_agrees_with_arb(text):
    """Arb's ball is a rigorous enclosure."""
    before, flint.ctx.prec = flint.ctx.prec, 400
    try:
        value = Fraction(text)
        m = flint.arb(flint.fmpq(value.denominator - value.numerator, value.denominator))
        ball = flint.acb(m).elliptic_k().real
        right = ball.str(80, radius=False)
    finally:
        flint.ctx.prec = before
    with working(90) as mp:
        assert abs(complete_first(mp, mp.mpf(value)) / mp.mpf(right) - 1) < mp.mpf(10) ** -75


@pytest.mark.parametrize("text", ["1e-12", "0.3", "0.999"])
@pytest.mark.parametrize("phi", ["0.4", "1.5", "-1.2"])
def test_incomplete_integral_agrees_with_quadrature(text, phi):
    with working(40) as mp:
        mc, m = pair(mp, text)
        end = mp.mpf(phi)
        pieces = [0, end / 2, end * 3 / 4, end]
        integral = mp.quad(lambda x: 1 / mp.sqrt(mp.cos(x) ** 2 + mc * mp.sin(x) ** 2), pieces)
        assert abs(incomplete_first(mp, end, mc, m) - integral) < mp.mpf(10) ** -25


def test_amplitude_past_a_quarter_period():
    """asin(sn) takes the wrong branch here: it would give 0.6816."""
    with working(30) as mp:
        half = mp.mpf(1) / 2
        assert mpmath.nstr(amplitude(mp, mp.mpf(3), half, half), 5) == "2.46"
        assert mpmath.nstr(mp.asin(jacobi(mp, mp.mpf(3), half, half)[1]), 4) == "0.6816"


def test_derivative_of_the_amplitude_is_dn():
    with working(90) as mp:
        h, u, mc = mp.mpf(10) ** -30, mp.mpf("7.7"), mp.mpf("1e-7")
        slope = (amplitude(mp, u + h, mc, 1 - mc) - amplitude(mp, u - h, mc, 1 - mc)) / (2 * h)
        # h^2 am'''/6, and 90 - 30 digits left by the difference
        assert abs(slope - jacobi(mp, u, mc, 1 - mc)[3]) < mp.mpf(10) ** -50
