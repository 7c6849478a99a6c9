"""The damped pendulum against Taylor integrations between its rests, its first integral and small-drag theory."""

import itertools
from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate
from gnomon.reference.pendulums.pendulum_quadratic_damping import DampedPendulum
from mpmath import mpf

W2 = Fraction(4)


@pytest.mark.parametrize(
    ("c", "theta", "v", "turns"),
    [
        ("0.1", 1, 0, 0),
        ("0.1", 0, 9, 2),
        ("0.1", 0, -30, -4),
        ("1e-10", -1, 1, 0),
        ("2", -1, "0.5", 0),
        ("0.1", 7, 0, 0),
    ],
)
def test_it_moves_as_integrated_until_it_rests(c, theta, v, turns):
    drag, start = exact(c), (exact(theta), exact(v))
    motion = DampedPendulum(W2, drag, *start)
    assert motion.turns == turns
    side = 1 if motion.forward else -1

    def field(t, state):
        angle, rate = state
        return rate, -ball(W2) * angle.sin() - side * ball(drag) * rate * rate

    rest, angle = motion.turning_point(1, 60)
    times = (exact(rest) / 3, exact(rest))
    found = integrate(field, start, times, 60)
    with mpmath.workdps(60):
        for time, state in zip(times, found, strict=True):
            for a, b in zip(motion.state(time, 55), state, strict=True):
                # the integration's 60 digits count from speeds of up to 30, along paths of up to 30 rad
                assert abs(a - mpf(b.numerator) / b.denominator) < mpf("1e-48")
        assert abs(angle - mpf(found[1][0].numerator) / found[1][0].denominator) < mpf("1e-48")


def test_the_first_integral_holds_on_the_way_back():
    """(v^2 - A (cos + 2 c sin)) e^(-2 c theta) while v < 0."""
    motion, c = DampedPendulum(W2, Fraction(1, 8), Fraction(-2), Fraction(0)), mpf(1) / 8
    first, _ = motion.turning_point(1, 40)
    second, _ = motion.turning_point(2, 40)
    with mpmath.workdps(40):
        kept = []
        for share in (mpf("0.1"), mpf("0.5"), mpf("0.95")):
            theta, v = motion.state(exact(first + share * (second - first)), 40)
            assert v < 0
            size = 2 * 4 / (1 + 4 * c * c)
            kept.append((v * v - size * (mpmath.cos(theta) + 2 * c * mpmath.sin(theta))) * mpmath.exp(-2 * c * theta))
        assert max(kept) - min(kept) < mpf("1e-36")


def test_a_small_half_swing_loses_four_thirds_of_c_a_squared():
    """To first order in c and second order in the amplitude a; the next term is of size c^2 a^3."""
    motion = DampedPendulum(W2, Fraction(1, 100), Fraction(1, 100), Fraction(0))
    _, first = motion.turning_point(1, 30)
    loss = mpf("0.01") + first
    assert abs(loss / (mpf(4) / 3 * mpf("0.01") ** 3) - 1) < mpf("3e-4")


def test_turning_points_stay_narrow_balls_over_many_swings():
    """They would widen at each swing if each were computed from the ball of the previous one."""
    motion = DampedPendulum(Fraction(1), Fraction(1, 5), Fraction(1), Fraction(0))
    times = [motion.turning_point(n, 20)[0] for n in range(1, 25)]
    gaps = [b - a for a, b in itertools.pairwise(times)]
    # half swings get smaller, and so nearer to pi, from above
    assert all(a > b > mpmath.pi for a, b in itertools.pairwise(gaps))


def test_a_rest_next_to_the_top_swings_back():
    """Thrown with 1e-60 less kinetic energy than the top needs: few bits cannot separate the rest from the top."""
    c = mpf(1) / 8
    with mpmath.workdps(80):
        speed = mpmath.sqrt(8 / (1 + 4 * c * c) * (1 + mpmath.exp(2 * c * mpmath.pi)) * (1 - mpf("1e-60")))
        motion = DampedPendulum(W2, Fraction(1, 8), Fraction(0), exact(speed))
        u = -motion.turning_point(2)[1]
        # as if released at the top: cos u - 2 c sin u + e^(-2 c (u + pi)) vanishes at the next rest
        assert abs(mpmath.cos(u) - 2 * c * mpmath.sin(u) + mpmath.exp(-2 * c * (u + mpmath.pi))) < mpf("1e-14")
        assert 0 < mpmath.pi - motion.turning_point(1, 40)[1] < mpf("1e-29")
