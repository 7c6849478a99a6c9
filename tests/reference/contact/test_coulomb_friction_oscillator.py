from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.contact.coulomb_friction_oscillator import CoulombOscillator
from mpmath import mpf


def oscillator(k=20, g="9.81", mu_k="0.05", mu_s="0.07", x="0.5", v=0):
    return CoulombOscillator(*map(Fraction, (1, k, g, mu_k, mu_s, x, v)))


@pytest.mark.parametrize(("x", "v"), [("0.5", 0), ("-0.5", 0), ("0.1", 2), ("-0.3", "-1"), ("-0.01", "0.01")])
def test_half_cycle_by_half_cycle(x, v, residual):
    """Each turning point by reflection at the centre, the equation between them, rest after the last."""
    motion = oscillator(x=x, v=v)
    with mpmath.workdps(60):
        rate, d, limit = mpmath.sqrt(20), mpf("9.81") / 400, mpf("9.81") * 7 / 2000
        place = motion.turn_position(1, 50)
        turn = 1
        while abs(place) > limit:
            following = 2 * (d if place > 0 else -d) - place
            turn += 1
            assert abs(motion.turn_position(turn, 50) - following) < mpf("1e-49")
            assert mpmath.almosteq(
                motion.turn_time(turn, 50) - motion.turn_time(turn - 1, 50), mpmath.pi / rate, mpf("1e-47")
            )
            place = following
        assert motion.turns == turn
        assert motion.state(motion.turn_time(turn, 50) + 1, 50) == (motion.turn_position(turn, 50), 0)

    def rates(m, y):
        return y[1], -20 * y[0] - m.mpf("9.81") * (1 if y[1] > 0 else -1) / 20

    for t in ("0.001", "0.9", "1.7"):
        if Fraction(t) < Fraction(float(motion.turn_time(motion.turns))):
            assert residual(motion, rates, t) < mpf("1e-55")


def test_it_stops_exactly_at_the_limit():
    motion = oscillator(4, 10, "0.25", "0.5", 5)
    assert (motion.turns, motion.turn_position(3)) == (3, -1.25)
    assert oscillator(4, 10, "0.25", Fraction("0.5") - Fraction(1, 10**30), 5).turns == 4


def test_ten_thousand_half_cycles():
    motion = oscillator(mu_k="1.0194e-4", mu_s="1.1e-4", x=1)
    assert motion.turns == 10000
    with mpmath.workdps(70):
        x, v = motion.state(motion.turn_time(9999, 60) + mpf("1e-20"), 50)
        # The spring has pulled for 1e-20 s.
        assert abs(v) < mpf("1e-22")
        assert abs(x - motion.turn_position(9999, 50)) < mpf("1e-42")


def test_without_friction_it_never_stops():
    motion = oscillator(mu_k=0, mu_s=0)
    assert motion.turns is None
    with mpmath.workdps(60):
        assert abs(motion.state(100, 50)[0] - mpmath.cos(100 * mpmath.sqrt(20)) / 2) < mpf("1e-49")


def test_the_dissipated_energy_is_the_friction_force_times_the_distance():
    motion = oscillator()
    way = sum(
        abs(float(motion.turn_position(n)) - float(motion.turn_position(n - 1))) for n in range(1, motion.turns + 1)
    )
    assert float(motion.dissipated()) == pytest.approx(0.05 * 9.81 * way, rel=1e-13)
    assert oscillator(x="0.03").turns == 0


def test_each_half_cycle_dissipates_the_friction_force_times_its_length():
    """From the energies at successive turning points."""
    motion = oscillator()
    with mpmath.workdps(60):
        before = mpf(20) * mpf("0.25") / 2
        for turn in range(1, 6):
            after = motion.energy_after(turn, 50)
            way = abs(motion.turn_position(turn, 50) - motion.turn_position(turn - 1, 50))
            assert abs(before - after - mpf("0.05") * mpf("9.81") * way) < mpf("1e-46")
            before = after
