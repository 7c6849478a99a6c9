from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate
from gnomon.reference.rigid_bodies.sliding_rods import FallingRod, SlidingLadder
from mpmath import mpf

G = Fraction("9.81")
STARTS = {"from rest": ("0.5", 0), "upright": ("1e-9", 0), "pushed": (0, 1), "fast": ("0.3", 2)}


def on_wall(t, state):
    return state[1], ball(G * 3 / 2) * state[0].sin()


def on_floor(t, state):
    """From Lagrange's function with the centre at height cos(theta)/2: moment 1/12 about it, mass 1, length 1."""
    theta, omega = state
    s, c, g = theta.sin(), theta.cos(), ball(G)
    return omega, (g * s / 2 - s * c * omega * omega / 4) / (s * s / 4 + ball(Fraction(1, 12)))


def difference(found, state):
    with mpmath.workdps(70):
        return max(abs(a - mpf(b.numerator) / b.denominator) for a, b in zip(found, state, strict=True))


@pytest.mark.parametrize("start", STARTS)
def test_the_rod_leaves_the_wall_and_falls_as_integrated(start):
    rod = SlidingLadder(G, Fraction(1), *map(exact, STARTS[start]))
    leaves, lies = (exact(rod.leaving_time(60)), exact(rod.floor_time(60)))
    (gone,) = integrate(on_wall, (rod.theta, rod.omega), (leaves,), 65)
    # From 1e-9 off the vertical, errors grow by 1e9.
    assert difference(rod.leaving_state(50), gone) < mpf("1e-47")
    (falling,) = integrate(on_floor, gone, ((lies - leaves) / 2,), 60)
    assert difference(rod.state((leaves + lies) / 2, 50), falling) < mpf("1e-47")
    assert difference(rod.state(2 * lies, 50), (exact(rod.flat_angle(60)), Fraction(0))) < mpf("1e-49")


@pytest.mark.parametrize("start", ["0.5", "1e-9", "1.5"])
def test_the_rod_falls_as_integrated(start):
    rod = FallingRod(G, Fraction(1), exact(start))
    lies = exact(rod.floor_time(60))
    half, end = integrate(on_floor, (rod.theta, Fraction(0)), (lies / 2, lies), 65)
    assert difference(rod.state(lies / 2, 50), half) < mpf("1e-47")
    assert difference((rod.flat_angle(50), rod.floor_rate(50)), end) < mpf("1e-47")


def test_the_rod_leaves_the_wall_at_two_thirds_of_the_height():
    angle, rate = SlidingLadder(G, Fraction(1), Fraction(1, 2), Fraction(0)).leaving_state(40)
    with mpmath.workdps(45):
        assert abs(mpmath.cos(angle) - 2 * mpmath.cos(mpf(1) / 2) / 3) < mpf("1e-39")
        assert abs(rate**2 - mpf("9.81") * mpmath.cos(mpf(1) / 2)) < mpf("1e-37")


def test_a_start_at_rest_and_exactly_upright_is_an_equilibrium():
    assert SlidingLadder(G, Fraction(1), Fraction(0), Fraction(0)).state(10**6) == (0, 0)
    assert FallingRod(G, Fraction(1), Fraction(0)).state(10**6) == (0, 0)
