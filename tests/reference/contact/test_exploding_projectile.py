"""The burst: momentum, the centre of mass, and the energy that it releases, all in rational numbers."""

from fractions import Fraction

from gnomon.reference.contact.exploding_projectile import Fragments


def made():
    numbers = map(Fraction, ("9.81", 2, 1, "1.3", 6, 15))
    return Fragments(*numbers, (Fraction(0),) * 4, tuple(map(Fraction, (30, 20, 30, 20))))


def test_the_centre_of_mass_stays_on_its_parabola():
    motion = made()
    for t in (Fraction("0.7"), Fraction("1.3"), Fraction(4)):
        x1, y1, x2, y2, vx1, vy1, vx2, vy2 = motion.at(t)
        assert 2 * x1 + x2 == 3 * 30 * t
        assert 2 * y1 + y2 == 3 * (20 * t - motion.g * t**2 / 2)
        assert (2 * vx1 + vx2, 2 * vy1 + vy2) == (90, 3 * (20 - motion.g * t))


def test_the_burst_adds_its_velocity_and_its_energy():
    motion = made()
    before, after = motion.before_the_burst(), motion.at(motion.burst)
    assert before[:4] == after[:4]
    assert (after[6] - after[4], after[7] - after[5]) == (6, 15)

    def kinetic(state):
        return (2 * (state[4] ** 2 + state[5] ** 2) + state[6] ** 2 + state[7] ** 2) / 2

    assert kinetic(after) - kinetic(before) == motion.energy_released == Fraction(2, 3) * (36 + 225) / 2
