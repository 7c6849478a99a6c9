"""The pulse gives its impulse, and the lag behind an instantaneous one; differences give the force."""

from __future__ import annotations

from fractions import Fraction

import pytest
from gnomon.reference.precision import exact
from gnomon.reference.pulse import Pulse


@pytest.mark.parametrize("length", ["0.1", "1e-9"])
def test_impulse_and_lag(length):
    motion = Pulse(*map(exact, (2, 3, "0.7", length, 0, "0.5")))
    x, v = motion.at(Fraction(2))
    assert v == Fraction(1, 2) + Fraction(3, 2)
    instantaneous = Fraction(1) + Fraction(3, 2) * (2 - exact("0.7"))
    assert instantaneous - x == Fraction(3, 4) * exact(length)


def test_second_difference_of_a_quartic_is_the_force():
    """Exact in rational numbers: x(t+h) - 2 x + x(t-h) = h^2 x'' + h^4 x''''/12."""
    motion = Pulse(*map(exact, (2, 3, "0.7", "0.1", 0, "0.5")))
    t, h, T = exact("0.73"), Fraction(1, 1000), exact("0.1")
    s = t - exact("0.7")
    force = 6 * 3 * s * (T - s) / T**3
    fourth = -12 * 3 / T**3 / 2
    second = motion.at(t + h)[0] - 2 * motion.at(t)[0] + motion.at(t - h)[0]
    assert second == h**2 * force / 2 + h**4 * fourth / 12
