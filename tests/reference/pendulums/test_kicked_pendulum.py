"""The impulse: the angle is continuous, the rate jumps, and the work is the difference of the energies."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.cases import case_class, get
from gnomon.reference.pendulums.pendulum_simple import Pendulum

VARIANTS = [None, *(v.name for v in case_class("torque_impulse_on_arm").variants)]


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_work_is_the_gain_of_energy(variant):
    case = get("torque_impulse_on_arm", variant)
    event = case.events(40)[0]
    with mpmath.workdps(40):
        _g, m, length, H, blow = (mpmath.mpf(v.numerator) / v.denominator for v in case.parameter_values())
        inertia = m * length**2 / 3
        assert abs(event.time - blow) < mpmath.mpf("1e-39")
        assert event.before[0] == event.after[0]
        before, after = event.before[1], event.after[1]
        # the jump cancels in `stopped` to 1e-9 of the rates
        assert abs(inertia * (after - before) - H) < mpmath.mpf("1e-37") * (abs(H) + 1)
        work = mpmath.mpf(case.quantities(40)["work"])
        assert abs(inertia * (after**2 - before**2) / 2 - work) < mpmath.mpf("1e-36") * (abs(H * after) + 1)


def test_an_impulse_to_the_top_gives_the_separatrix_and_a_pendulum_at_rest_stays_until_it():
    motion = get("torque_impulse_on_arm", "to_the_top").motion()
    assert motion.after().regime == Pendulum.SEPARATRIX
    still = get("torque_impulse_on_arm", "at_rest").motion()
    assert still.state(Fraction(12, 10)) == (0, 0)
    assert still.state(Fraction(13, 10)) == (0, 4)
