"""The harmonic oscillator by its equation, by mpmath's exponential of the matrix and by its invariant."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.oscillators.harmonic_oscillator import HarmonicMotion

MOTIONS = [
    HarmonicMotion(Fraction(1), Fraction(4), Fraction(1), Fraction(1, 2)),
    HarmonicMotion(exact("0.3"), exact(7.1), exact(-2.5), exact("1e-9")),
    HarmonicMotion(Fraction(1), Fraction(10**16), Fraction(1), Fraction(0)),
]


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("t", ["0", "0.77", "-3"])
def test_equation_of_motion_is_satisfied(motion, t, residual):
    """Differences over h = 1e-30 err by h^2/6 times the third derivative, at most w^4 x or w^3 v in v."""
    ratio = motion.stiffness / motion.mass
    third = (1 + ratio**2) * (abs(motion.x0) + abs(motion.v0))
    limit = mpmath.mpf(third.numerator) / third.denominator * mpmath.mpf(10) ** -60
    assert residual(motion, lambda mp, y: (y[1], -mp.mpf(ratio) * y[0]), t) < limit


@pytest.mark.parametrize("motion", MOTIONS)
def test_matrix_exponential_arrives_at_the_same_state(motion):
    with mpmath.workdps(80):
        t = mpmath.mpf("1.375") * mpmath.sqrt(mpmath.mpf(motion.mass.numerator) / motion.mass.denominator)
        ratio = motion.stiffness / motion.mass
        t = exact(t / mpmath.sqrt(mpmath.mpf(motion.stiffness.numerator) / motion.stiffness.denominator))
        step = mpmath.mpf(t.numerator) / t.denominator
        matrix = mpmath.matrix([[0, step], [-step * ratio.numerator / ratio.denominator, 0]])
        start = [mpmath.mpf(x.numerator) / x.denominator for x in (motion.x0, motion.v0)]
        there = mpmath.expm(matrix) * mpmath.matrix(start)
        for found, right in zip(motion.state(t, 50), there, strict=True):
            assert abs(found - right) < mpmath.mpf(10) ** -48 * max(map(abs, there))


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_million_periods_on(motion):
    """The state a whole number of periods later, and 50 digits against 100."""
    with mpmath.workdps(130):
        later = exact(motion.period(120)) * 10**6
        for found, start in zip(motion.state(later, 50), (motion.x0, motion.v0), strict=True):
            scale = mpmath.mpf(max(abs(motion.x0), abs(motion.v0)) + 1) * motion.stiffness / motion.mass
            assert abs(found - mpmath.mpf(start.numerator) / start.denominator) < scale * mpmath.mpf(10) ** -48
        far = later + 1
        for short, long in zip(motion.state(far, 50), motion.state(far, 100), strict=True):
            assert abs(short - long) <= abs(long) * mpmath.mpf(10) ** -48


def test_phase_amplitude_form():
    motion = MOTIONS[0]
    with mpmath.workdps(40):
        x = motion.amplitude(40) * mpmath.cos(2 * mpmath.mpf("0.7") - motion.phase(40))
        assert abs(x - motion.state("0.7", 40)[0]) < mpmath.mpf(10) ** -38
        assert motion.energy(30) == mpmath.mpf("2.125")
