"""The law of growth, on growths whose law is known."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from gnomon.harness.drift import law, rebuilt

from gnomon import cases

T = np.arange(1, 65) / 6.4


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        (1e-15 * T, "round-off"),
        (1e-6 * np.abs(np.sin(7 * T)), "bounded"),
        (1e-6 * np.sqrt(T), "sqrt t"),
        (1e-6 * T, "t"),
        (1e-6 * T * (1 + 0.1 * np.sin(9 * T)), "t"),
        (1e-6 * T**2, "t^2"),
        (1e-6 * T**4, "faster than t^2"),
        (1e-9 * np.exp(1.5 * T), "exponential"),
        (np.where(T > 5, np.nan, T), "diverged"),
    ],
)
def test_laws(sizes: np.ndarray, expected: str) -> None:
    assert law(T, sizes) == expected


def test_a_case_is_rebuilt_from_its_stored_numbers() -> None:
    case = cases.get("pendulum_simple", "rotation").rounded()
    numbers = {name: str(value) for name, value in case.numbers.items()}
    again = rebuilt("pendulum_simple", "rotation", numbers, float(case.span))
    assert (again.numbers, again.span, again.variant) == (case.numbers, Fraction(float(case.span)), "rotation")


def test_a_case_that_has_changed_since_is_refused() -> None:
    with pytest.raises(ValueError, match="theta"):
        rebuilt("pendulum_simple", "", {"g": "1", "L": "1", "omega": "0"}, 1.0)
