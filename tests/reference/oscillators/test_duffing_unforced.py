"""Duffing's exact motion in every regime, against the equation, a Taylor integration and the elementary limits."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.oscillators.duffing_unforced import DuffingMotion


def duffing(alpha, beta, x, v):
    return DuffingMotion(*(exact(value) for value in (alpha, beta, x, v)))


def equations(motion):
    def rates(arithmetic, state):
        x, v = state
        return v, -arithmetic.mpf(motion.alpha) * x - arithmetic.mpf(motion.beta) * x * x * x

    return rates


MOTIONS = {
    "hard": duffing(1, 1, 1, "0.5"),
    "hard without linear part": duffing(0, 1, 1, -0.5),
    "linear": duffing(2, 0, 1, 0.5),
    "soft": duffing(1, -0.25, "1.2", 0.3),
    "one well": duffing(-1, 1, 1.2, 0.1),
    "the other well": duffing(-1, 1, -1.2, 0.1),
    "bottom of a well": duffing(-1, 1, 1, 0),
    "next to the bottom": duffing(-1, 1, 1.0000000001, 0),
    "across both wells": duffing(-1, 1, 1.6, 0),
    "homoclinic": duffing(-1, 2, 1, 0),
    "homoclinic, inwards": duffing(-1, Fraction(3, 2), Fraction(1), -Fraction(1, 2)),
    "heteroclinic": duffing(1, -0.5, 0, 1),
    "next to escape": duffing(1, -0.5, 0, "0.999999999999"),
    "1e-60 from escape": duffing(1, -0.5, 0, 1 - Fraction(1, 10**60)),
    "1e-60 off the saddle, over it": duffing(-1, 1, "1e-60", "1.1e-60"),
    "1e-8 off the saddle": duffing(-1, 1, 1e-8, 0),
    "1e-12 off the saddle": duffing(-1, 1, 1e-12, 0),
    "1e-12 off the saddle, over it": duffing(-1, 1, 1e-12, 1.1e-12),
}
CASES = [pytest.param(motion, id=name) for name, motion in MOTIONS.items()]


@pytest.mark.parametrize("motion", CASES)
@pytest.mark.parametrize("t", ["0.125", "3.3", "-5.1", "31.7"])
def test_equation_of_motion_is_satisfied(motion, t, residual):
    assert residual(motion, equations(motion), t) < mpmath.mpf(10) ** -50


@pytest.mark.parametrize("motion", CASES)
def test_taylor_integration_arrives_at_the_same_state(motion, taylor):
    """Errors of the integration (1e-60) grow at most like e^(2 t): 1e-47."""
    with mpmath.workdps(70):
        there = taylor(equations(motion), (motion.x0, motion.v0), 15)
        for found, right in zip(motion.state(15, 50), there, strict=True):
            assert abs(found - right) < mpmath.mpf(10) ** -46


@pytest.mark.parametrize("motion", CASES)
def test_fifty_digits_agree_with_a_hundred(motion):
    far = exact(motion.period(30)) * Fraction("10000.37") if motion.periodic else Fraction(60)
    for time in (Fraction(1, 10**9), Fraction(29), far):
        with mpmath.workdps(110):
            for short, long in zip(motion.state(time, 50), motion.state(time, 100), strict=True):
                assert abs(short - long) < mpmath.mpf(10) ** -48


@pytest.mark.parametrize("motion", [motion for motion in MOTIONS.values() if motion.periodic])
def test_turning_points_and_period(motion):
    """Released at a turning point, the motion is at the other one after half a period.

    Rounding the point moves the energy, which lies 1e-120 from the separatrix at most: 200 digits of it are enough.
    """
    least, largest = motion.turning_points(200)
    released = DuffingMotion(motion.alpha, motion.beta, exact(largest), Fraction(0))
    half = exact(motion.period(120)) / 2
    with mpmath.workdps(60):
        x, v = released.state(half, 50)
        assert abs(x - least) < mpmath.mpf(10) ** -45
        assert abs(v) < mpmath.mpf(10) ** -45


def test_homoclinic_is_the_hyperbolic_secant():
    with mpmath.workdps(60):
        for t in (0, 1, 7, 40):
            assert mpmath.almosteq(MOTIONS["homoclinic"].state(t, 50)[0], mpmath.sech(t), rel_eps=mpmath.mpf(10) ** -48)


def test_heteroclinic_is_the_hyperbolic_tangent():
    with mpmath.workdps(60):
        root = mpmath.sqrt(2)
        for t in (1, 7, 40):
            found = MOTIONS["heteroclinic"].state(t, 50)[0]
            assert mpmath.almosteq(found, root * mpmath.tanh(t / root), rel_eps=mpmath.mpf(10) ** -48)


def test_hard_spring_released_at_rest_is_cn():
    """x = A cn(W t | b A^2 / (2 W^2)), W^2 = a + b A^2: mpmath's theta functions."""
    motion = duffing(1, 3, 2, 0)
    with mpmath.workdps(60):
        expected = 2 * mpmath.ellipfun("cn", mpmath.sqrt(13) * mpmath.mpf("2.5"), m=mpmath.mpf(12) / 26)
        assert mpmath.almosteq(motion.state("2.5", 50)[0], expected, rel_eps=mpmath.mpf(10) ** -48)


@pytest.mark.parametrize(
    ("motion", "bounded"),
    [
        (duffing(1, -0.5, 0, 1), True),
        (duffing(1, -0.5, 0, 1.0000000000000002), False),
        (duffing(1, -0.5, 1.5, 0), False),
        (duffing(1, -1, 1, 0), True),
        (duffing(-1, -1, 0, 0.1), False),
        (duffing(-1, 0, 1, 0), False),
        (duffing(-1, -1, 0, 0), True),
        (duffing(-1, 1e-9, 5, 5), True),
    ],
)
def test_bounded_is_decided_exactly(motion, bounded):
    assert motion.bounded is bounded
