"""Störmer's multistep methods: coefficients, measured order, no drift of round-off."""

from fractions import Fraction
from math import comb
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import SecondOrder, Values
from gnomon.cases.core.registry import get
from gnomon.harness.integrators.multistep_extrapolation.stormer import (
    Stormer,
    Stormer8,
    Stormer12,
    adams_weights,
    stormer_weights,
)
from gnomon.harness.studies.orders import solve_exactly
from on_cases import solved


def ordinates(differences: tuple[Fraction, ...]) -> tuple[Fraction, ...]:
    """Weights of values, newest first, from weights of their backward differences of order 0, 1, ..."""
    return tuple(
        sum(((-1) ** m * comb(j, m) * weight for j, weight in enumerate(differences)), Fraction(0))
        for m in range(len(differences))
    )


@pytest.mark.parametrize("count", [1, 2, 3, 8, 12])
def test_formulas_are_exact_for_polynomials_up_to_their_order_only(count: int) -> None:
    """With a = t^m, q = t^(m+2) / ((m+1)(m+2)) and v = t^(m+1) / (m+1), from t = 0 to 1."""
    position, speed = ordinates(stormer_weights(count)), ordinates(adams_weights(count))
    for m in range(count + 1):
        wanted = Fraction(1 + (-1) ** m, (m + 1) * (m + 2))
        found = sum(w * Fraction(-j) ** m for j, w in enumerate(position))
        # The term of the first difference is zero: one acceleration gives the result of two.
        assert (found == wanted) == (m < max(count, 2))
        found = sum(w * Fraction(1 - j) ** m for j, w in enumerate(speed))
        assert (found == Fraction(1, m + 1)) == (m < count)


def test_the_first_weights_are_the_known_ones() -> None:
    """Störmer's of four accelerations, (14, -5, 4, -1) / 12 (Hairer, Norsett, Wanner III.10.11); Adams-Moulton's."""
    assert ordinates(stormer_weights(4)) == tuple(Fraction(n, 12) for n in (14, -5, 4, -1))
    assert ordinates(adams_weights(4)) == tuple(Fraction(n, 24) for n in (9, 19, -5, 1))


def power_of_time(t: Any, q: Values, parameters: Values) -> Values:
    (power,) = parameters
    return (t**power,)


@pytest.mark.parametrize("method", [Stormer8, Stormer12])
def test_the_velocity_is_exact_for_one_power_of_time_more_than_the_place(method: type[Stormer]) -> None:
    """For q'' = t^p: Adams' formula takes p + 1 accelerations, Störmer's p, and after its start the method makes 20 steps.
    The error of the start, of order 12, is far below the error of either formula."""
    power, count = method.order, 20 + method.order
    parameters, zero = (Fraction(power),), (Fraction(0), Fraction(0))
    q, v = solve_exactly(method(), SecondOrder(power_of_time), parameters, zero, Fraction(1), count)
    assert abs(v * (power + 1) - 1) < 1e-17
    assert abs(q * (power + 1) * (power + 2) - 1) > 1e-14


@pytest.mark.parametrize("method", [Stormer8, Stormer12])
def test_round_off_stays_near_the_conditioning(method: type[Stormer]) -> None:
    """At 6.5e4 steps, where plain sums of positions would lose 1e-16 times the square of their number: 4e-7."""
    case = get("pendulum_simple").rounded()
    assert solved(method(), case, steps=1024).error < 20 * np.max(case.conditioning(case.times))
