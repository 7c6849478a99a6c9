"""The attraction k/r^5: the circle through the centre in closed form, the instability of the circle about it."""

import math

import mpmath
import numpy as np
from gnomon.cases import get
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
    )  # perturbed outward; its momentum remains close to that of the circle
    path = perturbed.sample(circle.times)
    off = np.hypot(path[:, 0], path[:, 1]) - 1
    expected = 2.0**-30 * np.sinh(math.sqrt(2) * circle.times) / math.sqrt(2)
    assert np.allclose(off, expected, rtol=1e-4, atol=1e-15)
