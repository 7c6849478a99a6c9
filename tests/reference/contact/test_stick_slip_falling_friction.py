"""Stick-slip with falling friction: its limits, and slips that end at the first passage of the belt's speed."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.cases import get
from gnomon.reference.contact.stick_slip_belt import StickSlip
from gnomon.reference.contact.stick_slip_falling_friction import FallingStickSlip
from mpmath import mpf

NAME = "stick_slip_falling_friction"


@pytest.mark.parametrize("start", [(0, "0.5"), ("0.02", "-0.3"), (0, 0)])
def test_without_a_fall_it_is_the_block_of_coulomb_friction(start):
    """The difference falls in proportion to the slope."""
    numbers = tuple(map(Fraction, (1, 20, "9.81", "0.5", "0.3", "0.5", *start)))
    coulomb = StickSlip(*numbers)
    gaps = []
    for slope in ("1e-10", "1e-12"):
        falling = FallingStickSlip(*numbers, Fraction(slope))
        times = [Fraction(k, 3) for k in range(1, 15)]
        pairs = [zip(falling.state(t, 40), coulomb.state(t, 40), strict=True) for t in times]
        gaps.append(max(abs(a - b) for pair in pairs for a, b in pair))
    assert 0 < gaps[1] < mpf("1e-9")
    assert abs(gaps[0] / gaps[1] - 100) < 1e-3


def test_a_slip_by_roots_of_its_formula():
    """The end of the slip that follows a release, by a search in mpmath; the state there."""
    case = get(NAME)
    with mpmath.workdps(60):
        g, belt, slope, mu_s, mu_k = mpf("9.81"), mpf("0.5"), mpf("0.1"), mpf("0.5"), mpf("0.4")
        d = slope * g / 2
        turn = mpmath.sqrt(20 - d * d)
        far = (mu_s - mu_k + slope * belt) * g / 20

        def speed(t):
            return mpmath.exp(d * t) * (
                belt * mpmath.cos(turn * t) + (d * belt - 20 * far) / turn * mpmath.sin(turn * t)
            )

        end = mpmath.findroot(lambda t: speed(t) - belt, mpf("1.07"))
        assert abs(case.exact_motion.slip_time(50) - end) < mpf("1e-48")
        assert all(speed(end * k / 500) < belt for k in range(1, 500))
        begin = case.exact_motion.release_time(60)
        for part in (mpf(1) / 7, mpf(1) / 2, mpf(9) / 10):
            t = Fraction(*map(int, ((begin + part * end) * 2**180, 2**180)))
            since = mpf(t.numerator) / t.denominator - begin
            assert abs(case.exact(t, 50)[1] - speed(since)) < mpf("1e-44")


def test_grazing():
    """Of two starts 2e-11 m apart one is caught on the second peak, one on the third."""
    caught, missed = (get(NAME, variant) for variant in ("grazing", "missed"))
    assert (caught.exact_motion.turns, missed.exact_motion.turns) == (1, 2)
    assert caught.events()[0].time < 1.8 < 2.9 < missed.events()[0].time


@pytest.mark.parametrize("variant", [None, "slope_near_zero", "grazing", "missed", "spirals_out", "stiff_spring"])
def test_no_passage_of_the_speed_of_the_belt_between_events(variant):
    """Fine samples are never faster than the belt: the search for the end of a slip has missed none before."""
    case = get(NAME, variant) if variant else get(NAME)
    for k in range(1, 400):
        assert case.exact(case.span * k / 400, 20)[1] <= float(case.parameters["V"])


@pytest.mark.parametrize(
    ("numbers", "start", "reason"),
    [
        ({"slope": "1"}, (0, "0.5"), "a slipping block swings"),
        ({"slope": "0.4"}, (0, "0.5"), "friction stays positive"),
        ({"V": "0.5", "mu_k": "0.4", "slope": "0.1"}, ("0.171675", 0), "slide steadily"),
        ({}, ("-0.3", "0.5"), "can be held"),
    ],
)
def test_refuses_what_its_law_does_not_describe(numbers, start, reason):
    with pytest.raises(ValueError, match=reason):
        get(NAME, initial_state=start, **numbers)
