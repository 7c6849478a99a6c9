from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.guided.pendulum_on_hoop import Hoop
from gnomon.reference.numerics.precision import exact
from gnomon.reference.pendulums.pendulum_simple import Pendulum
from mpmath import mpf

MOTIONS = {
    "one well": (("9.81", 16, "0.5", 0), Hoop.LIBRATION),
    "both wells": ((1, 4, 2, "0.9"), Hoop.LIBRATION),
    "wide swing from beyond the middle": ((2, 0, "-2.5", 0), Hoop.LIBRATION),
    "rotation": ((2, 3, 1, 5), Hoop.ROTATION),
    "backwards, many turns away": ((3, 4, -9, -6), Hoop.ROTATION),
    "separatrix": ((1, "0.25", 0, 2), Hoop.SEPARATRIX),
    "bifurcation": ((9, 9, "0.1", 0), Hoop.LIBRATION),
    "beside the unstable bottom": ((1, 4, "1e-12", 0), Hoop.LIBRATION),
    "stable upright": ((2, -3, 3, Fraction(1, 3)), Hoop.LIBRATION),
    "level with the stable upright": ((1, -3, 0, 2), Hoop.LIBRATION),
    "a quartic that is a square": ((2, -1, 0, 3), Hoop.ROTATION),
    "south-seeking": ((-2, 1, 3, 1), Hoop.LIBRATION),
    "no gravity": ((0, 2, 1, 0), Hoop.LIBRATION),
    "no force": ((0, 0, 1, 2), Hoop.ROTATION),
    "at rest": ((1, 2, 0, 0), Hoop.REST),
}
ALL = [pytest.param(Hoop(*map(exact, numbers)), regime, id=name) for name, (numbers, regime) in MOTIONS.items()]


def rates(motion):
    def field(mp, state):
        theta, omega = state
        pull, lift = mp.mpf(motion.pull), mp.mpf(motion.lift)
        return omega, lift * mp.sin(2 * theta) / 2 - pull * mp.sin(theta)

    return field


def mpmath_rates(motion):
    pull, lift = ((mpf(x.numerator), x.denominator) for x in (motion.pull, motion.lift))

    def field(mp, state):
        theta, omega = state
        return omega, lift[0] / lift[1] * mp.sin(2 * theta) / 2 - pull[0] / pull[1] * mp.sin(theta)

    return field


@pytest.mark.parametrize(("motion", "regime"), ALL)
def test_the_equation_holds(motion, regime, residual):
    assert motion.regime == regime
    for t in ("0.3", "17.3", 1234):
        # Central differences over 1e-30 err by 1e-60 of the third derivative, at most a few hundred.
        assert residual(motion, mpmath_rates(motion), t) < mpf("1e-56")


@pytest.mark.parametrize(("motion", "regime"), ALL)
def test_taylor_integration_agrees(motion, regime, taylor):
    found = taylor(rates(motion), (motion.theta0, motion.omega0), 4)
    with mpmath.workdps(60):
        # On the separatrix and from beside the unstable bottom errors of 1e-60 grow by e^8 at most.
        assert max(abs(a - b) for a, b in zip(found, motion.state(4, 55), strict=True)) < mpf("1e-50")


@pytest.mark.parametrize(("motion", "regime"), ALL)
def test_the_state_repeats_after_a_period(motion, regime):
    period = motion.period(60)
    if period is None:
        assert regime in (Hoop.REST, Hoop.SEPARATRIX)
        return
    with mpmath.workdps(60):
        turn = 0 if regime == Hoop.LIBRATION else mpmath.sign(motion.state(0)[1]) * 2 * mpmath.pi
        theta, omega = motion.state(1 + 3 * exact(period), 50)
        first = motion.state(1, 50)
        # Three times the error of the period, 1e-60, times rates of a few hundred at most.
        assert abs(theta - first[0] - 3 * turn) < mpf("1e-46")
        assert abs(omega - first[1]) < mpf("1e-46")


@pytest.mark.parametrize("start", [("2", 0), ("0.5", 7), ("3.14159265", 0)])
def test_without_lift_it_is_the_pendulum_of_jacobi(start):
    """Two independent formulas."""
    theta, omega = map(exact, start)
    hoop, pendulum = Hoop(Fraction(9), Fraction(0), theta, omega), Pendulum(Fraction(9), Fraction(1), theta, omega)
    for t in ("0.7", 100):
        with mpmath.workdps(60):
            pairs = zip(hoop.state(t, 50), pendulum.state(t, 50), strict=True)
            assert max(abs(a - b) for a, b in pairs) < mpf("1e-46")


def test_the_homoclinic_motion_in_closed_form():
    """At E = -A the motion is cos^2(theta/2) = ...: from the widest angle acos(2A/B - 1) to the bottom, u as a sech."""
    pull, lift = Fraction(1), Fraction(4)
    with mpmath.workdps(60):
        widest = mpmath.acos(mpf(2) * 1 / 4 - 1)
        # tan(theta/2) = sqrt(B/A - 1) sech(sqrt(B - A) t)
        start = exact(widest)
        hoop = Hoop(pull, lift, start, Fraction(0))
        for t in (mpf(1), mpf(3)):
            expected = 2 * mpmath.atan(mpmath.sqrt(3) / mpmath.cosh(mpmath.sqrt(3) * t))
            # The start is right to 1e-60 and errors grow by e^(2 sqrt(3) 3) = 3e4.
            assert abs(hoop.state(exact(t), 50)[0] - expected) < mpf("1e-49")


def test_derived_quantities():
    tilted = Hoop(Fraction(9), Fraction(16), Fraction("0.98"), Fraction(0))
    assert float(mpmath.cos(tilted.tilted_equilibrium())) == pytest.approx(9 / 16, rel=1e-14)
    # Near the tilted equilibrium (0.9733) the period is the period of small swings, to the square of the amplitude.
    assert float(tilted.period() * tilted.small_frequency()) == pytest.approx(2 * mpmath.pi, rel=1e-3)
    assert Hoop(Fraction(9), Fraction(9), Fraction(1), Fraction(0)).small_frequency() is None
