import math
from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.contact.block_incline_friction import BlockIncline, holds
from hypothesis import given
from hypothesis import strategies as st


def block(g="9.81", alpha="0.4", mu_k="0.3", mu_s="0.4", s0=0, v0=4):
    return BlockIncline(*map(Fraction, (g, alpha, mu_k, mu_s, s0, v0)))


def simulated(motion, t, steps=4000):
    """The motion by semi-explicit steps of Coulomb's law itself with Richardson extrapolation: no phase is assumed.

    Each step is exact for constant acceleration; a step in which the speed changes sign is cut where it is zero.
    """
    with mpmath.workdps(60):
        g, alpha, mu_k, mu_s, s, v = (
            mpmath.mpf(x.numerator) / x.denominator
            for x in (motion.g, motion.alpha, motion.mu_k, motion.mu_s, motion.s0, motion.v0)
        )
        left = mpmath.mpf(t.numerator) / t.denominator
        h = left / steps
        pull, normal = g * mpmath.sin(alpha), g * mpmath.cos(alpha)
        while left > 0:
            if v == 0 and pull <= mu_s * normal:
                return s, v
            way = mpmath.sign(v) or -1
            a = -pull - way * mu_k * normal
            dt = min(h, left)
            if v != 0 and (v + a * dt) * v < 0:
                dt = -v / a
                s, v = s + v * dt / 2, mpmath.mpf(0)
            else:
                s, v = s + v * dt + a * dt**2 / 2, v + a * dt
            left -= dt
        return s, v


@pytest.mark.parametrize(
    ("motion", "t"),
    [
        (block(), "0.5"),
        (block(), "2.9"),
        (block(mu_s="0.5"), 3),
        (block(v0=0), 2),
        (block(v0=0, mu_s="0.5"), 2),
        (block(v0=-4, mu_k="0.6", mu_s="0.7", s0=1), 2),
        (block(v0=-4, mu_k="0.6", mu_s="0.7"), 5),
        (block(v0=-4), 5),
        (block(alpha=0, mu_k=0, mu_s=0), 5),
        (block(alpha=0), 5),
    ],
)
def test_agrees_with_steps_of_coulombs_law(motion, t):
    t = Fraction(t)
    with mpmath.workdps(60):
        for found, expected in zip(motion.state(t, 50), simulated(motion, t), strict=True):
            # 4000 additions at 60 digits
            assert abs(found - expected) < mpmath.mpf("1e-49") * (1 + abs(expected))


@given(
    st.floats(0.01, 1.5),
    st.floats(0, 1),
    st.floats(0, 1),
    st.floats(-5, 5),
    st.fractions(0, 1, max_denominator=997),
)
def test_coulombs_law_holds_while_moving(alpha, mu_k, more, v0, share):
    """Where v is not zero, v' = -g (sin(alpha) + mu_k sign(v) cos(alpha)) and s' = v."""
    motion = block(alpha=alpha, mu_k=mu_k, mu_s=Fraction(mu_k) + Fraction(more), v0=v0)
    t = 5 * share + Fraction(1, 100)
    with mpmath.workdps(70):
        h = mpmath.mpf(10) ** -25
        at = mpmath.mpf(t.numerator) / t.denominator
        (s0, v_0), (s1, v1), (s2, v2) = (motion.state(at + k * h, 60) for k in (-1, 0, 1))
        if v_0 * v2 <= 0:
            return
        a = mpmath.mpf(alpha)
        expected = -mpmath.mpf("9.81") * (mpmath.sin(a) + mpmath.sign(v1) * mpmath.mpf(mu_k) * mpmath.cos(a))
        size = 1 + abs(v1) + abs(s1) + abs(mpmath.mpf(mu_k))
        assert abs((v2 - v_0) / (2 * h) - expected) < mpmath.mpf("1e-33") * size  # 1e-60 over h
        assert abs((s2 - s0) / (2 * h) - v1) < mpmath.mpf("1e-33") * size


@pytest.mark.parametrize("alpha", [0.4, 0.1, 1.0, 1.5707963267948966, 1e-9, 0.7853981633974483])
def test_the_friction_limit_is_decided_correctly_one_double_below_and_above(alpha):
    with mpmath.workdps(60):
        tangent = mpmath.tan(mpmath.mpf(alpha))
        below = above = float(tangent)
        while mpmath.mpf(below) > tangent:
            below = math.nextafter(below, 0)
        while mpmath.mpf(above) < tangent:
            above = math.nextafter(above, math.inf)
    assert not holds(Fraction(alpha), Fraction(below))
    assert holds(Fraction(alpha), Fraction(above))
    assert math.nextafter(below, math.inf) == above


def test_the_friction_limit_is_decided_far_below_a_double():
    with mpmath.workdps(120):
        tangent = Fraction(int(mpmath.tan(mpmath.mpf("0.5")) * mpmath.mpf(10) ** 100), 10**100)
    assert not holds(Fraction(1, 2), tangent)
    assert holds(Fraction(1, 2), tangent + Fraction(1, 10**100))


def test_level_ground_always_holds():
    assert holds(Fraction(0), Fraction(0))


def test_quantities_follow_from_the_work_energy_principle():
    motion = block()
    g, alpha, v0 = 9.81, 0.4, 4.0
    stop = float(motion.stop_position())
    lifted = g * stop * math.sin(alpha)
    assert v0**2 / 2 + float(motion.friction_work()) == pytest.approx(lifted, rel=1e-14)
    back = float(motion.return_speed())
    assert v0**2 / 2 + 2 * float(motion.friction_work()) == pytest.approx(back**2 / 2, rel=1e-14)
    s, v = motion.state(motion.return_time(60), 40)
    assert abs(s) < mpmath.mpf("1e-39")
    assert float(-v) == pytest.approx(back, rel=1e-15)
    assert float(motion.friction_angle()) == math.atan(0.4)


def test_a_slide_that_nearly_balances_keeps_its_digits():
    """mu_k one double below tan(alpha): the acceleration is 1e-17 g, and correct to 50 digits."""
    motion = block(alpha=0.4, mu_k=0.4227932187381618, mu_s=0.4227932187381618, v0=0)
    s, v = motion.state(2, 50)
    assert v < 0
    with mpmath.workdps(90):
        a = mpmath.mpf(0.4)
        excess = mpmath.mpf("9.81") * (mpmath.sin(a) - mpmath.mpf(0.4227932187381618) * mpmath.cos(a))
        assert mpmath.almosteq(s, -2 * excess, rel_eps=mpmath.mpf("1e-49"))


def test_the_stop_time_of_a_block_that_never_stops_is_infinite():
    assert block(v0=-4).stop_time() == mpmath.inf
    assert block(alpha=0, mu_k=0, mu_s=0).stop_time() == mpmath.inf
    assert block(mu_s="0.5").return_time() == mpmath.inf
