from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.contact.sliding_can import SlidingCan
from mpmath import mpf


def can(alpha="0.1", lift="0.17", mu_k="0.25"):
    return SlidingCan(*map(Fraction, ("0.02", "9.81", alpha, "0.3", mu_k, lift, 5, 1, 0)))


def test_sliding_starts_where_gravity_exceeds_friction():
    motion = can()
    with mpmath.workdps(60):
        t, a = motion.onset(50), mpf("0.1")
        weight = mpf("0.02") * mpf("9.81")
        normal = weight * mpmath.cos(a) - mpf("0.17") * (1 - mpmath.exp(-t / 5))
        assert mpmath.almosteq(weight * mpmath.sin(a), mpf("0.3") * normal, mpf("1e-48"))
        assert motion.state(t - mpf("1e-30"), 40) == (1, 0)


@pytest.mark.parametrize(("alpha", "t"), [("0.1", 11), ("0.4", 2)])
def test_the_equation_holds(alpha, t, residual):
    def rates(m, y):
        a = m.mpf(alpha)
        lift = m.mpf("0.17") * (1 - m.exp(-m.mpf(t) / 5)) / m.mpf("0.02")
        return y[1], m.mpf("9.81") * m.sin(a) - (m.mpf("9.81") * m.cos(a) - lift) / 4

    assert residual(can(alpha), rates, t) < mpf("1e-55")


def test_the_position_is_the_integral_of_the_velocity():
    motion = can()
    with mpmath.workdps(40):
        begin = motion.onset(40)
        way = mpmath.quad(lambda t: motion.state(t, 35)[1], [begin, 11])
        assert mpmath.almosteq(motion.state(11, 40)[0] - 1, way, mpf("1e-28"))


def test_it_holds_or_slides_at_once():
    assert can(lift="0.12").holds
    assert can("0.4").slides_first
    assert can("0.4").onset() == 0


def test_it_lifts_off_where_the_lift_equals_the_weight():
    motion = can(lift="0.25")
    with mpmath.workdps(60):
        t, weight = motion.lift_off(50), mpf("0.02") * mpf("9.81")
        air = mpf("0.25") * (1 - mpmath.exp(-t / 5))
        assert mpmath.almosteq(air, weight * mpmath.cos(mpf("0.1")), mpf("1e-48"))
        # then only the weight along the slope acts
        s, v = motion.state_at_lift_off(50)
        pull = mpf("9.81") * mpmath.sin(mpf("0.1"))
        found = motion.state(t + 3, 50)
        assert mpmath.almosteq(found[1], v + 3 * pull, mpf("1e-47"))
        assert mpmath.almosteq(found[0], s + 3 * v + 9 * pull / 2, mpf("1e-47"))
        way = mpmath.quad(lambda u: motion.state(u, 35)[1], [motion.onset(40), t, 12])
        assert mpmath.almosteq(motion.state(12, 40)[0] - 1, way, mpf("1e-28"))


def test_the_largest_lift_that_holds():
    """One double below it the can stays, one above it slides at some time."""
    numbers = [Fraction(x) for x in (0.02, 9.81, 0.1, 0.3, 0.25)]
    below, above = (
        SlidingCan(*numbers, Fraction(lift), Fraction(5), Fraction(0), Fraction(0))
        for lift in (0.12992876274052303, 0.12992876274052306)
    )
    assert below.holds
    assert not above.holds
    assert below.lift < above.holding_lift(30) < above.lift
    # the lift is within an ulp of its limit after 36.6 time constants
    assert 180 < above.onset() < 185
