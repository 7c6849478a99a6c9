from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import ball, integrate
from gnomon.reference.rigid_bodies.lagrange_top import LagrangeTop, SphericalPendulum
from gnomon.reference.rigid_bodies.lagrange_top_attitude import TopAttitude
from mpmath import mpf

IDENTITY = (1, 0, 0, 0, 1, 0, 0, 0, 1)
TILTED = (1, 0, 0, 0, "0.6", "-0.8", 0, "0.8", "0.6")
HANGING = (1, 0, 0, 0, -1, 0, 0, 0, -1)
SKEWED = ("1.1", "0.2", 0, "-0.3", "0.9", "0.4", "0.2", "0.1", 2)
BODIES = {
    "general": (1, "0.5", 1, ("0.1", "0.2", 3), TILTED),
    "an attitude that is no rotation": (1, "0.5", 1, ("0.1", "0.2", 3), SKEWED),
    "at the lower turning point": (1, "0.5", 1, (0, 0, 3), TILTED),
    "at the upper turning point": (1, "0.5", 1, (0, 2, 3), TILTED),
    "regular precession": ("0.5", "0.5", 1, (0, "1.25", "0.9375"), TILTED),
    "through the vertical": (1, "0.5", 1, ("0.3", "0.7", "0.5"), IDENTITY),
    "through the lowest point": (1, "0.5", 1, ("0.3", "0.7", 3), HANGING),
    "asleep": (1, "0.5", 1, (0, 0, 1), IDENTITY),
    "hanging": (1, "0.5", 1, (0, 0, 1), HANGING),
    "in a plane": (1, "0.5", 1, ("0.3", 0, 0), TILTED),
    "in a plane, over the top": (1, "0.5", 1, (3, "0.5", 0), HANGING),
    "in a plane, exactly to the top": (1, "0.5", 1, (2, 0, 0), HANGING),
    "rising for ever": ("0.0625", "0.03125", "1.5625", (3, 4, 16), ("1.25", 0, 0, 0, "0.75", -1, 0, 1, "0.75")),
    "coming from the vertical": ("0.0625", "0.03125", "1.5625", (-3, 4, 16), (*SKEWED[:6], 0, 1, "0.75")),
    "no vertical": (1, "0.5", 1, (1, 0, 2), (*IDENTITY[:6], 0, 0, 0)),
}


def body(i1, i3, weight, rates, attitude):
    return TopAttitude(*map(exact, (i1, i3, weight)), tuple(map(exact, rates)), tuple(map(exact, attitude)))


def body_field(motion):
    def field(t, state):
        moment, axial, weight = (ball(x) for x in (motion.I1, motion.I3, motion.W))
        w1, w2, w3, *R = state
        rates = [
            ((moment - axial) * w2 * w3 + weight * R[7]) / moment,
            ((axial - moment) * w3 * w1 - weight * R[6]) / moment,
            0 * w3,
        ]
        for x, y, z in (R[:3], R[3:6], R[6:]):
            rates += [y * w3 - z * w2, z * w1 - x * w3, x * w2 - y * w1]
        return tuple(rates)

    return field


def difference(found, state):
    with mpmath.workdps(60):
        return max(abs(a - mpf(b.numerator) / b.denominator) for a, b in zip(found, state, strict=True))


@pytest.mark.parametrize("name", BODIES)
def test_the_body_moves_as_integrated(name):
    motion = body(*BODIES[name])
    start = (*motion.rates, *motion.attitude)
    (state,) = integrate(body_field(motion), start, (Fraction(1),), 60)
    # Next to the vertical errors of 1e-60 grow by e^8 at most, k = sqrt(61) here.
    assert difference(motion.state(1, 50), state) < mpf("1e-46")


@pytest.mark.parametrize("name", BODIES)
def test_momenta_and_energy_of_the_body_far_out(name):
    motion = body(*BODIES[name])
    with mpmath.workdps(70):
        i1, i3, weight = (mpf(x.numerator) / x.denominator for x in (motion.I1, motion.I3, motion.W))

        def constants(state):
            w1, w2, w3, *R = state
            return (
                i1 * (w1**2 + w2**2) / 2 + weight * R[8],
                i3 * w3,
                i1 * (w1 * R[6] + w2 * R[7]) + i3 * w3 * R[8],
                *(R[i] * R[j] + R[i + 1] * R[j + 1] + R[i + 2] * R[j + 2] for i in (0, 3, 6) for j in (0, 3, 6)),
            )

        first, later = constants(motion.state(0, 60)), constants(motion.state("12345.6", 60))
        # Products of numbers up to a few hundred with 60 digits.
        assert max(abs(a - b) for a, b in zip(first, later, strict=True)) < mpf("1e-55")


@pytest.mark.parametrize(
    "numbers", [(1, "0.5", 1, 2, "1.7", "0.6", "0.3"), (1, "0.5", 1, 1, 1, "0.6", "0.5"), (1, 2, 3, -1, "0.2", 3, 0)]
)
def test_angles_and_body_agree(numbers):
    """R33 = cos(theta), R13 = sin(theta) sin(phi), R31 = sin(theta) sin(psi): two formulas."""
    i1, i3, weight, a, b, tilt, rate = map(exact, numbers)
    angles = LagrangeTop(i1, i3, weight, a, b, tilt, rate, Fraction(0), Fraction(0))
    with mpmath.workdps(90):
        s, c = mpmath.sin(mpf(tilt.numerator) / tilt.denominator), mpmath.cos(mpf(tilt.numerator) / tilt.denominator)
        momenta = [mpf(x.numerator) / x.denominator for x in (i1, a, b)]
        across = (momenta[2] - momenta[1] * c) / (s * momenta[0])
        rates = (rate, exact(across), a / i3)
        rows = (Fraction(1), *[Fraction(0)] * 3, exact(c), exact(-s), Fraction(0), exact(s), exact(c))
    top = TopAttitude(i1, i3, weight, rates, rows)
    for t in ("0.7", 5, 40):
        with mpmath.workdps(60):
            theta, _, phi, psi = angles.state(t, 50)
            R = top.state(t, 50)[3:]
            assert abs(R[8] - mpmath.cos(theta)) < mpf("1e-46")
            assert abs(R[2] - mpmath.sin(theta) * mpmath.sin(phi)) < mpf("1e-46")
            assert abs(R[6] - mpmath.sin(theta) * mpmath.sin(psi)) < mpf("1e-46")


@pytest.mark.parametrize("b", ["1.7", "1.650671229819", "2.0000001"])
def test_a_nutation_brings_the_tilt_back_and_advances_the_angles(b):
    """1.6506... is nearly cuspidal, the last b passes the vertical closely."""
    top = LagrangeTop(*map(exact, (1, "0.5", 1, 2, b, "0.6", 0)), Fraction(0), Fraction(0))
    period, gained = top.nutation_period(60), top.precession_per_nutation(60)
    first, later = top.state(1, 50), top.state(1 + 100 * exact(period), 50)
    with mpmath.workdps(60):
        assert abs(first[0] - later[0]) < mpf("1e-45")
        assert abs(later[2] - first[2] - 100 * gained) < mpf("1e-40")


@pytest.mark.parametrize("h", ["1e-3", "0.5", "3.017132507336929"])
def test_the_spherical_pendulum_moves_as_integrated(h):
    motion = SphericalPendulum(*map(exact, ("9.81", 1, h, 1, 0)), Fraction(0))

    def field(t, state):
        theta, omega, _ = state
        s = theta.sin()
        k = ball(motion.h)
        return omega, k * k * theta.cos() / (s * s * s) - ball(motion.g) * s, k / (s * s)

    (state,) = integrate(field, (Fraction(1), Fraction(0), Fraction(0)), (Fraction(1),), 60)
    # At 1e-3 from the pole an error of the tilt is 1e3 as large in phi.
    assert difference(motion.state(1, 55), state) < mpf("1e-46")


def test_the_thin_ellipse_precesses_as_in_the_book():
    """(3/8)(ab/L^2) of 2 pi a period, to the square of the amplitude, a = 0.01; b = h/(w a)."""
    motion = SphericalPendulum(*map(exact, (1, 1, "1e-6", "0.01", 0)), Fraction(0))
    excess = motion.precession_per_nutation(30) - mpmath.pi
    assert float(excess) == pytest.approx(float(3 / 8 * 1e-6 * mpmath.pi), rel=1e-3)
