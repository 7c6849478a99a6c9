"""Impacts on the moving table: at the position of the table, against the bouncing ball, and their number."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.cases import case_class, get
from gnomon.reference.contact.bouncing_ball import BouncingBall
from gnomon.reference.contact.bouncing_ball_table import VibratingTable
from gnomon.reference.numerics.precision import exact

VARIANTS = [None, *(v.name for v in case_class("bouncing_ball_table").variants)]


def test_a_constant_acceleration_of_the_table_adds_to_gravity():
    """A = 0: impacts in closed form."""
    moving = VibratingTable(*map(exact, ("11.81", "0.9", 0, 5, 1, "0.5")))
    still = BouncingBall(*map(exact, ("11.81", "0.9", 1, "0.5")))
    assert moving.impacts(Fraction(4)) == still.impacts(Fraction(4))
    for n in (1, 5, moving.impacts(Fraction(4))):
        assert abs(moving.impact(n, Fraction(4), 40)[0] - still.impact_time(n, 40)) < mpmath.mpf("1e-38")
    for t in ("0.3", "1.7", "3.9"):
        for one, other in zip(moving.state(t, 40), still.state(t, 40), strict=True):
            assert abs(one - other) < mpmath.mpf("1e-38")


@pytest.mark.parametrize("variant", VARIANTS)
def test_ball_and_table_meet_in_the_inertial_frame(variant):
    """Parabolas from impact to impact, velocities by the law of restitution, and no contact in between."""
    case = get("bouncing_ball_table", variant)
    events = case.events(60)
    with mpmath.workdps(60):
        g, e, b, A, w = (mpmath.mpf(v.numerator) / v.denominator for v in case.parameter_values())
        z0, u0 = (mpmath.mpf(v.numerator) / v.denominator for v in case.initial_state)

        def table(t):
            return b * t**2 / 2 + A * mpmath.sin(w * t), b * t + A * w * mpmath.cos(w * t)

        t0, y, v = mpmath.mpf(0), z0, u0 + table(0)[1]
        for event in events:
            t = event.time
            for k in range(1, 40):
                s = (t - t0) * k / 40
                assert y + v * s - g * s**2 / 2 > table(t0 + s)[0]
            s = t - t0
            y, v = y + v * s - g * s**2 / 2, v - g * s
            place, speed = table(t)
            assert abs(y - place) < mpmath.mpf("1e-35")
            t0, y, v = t, place, speed - e * (v - speed)
            assert abs(v - speed - event.after[1]) < mpmath.mpf("1e-35")


def test_accumulating_impacts_are_refused():
    with pytest.raises(ValueError, match="give a shorter span"):
        get("bouncing_ball_table", A=0, e="0.5", span=3)


def test_all_impacts_of_a_long_chaotic_motion_are_found_at_few_digits() -> None:
    """After 41 impacts that double errors, 15 digits and their guard are fewer than the digits that are lost."""
    case = get("bouncing_ball_table", "chaotic", span=7).rounded()
    assert len(case.events()) == case.exact_motion.impacts(case.span) == 42
