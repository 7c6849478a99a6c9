from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.contact.rolling_bodies import RollingBody
from gnomon.reference.numerics.precision import exact
from mpmath import mpf

BODIES = {
    "slips and rolls": (("9.81", "0.4", "0.2", "0.5", "0.1"), (0, 2, 0)),
    "bowled": (("9.81", 0, "0.2", "0.4", "0.1"), (0, 8, 0)),
    "back spin": (("9.81", "0.4", "0.2", "0.4", "0.1"), (0, -3, 60)),
    "too steep": (("9.81", 1, "0.2", "0.5", "0.1"), (0, 0, 40)),
}


def body(name):
    numbers, start = BODIES[name]
    return RollingBody(*map(exact, numbers), *map(exact, start))


@pytest.mark.parametrize("name", BODIES)
def test_newtons_and_eulers_equations_hold_while_slipping_and_rolling(name):
    """m v' + I w'/R = m g sin(alpha) with or without slip; friction obeys Coulomb's law."""
    motion = body(name)
    slip_ends = exact(motion.slip_time(60))
    h = Fraction(1, 10**20)
    for t in (slip_ends / 2, 2 * slip_ends):
        with mpmath.workdps(90):
            g, alpha, mu, k, R = (mpf(x.numerator) / x.denominator for x in map(exact, BODIES[name][0]))
            before, here, after = (motion.state(t + d, 85) for d in (-h, 0, h))
            slopes = [(b - a) * mpf(10) ** 20 / 2 for a, b in zip(before, after, strict=True)]
            # The motion is quadratic between events: central differences are exact but for 85 digits over 1e-20.
            assert abs(slopes[0] - here[1]) < mpf("1e-60")
            assert abs(slopes[1] + k * R * slopes[2] - g * mpmath.sin(alpha)) < mpf("1e-60")
            friction, limit = k * R * slopes[2], mu * g * mpmath.cos(alpha)
            slip = here[1] - R * here[2]
            if abs(slip) < mpf("1e-70"):
                assert abs(friction) <= limit
            else:
                assert abs(friction - mpmath.sign(slip) * limit) < mpf("1e-60")


def test_a_bowled_ball_ends_with_five_sevenths_of_its_speed():
    with mpmath.workdps(50):
        assert abs(body("bowled").slip_state(40)[1] - mpf(40) / 7) < mpf("1e-38")


def test_the_limit_of_rolling_is_decided_between_neighbouring_doubles():
    for mu, rolls in ((0.42279321873816184, True), (0.4227932187381618, False)):
        numbers = map(exact, (9.81, 0.4, mu / 2, 1, "0.1", 0, 0, 0))
        assert RollingBody(*numbers).can_roll is rolls


def test_without_friction_the_rotation_keeps_its_value_exactly():
    """The value may be 0, of which no error is small; and at v = R w the velocity is exactly R w."""
    for w in (0, 3):
        motion = RollingBody(*map(exact, (1, 1, 0, 1, 2, 0, -1, w)))
        assert exact(motion.slip_state(40)[2]) == w
        assert exact(motion.slip_state(40)[1]) == 2 * w
        assert exact(motion.state(exact(motion.slip_time()) * 2, 40)[2]) == w
