"""Slider-crank and four-bar linkage, each a second time: quadrature by the energy, a pendulum, elimination of multipliers."""

import random
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import pytest
from gnomon.cases import get
from gnomon.cases.core.elimination import index_one, product, rows_of
from gnomon.cases.mechanisms import four_bar_linkage, slider_crank
from gnomon.reference.pendulums.pendulum_simple import Pendulum

TIME, DIGITS = Fraction(2, 5), 25
"""Within the first turn of both cranks, which begin upright."""
Kinetics = Callable[[Any], tuple[Any, Any]]


def time_of_turn(crank: Kinetics, end: Any, rate: Any) -> tuple[Any, Any]:
    """The time in which the crank turns from upright to `end` and its rate there, by the conservation of energy.

    crank(angle) -> its moment of inertia, with all that moves along, and the potential energy.
    """
    inertia, height = crank(mpmath.pi / 2)
    total = inertia * rate * rate / 2 + height

    def pace(angle: Any) -> Any:
        moment, potential = crank(angle)
        return mpmath.sqrt(2 * (total - potential) / moment)

    return mpmath.quad(lambda angle: 1 / pace(angle), mpmath.linspace(mpmath.pi / 2, end, 9)), pace(end)


def at_the_time(name: str) -> tuple[list[Any], Any, Any]:
    """The exact state, the angle of the crank in its first turn, and the parameters."""
    case = get(name)
    state = list(case.exact_motion.state(TIME, 30))
    angle = mpmath.pi / 2 + mpmath.atan2(-state[0], state[1]) % (2 * mpmath.pi)
    return state, angle, [mpmath.mpf(x.numerator) / x.denominator for x in case.parameter_values()]


def near(found: Any, expected: Any) -> bool:
    return abs(found - expected) < mpmath.mpf(10) ** -DIGITS * (1 + abs(expected))


def test_slider_crank_takes_the_time_that_its_energy_allows() -> None:
    with mpmath.workdps(DIGITS + 10):
        (x, y, s, vx, vy, _vs), end, (m1, m2, m3, g) = at_the_time("slider_crank")
        r, square = mpmath.mpf("0.5"), mpmath.mpf("1.69")

        def crank(angle: Any) -> tuple[Any, Any]:
            up, right = r * mpmath.sin(angle), r * mpmath.cos(angle)
            slid = -up - up * right / mpmath.sqrt(square - up * up)
            inertia = (m1 * r * r + m2 * (r * r - up * slid + slid * slid)) / 3 + m3 * slid * slid
            return inertia, (m1 + m2) * g * up / 2

        elapsed, rate = time_of_turn(crank, end, mpmath.mpf(6))
        assert near(elapsed, mpmath.mpf(2) / 5)
        assert near(x * vy - y * vx, r * r * rate)
        assert near(s, x + mpmath.sqrt(square - y * y))


def test_four_bar_linkage_takes_the_time_that_its_energy_allows() -> None:
    """The rocker's end is where two circles meet; its velocity follows from the coupler's length."""
    with mpmath.workdps(DIGITS + 10):
        (xa, ya, xb, yb, vxa, vya, _vxb, _vyb), end, (m1, m2, m3, d, g) = at_the_time("four_bar_linkage")
        a, b2, c2 = mpmath.mpf("0.3"), mpmath.mpf("1.36"), mpmath.mpf("0.81")

        def joint(angle: Any) -> tuple[Any, Any]:
            along, across = d - a * mpmath.cos(angle), -a * mpmath.sin(angle)
            apart = along * along + across * across
            share = (apart + b2 - c2) / (2 * apart)
            rise = mpmath.sqrt(b2 / apart - share * share)
            return d - (1 - share) * along - rise * across, rise * along - (1 - share) * across

        def crank(angle: Any) -> tuple[Any, Any]:
            (px, py), (qx, qy) = (a * mpmath.cos(angle), a * mpmath.sin(angle)), joint(angle)
            x, y = qx - px, qy - py
            ratio = (y * px - x * py) / (y * (qx - d) - x * qy)  # rates of rocker and crank
            ux, uy, wx, wy = -py, px, -qy * ratio, (qx - d) * ratio
            coupler = ux * ux + uy * uy + ux * wx + uy * wy + wx * wx + wy * wy
            inertia = (m1 * a * a + m2 * coupler + m3 * (wx * wx + wy * wy)) / 3
            return inertia, g * ((m1 + m2) * py + (m2 + m3) * qy) / 2

        elapsed, rate = time_of_turn(crank, end, mpmath.mpf(10))
        assert near(elapsed, mpmath.mpf(2) / 5)
        assert near(xa * vya - ya * vxa, a * a * rate)
        assert all(near(found, expected) for found, expected in zip((xb, yb), joint(end), strict=True))


def test_a_parallelogram_swings_as_a_compound_pendulum() -> None:
    """Its coupler stays level: I = (m1 + m3) a^2/3 + m2 a^2, moment of weight g a (m1/2 + m2 + m3/2)."""
    case = get("four_bar_linkage", "parallelogram")
    pendulum = Pendulum(case.parameters["g"], Fraction(4, 9), Fraction(0), Fraction(6))
    with mpmath.workdps(30):
        for time in (Fraction(3, 10), Fraction(1)):
            xa, ya, xb, yb, *_ = case.exact_motion.state(time, 30)
            theta, _ = pendulum.state(time, 30)
            x, y = mpmath.sin(theta) / 2, -mpmath.cos(theta) / 2
            assert all(
                near(found, expected) for found, expected in zip((xa, ya, xb, yb), (x, y, 1 + x, y), strict=True)
            )


@pytest.mark.parametrize(("module", "count"), [(slider_crank, 3), (four_bar_linkage, 4)])
def test_equations_are_those_of_the_form(module: Any, count: int) -> None:
    """In rational numbers: masses, forces and gradients of the form, its multipliers eliminated by linear equations."""
    form, chance = module.FORM, random.Random(7)

    def bend(t: Any, state: Any, parameters: Any) -> tuple[Any, ...]:
        """The gradients are linear in the place, so that differences are derivatives."""
        place, velocity = state[:count], state[count:]
        ahead = form.gradient(t, tuple(q + v for q, v in zip(place, velocity, strict=True)), parameters)
        here = form.gradient(t, place, parameters)
        change = tuple(a - b for a, b in zip(ahead, here, strict=True))
        return tuple(product(row, velocity) for row in rows_of(change, count))

    eliminated = index_one(force=form.force, gradient=form.gradient, curvature=bend, mass=form.mass)
    for _ in range(5):
        state = tuple(Fraction(chance.randint(1, 99), 10) for _ in range(2 * count))
        parameters = tuple(Fraction(chance.randint(1, 99), 10) for _ in range(count + 1))
        assert form.equations(0, state, parameters) == eliminated(0, state, parameters)


@pytest.mark.parametrize(
    ("name", "start", "reason"),
    [
        ("slider_crank", (0, 1, 1, -3, 0, -2), "velocities keep both lengths"),
        ("slider_crank", (1, 1, 2, 1, -1, 0), "different lengths"),
        ("four_bar_linkage", (0, "0.3", 1, "0.3", -3, 0, -3, 0), "come to lie flat"),
        ("four_bar_linkage", (0, "0.3", 1, "0.9", -3, 0, -2, 0), "velocities keep the three lengths"),
    ],
)
def test_starts_off_the_constraints_or_that_lie_flat_are_refused(name: str, start: Any, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        get(name, initial_state=start)
