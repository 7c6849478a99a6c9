"""Sphere and loop: the normal force vanishes where contact is lost, energy through both phases, the next contact."""

import mpmath
import pytest
from gnomon.reference.guided.contact_loss import ContactLoss
from gnomon.reference.numerics.precision import exact


def made(inside, g, radius, theta, omega):
    return ContactLoss(*map(exact, (g, radius, theta, omega)), inside)


SPHERE = made(False, "9.81", 1, "0.1", 0)
LOOP = made(True, "9.81", 1, 0, "6.5")
CASES = [
    pytest.param(SPHERE, id="sphere"),
    pytest.param(made(False, 2, "0.5", 0, 1), id="launched"),
    pytest.param(LOOP, id="loop"),
    pytest.param(made(True, 5, 1, 0, "4.99"), id="nearly through"),
]


@pytest.mark.parametrize("motion", CASES)
def test_contact_is_lost_where_the_normal_force_vanishes(motion):
    """From the state of the pendulum at the leaving time, which has 40 digits."""
    with mpmath.workdps(60):
        theta, h, omega, u = motion.state(exact(motion.leaving_time(60)) * (1 - exact("1e-50")), 50)
        side = 1 if motion.inside else -1
        force = mpmath.mpf(motion.g.numerator) / motion.g.denominator * mpmath.cos(theta)
        force += side * omega**2 * motion.radius.numerator / motion.radius.denominator
        assert abs(force) < mpmath.mpf(10) ** -43
        assert (h, u) == (0, 0)


@pytest.mark.parametrize("motion", CASES)
def test_energy_is_the_same_before_and_after(motion):
    with mpmath.workdps(60):
        g, radius = (mpmath.mpf(x.numerator) / x.denominator for x in (motion.g, motion.radius))
        side = -1 if motion.inside else 1
        leaving = exact(motion.leaving_time(60))
        found = []
        for t in (exact(0), leaving / 2, leaving * 5 / 4, leaving * 3 / 2):
            theta, h, omega, u = motion.state(t, 50)
            r = radius + side * h
            found.append((u**2 + (r * omega) ** 2) / 2 + side * g * r * mpmath.cos(theta))
        assert max(abs(x - found[0]) for x in found) < mpmath.mpf(10) ** -45


def test_flight_ends_on_the_loop():
    with mpmath.workdps(60):
        end = LOOP.leaving_time(55) + LOOP.flight_time(55)
        assert abs(LOOP.state(exact(end), 50)[1]) < mpmath.mpf(10) ** -45
        assert LOOP.state(exact(end) * exact("0.99"), 50)[1] > 0


def test_contact_in_a_loop_is_lost_only_at_intermediate_speeds():
    assert not made(True, 5, 1, 0, 5).leaves  # exactly fast enough
    assert made(True, 5, 1, 0, "4.999999999999999").leaves
    assert not made(True, 5, 1, 0, 3).leaves
    assert not made(False, 5, 1, 0, 0).leaves
