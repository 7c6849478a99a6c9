"""The projectile in parabolic coordinates: in x and y it is the parabola, and the roots are continuous."""

from fractions import Fraction
from itertools import pairwise

import pytest
from gnomon.reference.flight.projectile_parabolic_coordinates import ParabolicProjectile
from gnomon.reference.numerics.precision import exact, working

STARTS = {
    "below": ("9.81", -2, 3, "1.5", "0.5"),
    "below, from the line": (10, 2, 0, 0, -1),
    "above": (8, -1, 1, "2.000001", "1e-6"),
    "above, other sheet": (8, 1, -1, -2, "-0.3"),
    "beside": (5, 1, 2, 1, -2),  # straight up and down at x = 2
    "no gravity": (0, 1, 2, 3, -1),
}


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
def test_squares_give_the_parabola_and_signs_change_only_at_zero(start: tuple[object, ...]) -> None:
    motion = ParabolicProjectile(*map(exact, start))
    flight = motion.projectile()
    times = [Fraction(k, 64) for k in range(-100, 200)]
    with working(50) as mp:
        states = [[mp.mpf(x) for x in motion.state(t, 45)] for t in times]
        for t, (xi, eta, u, v) in zip(times, states, strict=True):
            x, y, vx, vy = (mp.mpf(value) for value in flight.rational(t))
            found = (xi * eta, (eta**2 - xi**2) / 2, u * eta + xi * v, eta * v - xi * u)
            size = xi**2 + eta**2 + abs(u * eta) + abs(xi * u) + 1
            assert max(abs(a - b) for a, b in zip(found, (x, y, vx, vy), strict=True)) < size * mp.mpf(10) ** -43
        # Of the two signs of the root, the one closer to the previous value is the continuation: all steps are small.
        for (a, b, *_), (c, d, *_) in pairwise(states):
            assert (a - c) ** 2 + (b - d) ** 2 <= (a + c) ** 2 + (b + d) ** 2


def test_a_confocal_path_has_one_constant_coordinate() -> None:
    motion = ParabolicProjectile(*map(Fraction, (4, 0, 1, 2, 0)))
    assert [float(x) for x in motion.state(3)] == [6.0, 1.0, 2.0, 0.0]
