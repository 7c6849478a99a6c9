"""The chain through a quarter circle: Taylor integrations of each stage, the energy, the sharp edge as a limit."""

import mpmath
import pytest
from gnomon.reference.guided.chain_quarter_circle import ChainQuarter
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate
from mpmath import mpf


def made(*numbers):
    return ChainQuarter(*map(exact, numbers))


def energy(motion, s, v):
    """Energy per unit mass and length: the drop of each element, integrated along the chain."""
    g, length, radius = (mpf(x.numerator) / x.denominator for x in (motion.g, motion.length, motion.radius))
    quarter = mpmath.pi * radius / 2

    def dropped(x):
        """The integral of the drop up to x."""
        if x < 0:
            return mpf(0)
        on = min(x, quarter)
        below = max(x - quarter, mpf(0))
        return radius * (on - radius * mpmath.sin(on / radius)) + radius * below + below**2 / 2

    return length * v**2 / 2 - g * (dropped(s) - dropped(s - length))


@pytest.mark.parametrize(
    "numbers", [("9.81", 2, "0.5", "0.25", 0), ("9.81", "0.78543", "0.5", 0, 1), (1, 3, 1, "0.1", "0.2")]
)
def test_energy_is_kept_through_all_stages(numbers):
    motion = made(*numbers)
    with mpmath.workdps(45):
        times = [mpf(t) for t in motion.event_times(40)]
        middles = [(a + b) / 2 for a, b in zip([mpf(0), *times], [*times, times[2] + 1], strict=True)]
        kept = [energy(motion, *motion.state(exact(t), 40)) for t in middles]
        first = energy(motion, *(mpf(x.numerator) / x.denominator for x in (motion.s, motion.v)))
        assert max(abs(e - first) for e in kept) < mpf("1e-36")


@pytest.mark.parametrize("numbers", [("9.81", 2, "0.5", "0.25", 0), (1, 3, 1, "0.1", "0.2")])
def test_the_front_moves_as_integrated(numbers):
    motion = made(*numbers)
    time = exact(motion.event_times(40)[0]) * 2 / 3

    def field(t, state):
        s, v = state
        return v, ball(motion.g * motion.radius / motion.length) * (1 - (s / ball(motion.radius)).cos())

    (found,) = integrate(field, (motion.s, motion.v), (time,), 50)
    with mpmath.workdps(50):
        for a, b in zip(motion.state(time, 40), found, strict=True):
            assert abs(a - mpf(b.numerator) / b.denominator) < mpf("1e-38")


def test_a_sharp_edge_is_the_chain_off_a_table():
    """s'' = (g/L) s, s = s0 cosh(w t), but for terms of the size of the radius."""
    motion = made("9.81", 2, "1e-9", "1e-9", "0.5")
    hangs, enters, _ = motion.event_times(20)
    rate = mpmath.sqrt(mpf("9.81") / 2)
    assert abs((enters - hangs) - mpmath.asinh(2 * rate / mpf("0.5")) / rate) < mpf("1e-7")
    speed = motion.event_speeds(20)[2]
    assert abs(speed**2 - (mpf("0.25") + mpf("9.81") * 2)) < mpf("1e-7")
