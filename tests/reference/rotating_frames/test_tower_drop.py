"""The fall from a tower against a plane orbit in the inertial frame, and against the first-order deflection."""

from fractions import Fraction

import mpmath
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.kepler_orbit import Kepler
from gnomon.reference.rotating_frames.tower_drop import TowerDrop
from mpmath import mpf


def drop(z="158.5", rate="7.292115e-5", lat="0.89", speed=(0, 0, 0)):
    numbers = map(Fraction, ("9.825", 6371000, rate, lat))
    return TowerDrop(*numbers, (Fraction(0), Fraction(0), Fraction(z)), tuple(map(Fraction, speed)))


def test_without_rotation_it_is_a_radial_fall():
    motion = drop(rate=0)
    point = Kepler(motion.mu, motion.R + Fraction("158.5"), Fraction(0), Fraction(0), Fraction(0))
    with mpmath.workdps(60):
        x, y, z, vx, vy, vz = motion.state(5, 45)
        r, _, v, _ = point.state(5, 50)
        assert x == y == vx == vy == 0
        assert abs(z + motion.R.numerator - r) < mpf("1e-40")
        assert abs(vz - v) < mpf("1e-42")


def test_over_the_equator_it_is_the_plane_orbit_in_the_rotating_frame():
    """The plane Kepler motion, rotated by complex numbers: no formula of the motion in space is used."""
    motion = drop(z=10**7, rate="2e-4", lat=0, speed=(300, 0, -50))
    rate, far = motion.Om, motion.R + 10**7
    # outward and east in the inertial frame
    orbit = Kepler(motion.mu, far, Fraction(0), Fraction(-50), Fraction(300) + rate * far)
    t = Fraction(4000)
    with mpmath.workdps(70):
        a, b, va, vb = orbit.state(t, 55)
        back = mpmath.expj(-mpf(rate.numerator) / rate.denominator * t.numerator)
        place, velocity = back * mpmath.mpc(a, b), back * mpmath.mpc(va, vb)
        seen = velocity - mpmath.mpc(0, mpf(rate.numerator) / rate.denominator) * place
        x, y, z, vx, vy, vz = motion.state(t, 50)
        assert y == vy == 0
        assert abs(z + motion.R.numerator - place.real) < mpf("1e-40")
        assert abs(x - place.imag) < mpf("1e-40")
        assert abs(vz - seen.real) < mpf("1e-43")
        assert abs(vx - seen.imag) < mpf("1e-43")


def test_a_small_drop_is_deflected_east_by_the_first_order():
    """g Om cos(lat) t^3/3, up to height over radius, 1.6e-10 for 1 mm, and (Om t)^2."""
    motion = drop(z="1e-3")
    t = exact("0.01")
    with mpmath.workdps(40):
        x = motion.state(t, 30)[0]
        first = mpf("9.825") * mpf("7.292115e-5") * mpmath.cos(mpf("0.89")) * mpf("1e-6") / 3
        # the centrifugal force reduces it by about Om^2 R/g, through its vertical and its southward component
        weight = 1 - mpf("7.292115e-5") ** 2 * 6371000 / mpf("9.825")
        assert abs(x / (first * weight) - 1) < mpf("1e-8")
