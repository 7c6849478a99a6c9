"""Weierstrass's P against its equation, degenerate forms and Arb; Biermann's formula on elementary motions."""

from fractions import Fraction

import flint
import mpmath
import pytest
from gnomon.reference.numerics.precision import working
from gnomon.reference.numerics.weierstrass import invariants, solve_quartic, weierstrass

PAIRS = [
    (Fraction(4), Fraction(1)),
    (Fraction(0), Fraction(1)),
    (Fraction(-3), Fraction(0)),
    (Fraction(12), Fraction(-8)),
]


@pytest.mark.parametrize(("g2", "g3"), PAIRS)
@pytest.mark.parametrize("z", ["0.001", "0.7", "-1.1", "5.3"])
def test_first_integral_holds(g2, g3, z):
    """P'^2 = 4 P^3 - g2 P - g3, relative to its largest term; duplication adds guard digits itself."""
    with working(60) as mp:
        p, slope = weierstrass(mp, mp.mpf(z), mp.mpf(g2), mp.mpf(g3))
        size = abs(4 * p**3) + abs(mp.mpf(g2) * p) + abs(mp.mpf(g3))
        assert abs(slope**2 - 4 * p**3 + mp.mpf(g2) * p + mp.mpf(g3)) < size * mp.mpf(10) ** -55


@pytest.mark.parametrize("z", ["0.3", "1", "4.5"])
def test_double_root_gives_hyperbolic_functions(z):
    """g2 = 12, g3 = -8: roots 1, 1, -2 and P = 1 + 3/sinh^2(sqrt(3) z)."""
    with working(50) as mp:
        p, _ = weierstrass(mp, mp.mpf(z), mp.mpf(12), mp.mpf(-8))
        assert abs(p - 1 - 3 / mp.sinh(mp.sqrt(3) * mp.mpf(z)) ** 2) < mp.mpf(10) ** -44


def test_agrees_with_arb():
    """Arb's P has the period lattice as its argument: the square lattice of g3 = 0 with half period w."""
    before, flint.ctx.prec = flint.ctx.prec, 300
    try:
        z, tau = flint.acb("0.3"), flint.acb(0, 1)
        right = z.elliptic_p(tau).real.str(60, radius=False)
        g2, g3 = (x.real.str(70, radius=False) for x in tau.elliptic_invariants())
    finally:
        flint.ctx.prec = before
    with working(60) as mp:
        found, _ = weierstrass(mp, mp.mpf("0.3"), mp.mpf(g2), mp.mpf(g3))
        assert abs(found / mp.mpf(right) - 1) < mp.mpf(10) ** -50


def test_invariants_of_a_quartic_do_not_depend_on_the_origin():
    f = tuple(map(Fraction, (3, -1, 4, 1, -5)))
    shifted = tuple(
        sum((f[n] * mpmath.binomial(n, k) * 2 ** (n - k) for n in range(k, 5)), 0) for k in range(5)
    )  # f(x + 2)
    assert invariants(f) == invariants(tuple(Fraction(int(c)) for c in shifted))


def test_polynomial_of_degree_two_is_elementary():
    """x'^2 = 4 + x^2 from 0: x = 2 sinh t."""
    f = (Fraction(4), Fraction(0), Fraction(1), Fraction(0), Fraction(0))
    with working(60) as mp:
        x, v = solve_quartic(mp, f, 0, 2, mp.mpf(3))
        assert abs(x - 2 * mp.sinh(3)) < mp.mpf(10) ** -50
        assert abs(v - 2 * mp.cosh(3)) < mp.mpf(10) ** -50


def test_logistic_growth_backwards():
    """x' = -x (1 - x), a quartic with two double roots: 1/(1 + e^t) from 1/2."""
    f = (Fraction(0), Fraction(0), Fraction(1), Fraction(-2), Fraction(1))
    with working(60) as mp:
        x, v = solve_quartic(mp, f, Fraction(1, 2), Fraction(-1, 4), mp.mpf(5))
        right = 1 / (1 + mp.exp(5))
        assert abs(x - right) < mp.mpf(10) ** -50
        assert abs(v + right * (1 - right)) < mp.mpf(10) ** -50


def test_a_start_at_rest_moves_along_the_force():
    """x'^2 = 1 - x^2 from x = 1 at rest: cos t, not the equilibrium that x' = 0 alone would allow."""
    f = (Fraction(1), Fraction(0), Fraction(-1), Fraction(0), Fraction(0))
    with working(50) as mp:
        x, v = solve_quartic(mp, f, 1, 0, mp.mpf(2))
        assert abs(x - mp.cos(2)) < mp.mpf(10) ** -40
        assert abs(v + mp.sin(2)) < mp.mpf(10) ** -40
