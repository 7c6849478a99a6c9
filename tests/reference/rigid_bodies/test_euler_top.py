from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate
from gnomon.reference.rigid_bodies.euler_top import EulerTop
from mpmath import mpf

SKEWED = tuple(map(Fraction, ("1.1", "0.2", 0, "-0.3", "0.9", "0.4", 0, "0.1", 2)))


def top(moments, rates, attitude=None):
    extra = () if attitude is None else (attitude,)
    return EulerTop(tuple(map(exact, moments)), tuple(map(exact, rates)), *extra)


BODIES = {
    "general": top((2, 3, 4), (1, "0.6", "0.3")),
    "circulates about the small axis": top((2, 3, 4), (1, "0.3", "0.1")),
    "axes 312": top((4, 2, 3), ("0.3", 1, "0.6")),
    "axes 213": top((3, 2, 4), ("-0.6", 1, "0.3")),
    "axes 321": top((4, 3, 2), ("0.3", "-0.6", -1)),
    "skewed attitude": top((2, 3, 4), (-1, "0.6", "-0.3"), SKEWED),
    "a rate of zero": top((1, 2, 3), (1, "0.6", 0)),
    "flat": top((1, 2, 3), (0.1, 3, 0.1)),
    "near the middle axis": top((1, 2, 3), (1e-12, 1, 1e-12)),
    "near the separatrix": top((1, 2, 2.25), (3 * (1 + 1e-12), 1, 4)),
    "separatrix": top((1, 2, 2.25), (3, 1, 4)),
    "separatrix, other signs and axes": top((2.25, 1, 2), (-4, -3, 1)),
    "near-symmetric": top((1, "1.0000000001", 2), (1, "0.6", "0.8")),
    "near-symmetric above": top((1, 2, "2.0000000001"), (1, "0.6", "0.8")),
    "thin cone": top((1, 2, 3), ("1e-9", 0, 1)),
    "oblate": top((2, 2, 3), (1, "0.6", "0.8"), SKEWED),
    "prolate": top((1, 3, 3), (1, "0.6", "0.8")),
    "symmetric about the second": top((3, 1, 3), (1, "0.6", "0.8")),
    "sphere": top((2, 2, 2), (1, "0.6", "0.8")),
    "principal axis": top((1, 2, 3), (0, "-0.6", 0)),
    "at rest": top((1, 2, 3), (0, 0, 0)),
}
TIMES = ("0.7", 23, "-11.5", 10**5)
ALL = [pytest.param(body, id=name) for name, body in BODIES.items()]


def momenta(body):
    return tuple(mpf(i.numerator) / i.denominator for i in body.moments)


@pytest.mark.parametrize("body", ALL)
def test_fifty_digits_agree_with_a_hundred(body):
    with mpmath.workdps(110):
        for t in TIMES:
            short, long = body.state(t, 50), body.state(t, 100)
            assert max(abs(a - b) for a, b in zip(short, long, strict=True)) < mpf("1e-49") * max(map(abs, long))


@pytest.mark.parametrize("body", ALL)
def test_the_state_at_zero_is_the_start(body):
    with mpmath.workdps(60):
        expected = [mpf(v.numerator) / v.denominator for v in (*body.rates, *body.attitude)]
        found = body.state(0, 50)
        assert max(abs(a - b) for a, b in zip(found, expected, strict=True)) < mpf("1e-48")


@pytest.mark.parametrize("body", ALL)
def test_eulers_equations_hold(body):
    """Central differences with h = 1e-40 in 150 digits: their own error is h^2."""
    h = Fraction(1, 10**40)
    for t in map(Fraction, TIMES):
        with mpmath.workdps(150):
            before, here, after = (body.state(s, 150) for s in (t - h, t, t + h))
            w1, w2, w3, *R = here
            i1, i2, i3 = momenta(body)
            rates = [(i2 - i3) * w2 * w3 / i1, (i3 - i1) * w3 * w1 / i2, (i1 - i2) * w1 * w2 / i3]
            for x, y, z in (R[:3], R[3:6], R[6:]):
                rates += [y * w3 - z * w2, z * w1 - x * w3, x * w2 - y * w1]
            slopes = [(b - a) * mpf(10) ** 40 / 2 for a, b in zip(before, after, strict=True)]
            assert max(abs(a - b) for a, b in zip(slopes, rates, strict=True)) < mpf("1e-75")


@pytest.mark.parametrize("body", ALL)
def test_energy_and_momentum_in_space(body):
    with mpmath.workdps(90):

        def values(state):
            w, R = state[:3], state[3:]
            L = [i * x for i, x in zip(momenta(body), w, strict=True)]
            space = [sum(R[3 * k + j] * L[j] for j in range(3)) for k in range(3)]
            return [sum(a * b for a, b in zip(L, w, strict=True)), *space]

        start = values(body.state(0, 85))
        for t in TIMES:
            found = values(body.state(t, 80))
            # Products of numbers up to 5 with 80 digits each.
            assert max(abs(a - b) for a, b in zip(found, start, strict=True)) < mpf("1e-77")


@pytest.mark.parametrize("name", ["general", "skewed attitude", "near the separatrix", "separatrix", "oblate"])
def test_against_taylor_integration(name):
    body = BODIES[name]

    def field(t, y):
        w1, w2, w3, *R = y
        i1, i2, i3 = (int(4 * i) for i in body.moments)
        rates = [(i2 - i3) * w2 * w3 / i1, (i3 - i1) * w3 * w1 / i2, (i1 - i2) * w1 * w2 / i3]
        for x, p, q in (R[:3], R[3:6], R[6:]):
            rates += [p * w3 - q * w2, q * w1 - x * w3, x * w2 - p * w1]
        return tuple(rates)

    (found,) = integrate(field, (*body.rates, *body.attitude), [Fraction(3, 2)], 60)
    with mpmath.workdps(60):
        for a, b in zip(body.state(Fraction(3, 2), 50), found, strict=True):
            assert abs(a - mpf(b.numerator) / b.denominator) < mpf("1e-47")


@pytest.mark.parametrize("name", ["general", "near the middle axis", "separatrix", "oblate", "skewed attitude"])
def test_group_property_and_reversal(name):
    body = BODIES[name]
    halfway = [Fraction(*mpmath.libmp.to_rational(x._mpf_)) for x in body.state(2, 120)]
    later = EulerTop(body.moments, tuple(halfway[:3]), tuple(halfway[3:]))
    back = EulerTop(body.moments, tuple(-w for w in halfway[:3]), tuple(halfway[3:]))
    with mpmath.workdps(60):
        assert max(abs(a - b) for a, b in zip(later.state(3, 50), body.state(5, 50), strict=True)) < mpf("1e-48")
        found = back.state(2, 50)
        start = body.state(0, 50)
        signs = [-1] * 3 + [1] * 9
        assert max(abs(s * a - b) for s, a, b in zip(signs, found, start, strict=True)) < mpf("1e-48")


def test_relabelled_axes_give_the_relabelled_motion():
    """A cyclic permutation of the axes is a proper rotation."""
    first = top((2, 3, 4), (1, "0.6", "0.3")).state(5, 40)
    relabelled = top((4, 2, 3), ("0.3", 1, "0.6")).state(5, 40)
    labels = (2, 0, 1)
    for a, k in zip(relabelled[:3], labels, strict=True):
        assert mpmath.almosteq(a, first[k], rel_eps=1e-14)
    for i in range(3):
        for j in range(3):
            assert float(relabelled[3 + 3 * i + j]) == pytest.approx(
                float(first[3 + 3 * labels[i] + labels[j]]), rel=1e-15, abs=1e-15
            )


def test_nearly_equal_moments_approach_the_symmetric_formula():
    near = top((2, 2 + Fraction(1, 10**25), 3), (1, "0.6", "0.8")).state(4, 40)
    equal = top((2, 2, 3), (1, "0.6", "0.8")).state(4, 40)
    with mpmath.workdps(50):
        # The relative difference of the moments, times a few radians.
        assert max(abs(a - b) for a, b in zip(near, equal, strict=True)) < mpf("1e-24")


def test_the_separatrix_is_decided_exactly_and_joined_continuously():
    exactly = top((1, 2, 2.25), (3, 1, 4))
    assert exactly.kind == "separatrix"
    for sign in (1, -1):
        beside = top((1, 2, 2.25), (3 + sign * Fraction(1, 10**30), 1, 4))
        assert beside.kind == "general"
        with mpmath.workdps(60):
            pairs = zip(beside.state(3, 50), exactly.state(3, 50), strict=True)
            # 1e-30 grows by exp(2 * 1.6 * 3) and the factors of the start.
            assert max(abs(a - b) for a, b in pairs) < mpf("1e-24")


@pytest.mark.parametrize("name", ["general", "near the middle axis", "oblate", "symmetric about the second"])
def test_rates_repeat_after_the_body_period(name):
    body = BODIES[name]
    period = Fraction(*mpmath.libmp.to_rational(body.body_period(60)._mpf_))
    with mpmath.workdps(60):
        pairs = zip(body.state(2 + period, 50)[:3], body.state(2, 50)[:3], strict=True)
        assert max(abs(a - b) for a, b in pairs) < mpf("1e-48")


def test_precession_is_the_mean_turn_about_the_momentum():
    """From the attitude alone: the angle of a body axis about L after one body period."""
    body = BODIES["general"]
    period = body.body_period(40)
    time = Fraction(*mpmath.libmp.to_rational(period._mpf_))
    with mpmath.workdps(40):
        R = mpmath.matrix(3, 3)
        for k, value in enumerate(body.state(time, 40)[3:]):
            R[k // 3, k % 3] = value
        # After the period w is back, so that R(T) is a pure turn about L: its trace gives the angle.
        angle = mpmath.acos((R[0, 0] + R[1, 1] + R[2, 2] - 1) / 2)
        turn = mpmath.fmod(body.precession(40) * period, 2 * mpmath.pi)
        assert min(abs(turn - angle), abs(turn + angle - 2 * mpmath.pi)) < mpf("1e-30")


def test_a_moment_must_be_positive():
    with pytest.raises(ValueError, match="not positive"):
        top((1, 2, 0), (1, 1, 1))
