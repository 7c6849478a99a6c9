"""The slider: its equation at and around the critical speed, and the closed form without friction."""

import mpmath
import pytest
from gnomon.reference.guided.slider_rotating_slot import Slot
from gnomon.reference.numerics.precision import exact


def slot(k, mu):
    return Slot(*map(exact, (1, k, "0.2", 3, mu, "0.3", "0.4")))


MOTIONS = [slot(k, mu) for k, mu in ((20, "0.1"), (0, 0), (9, 0), ("9.000000000001", 0), (20, 2))]


@pytest.mark.parametrize("motion", MOTIONS)
def test_equation_of_motion_is_satisfied(motion, residual):
    pull, damping, push = motion.pull, motion.damping, motion.stiffness * motion.natural

    def rates(mp, y):
        return y[1], mp.mpf(pull) * y[0] + mp.mpf(push) - mp.mpf(damping) * y[1]

    assert residual(motion, lambda mp, y: rates(Numbers, y), "2.9") < mpmath.mpf(10) ** -45


class Numbers:
    mpf = staticmethod(lambda x: mpmath.mpf(x.numerator) / x.denominator)


def test_free_slider_is_a_cosh():
    with mpmath.workdps(60):
        r, v = MOTIONS[1].state(16, 50)
        r0, v0 = mpmath.mpf("0.3"), mpmath.mpf("0.4")
        expected = r0 * mpmath.cosh(48) + v0 / 3 * mpmath.sinh(48)
        assert abs(r / expected - 1) < mpmath.mpf(10) ** -48
        assert abs(v / (3 * r0 * mpmath.sinh(48) + v0 * mpmath.cosh(48)) - 1) < mpmath.mpf(10) ** -48


def test_critical_speed_is_uniform_acceleration():
    with mpmath.workdps(60):
        r, _ = MOTIONS[2].state(10, 50)
        assert abs(r - (mpmath.mpf("0.3") + 4 + 50 * mpmath.mpf("1.8"))) < mpmath.mpf(10) ** -46
