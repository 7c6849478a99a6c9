"""Motions that combine or specialise others: hanging springs, ball on an incline, Foucault with centrifugal terms."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.contact.bouncing_ball import BouncingBall
from gnomon.reference.contact.bouncing_ball_incline import BouncingIncline
from gnomon.reference.numerics.precision import exact
from gnomon.reference.oscillators.hanging_springs import HangingSprings
from gnomon.reference.oscillators.harmonic_oscillator import HarmonicMotion
from gnomon.reference.pendulums.foucault_pendulum_centrifugal import FoucaultCentrifugal


def test_hanging_springs_swing_about_their_sag():
    motion = HangingSprings(*map(Fraction, (2, 100, 300, 10)), Fraction(1, 2), Fraction(1))
    assert (motion.stiffness(), motion.side_by_side()) == (75, 400)
    sag = Fraction(20, 75)
    about = HarmonicMotion(Fraction(2), Fraction(75), Fraction(1, 2) - sag, Fraction(1))
    with mpmath.workdps(60):
        assert abs(motion.sag(50) - mpmath.mpf(4) / 15) < 1e-48
        for t in ("0.3", "1e4"):
            found, right = motion.state(t, 50), about.state(t, 50)
            assert abs(found[0] - mpmath.mpf(4) / 15 - right[0]) < 1e-48
            assert abs(found[1] - right[1]) < 1e-47


def test_impacts_do_not_change_the_motion_along_a_smooth_incline():
    """g = 2 normal to it, dropped from 1 m, e = 1/2: impacts at the rational times 1, 2, 2.5, ..., limit at 3."""
    ball = BouncingBall(Fraction(2), Fraction(1, 2), Fraction(1), Fraction(0))
    motion = BouncingIncline(ball, Fraction(3), Fraction(5), Fraction(-1))
    assert motion.state(1) == (Fraction(11, 2), 0, 2, 1)
    assert motion.state(3) == (Fraction(31, 2), 0, 8, 0)
    assert motion.state(5) == (Fraction(75, 2), 0, 14, 0)
    assert motion.place(Fraction(5, 2), 30) == (Fraction(95, 8), Fraction(13, 2))


@pytest.mark.parametrize("lat", ["0.8526", "-1.2", 0])
def test_centrifugal_pendulum_is_a_sum_of_two_elliptic_modes(lat):
    """(w^2 - a)(w^2 - b) = 4 W^2 w^2 gives two frequencies; released from rest, each mode is an ellipse."""
    g, length, rate, start = Fraction(981, 100), Fraction(1), Fraction(2), (Fraction(1, 10), Fraction(0))
    motion = FoucaultCentrifugal(g, length, rate, exact(lat), (*start, Fraction(0), Fraction(0)))
    with mpmath.workdps(70):
        turn = 2 * mpmath.sin(mpmath.mpf(exact(lat).numerator) / exact(lat).denominator)
        a, b = mpmath.mpf("9.81") - 4, mpmath.mpf("9.81") - turn**2
        half = (a + b + 4 * turn**2) / 2
        w = [mpmath.sqrt(half + sign * mpmath.sqrt(half**2 - a * b)) for sign in (1, -1)]
        t = mpmath.mpf("7.3")
        # x = sum A_i cos w_i t with y = sum A_i r_i sin w_i t: x'' = 2 W y' - a x gives r_i = (a - w_i^2)/(2 W w_i).
        # From rest sum A_i = x0 and sum A_i r_i w_i = 0.
        weights = [a - w[1] ** 2, w[0] ** 2 - a]
        amplitudes = [mpmath.mpf("0.1") * weight / sum(weights) for weight in weights]
        if turn == 0:
            right = mpmath.mpf("0.1") * mpmath.cos(mpmath.sqrt(a) * t), mpmath.mpf(0)
        else:
            ratios = [(a - x**2) / (2 * turn * x) for x in w]
            right = (
                sum(amplitude * mpmath.cos(x * t) for amplitude, x in zip(amplitudes, w, strict=True)),
                sum(A * r * mpmath.sin(x * t) for A, r, x in zip(amplitudes, ratios, w, strict=True)),
            )
        for found, expected in zip(motion.state("7.3", 50), right, strict=False):
            assert abs(found - expected) < mpmath.mpf(10) ** -48
