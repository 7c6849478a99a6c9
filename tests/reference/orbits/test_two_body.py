"""Two bodies: by the equations of both, by a Taylor integration, and by the digits of the heavy body."""

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.two_body import TwoBody


def two_body(G, m1, m2, *start):
    numbers = tuple(map(exact, start))
    return TwoBody(exact(G), exact(m1), exact(m2), numbers[:4], numbers[4:])


MOTIONS = {
    "bound": two_body(1, 1, "0.5", 0, 0, 1, 0, 0, "-0.25", 0, "0.75"),
    "planet": two_body(1, 1, "1e-9", 0, 0, 1, 0, 0, 0, 0, "1.2"),
    "unbound": two_body(1, 1, "0.5", 0, 0, -10, 1, 0, 0, 2, 0),
    "drifting": two_body(1, 1, "0.5", 0, 0, 1, 0, 10**6, "-0.25", 10**6, "0.75"),
}
CASES = [pytest.param(motion, id=name) for name, motion in MOTIONS.items()]


def rates(motion):
    def function(mp, y):
        x, y_ = y[2] - y[0], y[3] - y[1]
        square = x * x + y_ * y_
        cube = square * (square.sqrt() if hasattr(square, "sqrt") else mp.sqrt(square))
        a, b = (mp.mpf(motion.G * m) / cube for m in (motion.m2, motion.m1))
        return (*y[4:], a * x, a * y_, -b * x, -b * y_)

    return function


@pytest.mark.parametrize("motion", CASES)
def test_equations_of_both_bodies_are_satisfied(motion, residual):
    """Differences over 1e-30 s; relative to speeds up to 1e6."""
    assert residual(motion, rates(motion), "3.7") < mpmath.mpf(10) ** -45


@pytest.mark.parametrize("motion", CASES)
def test_taylor_integration_arrives_at_the_same_state(motion, taylor):
    there = taylor(rates(motion), (*motion.places, *motion.velocities), "2.3")
    with mpmath.workdps(60):
        for found, right in zip(motion.state("2.3", 50), there, strict=True):
            assert abs(found - right) < mpmath.mpf(10) ** -48 * max(1, abs(right))


def test_heavy_body_keeps_its_digits():
    """It moves by 1e-9 of the distance: its motion is the motion of the light body, scaled, to 40 digits."""
    motion = MOTIONS["planet"]
    state = motion.state(5, 50)
    with mpmath.workdps(60):
        total = [motion.m1 * exact(a) + motion.m2 * exact(b) for a, b in zip(state[:2], state[2:4], strict=True)]
        centre = motion.centre(motion.places)[0] + 0
        assert abs(total[0] / (motion.m1 + motion.m2) - centre) < exact("1e-57")
