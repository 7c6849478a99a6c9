"""The damped oscillator in its three regimes, by its equation and by the exponential of its matrix."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.oscillators.damped_oscillator import DampedMotion


def damped(m, c, k, x, v):
    return DampedMotion(*(exact(value) for value in (m, c, k, x, v)))


MOTIONS = {
    "under": damped(1, 0.4, 20, 0.5, 0),
    "undamped": damped(2, 0, 3, 1, -1),
    "critical": damped(1, 4, 4, 1, 1),
    "a double above critical": damped(1, 4.000000000000001, 4, 1, 1),
    "a double below critical": damped(1, 3.9999999999999996, 4, 1, 1),
    "1e-60 above critical": damped(1, 4 + Fraction(1, 10**60), 4, 1, 1),
    "over": damped(0.5, 7, "3.3", -1, 9),
    "stiff 1e6": damped(1, 10**6 + 1, 10**6, 1, 0),
    "stiff 1e12": damped(1, 10**12 + 1, 10**12, 1, 0),
    "barely damped": damped(1, "2e-6", 1, 1, 0),
}
CASES = [pytest.param(motion, id=name) for name, motion in MOTIONS.items()]


@pytest.mark.parametrize("motion", CASES)
@pytest.mark.parametrize("t", ["0.001", "0.77", "6"])
def test_equation_of_motion_is_satisfied(motion, t, residual):
    """The error of differences over 1e-30 is 1e-60 times the cube of the slow rate: the fast mode has decayed."""
    b, k = motion.damping / motion.mass, motion.stiffness / motion.mass
    assert residual(motion, lambda mp, y: (y[1], -mp.mpf(b) * y[1] - mp.mpf(k) * y[0]), t) < mpmath.mpf(10) ** -45


@pytest.mark.parametrize("motion", CASES)
@pytest.mark.parametrize("t", ["1e-12", "0.5", "6"])
def test_matrix_exponential_arrives_at_the_same_state(motion, t):
    """Scaling and squaring loses the digits of the matrix's size, 1e13 at most, squared."""
    with mpmath.workdps(130):
        numbers = (exact(t), motion.damping / motion.mass, motion.stiffness / motion.mass)
        step, b, k = (mpmath.mpf(x.numerator) / x.denominator for x in numbers)
        start = [mpmath.mpf(x.numerator) / x.denominator for x in (motion.x0, motion.v0)]
        there = mpmath.expm(mpmath.matrix([[0, step], [-k * step, -b * step]])) * mpmath.matrix(start)
        for found, right in zip(motion.state(t, 50), there, strict=True):
            assert abs(found - right) < mpmath.mpf(10) ** -48 * max(map(abs, there))


@pytest.mark.parametrize("motion", CASES)
@pytest.mark.parametrize("t", ["1e-13", "3", "628472.25"])
def test_fifty_digits_agree_with_a_hundred(motion, t):
    with mpmath.workdps(110):
        long = motion.state(t, 100)
        for found, right in zip(motion.state(t, 50), long, strict=True):
            assert abs(found - right) <= mpmath.mpf(10) ** -48 * max(map(abs, long))


@pytest.mark.parametrize(
    ("name", "regime"),
    [
        ("critical", DampedMotion.CRITICAL),
        ("a double above critical", DampedMotion.OVERDAMPED),
        ("a double below critical", DampedMotion.UNDERDAMPED),
        ("1e-60 above critical", DampedMotion.OVERDAMPED),
    ],
)
def test_regime_is_decided_exactly(name, regime):
    assert MOTIONS[name].regime == regime


def test_neighbours_of_critical_damping_agree_with_it():
    """A relative change d of the damping moves the motion by about d."""
    critical = MOTIONS["critical"].state(2, 40)
    with mpmath.workdps(40):
        for name, size in (("a double above critical", 1e-15), ("1e-60 above critical", 1e-39)):
            for found, right in zip(MOTIONS[name].state(2, 40), critical, strict=True):
                assert abs(found - right) < size


def test_logarithmic_decrement_is_the_ratio_of_states_a_period_apart():
    motion = MOTIONS["under"]
    period = exact(motion.period(60))
    with mpmath.workdps(50):
        ratio = motion.state(1, 50)[0] / motion.state(1 + period, 50)[0]
        assert mpmath.almosteq(mpmath.log(ratio), motion.logarithmic_decrement(45), rel_eps=mpmath.mpf(10) ** -43)


@pytest.mark.parametrize("motion", [*MOTIONS.values(), damped(1, 3, 1, 1, -5), damped(1, 2, 1, 1, -3)])
def test_overshoot_time_is_the_first_zero(motion):
    time = motion.overshoot_time(60)
    if time is None:
        states = [motion.state(Fraction(k, 7) / motion.rates()[1], 20)[0] for k in range(1, 200)]
        assert all(x * motion.x0 > 0 for x in states)
        return
    with mpmath.workdps(60):
        assert time > 0
        assert abs(motion.state(time, 50)[0]) < mpmath.mpf(10) ** -40 * abs(motion.state(time, 50)[1])
        if motion.x0:
            for k in range(1, 8):
                assert motion.state(time * k / 8, 30)[0] * motion.x0 > 0


def test_fast_and_slow_rate_do_not_cancel():
    slow, fast = MOTIONS["stiff 1e12"].rates(50)
    assert slow == 1
    assert fast == 10**12
