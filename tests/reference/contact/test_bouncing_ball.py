from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.contact.bouncing_ball import BouncingBall
from hypothesis import given
from hypothesis import strategies as st


def ball(g="9.81", e="0.8", y0=1, v0=0):
    return BouncingBall(*map(Fraction, (g, e, y0, v0)))


def simulated(motion, t, digits=90):
    """The state at t by following one flight after another; each flight's end is found by bisection on its height.

    Shares with the closed form only the law of the flight: no geometric sum, no energy.
    """
    with mpmath.workdps(digits):
        g, e, y, v = (mpmath.mpf(x.numerator) / x.denominator for x in (motion.g, motion.e, motion.y0, motion.v0))
        left = mpmath.mpf(t.numerator) / t.denominator
        count = 0
        while True:
            low = max(v, 0) / g  # the apex, or the start of a fall
            high = low + 1
            while y + v * high - g * high**2 / 2 > 0:
                high *= 2
            if y + v * left - g * left**2 / 2 > 0 and left < high:
                return count, (y + v * left - g * left**2 / 2, v - g * left)
            for _ in range(4 * digits):
                middle = (low + high) / 2
                low, high = (middle, high) if y + v * middle - g * middle**2 / 2 > 0 else (low, middle)
            y, v, left, count = mpmath.mpf(0), -e * (v - g * low), left - low, count + 1


@pytest.mark.parametrize(
    ("motion", "t"),
    [
        (ball(), "0.3"),
        (ball(), "2.7"),
        (ball(e=0.8), "4.05"),
        (ball(e="0.99", y0="0.3", v0=-2), 20),
        (ball(e=1, v0="1.5"), 31),
        (ball(y0=0, v0=3), "1.9"),
        (ball(e="0.05"), "0.49"),
    ],
)
def test_agrees_with_following_the_flights(motion, t):
    t = Fraction(t)
    count, state = simulated(motion, t)
    assert motion.impacts(t) == count
    with mpmath.workdps(90):
        for found, expected in zip(motion.state(t, 50), state, strict=True):
            assert abs(found - expected) < mpmath.mpf(10) ** -49 * 10


@given(
    st.fractions("0.5", 20, max_denominator=1000),
    st.fractions("0.05", 1, max_denominator=1000),
    st.fractions("0.01", 5, max_denominator=1000),
    st.fractions(-5, 5, max_denominator=1000),
    st.fractions(0, 1, max_denominator=997),
)
def test_motion_between_and_at_impacts(g, e, y0, v0, share):
    """In flight y'' = -g; at an impact the height is zero and the velocity is multiplied by -e; y is never negative."""
    motion = BouncingBall(g, e, y0, v0)
    end = motion.limit_time(60) if e < 1 else motion.impact_time(12, 60)
    t = Fraction(share.numerator * int(end * 10**6), share.denominator * 10**6)
    y, v = motion.state(t, 50)
    assert y >= 0
    count = motion.impacts(t)
    if count is None:
        assert (y, v) == (0, 0)
        return
    with mpmath.workdps(80):
        last = motion.impact_time(count, 70) if count else mpmath.mpf(0)
        following = motion.impact_time(count + 1, 70)
        assert last <= mpmath.mpf(t.numerator) / t.denominator < following
        scale = mpmath.mpf(10) ** -48 * (1 + motion.impact_speed() ** 2) * (1 + following)
        middle = (last + following) / 2
        h = (following - last) / 8
        a, b, c = (motion.state(middle + k * h, 70)[0] for k in (-1, 0, 1))
        # a second difference is exact for a parabola
        assert abs((a - 2 * b + c) + mpmath.mpf(g.numerator) / g.denominator * h**2) < scale
        close = (following - last) * mpmath.mpf(10) ** -55
        before, after = motion.state(following - close, 60), motion.state(following + close, 60)
        assert abs(before[0]) < scale
        assert abs(after[1] + mpmath.mpf(e.numerator) / e.denominator * before[1]) < scale


def test_an_event_at_a_rational_time_has_its_right_limit():
    motion = ball(g=2, e="0.5")  # u = 2: impacts at 1, 2, 2.5, ...; limit at 3
    assert [motion.impacts(Fraction(t)) for t in ("0.99", "1", "2", "2.5", "2.75", "3")] == [0, 1, 2, 3, 4, None]
    assert motion.state(1) == (0, 1)
    assert motion.state(2) == (0, 0.5)
    assert motion.state(3) == (0, 0)
    below = Fraction(2) - Fraction(1, 10**80)
    assert motion.impacts(below) == 1
    assert motion.state(below, 20)[1] < -0.99


def test_state_just_before_the_limit():
    """1e-30 before the end the ball still bounces, after log(1e-30)/log(e) impacts."""
    motion = ball(g=2, e="0.5")
    t = 3 - Fraction(1, 10**30)
    count = motion.impacts(t)
    assert count == 1 + int(mpmath.log(2 * mpmath.mpf(10) ** 30, 2))  # 2 - t_n halves at each impact, from 2 at t_1
    y, v = motion.state(t, 40)
    assert 0 <= y < mpmath.mpf(10) ** -60
    assert 0 < abs(v) < mpmath.mpf(10) ** -29


def test_many_elastic_impacts_are_periodic():
    motion = ball(e=1)
    shift = motion.flight_time(1, 70)
    with mpmath.workdps(70):
        later = motion.state(mpmath.mpf("0.7") + 10**6 * shift, 50)
        now = motion.state(mpmath.mpf("0.7"), 50)
        assert all(abs(a - b) < mpmath.mpf(10) ** -48 for a, b in zip(later, now, strict=True))


def test_listed_impacts_end_before_the_first_short_gap():
    motion = ball(g=2, e="0.5")  # gaps 1, 0.5, 0.25, ...
    times = [time for time, _ in motion.impact_list(Fraction("0.2"), Fraction(100), 30)]
    assert times == [1, 2, 2.5, 2.75]
    assert [t for t, _ in motion.impact_list(Fraction("0.2"), Fraction(2), 30)] == [1, 2]
    for n, (time, speed) in enumerate(ball().impact_list(Fraction(1, 10**6), Fraction(100), 40), start=1):
        assert mpmath.almosteq(time, ball().impact_time(n, 40), rel_eps=mpmath.mpf("1e-38"))
        assert mpmath.almosteq(speed, ball().speed_after(n - 1, 40) if n > 1 else ball().impact_speed(40), 1e-15)


def test_path_length_is_the_sum_over_the_flights():
    motion = ball(e="0.9", v0=2)
    g = 9.81
    legs = 2 * 2**2 / (2 * g) + 1 + sum(float(motion.speed_after(n)) ** 2 / g for n in range(1, 400))
    assert float(motion.path_length()) == pytest.approx(legs, rel=1e-13)  # 400 additions of doubles


def test_rest_stays_rest():
    motion = ball(y0=0)
    assert motion.state(17) == (0, 0)
    assert motion.limit_time() == 0
    assert motion.path_length() == 0
    assert ball(e=1).path_length() == mpmath.inf
    assert ball(e=1).limit_time() == mpmath.inf
