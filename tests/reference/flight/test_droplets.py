from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.flight.droplets import InkJet, OilDrop
from mpmath import mpf


def jet(nu=0, vx=18):
    return InkJet(*map(Fraction, (2100, "0.016", "0.026", nu, 0, 0, vx, 0)))


def test_without_drag_the_deflection_is_that_of_the_book():
    motion = jet()
    *_, vy = motion.crossing(motion.paper, 40)
    with mpmath.workdps(60):
        plates, flight, speed = mpf("0.016"), mpf("0.01"), mpf(18)
        y = motion.crossing(motion.paper, 50)[1]
        assert mpmath.almosteq(y, 2100 * plates / speed**2 * (plates / 2 + flight), mpf("1e-49"))
        assert mpmath.almosteq(vy, 2100 * plates / speed, mpf("1e-14"))
        assert motion.state(1, 50)[1] == y


@pytest.mark.parametrize("nu", [400, "1e-9"])
def test_with_drag_the_phases_are_continuous_and_obey_their_equations(nu, residual):
    motion, k = jet(nu), mpf(nu)
    leaves = Fraction(float(motion.time_at(motion.plates)))
    for t, pull in ((leaves / 2, 2100), (leaves * 5 / 4, 0)):
        with mpmath.workdps(100):

            def rates(m, y, pull=pull):
                return y[2], y[3], -m.mpf(nu) * y[2], pull - m.mpf(nu) * y[3]

            assert residual(motion, rates, t) < mpf("1e-44")
    with mpmath.workdps(60):
        end = motion.time_at(motion.plates, 55)
        for a, b in zip(motion.state(end - mpf("1e-50"), 45), motion.crossing(motion.plates, 45), strict=True):
            assert abs(a - b) < mpf("1e-43")
        assert k > 0


def test_drag_can_stop_the_drop_short():
    motion = jet(1000)
    assert motion.reaches(motion.plates)
    assert not motion.reaches(motion.paper)
    assert float(motion.state(1)[0]) == pytest.approx(0.018, rel=1e-14)


def test_the_charge_follows_from_the_two_speeds():
    a, rho, air, eta, q, field = map(Fraction, ("1e-6", 886, "1.2", "1.8e-5", "8.01e-19", 100000))
    g = Fraction("9.81")
    nu, load = 9 * eta / (2 * a**2 * rho), -g * (1 - air / rho)
    drop = OilDrop(nu, (load,), (Fraction(0),), (Fraction(0),), 3 * q * field / (4 * a**3 * rho))
    with mpmath.workdps(60):
        assert mpmath.almosteq(drop.charge(a, eta, field, 50), mpf("8.01e-19"), mpf("1e-49"))
        mass = 4 * mpmath.pi / 3 * mpf("1e-18") * 886
        tau = mass / (6 * mpmath.pi * mpf("1.8e-5") * mpf("1e-6"))
        speed = tau * (mpf("8.01e-14") / mass - mpf("9.81") * (1 - mpf("1.2") / 886))
        y, v = drop.state(1, 50)
        # After 1e5 relaxation times the speed is the terminal speed.
        assert mpmath.almosteq(v, speed, mpf("1e-49"))
        assert mpmath.almosteq(y, speed * (1 - tau), mpf("1e-48"))
        assert float(drop.falling_speed()) == pytest.approx(2 / 9 * 884.8 * 9.81 * 1e-12 / 1.8e-5, rel=1e-14)
