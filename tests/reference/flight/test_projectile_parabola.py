from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.flight.projectile_parabola import Projectile


def thrown(g="9.81", x=0, y=0, vx=20, vy=15):
    return Projectile(*map(Fraction, (g, x, y, vx, vy)))


def test_state_is_the_rational_parabola():
    motion = thrown(x="1.5", y=-2)
    t = Fraction(7, 3)
    expected = (
        Fraction(3, 2) + 20 * t,
        -2 + 15 * t - Fraction("9.81") * t**2 / 2,
        Fraction(20),
        15 - Fraction("9.81") * t,
    )
    with mpmath.workdps(80):
        for found, value in zip(motion.state(t, 50), expected, strict=True):
            assert abs(found - mpmath.mpf(value.numerator) / value.denominator) <= abs(found) * mpmath.mpf(10) ** -50


def test_the_start_is_exact():
    assert thrown(x="0.5", y="0.25").state(0) == (0.5, 0.25, 20, 15)


@pytest.mark.parametrize("vy", [15, -15, 0, "-1e9"])
def test_landing_is_where_the_height_is_zero(vy):
    motion = thrown(y=3, vy=vy)
    time, x = motion.landing(50)
    with mpmath.workdps(90):
        height = 3 + mpmath.mpf(vy) * time - mpmath.mpf("9.81") * time**2 / 2
        # An error of 1e-50 in the time moves the height by the fall speed times that.
        assert abs(height) < mpmath.mpf("1e-48") * time * (abs(mpmath.mpf(vy)) + 10)
        assert time > 0
        assert mpmath.almosteq(x, 20 * time, rel_eps=mpmath.mpf("1e-49"))


def test_a_throw_from_below_that_does_not_reach_the_ground():
    assert thrown(y=-100, vy=1).landing() is None


def test_apex_is_the_greatest_height():
    time, height = thrown().apex(40)
    at_apex = thrown().state(Fraction(15) / Fraction("9.81"), 40)
    assert mpmath.almosteq(at_apex[1], height, rel_eps=1e-30)
    assert at_apex[3] == 0
    assert mpmath.almosteq(time, mpmath.mpf(15) / mpmath.mpf("9.81"), rel_eps=1e-14)


def test_the_envelope_touches_every_parabola_from_above():
    # Throws of 25 m/s in Pythagorean directions: tangent to the envelope where d = v^2 / (g tan a), tan a = vy / vx.
    for vx, vy in [(7, 24), (15, 20), (20, 15), (24, 7)]:
        motion = thrown(g=10, vx=vx, vy=vy)
        touch = Fraction(625 * vx, 10 * vy)
        state = motion.rational(touch / vx)
        assert motion.envelope(touch, 30) == pytest.approx(float(state[1]), rel=1e-14)
        for d in (touch - 1, touch + 1):
            assert motion.envelope(d, 30) > float(motion.rational(d / vx)[1])


def test_a_falling_target_is_always_hit():
    # Aimed straight at a target at (40, 30) that starts to fall at the throw: they meet at t = d / v, at any speed.
    target = thrown(x=40, y=30, vx=0, vy=0)
    for speed in (Fraction(1), Fraction(37), Fraction(10**6)):
        throw = thrown(vx=speed * 4 / 5, vy=speed * 3 / 5)
        meeting = 50 / speed
        assert throw.rational(meeting)[:2] == target.rational(meeting)[:2]


def test_without_gravity_there_is_no_apex():
    with pytest.raises(ValueError, match="g > 0"):
        thrown(g=0).apex()
    with pytest.raises(ValueError, match="speed"):
        thrown(vx=0, vy=0).envelope(1)
