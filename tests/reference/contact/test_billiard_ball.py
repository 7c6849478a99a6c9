from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.contact.billiard_ball import BilliardBall
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate
from mpmath import mpf

THROWS = {
    "oblique": ("0.03", "0.2", "9.81", 0, 0, 2, "0.5", 20, -30, 10),
    "draw shot": ("0.03", "0.2", "9.81", 0, 0, 1, 0, 0, -150, 0),
    "almost rolling": ("0.03", "0.2", "9.81", 0, 0, 3, "1e-12", 0, 100, 0),
    "ends at rest": ("0.03125", "0.2", "9.81", 0, 0, 1, 0, 0, -80, 0),
}


def thrown(name):
    return BilliardBall(*map(exact, THROWS[name]))


@pytest.mark.parametrize("name", THROWS)
def test_sliding_as_integrated(name):
    """Newton's and Euler's equations with friction against the slip, up to just before its end."""
    motion = thrown(name)

    def field(t, state):
        _x, _y, vx, vy, wx, wy, wz = state
        radius, push = ball(motion.R), ball(motion.mu * motion.g)
        sx, sy = vx - radius * wy, vy + radius * wx
        size = (sx * sx + sy * sy).sqrt()
        dx, dy = -push * sx / size, -push * sy / size
        # The torque of the friction about the centre, (0, 0, -R) x force, over I = 2 R^2/5.
        return vx, vy, dx, dy, radius * dy * 5 / (2 * radius * radius), -radius * dx * 5 / (2 * radius * radius), 0 * wz

    end = exact(motion.rolling_time(40)) * Fraction(3, 4)
    start = (motion.x, motion.y, motion.vx, motion.vy, motion.wx, motion.wy, motion.wz)
    (state,) = integrate(field, start, (end,), 60)
    with mpmath.workdps(60):
        pairs = zip(motion.state(end, 50), state, strict=True)
        # The direction of a slip of 1e-12 has lost 12 of 60 digits.
        assert max(abs(a - mpf(b.numerator) / b.denominator) for a, b in pairs) < mpf("1e-44")


@pytest.mark.parametrize("name", THROWS)
def test_the_slip_ends_and_the_ball_rolls(name):
    motion = thrown(name)
    with mpmath.workdps(60):
        end = motion.rolling_time(55)
        just, later = motion.state(exact(end * (1 - mpf("1e-30"))), 50), motion.state(exact(2 * end), 50)
        radius = mpf(motion.R.numerator) / motion.R.denominator
        for state in (just, later):
            slip = max(abs(state[2] - radius * state[5]), abs(state[3] + radius * state[4]))
            assert slip < mpf("1e-28")
        assert max(abs(a - b) for a, b in zip(just[2:], later[2:], strict=True)) < mpf("1e-25")


def test_energy_lost_is_a_seventh_of_the_slip_squared():
    motion = thrown("oblique")
    with mpmath.workdps(50):
        radius = mpf(motion.R.numerator) / motion.R.denominator

        def energy(state):
            return (state[2] ** 2 + state[3] ** 2) / 2 + radius**2 * sum(w**2 for w in state[4:]) / 5

        lost = energy(motion.state(0, 45)) - energy(motion.state(10, 45))
        assert abs(lost - motion.energy_loss(45)) < mpf("1e-40")


def test_without_friction_nothing_changes():
    motion = BilliardBall(*map(exact, ("0.03", 0, "9.81", 0, 0, 2, "0.5", 20, -30, 10)))
    assert motion.state(100)[2:] == motion.state(0)[2:]
    assert not motion.will_roll
