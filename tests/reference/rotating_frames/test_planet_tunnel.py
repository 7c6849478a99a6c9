from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.kepler_orbit import Kepler
from gnomon.reference.rotating_frames.planet_tunnel import PlanetTunnel
from mpmath import mpf


def tunnel(x, v=0, g=2, radius=3):
    return PlanetTunnel(*map(Fraction, (g, radius, x, v)))


def test_inside_it_is_harmonic():
    with mpmath.workdps(60):
        w = mpmath.sqrt(mpf(2) / 3)
        x, _v = tunnel(2, "0.5").state(10, 50)
        assert abs(x - (2 * mpmath.cos(10 * w) + mpmath.sin(10 * w) / (2 * w))) < mpf("1e-48")
        assert mpmath.almosteq(tunnel(2, "0.5").period(50), 2 * mpmath.pi / w, mpf("1e-48"))


def test_above_the_surface_it_falls_as_to_a_point():
    """Kepler's motion in universal variables, which shares no formula with the cycloid."""
    motion, point = tunnel(7, "0.3"), Kepler(Fraction(18), Fraction(7), Fraction(0), Fraction("0.3"), Fraction(0))
    first = motion.crossings(Fraction(100), 40)[0][0]
    with mpmath.workdps(60):
        for t in (Fraction(1, 10), Fraction(3), exact(first)):
            r, _y, v, _w = point.state(t, 45)
            assert abs(motion.state(t, 45)[0] - r) < mpf("1e-38")
            assert abs(motion.state(t, 45)[1] - v) < mpf("1e-38")
        assert abs(motion.state(first, 40)[0] - 3) < mpf("1e-37")


@pytest.mark.parametrize(("x", "v"), [(7, "0.3"), (-5, "-0.1"), (4, 0), (0, 4), (1, -3), (-2, "2.9")])
def test_the_state_repeats_after_a_period_and_the_equations_hold(x, v, residual):
    motion = tunnel(x, v)
    with mpmath.workdps(70):
        period = motion.period(65)
        for t in (0, mpf("1.234")):
            for a, b in zip(motion.state(t, 50), motion.state(t + 3 * period, 50), strict=True):
                assert abs(a - b) < mpf("1e-47")

    def rates(m, y):
        inside = abs(y[0]) < 3
        return y[1], -2 * y[0] / 3 if inside else -18 / (y[0] * abs(y[0]))

    for t in ("0.01", "2.3", "11.7", "29.1"):
        assert residual(motion, rates, t) < mpf("1e-52")


def test_crossings_are_at_the_surface_and_alternate():
    motion = tunnel(0, 4)
    found = motion.crossings(Fraction(60), 40)
    assert [enters for _, enters, _ in found] == [bool(n % 2) for n in range(len(found))]
    with mpmath.workdps(60):
        for time, _enters, side in found:
            x, v = motion.state(time, 40)
            assert abs(x - 3 * side) < mpf("1e-36")
            assert abs(abs(v) - motion.surface_speed(40)) < mpf("1e-36")
