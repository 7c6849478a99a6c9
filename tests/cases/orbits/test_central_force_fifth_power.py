"""The attraction k/r^5: the circle through the centre in closed form, the instability of the circle about it."""

import math
import random

import mpmath
import numpy as np
import pytest
from gnomon.cases import case_class, get
from gnomon.reference.numerics.certified import Scout
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.central_force_fifth_power import collision_time
from mpmath import mpf

NAME = "central_force_fifth_power"


def test_at_zero_energy_the_orbit_is_a_circle_through_the_centre():
    """r = cos(theta), and h t = theta/2 + sin(2 theta)/4 with h = 1: from r^2 theta' = h."""
    case = get(NAME)
    with mpmath.workdps(40):
        for t in ("0.2", "0.5", "0.77"):
            x, y, vx, vy = case.exact(t, 32)
            assert abs((x - mpf("0.5")) ** 2 + y**2 - mpf("0.25")) < mpf("1e-30")
            theta = mpmath.atan2(y, x)
            assert abs(theta / 2 + mpmath.sin(2 * theta) / 4 - mpf(t)) < mpf("1e-30")
            # the speed is h over the pedal p = r^2 of the circle
            assert abs(vx**2 + vy**2 - 1 / (x**2 + y**2) ** 2) < mpf("1e-26")
    assert math.isclose(float(case.quantities()["collision_time"]), math.pi / 4)


def test_a_circle_about_the_centre_stays_and_errors_grow():
    """delta'' = 2 delta at constant angular momentum: errors grow as e^(sqrt(2) t)."""
    circle = get(NAME, "circle")
    found = circle.sample(circle.times)
    assert np.max(np.abs(np.hypot(found[:, 0], found[:, 1]) - 1)) < 3e-16
    perturbed = circle.with_numbers(
        (1, 0, 2.0**-30, 1), circle.parameters
    )  # perturbed outward; its momentum remains close to the momentum of the circle
    path = perturbed.sample(circle.times)
    off = np.hypot(path[:, 0], path[:, 1]) - 1
    expected = 2.0**-30 * np.sinh(math.sqrt(2) * circle.times) / math.sqrt(2)
    assert np.allclose(off, expected, rtol=1e-4, atol=1e-15)


@pytest.mark.parametrize(
    ("k", "start", "span", "time"),
    [
        (1, (1, 0, "-0.125", "0.75"), 1, "0.9444251337"),
        (2, (1, 0, 0, 0), 1, "0.5990701174"),  # from rest: the integral of r^2/sqrt(1 - r^4) is lemniscatic
        (2, (1, 0, 0, 1), "0.785398", "0.7853981634"),  # later than 1 - 2^-19 of the fall
    ],
)
def test_a_span_that_reaches_the_centre_is_refused_with_the_time_of_the_fall(k, start, span, time):
    with pytest.raises(ValueError, match=f"^{NAME}: .*k = {k}.*span = {span} s.* falls into the centre at {time}"):
        get(NAME, initial_state=start, k=k, span=span)


def test_what_falls_is_at_the_centre_then_and_what_does_not_goes_on():
    """Next to the centre T - t = sqrt(2/k) (r^3/3 + h^2 r^5/(5 k)), by energy; a fall that was not foreseen would end the integration."""
    chance, fell = random.Random(7), 0
    for _ in range(10):
        x, y, vx, vy = case_class(NAME).domain.draw(("x", "y", "vx", "vy"), chance.random).values()
        k = chance.uniform(0.5, 2) * (x * x + y * y) ** 2 * (vx * vx + vy * vy)  # about the k of a circle
        case = get(NAME, initial_state=(x, y, vx, vy), k=k)
        end = collision_time(case.parameters["k"], case.initial_state, 30)
        if end is None:
            Scout(case.motion().rates, case.initial_state, False).reach(exact(20 * case.time_scale))
            continue
        fell += 1
        assert end > 1.05 * float(case.span)
        left = end / 10**4
        x, y, _, _ = case.with_span(exact(end - left)).exact(exact(end - left))
        square, spin = x * x + y * y, case.initial_state[0] * vy - case.initial_state[1] * vx
        expected = mpmath.sqrt(2 / k) * square**1.5 / 3 * (1 + 0.6 * float(spin) ** 2 * square / k)
        assert abs(left / expected - 1) < 2e-3
    assert 3 <= fell <= 7
