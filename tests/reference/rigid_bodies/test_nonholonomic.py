from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate
from gnomon.reference.rigid_bodies.nonholonomic import ChaplyginSleigh, KnifeEdge
from mpmath import mpf


def difference(motion, field, start, t):
    (state,) = integrate(field, tuple(map(exact, start)), (exact(t),), 60)
    with mpmath.workdps(70):
        return max(
            abs(a - mpf(b.numerator) / b.denominator) for a, b in zip(motion.state(exact(t), 50), state, strict=True)
        )


@pytest.mark.parametrize("start", [("-1.5", "0.4", 0), (-1, "1e-12", 0), (0, -20, 1), (-1, 0, 0)])
def test_the_sleigh_moves_as_integrated(start):
    m, inertia, a = Fraction(2), Fraction("0.5"), Fraction("0.3")

    def field(t, state):
        v, w, _ = state
        return ball(a) * w * w, -ball(m * a / (inertia + m * a**2)) * v * w, w

    assert difference(ChaplyginSleigh(m, inertia, a, *map(exact, start)), field, start, 3) < mpf("1e-47")


@pytest.mark.parametrize(
    ("a", "start"),
    [("0.3", ("-1.5", "0.4", 0)), ("0.3", (-1, "1e-12", 2)), ("0.01", (0, -20, 1)), ("0.3", (-1, 0, "0.7"))],
)
def test_the_path_of_the_edge_is_the_integral_of_its_velocity(a, start):
    """A Taylor integration of all five equations; the variable of the path's quadrature is the angle, not the time."""
    m, inertia, arm = Fraction(2), Fraction("0.5"), Fraction(a)

    def field(t, state):
        v, w, theta, _x, _y = state
        return ball(arm) * w * w, -ball(m * arm / (inertia + m * arm**2)) * v * w, w, v * theta.cos(), v * theta.sin()

    sleigh = ChaplyginSleigh(m, inertia, arm, *map(exact, start))
    (state,) = integrate(field, (*map(exact, start), Fraction(0), Fraction(0)), (Fraction(3),), 60)
    with mpmath.workdps(70):
        for a, b in zip(sleigh.path(3, 50), state[3:], strict=True):
            assert abs(a - mpf(b.numerator) / b.denominator) < mpf("1e-46")


def test_the_sleigh_ends_straight_ahead_after_half_a_turn_times_root_q_over_a():
    sleigh = ChaplyginSleigh(Fraction(1), Fraction(3), Fraction(1), Fraction(-1), Fraction(1, 10**20), Fraction(0))
    v, w, theta = sleigh.state(1000, 30)
    assert abs(v - 1) < mpf("1e-25")
    assert abs(w) < mpf("1e-40")
    # The angle at the start differs from the limit by 2e-20.
    assert abs(theta - sleigh.whole_turn(30)) < mpf("1e-18")


@pytest.mark.parametrize(
    ("w", "start"), [("0.7", (0, 0, 0, 0)), ("1e-8", (0, 0, "0.3", 2)), (0, (0, 0, "0.3", 2)), (-3, (1, 2, -4, -1))]
)
def test_the_skate_moves_as_integrated(w, start):
    rate, pull = exact(w), Fraction("1.7")

    def field(t, state):
        _x, _y, th, v = state
        return v * th.cos(), v * th.sin(), ball(rate) + 0 * v, ball(pull) * th.cos()

    assert difference(KnifeEdge(rate, pull, *map(exact, start)), field, start, 7) < mpf("1e-46")


def test_the_skate_drifts_across_not_down():
    skate = KnifeEdge(Fraction(7, 10), Fraction("1.7"), *[Fraction(0)] * 4)
    with mpmath.workdps(50):
        turns = 100 * 2 * mpmath.pi / mpf("0.7")
        x, y, _, _ = skate.state(exact(turns), 40)
        assert abs(x) < mpf("1e-35")
        assert abs(y / turns - skate.drift(40)) < mpf("1e-38")
