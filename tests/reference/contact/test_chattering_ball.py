"""A ball that chatters to rest on a vibrating table and lifts off: accumulations by other ways, rest, release."""

import itertools
from fractions import Fraction

import mpmath
import pytest
from gnomon.cases import get
from gnomon.reference.contact.bouncing_ball import BouncingBall
from gnomon.reference.contact.chattering_ball import ChatteringBall
from mpmath import mpf


def bounces_by_search(count):
    """Times of the first bounces of the default case, each by a root search in mpmath."""
    g, e, size, rate = mpf("9.81"), mpf("0.5"), mpf("0.03"), mpf(20)
    t, z, u, found = mpf(0), mpf("0.05"), mpf(0), []
    for _ in range(count):

        def height(s, t=t, z=z, u=u):
            swing = mpmath.sin(rate * (t + s)) - mpmath.sin(rate * t) - rate * s * mpmath.cos(rate * t)
            return z + u * s - g * s * s / 2 - size * swing

        pull = g - size * rate**2 * mpmath.sin(rate * t)
        s = mpmath.findroot(height, mpf("0.196") if z else 2 * u / pull, tol=mpf(10) ** -150)
        arriving = u - g * s - size * rate * (mpmath.cos(rate * (t + s)) - mpmath.cos(rate * t))
        t, z, u = t + s, mpf(0), -e * arriving
        found.append(t)
    return found


def test_the_time_of_rest_by_extrapolation():
    """Bounces found by another search accumulate there: what is left after 60 is less than 2^-59 of the first flights."""
    case = get("chattering_ball")
    with mpmath.workdps(120):
        times = bounces_by_search(60)
        for n in (1, 2, 5, 20):
            assert abs(case.exact_motion.bounce(0, n, case.span, 50)[0] - times[n - 1]) < mpf("1e-48")
        # the flights halve, with a defect that halves too: two steps of Richardson's extrapolation
        one = [2 * b - a for a, b in itertools.pairwise(times)]
        two = [(4 * b - a) / 3 for a, b in itertools.pairwise(one)]
        limit = case.exact_motion.rest_time(0, case.span, 50)
        assert abs(two[-1] - limit) < mpf("1e-36")
        assert abs(times[-1] - limit) > mpf("1e-20")


def test_a_table_at_rest_is_the_bouncing_ball():
    """A = 0: the closed form of the bouncing ball, its limit among it."""
    numbers = tuple(map(Fraction, ("9.81", "0.5")))
    still = ChatteringBall(*numbers, Fraction(0), Fraction(20), Fraction(1), Fraction(0))
    closed = BouncingBall(*numbers, Fraction(1), Fraction(0))
    end = Fraction(2)
    assert abs(still.rest_time(0, end, 50) - closed.limit_time(50)) < mpf("1e-48")
    for t in map(Fraction, ("0.3", "0.9", "1.2", "1.99")):
        for a, b in zip(still.state(t, 40), closed.state(t, 40), strict=True):
            assert abs(a - b) < mpf("1e-38")


def test_what_was_before_a_rest_is_forgotten():
    """After the first rest two starts have the same motion, from a release at asin(g/(A w^2))/w and whole turns."""
    one, other = get("chattering_ball"), get("chattering_ball", initial_state=("0.04", "0.05"))
    t = Fraction("0.9")
    assert one.exact(Fraction("0.1"), 30) != other.exact(Fraction("0.1"), 30)
    assert one.exact(t, 40) == other.exact(t, 40)
    with mpmath.workdps(60):
        release = one.exact_motion.release_time(1, one.span, 50)
        assert abs(release - (mpmath.asin(mpf("9.81") / 12) + 2 * mpmath.pi) / 20) < mpf("1e-48")


@pytest.mark.parametrize("variant", [None, "hard_bounces", "barely_lifts", "held"])
def test_it_is_never_below_the_table_and_rests_between_limit_and_release(variant):
    case = get("chattering_ball", variant) if variant else get("chattering_ball")
    events = case.events(20)
    for k in range(1, 300):
        t = case.span * k / 300
        z, u = case.exact(t, 20)
        assert z >= 0
        last = next((event.name for event in reversed(events) if event.time <= t), "")
        assert (z == 0 and u == 0) == (last == "limit")


def test_a_table_that_never_falls_as_fast_as_the_ball_holds_it():
    names = [event.name for event in get("chattering_ball", "held").events()]
    assert names[-1] == "limit"
    assert "release" not in names
