"""Impacts against their laws: momentum, the ratio of normal speeds, and results of the textbook."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.contact.impacts import BallLine, DiscImpact
from mpmath import mpf


def line(masses, e, places, velocities):
    return BallLine(
        *(tuple(map(Fraction, x)) if isinstance(x, tuple) else Fraction(x) for x in (masses, e, places, velocities))
    )


def test_each_impact_keeps_momentum_and_multiplies_the_relative_speed_by_e():
    motion = line((4, 2, 1), "0.8", (0, 1, 2), (1, 0, 0))
    for before, after in zip(motion.legs, motion.legs[1:], strict=False):
        i = after.pair
        assert sum(m * v for m, v in zip(motion.masses, before.velocities, strict=True)) == 4
        left, right = (leg.velocities[i] - leg.velocities[i + 1] for leg in (before, after))
        assert right == -motion.e * left
        kinetic = [
            sum(m * v * v for m, v in zip(motion.masses, leg.velocities, strict=True)) / 2 for leg in (before, after)
        ]
        assert kinetic[0] - kinetic[1] == motion.energy_lost(motion.legs.index(after))
        assert after.places[i] == after.places[i + 1]


def test_the_last_of_three_balls_is_fastest_if_the_middle_mass_is_the_geometric_mean():
    """v3 = (1 + e)^2 m1 m2 v1/((m1 + m2)(m2 + m3)): highest at m2 = sqrt(m1 m3) = 2."""

    def passed_on(middle):
        return line((4, middle, 1), 1, (0, 1, 2), (1, 0, 0)).legs[2].velocities[2]

    assert passed_on(2) == 4 * Fraction(4 * 2, 6 * 3)
    assert max(map(passed_on, ("1.9", "1.999", 2, "2.001", "2.1"))) == passed_on(2)


def test_in_the_cradle_as_many_balls_leave_as_arrive():
    two = line((1,) * 5, 1, (0, "0.25", 1, "1.5", 2), (1, 1, 0, 0, 0))
    assert two.legs[-1].velocities == (0, 0, 0, 1, 1)
    assert len(two.legs) == 7


def test_three_balls_that_meet_at_the_same_time_are_refused():
    with pytest.raises(ValueError, match="meet at the same time"):
        _ = line((1, 1, 1), 1, (-1, 0, 1), (1, 0, -1)).legs


def disc(e="0.7", m2=2, start=(-2, "0.3", 0, 0), speed=(3, "0.2", "-0.5", "0.1")):
    return DiscImpact(*map(Fraction, (1, m2, "0.5", e)), tuple(map(Fraction, start)), tuple(map(Fraction, speed)))


@pytest.mark.parametrize(
    "motion", [disc(), disc(0), disc(1, 10**9), disc(start=(-2, "0.4999999", 0, 0), speed=(3, 0, 0, 0))]
)
def test_discs_meet_at_the_distance_r_and_part_with_e(motion):
    with mpmath.workdps(40):
        time, before, after = motion.impact(40)
        nx, ny = (before[2] - before[0]) * 2, (before[3] - before[1]) * 2
        assert abs(nx**2 + ny**2 - 1) < mpf("1e-36")
        first = nx * (before[6] - before[4]) + ny * (before[7] - before[5])
        last = nx * (after[6] - after[4]) + ny * (after[7] - after[5])
        assert first < 0
        assert abs(last + mpf(motion.e.numerator) / motion.e.denominator * first) < mpf("1e-36")
        across = [nx * (s[7] - s[5]) - ny * (s[6] - s[4]) for s in (before, after)]
        assert abs(across[0] - across[1]) < mpf("1e-36")
        mass = mpf(motion.m2.numerator)
        for one, two in ((4, 6), (5, 7)):
            assert abs(before[one] + mass * before[two] - after[one] - mass * after[two]) < mpf("1e-28")
        kinetic = [sum(w * v * v for w, v in zip((1, 1, mass, mass), s[4:], strict=True)) / 2 for s in (before, after)]
        lost = mpf(motion.energy_lost.numerator) / motion.energy_lost.denominator
        assert abs(kinetic[0] - kinetic[1] - lost) < mpf("1e-26") * max(kinetic)
        assert motion.state(0, 30)[0] == -2
        assert time > 0


def test_equal_elastic_discs_leave_at_a_right_angle():
    _, _, after = disc(1, 1, speed=(3, 0, 0, 0)).impact(30)
    assert abs(after[4] * after[6] + after[5] * after[7]) < mpf("1e-27")


def test_discs_that_miss_or_move_apart_do_not_touch():
    assert not disc(start=(-2, "0.5", 0, 0), speed=(3, 0, 0, 0)).touches  # grazes at zero normal speed
    assert not disc(speed=(-3, 0, 0, 0)).touches
    assert not disc(speed=(0, 0, 0, 0)).touches


def test_times_just_before_and_after_the_impact_are_distinguished():
    motion = disc()
    time = Fraction(*motion.impact_time(40).as_integer_ratio())
    assert not motion.is_past(time - Fraction(1, 10**30))
    assert motion.is_past(time + Fraction(1, 10**30))
    assert motion.is_past(time + 100)
