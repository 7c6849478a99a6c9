"""Free fall inside a rotating planet: an ellipse in the inertial frame."""

from fractions import Fraction

import mpmath
from gnomon.reference.rotating_frames.planet_tunnel_rotating import TurningPlanet
from mpmath import mpf


def fall(*start, g=2, R=3, Om="0.1"):
    return TurningPlanet(*map(Fraction, (g, R, Om, *start)))


def test_in_the_inertial_frame_it_is_an_ellipse():
    motion = fall(1, "0.5", "-0.25", "0.75")
    with mpmath.workdps(60):
        w, t = mpmath.sqrt(mpf(2) / 3), mpf(7)
        z, v = mpmath.mpc(1, "0.5"), mpmath.mpc("-0.25", "0.75")
        place = z * mpmath.cos(w * t) + (v + mpmath.mpc(0, "0.1") * z) / w * mpmath.sin(w * t)
        seen = place * mpmath.expj(-t / 10)
        x, y, *_ = motion.state(7, 50)
        assert abs(x - seen.real) < mpf("1e-48")
        assert abs(y - seen.imag) < mpf("1e-48")


def test_half_axes_are_the_extremes_of_the_distance():
    motion = fall(1, "0.5", "-0.25", "0.75")
    farthest, closest = map(float, motion.half_axes())
    period = float(motion.period())
    distances = [mpmath.hypot(*motion.state(period * k / 4000)[:2]) for k in range(2001)]
    # a quarter of a step from an extreme, second order
    assert abs(float(max(distances)) - farthest) < 1e-5
    assert abs(float(min(distances)) - closest) < 1e-5


def test_released_at_the_surface_it_stays_inside():
    """The limit: from rest on the rotating planet the start is the farthest point."""
    assert fall(3, 0, 0, 0).inside
    assert not fall(3, 0, "1e-30", 0).inside
    assert not fall(3, 0, 0, 0, Om=1).inside
