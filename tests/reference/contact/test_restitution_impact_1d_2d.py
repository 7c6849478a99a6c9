"""Two blocks and a wall: the unfolded line against impacts followed one by one in rational numbers."""

import math
from fractions import Fraction

import pytest
from gnomon.reference.contact.restitution_impact_1d_2d import TwoBlocks


def made(ratio):
    return TwoBlocks(*map(Fraction, (1, ratio, 1, 2, 0, -1)))


def followed(motion):
    """(time, name, x1, x2, v1, v2) after each impact, from one to the next."""
    m1, m2, x1, x2, v1, v2 = motion.m1, motion.m2, motion.x1, motion.x2, motion.v1, motion.v2
    time = Fraction(0)
    while True:
        meet = (x2 - x1) / (v1 - v2) if v1 > v2 and x2 > x1 else None
        hit = -x1 / v1 if v1 < 0 and x1 > 0 else None
        if meet is None and hit is None:
            return
        step = min(s for s in (meet, hit) if s is not None)
        time, x1, x2 = time + step, x1 + v1 * step, x2 + v2 * step
        if step == hit:
            name, v1 = "wall", -v1
        else:
            name, mean = "blocks", (m1 * v1 + m2 * v2) / (m1 + m2)
            v1, v2 = 2 * mean - v1, 2 * mean - v2
        yield time, name, x1, x2, v1, v2


STARTS = [
    (1, 100, 1, 2, 0, -1),
    (1, 1, 1, 2, 0, -1),
    (1, 3, 1, 2, 0, -1),
    (1, 1, 1, 3, -2, -1),
    ("0.7", "23.4", "0.6", "1.7", "-0.9", "-1.3"),
    (2, "0.5", 1, "1.1", "0.3", "-0.8"),
    (1, 3, 1, 3, -1, -2),
    (1, 5, 1, 2, 1, 3),
]


@pytest.mark.parametrize("numbers", STARTS)
def test_the_unfolded_line_has_the_same_impacts(numbers):
    motion = TwoBlocks(*map(Fraction, numbers))
    expected = list(followed(motion))
    assert motion.impacts == len(expected)
    for n, (time, name, x1, x2, v1, v2) in enumerate(expected, start=1):
        impact = motion.impact(n, 40)
        assert impact.name == name
        for found, true in zip((impact.time, *impact.places, *impact.after), (time, x1, x2, v1, v2), strict=True):
            assert abs(Fraction(*found.as_integer_ratio()) - true) < Fraction(1, 10**37)
        # exactly at the time of the impact, a rational number, the state is that after it
        state = motion.state(time, 40)
        assert motion.passed(time) == n
        assert motion.passed(time - Fraction(1, 10**100)) == n - 1
        for found, true in zip(state, (x1, x2, v1, v2), strict=True):
            assert abs(Fraction(*found.as_integer_ratio()) - true) < Fraction(1, 10**37)


@pytest.mark.parametrize(
    ("ratio", "count"),
    [(1, 3), (3, 5), (100, 31), (10**4, 314), (10**6, 3141), (10**8, 31415), (10**10, 314159)],
)
def test_the_number_of_impacts_is_that_of_galperin(ratio, count):
    """ceil(pi/atan(sqrt(m1/m2))) - 1; for equal masses and 1 to 3 the last ray is parallel to the line."""
    assert made(ratio).impacts == count
    assert count == math.ceil(math.pi / math.atan(math.sqrt(1 / ratio)) - 1e-9) - 1


def test_after_the_last_impact_they_separate():
    motion = made(10**6)
    last = motion.impact(3141, 30)
    assert 0 <= last.after[0] <= last.after[1]
    assert abs(last.after[0] ** 2 + 10**6 * last.after[1] ** 2 - 10**6) < 1e-20
    assert last.time < motion.impact_time(3141, 30) + 1


def test_state_between_and_at_an_impact():
    motion = made(1)
    assert [float(x) for x in motion.state("0.5")] == pytest.approx([1, 1.5, 0, -1], abs=1e-14)
    assert [float(x) for x in motion.state(1)] == pytest.approx([1, 1, -1, 0], abs=1e-14)
    assert [float(x) for x in motion.state(5)] == pytest.approx([1, 3, 0, 1], abs=1e-14)
