"""Foucault's pendulum at any amplitude agrees with closed forms where they exist."""

import math
from fractions import Fraction

import mpmath
from gnomon.cases import get
from gnomon.reference.numerics.weierstrass import solve_quartic
from mpmath import mpf


def test_without_rotation_a_plane_swing_is_the_pendulum() -> None:
    """e = (sin theta, 0, -cos theta), the exact motion in elliptic functions."""
    sphere = get("foucault_pendulum_nonlinear", "wide", Om=0, span=3)
    with mpmath.workdps(60):
        angle = mpmath.acos(mpf("0.28"))
        plane = get("pendulum_simple", initial_state=(angle, 0), L=1, span=3)
        for t in ("0.7", "3"):
            theta, omega = plane.exact(t, 45)
            ex, ey, ez, vx, vy, vz = sphere.exact(t, 36)
            assert ey == vy == 0
            pairs = ((ex, mpmath.sin(theta)), (ez, -mpmath.cos(theta)), (vx, omega * mpmath.cos(theta)))
            for a, b in (*pairs, (vz, omega * mpmath.sin(theta))):
                # The angle has 60 digits, the states 36; rates are about 1/s.
                assert abs(a - b) < mpf("1e-34")


def test_at_the_pole_the_height_is_an_elliptic_function() -> None:
    """z'^2 = (1 - z^2)(2E - 2(g/L) z) - (J - Om (1 - z^2))^2 by Biermann and Weierstrass: no integration."""
    with mpmath.workdps(60):
        pole = mpmath.nstr(mpmath.pi / 2, 58)
        case = get("foucault_pendulum_nonlinear", "pole", initial_state=("0.28", 0, "-0.96", 0, "0.5", 0), lat=pole)
        pull, rate, height = Fraction("9.81"), Fraction("0.5"), Fraction("-0.96")
        energy, spin = Fraction("0.25") / 2 + pull * height, Fraction("0.28") / 2 + rate * Fraction("0.28") ** 2
        rest = spin - rate  # J - Om (1 - z^2) = rest + Om z^2
        quartic = (2 * energy - rest**2, -2 * pull, -2 * energy - 2 * rest * rate, 2 * pull, -(rate**2))
        for t in ("0.9", "4.7"):
            z, rising = solve_quartic(mpmath.mp, quartic, height, Fraction(0), mpf(t))
            found = case.exact(t, 40)
            # the equations have the cosine of a latitude that is pi/2 to 58 digits
            assert abs(found[2] - z) < mpf("1e-35")
            assert abs(found[5] - rising) < mpf("1e-35")


def test_small_swings_follow_the_linear_pendulum() -> None:
    """Amplitude 1e-4: the error is its third power times the phase of 15 rad."""
    start = ("1e-4", 0, "-0.999999995", 0, 0, 0)
    sphere = get("foucault_pendulum_nonlinear", initial_state=start, Om=1, L=1, span=5)
    linear = get("foucault_pendulum_linear", initial_state=("1e-4", 0, 0, 0), Om=1, L=1, span=5)
    for a, b in zip(sphere.exact(5)[:2], linear.exact(5)[:2], strict=True):
        assert abs(float(a - b)) < 1e-4 * 1e-4 * 15


def test_the_plane_turns_clockwise_in_the_north() -> None:
    # At 90 degrees the plane of a swing through the centre turns by -Om t, seen after whole numbers of half swings.
    case = get(
        "foucault_pendulum_nonlinear",
        initial_state=("1e-3", 0, "-0.9999995", 0, 0, 0),
        L=1,
        Om="0.01",
        lat=1.5707963267948966,
    )
    t = 8 * float(case.quantities()["small_swing_period"])
    x, y = map(float, case.exact(t)[:2])
    assert math.isclose(math.atan2(y, x), -0.01 * t, rel_tol=1e-3)
