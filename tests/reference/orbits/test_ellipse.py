"""Fast sampling of an ellipse against high precision, value by value."""

import math
from fractions import Fraction

import numpy as np
import pytest
from gnomon.reference.orbits import ellipse
from gnomon.reference.orbits.kepler_orbit import Kepler


def orbit(mu, x, y, vx, vy):
    return Kepler(*map(Fraction, (mu, x, y, vx, vy)))


ORBITS = {
    "e=0.6": (orbit(1, 0.4, 0, 0, 2), 65.0),
    "turned, clockwise": (orbit(1.3, -0.7, 0.45, -0.4, -0.9), -40.0),
    "circle": (orbit(4, 4, 0, 0, 1), 100.0),
    "nearly a circle": (orbit(4, 4, 0, 1e-9, 1), 100.0),
    "e=0.999999": (orbit(1, 1e-6, 0, 0, math.sqrt(1.999999e6)), 65.0),
    "e=0.999999, turned": (orbit(1, 1.2, 1.6, -1e-4, 7e-4), 65.0),
    "fall from rest": (orbit(1, 1, 0.5, 0, 0), 1.3),
    "thrown up": (orbit(1, 1, 0, 1, 0), 4.9),
    "nearly a parabola": (orbit(2, 1, 0, 0, 2 * (1 - 1e-12)), 100.0),
    "1e6 periods": (orbit(1, 0.4, 0, 0, 2), 6283192.0),
}


@pytest.mark.parametrize("name", ORBITS)
def test_every_value_is_the_nearest_double(name):
    motion, end = ORBITS[name]
    times = np.concatenate([end * np.random.default_rng(7).uniform(0, 1, 300), [0.0, end]])
    np.testing.assert_array_equal(ellipse.sample(motion, times), motion.sample_each(times))


def test_times_at_and_around_the_pericentre():
    motion, _ = ORBITS["e=0.999999"]
    period = float(motion.period())
    times = 3 * period + np.concatenate([np.linspace(-1e-8, 1e-8, 101), [0.0]])
    np.testing.assert_array_equal(ellipse.sample(motion, times), motion.sample_each(times))


def test_most_values_need_no_high_precision(monkeypatch):
    """The share of unproved values is 2**-98 over 2**-53, times the slope of Kepler's equation: at most 1e-3 here."""
    slow = []
    monkeypatch.setattr(Kepler, "sample_each", lambda _, times: slow.extend(times) or np.zeros((len(times), 4)))
    for name in ("e=0.6", "turned, clockwise", "e=0.999999", "thrown up"):
        motion, end = ORBITS[name]
        ellipse.sample(motion, np.linspace(end / 7e4, end, 20000))
    assert len(slow) < 80


def test_times_beyond_the_collision_are_refused():
    motion, end = ORBITS["fall from rest"]
    with pytest.raises(ValueError, match="not before the collision"):
        motion.sample(np.linspace(0, 2 * end, 1000))
