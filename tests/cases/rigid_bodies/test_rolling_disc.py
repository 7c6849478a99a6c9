"""The rolling disc agrees with results that need no integration: Legendre functions, small tilts, the circle."""

import math

import mpmath
import numpy as np
import pytest
from gnomon.cases import get
from mpmath import mpf


def legendre(theta):
    """Two solutions w3(theta) of d(sin w3')/dtheta = (4/3) sin w3, Legendre's equation of degree n(n + 1) = -4/3."""
    degree = mpmath.mpc(-0.5, mpmath.sqrt(mpf(13) / 12))

    def solution(x):
        return mpmath.re(mpmath.hyp2f1(-degree, degree + 1, 1, (1 - x) / 2))

    def slope(x):
        return mpmath.re(mpmath.hyp2f1(1 - degree, degree + 2, 2, (1 - x) / 2) * degree * (degree + 1) / 2)

    cosine, sine = mpmath.cos(theta), mpmath.sin(theta)
    return (
        (solution(cosine), -sine * slope(cosine)),
        (solution(-cosine), sine * slope(-cosine)),
    )


def first_integrals(state):
    """The coefficients of the two solutions in w3, from w3 and dw3/dtheta = (2/3) w2 (Chaplygin 1897, Appell 1900)."""
    _, _, theta, _, _, _, w2, w3 = map(mpf, state)
    (p, dp), (q, dq) = legendre(theta)
    slope, determinant = 2 * w2 / 3, p * dq - q * dp
    return (w3 * dq - slope * q) / determinant, (p * slope - dp * w3) / determinant


@pytest.mark.parametrize("variant", [None, "straight_slow", "grazing"])
def test_legendre_functions_of_the_inclination_give_the_spin(variant):
    case = get("rolling_disc", variant)
    case = case.with_span(case.span / 4)
    with mpmath.workdps(40):
        start = first_integrals([mpf(x.numerator) / x.denominator for x in case.initial_state])
        for share in (mpf("0.3"), mpf("0.7"), mpf(1)):
            there = first_integrals(case.exact(case.span.numerator * share / case.span.denominator, 35))
            for a, b in zip(start, there, strict=True):
                assert abs(a - b) < mpf("1e-27") * max(map(abs, start))


@pytest.mark.parametrize("variant", ["straight_stable", "straight_unstable", "spinning_stable", "spinning_unstable"])
def test_small_tilts_grow_or_swing_as_the_linear_theory_says(variant):
    """5 e'' = 4 (g/a) e - 6 w2 w3 - w2^2 e, e = theta - pi/2, with w2' = 2 w3 e', w3' = (2/3) w2 e'."""
    case = get("rolling_disc", variant)
    g, a = map(float, case.parameter_values())
    first, turn, roll = (float(case.initial_state[i]) for i in (2, 6, 7))
    first -= math.pi / 2
    if "straight" in variant:  # w2 = turn + 2 roll (e - first)
        square, push = (4 * g / a - 12 * roll**2) / 5, (12 * roll**2 * first - 6 * turn * roll) / 5
    else:  # w3 = (2/3) turn (e - first)
        square, push = (4 * g / a - 5 * turn**2) / 5, 4 * turn**2 * first / 5
    assert (square > 0) == ("unstable" in variant)
    times = case.times[:16]
    tilt = case.sample(times)[:, 2] - math.pi / 2
    root, middle = math.sqrt(abs(square)), -push / square
    expected = middle + (first - middle) * (np.cosh(root * times) if square > 0 else np.cos(root * times))
    # The linear theory omits terms of second order in the tilt, below 3e-4.
    assert np.allclose(tilt, expected, rtol=0, atol=1e-3 * np.max(np.abs(expected)))


def test_a_disc_with_the_circle_spin_keeps_its_inclination():
    case = get("rolling_disc", "circle")
    spin = case.quantities()["circle_spin"]
    assert abs(float(spin) - float(case.initial_state[7])) < 1e-14
    found = case.sample(case.times)
    # The start is within 1e-15 of the circle, and the circle is stable.
    assert np.max(np.abs(found[:, [2, 5, 6, 7]] - [1, 0, 2, float(spin)])) < 1e-13
    # The point of contact moves at -a psi' and its direction turns at phi': a circle of radius a |psi'/phi'|.
    phi, psi = 2 / math.sin(1), float(spin) - 2 / math.tan(1)
    radius = float(case.parameters["a"]) * psi / phi
    x = -radius * np.sin(phi * case.times)
    y = -radius * (1 - np.cos(phi * case.times))
    assert np.allclose(found[:, :2], np.stack([x, y], axis=1), atol=1e-12)


def test_whole_turns_of_a_diverged_answer_can_be_counted_and_stored():
    """An integrator that diverges may return angles of 1e300, whose turns exceed the integers of a database."""
    case = get("rolling_disc", "circle", span=1)
    wrong = case.sample(case.times[:2])
    wrong[0, 3] = 1e300
    assert case.metric.turns(wrong, case.sample(case.times[:2])) == 2**53
