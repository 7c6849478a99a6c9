"""The ballistic pendulum: the quantities that the impact conserves, and the swing after it."""

from fractions import Fraction

import mpmath
from gnomon.reference.contact.ballistic_pendulum import BallisticPendulum
from mpmath import mpf


def made(u=400, m="0.01"):
    return BallisticPendulum(*map(Fraction, ("9.81", 2, m, "1.99", -10, u)))


def test_angular_momentum_is_kept_and_energy_lost():
    motion = made()
    total = motion.m + motion.M
    assert total * motion.length**2 * motion.rate == motion.m * motion.u * motion.length
    assert motion.m * motion.u**2 - total * (motion.length * motion.rate) ** 2 == 2 * motion.energy_lost
    assert motion.impact_time == Fraction(10, 400)


def test_the_bullets_speed_follows_from_the_rise():
    """u = (m + M)/m sqrt(2 g h), with h = L (1 - cos) of the angle at which the block rests."""
    motion = made()
    angle = motion.swing.amplitude(30)
    state = motion.state(motion.impact_time + Fraction(*(motion.swing.period(40) / 4).as_integer_ratio()), 30)
    assert abs(state[1] - angle) < mpf("1e-14")  # the quarter period is divided in 15 digits
    with mpmath.workdps(30):
        height = 2 * (1 - mpmath.cos(angle))
        assert abs(200 * mpmath.sqrt(2 * mpf("9.81") * height) - 400) < mpf("1e-25")


def test_before_the_impact_the_block_is_at_rest():
    assert made().state("0.0125") == (-5, 0, 400, 0)
    assert made().state("0.025") == (0, 0, 0, 1)
