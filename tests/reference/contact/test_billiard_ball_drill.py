"""The attitude of the billiard ball and the drilling friction against elementary cases."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.cases import get
from gnomon.reference.contact.billiard_ball import BilliardBall
from gnomon.reference.contact.billiard_ball_attitude import BilliardAttitude
from gnomon.reference.contact.billiard_ball_drill import DrillingBall
from gnomon.reference.numerics.precision import exact
from gnomon.reference.rigid_bodies.euler_top import IDENTITY

NONE = Fraction(0)


def test_without_spin_the_ball_turns_about_one_axis():
    """Pushed along x: w_y = 5 mu g t/(2 R) until it rolls, so the angle is 5 mu g t^2/(4 R), then v t/R on top."""
    radius, mu, g, speed = exact("0.1"), exact("0.2"), exact("9.81"), Fraction(3)
    plain = BilliardBall(radius, mu, g, NONE, NONE, speed, NONE, NONE, NONE, NONE)
    motion = BilliardAttitude(plain, IDENTITY)
    with mpmath.workdps(50):
        until = 2 * mpmath.mpf(3) / (7 * mpmath.mpf("0.2") * mpmath.mpf("9.81"))
        growth = 5 * mpmath.mpf("0.2") * mpmath.mpf("9.81") / (4 * mpmath.mpf("0.1"))
        for t in ("0.2", "1.7"):
            time = mpmath.mpf(t)
            slid = min(time, until)
            angle = growth * slid**2 + (time - slid) * 2 * growth * until
            r = motion.state(t, 40)[7:]
            assert abs(r[0] - mpmath.cos(angle)) < mpmath.mpf(10) ** -38
            assert abs(r[2] - mpmath.sin(angle)) < mpmath.mpf(10) ** -38
            assert r[4] == 1


def test_a_point_of_contact_is_the_plain_ball():
    """rho = 1e-20 m: drilling reduces the force by 1e-17 until the slip is 1e-17 of the initial one."""
    numbers = (exact("0.03"), exact("0.2"), exact("9.81"))
    start = (NONE, NONE, Fraction(2), exact("0.5"), Fraction(20), Fraction(-30), Fraction(80))
    drilling = DrillingBall(*numbers, *start, Fraction(1, 10**20))
    plain = BilliardBall(*numbers, *start)
    for a, b in zip(drilling.state("0.3", 30), plain.state("0.3", 30), strict=True):
        assert abs(a - b) < mpmath.mpf(10) ** -14


def test_slip_and_drilling_end_at_the_end_time():
    """Just before the end slip and drilling rate are nearly zero, and the velocity is the final one."""
    case = get("billiard_ball_drill")
    end = exact(case.exact_motion.end_time(60))
    *_, vx, vy, wx, wy, wz = case.exact_motion.state(end * (1 - Fraction(1, 10**12)), 30)
    assert abs(wz) < 1e-9
    assert abs(vx - case.quantities()["final_vx"]) < 1e-12
    assert abs(vx - mpmath.mpf("0.03") * wy) < 1e-12
    assert abs(vy + mpmath.mpf("0.03") * wx) < 1e-12
    with pytest.raises(ValueError, match="neither slides nor drills"):
        get("billiard_ball_drill", span=5)
    with pytest.raises(ValueError, match="wz is not 0"):
        get("billiard_ball_drill", initial_state=(0, 0, 1, 0, 0, 0, 0))
