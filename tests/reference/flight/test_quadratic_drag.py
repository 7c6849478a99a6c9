from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.flight.quadratic_drag import QuadraticDragPlane, QuadraticDragVertical
from gnomon.reference.numerics.precision import exact
from mpmath import mpf


def thrown(k="0.01", vx=20, vy=15):
    return QuadraticDragPlane(*map(Fraction, ("9.81", k, 1, 2, vx, vy)))


def vertical(k="0.01", v=40):
    return QuadraticDragVertical(*map(Fraction, ("9.81", k, 2, v)))


@pytest.mark.parametrize(("k", "vx", "vy", "t"), [("0.01", 20, 15, 4), ("0.5", -3, 10, 2), ("1e-10", 20, 15, 3)])
def test_the_plane_throw_against_a_taylor_integration(k, vx, vy, t, residual):
    from gnomon.reference.numerics.balls import ball
    from gnomon.reference.numerics.taylor import integrate

    motion = thrown(k, vx, vy)
    found = motion.state(t, 50)

    def field(_, y):
        drag = ball(Fraction(k)) * (y[2] * y[2] + y[3] * y[3]).sqrt()
        return y[2], y[3], -drag * y[2], -ball(Fraction("9.81")) - drag * y[3]

    expected = integrate(field, (Fraction(1), Fraction(2), Fraction(vx), Fraction(vy)), [Fraction(t)], 60)[0]
    with mpmath.workdps(70):
        size = max(map(abs, found))
        for a, b in zip(found, expected, strict=True):
            assert abs(a - mpf(b.numerator) / b.denominator) < mpf("1e-48") * size


@pytest.mark.parametrize(("k", "vx", "vy", "t"), [("3.5", 20, 49, 1), ("0.01", "1e-6", 15, 2), ("0.01", 20, 15, 100)])
def test_the_equations_hold_where_it_is_hard(k, vx, vy, t, residual):
    motion = thrown(k, vx, vy)

    def rates(m, y):
        drag = m.mpf(k) * m.sqrt(y[2] ** 2 + y[3] ** 2)
        return y[2], y[3], -drag * y[2], -m.mpf("9.81") - drag * y[3]

    # Central differences err by 1e-60 of a third derivative, some (k v)^3 v.
    assert residual(motion, rates, t) < mpf("1e-50")


def test_the_apex_is_where_the_path_is_level():
    time, height = thrown().apex(50)
    state = thrown().state(time, 50)
    with mpmath.workdps(60):
        assert abs(state[3]) < mpf("1e-48")
        assert abs(state[1] - height) < mpf("1e-48")
    assert thrown(vy=-1).apex() is None


@pytest.mark.parametrize("vy", [0, "1e-9"])
def test_the_slowest_throw_upwards_has_an_apex(vy):
    """So low that it rises as without drag: for vy/g."""
    time, height = thrown(vy=vy).apex(50)
    assert float(time) == pytest.approx(float(vy) / 9.81, rel=1e-8)
    assert 0 <= height - 2 < 1e-18


@pytest.mark.parametrize(
    ("k", "v", "t"), [("0.01", 40, 1), ("0.01", 40, 5), ("0.1", "1e7", 1), ("1e-12", 40, 5), (1, -50, 3)]
)
def test_the_vertical_throw_satisfies_its_equation(k, v, t, residual):
    def rates(m, y):
        return y[1], -m.mpf("9.81") - m.mpf(k) * y[1] * abs(y[1])

    assert residual(vertical(k, v), rates, t) < mpf("1e-48")


@pytest.mark.parametrize("v", [40, "1e7"])
def test_a_vertical_throw_rises_to_its_apex_and_returns_slower(v):
    motion = vertical(v=v)
    with mpmath.workdps(60):
        top = motion.state(motion.apex_time(55), 50)
        assert abs(top[1]) < mpf("1e-47")
        assert abs(top[0] - motion.apex_height(50)) < mpf("1e-46")
        back = motion.state(motion.return_time(55), 50)
        assert abs(back[0] - 2) < mpf("1e-46") * motion.apex_height()
        assert abs(back[1] + motion.return_speed(50)) < mpf("1e-46")
    # Energy: v0 / sqrt(1 + v0^2 / vt^2).
    assert float(motion.return_speed()) == pytest.approx(float(v) / (1 + float(v) ** 2 * 0.01 / 9.81) ** 0.5, rel=1e-14)


def test_a_long_fall_reaches_the_terminal_speed_without_overflow():
    height, speed = vertical().state(10**6, 40)
    with mpmath.workdps(60):
        assert speed == -vertical().terminal_speed(40)
    assert height < -(10**7)


def test_the_start_is_exact():
    assert thrown().state(0) == (1, 2, 20, 15)
    assert [exact(x) for x in vertical().state(0)] == [2, 40]
