"""Pairs on a spring and on a rod: the equations, and the exponential of the spring's matrix."""

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.two_masses import RodPair, SpringPair

F = exact
MOTIONS = {
    "line": SpringPair(F(1), F(2), F(30), (F(1),), (F(0),), ((F(0), F("1.3")),), ((F(0), F("0.5")),)),
    "stiff": SpringPair(F(1), F(2), F(10**10), (F(1),), (F(0),), ((F(0), F("1.3")),), ((F(0), F("0.5")),)),
    "light": SpringPair(F(1), F("1e-9"), F(30), (F(0),), (F("-9.81"),), ((F(0), F(1)),), ((F(3), F(4)),)),
}
CASES = [pytest.param(motion, id=name) for name, motion in MOTIONS.items()]


@pytest.mark.parametrize("motion", CASES)
def test_matrix_exponential_arrives_at_the_same_state(motion):
    """y = (x1, x2, v1, v2, 1). Scaling and squaring loses the digits of the matrix's size, 1e10, squared."""
    t = F("0.37")
    with mpmath.workdps(100):
        k, one, two, rest, a, t_ = (
            mpmath.mpf(x.numerator) / x.denominator
            for x in (motion.k, motion.m1, motion.m2, motion.rests[0], motion.pulls[0], t)
        )
        rows = [
            [0, 0, 1, 0, 0],
            [0, 0, 0, 1, 0],
            [-k / one, k / one, 0, 0, -k * rest / one + a],
            [k / two, -k / two, 0, 0, k * rest / two + a],
            [0, 0, 0, 0, 0],
        ]
        start = [mpmath.mpf(x.numerator) / x.denominator for x in (*motion.places[0], *motion.velocities[0])]
        there = mpmath.expm(mpmath.matrix(rows) * t_) * mpmath.matrix([*start, 1])
        for found, right in zip(motion.state(t, 50), there, strict=False):
            assert abs(found - right) < mpmath.mpf(10) ** -45 * max(1, abs(right))


ROD = RodPair(*map(F, (1, 2, 1, "9.81", 0, 0, "0.5", 2, 8, 10)))


def test_rod_pulls_along_itself(residual):
    def rates(mp, y):
        pull = mp.mpf(2) / 3 * y[5] ** 2
        return (*y[3:], pull * mp.cos(y[2]), pull * mp.sin(y[2]) - mp.mpf(981) / 100, mp.mpf(0))

    with mpmath.workdps(110):
        assert residual(ROD, rates, "1.9") < mpmath.mpf(10) ** -45


def test_distance_of_the_second_mass_from_the_parabola_is_constant():
    """The centre of mass moves as one point, and mass 1 is at the distance 2/3 l from it."""
    with mpmath.workdps(60):
        for t in (F("0.3"), F(1000)):
            x, _y, theta, *_ = ROD.state(t, 50)
            centre = (
                mpmath.mpf(2) / 3 * mpmath.cos(mpmath.mpf("0.5"))
                + exact_to_mpf(2 * t)
                - mpmath.mpf(20) / 3 * mpmath.sin(mpmath.mpf("0.5")) * exact_to_mpf(t)
            )
            assert abs(x + mpmath.mpf(2) / 3 * mpmath.cos(theta) - centre) < mpmath.mpf(10) ** -44
        assert mpmath.almosteq(ROD.tension(30), mpmath.mpf(200) / 3, mpmath.mpf(10) ** -28)


def exact_to_mpf(x):
    return mpmath.mpf(x.numerator) / x.denominator
