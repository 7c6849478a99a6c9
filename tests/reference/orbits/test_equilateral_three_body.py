"""Lagrange's triangle: its sides stay equal and move on Kepler orbits, and Newton's equations hold."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.cases.orbits.equilateral_three_body import turning_triangle
from gnomon.reference.orbits.equilateral_three_body import Homographic, keeps_its_shape
from mpmath import mpf

MASSES = (Fraction(1), Fraction(5, 8), Fraction(3, 8))


def triangle(turn="0.40625", growth=0, masses=MASSES):
    numbers = turning_triangle(turn, ("0.5", "0.3125", "0.1875"), growth)
    vectors = [numbers[i : i + 3] for i in range(0, 18, 3)]
    return Homographic(masses, tuple(vectors[:3]), tuple(vectors[3:]))


def attraction(corners, body):
    """Attraction of a body by the other two."""
    found = [mpf(0)] * 3
    for mass, corner in zip(MASSES, corners, strict=True):
        if corner is not corners[body]:
            way = [x - y for x, y in zip(corner, corners[body], strict=True)]
            cube = mpmath.sqrt(sum(x * x for x in way)) ** 3
            found = [f + mpf(mass.numerator) / mass.denominator * x / cube for f, x in zip(found, way, strict=True)]
    return found


@pytest.mark.parametrize("motion", [triangle(), triangle("0.1533203125"), triangle("0.5", "-0.25"), triangle("1", "1")])
@pytest.mark.parametrize("time", ["0.7", "3.3", "-2"])
def test_the_acceleration_is_newtons(motion, time):
    """Second differences of the closed form against the attraction of the other two."""
    t, h = Fraction(time), Fraction(1, 10**15)
    before, here, after = (motion.state(s, 80) for s in (t - h, t, t + h))
    with mpmath.workdps(80):
        corners = [[mpf(x) for x in here[i : i + 3]] for i in (0, 3, 6)]
        pulls = [pull for body in range(3) for pull in attraction(corners, body)]
        step = mpf(h.numerator) / h.denominator
        for a, b, c, pull in zip(before, here, after, pulls, strict=False):
            # The fourth derivative over 12 times h^2 = 1e-30; next to the closest approach it is large.
            assert abs((a - 2 * b + c) / step**2 - pull) < mpf("1e-20")
        for a, c, rate in zip(before, after, here[9:], strict=False):
            assert abs((c - a) / (2 * step) - rate) < mpf("1e-20")


def test_sides_stay_equal_and_lie_between_the_apsides():
    motion = triangle()
    shortest, longest = motion.sides(40)
    with mpmath.workdps(40):
        for time in range(12):
            state = motion.state(Fraction(time, 2), 40)
            corners = [state[i : i + 3] for i in (0, 3, 6)]
            sides = [
                mpmath.sqrt(sum((x - y) ** 2 for x, y in zip(corners[i], corners[j], strict=True)))
                for i, j in ((0, 1), (1, 2), (2, 0))
            ]
            assert max(sides) - min(sides) < mpf("1e-38")
            assert shortest - mpf("1e-38") < sides[0] < longest + mpf("1e-38")
        # The period equals the period of a two-body orbit of the whole mass.
        axis, total = (shortest + longest) / 2, mpf(2)
        assert abs(motion.period(40) - 2 * mpmath.pi * mpmath.sqrt(axis**3 / total)) < mpf("1e-38")
        assert abs(motion.eccentricity(40) - (longest - shortest) / (longest + shortest)) < mpf("1e-38")


def test_a_start_that_is_no_rotating_equilateral_triangle_is_refused():
    good = turning_triangle("0.40625")
    vectors = [good[i : i + 3] for i in range(0, 18, 3)]
    assert keeps_its_shape(vectors[:3], vectors[3:])
    for index in range(18):
        numbers = list(good)
        numbers[index] += Fraction(1, 10**30)
        moved = [tuple(numbers[i : i + 3]) for i in range(0, 18, 3)]
        assert not keeps_its_shape(moved[:3], moved[3:])
        with pytest.raises(ValueError, match="equilateral"):
            Homographic(MASSES, tuple(moved[:3]), tuple(moved[3:]))
    assert not keeps_its_shape(vectors[:3], [(Fraction(0),) * 3] * 3)
