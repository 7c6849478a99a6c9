from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.flight.gyration import Charge, RotatingFall
from mpmath import matrix, mpf


def vector(*values):
    return tuple(Fraction(value) for value in values)


def cross(a, b):
    return matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def drift_formula(load, spin, r, v, t):
    """The textbook's drift, gyration and motion along the axis, at the precision that its cancellation requires."""
    w = mpmath.sqrt(dot(spin, spin))
    n = spin / w
    drift = cross(load, n) / w
    along = dot(v, n)
    turning = v - along * n - drift
    across = cross(turning, n)
    c, s = mpmath.cos(w * t), mpmath.sin(w * t)
    place = r + drift * t + (along * t + dot(load, n) * t * t / 2) * n + turning * s / w + across * (1 - c) / w
    return [*place, *(drift + (along + dot(load, n) * t) * n + turning * c + across * s)]


@pytest.mark.parametrize(
    ("magnetic", "t"),
    [
        (("1", "-3", "5"), "3.7"),
        (("0", "0", "1e-9"), "10"),
        (("0", "0", "1e5"), "0.63"),
        (("0", "0", "5"), "125664.37"),
    ],
)
def test_a_charge_drifts_and_gyrates(magnetic, t):
    motion = Charge(vector(1, 2, 3), vector(1, 0, "0.5"), Fraction(2), vector(1, 2, "0.2"), vector(*magnetic))
    found = motion.state(Fraction(t), 50)
    with mpmath.workdps(130):
        load, spin = 2 * matrix([1, 2, mpf("0.2")]), 2 * matrix([mpf(b) for b in magnetic])
        expected = drift_formula(load, spin, matrix([1, 2, 3]), matrix([1, 0, mpf("0.5")]), mpf(t))
        for a, b in zip(found, expected, strict=True):
            assert abs(a - b) <= mpf("1e-49") * abs(b)


def test_without_magnetic_field_it_is_a_parabola():
    motion = Charge(vector(1, 2, 3), vector(1, 0, -1), Fraction(2), vector(1, 0, "0.5"), vector(0, 0, 0))
    assert [float(x) for x in motion.state(3, 30)] == [13, 2, 4.5, 7, 0, 2]
    assert motion.gyration_rate() == 0


def test_drift_and_gyroradius():
    motion = Charge(vector(0, 0, 0), vector(1, 0, "0.5"), Fraction(1), vector(1, 0, "0.2"), vector(0, 0, 5))
    assert motion.drift == vector(0, "-0.2", 0)
    assert float(motion.gyroradius()) == pytest.approx((1 + 0.04) ** 0.5 / 5, rel=1e-15)
    # After a whole gyration only the drift and the motion along the field are left.
    period = motion.gyration_period(60)
    x, y, *_ = motion.state(period, 40)
    with mpmath.workdps(60):
        assert abs(x) < mpf("1e-40")
        assert abs(y + period / 5) < mpf("1e-39")


@pytest.mark.parametrize("rate", ["7.292115e-5", "1e-12", "10"])
def test_the_fall_on_the_rotating_earth(rate):
    motion = RotatingFall(vector(0, 0, "158.5"), vector(1, -2, 3), Fraction("9.81"), Fraction(rate), Fraction("0.89"))
    found = motion.state(5, 50)
    with mpmath.workdps(130):
        spin = 2 * mpf(rate) * matrix([0, mpmath.cos(mpf("0.89")), mpmath.sin(mpf("0.89"))])
        load, place, speed = matrix([0, 0, -mpf("9.81")]), matrix([0, 0, mpf("158.5")]), matrix([1, -2, 3])
        for a, b in zip(found, drift_formula(load, spin, place, speed, mpf(5)), strict=True):
            assert abs(a - b) <= mpf("1e-49") * abs(b)


@pytest.mark.parametrize("rate", ["7.292115e-5", "1e-12", "10"])
def test_with_the_centrifugal_force_it_is_free_motion_under_rotating_gravity(rate):
    """In the inertial frame, with complex numbers in the plane across the axis: r'' = e^(i Om t) g_t."""
    motion = RotatingFall(
        vector(4, 5, "158.5"), vector(1, -2, 3), Fraction("9.81"), Fraction(rate), Fraction("0.89"), centrifugal=True
    )
    found = motion.state(5, 50)
    with mpmath.workdps(150):
        om, t = mpf(rate), mpf(5)
        c, s, g = mpmath.cos(mpf("0.89")), mpmath.sin(mpf("0.89")), mpf("9.81")
        # n = (0, c, s); east e and n x e = (0, s, -c) span the plane across it.
        r, v = matrix([4, 5, mpf("158.5")]), matrix([1, -2, 3])
        z, w, gt = r[0] + 1j * (s * r[1] - c * r[2]), v[0] + 1j * (s * v[1] - c * v[2]), 1j * c * g
        a = z + gt / om**2
        turned = -gt / om**2 + mpmath.exp(-1j * om * t) * (a + (w + 1j * om * a) * t)
        along = c * r[1] + s * r[2] + (c * v[1] + s * v[2]) * t - s * g * t * t / 2
        expected = [turned.real, c * along + s * turned.imag, s * along - c * turned.imag]
        for a, b in zip(found[:3], expected, strict=True):
            assert abs(a - b) <= mpf("1e-49") * abs(b)
