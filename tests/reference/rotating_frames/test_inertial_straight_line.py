from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.flight.gyration import RotatingFall
from gnomon.reference.rotating_frames.inertial_straight_line import FirstOrderFall, StraightLine
from mpmath import mpf

DROP = (tuple(map(Fraction, (0, 0, "158.5"))), (Fraction(0),) * 3)
EARTH = (Fraction("9.81"), Fraction("7.292115e-5"), Fraction("0.8901179185171081"))


@pytest.mark.parametrize(("rate", "t"), [("2", 30), ("2", "314172.1"), ("1e-9", 10), (0, 3)])
def test_in_the_inertial_frame_the_path_is_straight(rate, t):
    motion = StraightLine(*map(Fraction, (rate, 1, 2, "0.5", -1)))
    x, y, vx, vy = motion.state(Fraction(t), 50)
    with mpmath.workdps(80):
        om, time = mpf(rate), mpf(t)
        turn = mpmath.exp(1j * om * time)
        start, speed = mpmath.mpc(1, 2), mpmath.mpc(mpf("0.5"), -1)
        constant = speed + 1j * om * start
        size = abs(start) + abs(constant) * time
        assert abs(turn * mpmath.mpc(x, y) - (start + constant * time)) < mpf("1e-49") * size
        back = turn * (mpmath.mpc(vx, vy) + 1j * om * mpmath.mpc(x, y))
        assert abs(back - constant) < mpf("1e-48") * (1 + om) * size


def test_the_drop_of_reich_strikes_27_mm_to_the_east():
    time, east, north = RotatingFall(*DROP, *EARTH).strike(5.7, 40)
    assert float(east) == pytest.approx(0.0275, abs=1e-4)
    with mpmath.workdps(50):
        first = (
            mpf("9.81") * mpf("7.292115e-5") * mpmath.cos(mpf(EARTH[2].numerator) / EARTH[2].denominator) * time**3 / 3
        )
        # The next term of the deflection is smaller by (Om t)^2.
        assert abs(east / first - 1) < (mpf("7.3e-5") * time) ** 2
    assert -1e-5 < north < 0
    assert abs(RotatingFall(*DROP, *EARTH).state(time, 40)[2]) < mpf("1e-36")


def test_the_first_order_fall_lacks_only_the_second_order():
    exact, first = RotatingFall(*DROP, *EARTH), FirstOrderFall(*EARTH, (Fraction(0),) * 3, *DROP)
    east, other = exact.state(5, 30)[0], first.state(5, 30)[0]
    assert abs(other / east - 1) < (7.3e-5 * 5) ** 2
