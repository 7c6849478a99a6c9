"""The pendulum's exact motion, by the equation, by a Taylor integration, by its invariants and limits."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.pendulums.pendulum_simple import Pendulum


def pendulum(g, length, theta, omega):
    return Pendulum(*(exact(x) for x in (g, length, theta, omega)))


def equations(motion):
    ratio = motion.g / motion.length

    def rates(arithmetic, state):
        theta, omega = state
        return omega, -arithmetic.mpf(ratio) * arithmetic.sin(theta)

    return rates


MOTIONS = {
    "swing": (pendulum("9.81", 1, 2.5, 0), 10),
    "swing with a push": (pendulum(9.81, "0.7", -1, "2.25"), 10),
    "a turn further on": (pendulum(1, 1, 7.5, 0.1), 20),
    "small": (pendulum(9.81, 1, 1e-8, 1e-9), 10),
    "rotation": (pendulum(9.81, 1, 0.5, 7), 10),
    "rotation backwards": (pendulum(9.81, 1, 100.5, -8.5), 10),
    "separatrix": (pendulum(9.81, 9.81, 0, 2), 9),
    "separatrix backwards": (pendulum(9.81, 9.81, 0, -2), 9),
    "just below the separatrix": (pendulum(9.81, 9.81, 0, "1.999999999999"), 100),
    "just above the separatrix": (pendulum(9.81, 9.81, 0, "2.000000000001"), 100),
    "1e-40 above the separatrix": (pendulum(Fraction(1, 3), Fraction(1, 3), 0, 2 + Fraction(1, 10**40)), 150),
    "upright": (pendulum(9.81, 1, "3.141592653588793", 0), 17),
    "upright, 40 digits": (pendulum(9.81, 1, "3.1415926535897932384626433832795028841971", 0), 40),
}
CASES = [pytest.param(motion, t, id=name) for name, (motion, t) in MOTIONS.items()]


@pytest.mark.parametrize(("motion", "t"), CASES)
@pytest.mark.parametrize("share", [Fraction(1, 7), Fraction(5, 8), Fraction(1)])
def test_equation_of_motion_is_satisfied(motion, t, share, residual):
    assert residual(motion, equations(motion), t * share) < mpmath.mpf(10) ** -50


@pytest.mark.parametrize(("motion", "t"), CASES)
def test_start_is_the_given_one(motion, t):
    start = motion.state(0, 50)
    with mpmath.workdps(70):
        for found, given in zip(start, (motion.theta0, motion.omega0), strict=True):
            assert abs(found - mpmath.mpf(given.numerator) / given.denominator) < mpmath.mpf(10) ** -48


@pytest.mark.parametrize(("motion", "t"), CASES)
def test_taylor_integration_arrives_at_the_same_state(motion, t, taylor):
    """Errors of the integration (1e-60) grow at most like e^(2 w t): 1e-47 next to the separatrix."""
    time = min(Fraction(t), Fraction(15))
    with mpmath.workdps(70):
        there = taylor(equations(motion), (motion.theta0, motion.omega0), time)
        for found, right in zip(motion.state(time, 50), there, strict=True):
            assert abs(found - right) < mpmath.mpf(10) ** -46


@pytest.mark.parametrize(("motion", "t"), CASES)
def test_fifty_digits_agree_with_a_hundred(motion, t):
    period = motion.period(40)
    far = exact(t) if mpmath.isinf(period) else exact(period) * Fraction("10000.37")
    for time in (exact(t), far):
        with mpmath.workdps(110):
            for short, long in zip(motion.state(time, 50), motion.state(time, 100), strict=True):
                assert abs(short - long) <= abs(long) * mpmath.mpf(10) ** -48 + mpmath.mpf(10) ** -50


@pytest.mark.parametrize("motion", [motion for motion, _ in MOTIONS.values() if motion.regime != Pendulum.SEPARATRIX])
def test_state_returns_after_a_period(motion):
    period = motion.period(120)
    with mpmath.workdps(130):
        turn = 2 * mpmath.pi * mpmath.sign(motion.omega0) if motion.regime == Pendulum.ROTATION else 0
        later = motion.state(period, 50)
        assert abs(later[0] - turn - motion.state(0, 50)[0]) < mpmath.mpf(10) ** -46
        assert abs(later[1] - motion.state(0, 50)[1]) < mpmath.mpf(10) ** -48


@pytest.mark.parametrize(
    ("motion", "regime"),
    [
        (pendulum(9.81, 9.81, 0, 2), Pendulum.SEPARATRIX),
        (pendulum("9.81", "9.81", 0, "-2"), Pendulum.SEPARATRIX),
        (pendulum(9.81, 9.81, 0, 2.0000000000000004), Pendulum.ROTATION),
        (pendulum(9.81, 9.81, 0, 1.9999999999999998), Pendulum.LIBRATION),
        (pendulum(1, 1, 3.141592653589793, 0), Pendulum.LIBRATION),
        (pendulum(1, 1, 3.1415926535897936, 0), Pendulum.LIBRATION),
        (pendulum(1, 1, 0, 0), Pendulum.REST),
    ],
)
def test_regime_is_decided_exactly(motion, regime):
    assert motion.regime == regime


def test_on_the_separatrix_the_top_is_approached_exponentially():
    motion = pendulum(9.81, 9.81, 0, 2)
    theta, omega = motion.state(200, 30)
    with mpmath.workdps(130):
        short = motion.state(200, 120)[0] - mpmath.pi
        assert mpmath.almosteq(-short, 4 * mpmath.exp(-200), rel_eps=mpmath.mpf(10) ** -20)
        assert mpmath.almosteq(omega, 4 * mpmath.exp(-200), rel_eps=mpmath.mpf(10) ** -28)
        assert mpmath.almosteq(theta, mpmath.pi, rel_eps=mpmath.mpf(10) ** -29)


def test_period_of_a_swing_of_a_right_angle():
    """K(1/2) = Gamma(1/4)^2 / (4 sqrt(pi)): amplitude pi/2 up to its rounding, which moves K by 1e-17."""
    period = pendulum(1, 1, 1.5707963267948966, 0).period(30)
    with mpmath.workdps(30):
        assert abs(period - mpmath.gamma(0.25) ** 2 / mpmath.sqrt(mpmath.pi)) < 1e-15


def test_period_exceeds_the_linear_one_by_a_sixteenth_of_the_amplitude_squared():
    """T/T0 = 1 + a^2/16 + 11 a^4/3072 + ..."""
    amplitude = mpmath.mpf("1e-5")
    motion = pendulum(9.81, 1, "1e-5", 0)
    with mpmath.workdps(40):
        excess = motion.period(40) / motion.small_swing_period(40) - 1
        a = mpmath.mpf("1e-5")
        assert abs(excess - a**2 / 16 - 11 * a**4 / 3072) < amplitude**6


def test_rod_pushes_at_the_highest_point_of_a_wide_swing():
    motion = pendulum(9.81, 1, 2.5, 0)
    with mpmath.workdps(25):
        assert mpmath.almosteq(motion.tension_highest(20), mpmath.mpf(9.81) * mpmath.cos(2.5), rel_eps=1e-19)
        bottom = motion.top_speed(20) ** 2 + mpmath.mpf(9.81)
        assert mpmath.almosteq(motion.tension_lowest(20), bottom, rel_eps=1e-18)


def test_the_precision_of_the_caller_does_not_change():
    before = mpmath.mp.dps
    MOTIONS["swing"][0].state(3, 80)
    assert mpmath.mp.dps == before
