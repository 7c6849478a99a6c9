"""What a table hands out without a look at more digits is the nearest double, but for ties that nobody could tell."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from gnomon.reference.numerics.tablekernel import evaluate

MOST = Fraction(51, 100)
"""Of the spacing of doubles: what a sample may be off."""


def handed_out(high: float, low: float, error: float) -> tuple[float, bool]:
    """The value at 0 of a table whose only polynomial is the constant high + low, known to `error`; whether it is sure."""
    values, sure = np.empty((1, 1)), np.empty(1, dtype=np.bool_)
    one = np.array([[1.0, 0.0]])
    evaluate(
        np.zeros(1), np.zeros(1), np.array([-1.0]), 0 * one, one, np.full((1, 1, 1), high), np.full((1, 1, 1), low),
        np.full((1, 1), error), np.zeros((1, 1)), np.zeros(3), np.zeros((1, 2)), np.empty((0, 1, 1, 1, 2)),
        np.empty((0, 1, 1, 1, 2)), np.empty((0, 1, 1), dtype=np.int64), values, sure,
    )  # fmt: skip
    return float(values[0, 0]), bool(sure[0])


@pytest.mark.parametrize("high", [1.0, 1.5, math.nextafter(2.0, 0.0), -math.pi, 2.0**-200, -(2.0**60)])
def test_a_value_that_is_sure_is_the_nearest_double_whatever_the_error(high: float) -> None:
    """The true value may be anywhere within the error: next to a tie it is soon nearer to another double."""
    outward = abs(math.nextafter(high, math.inf * high) - high)
    inward = abs(math.nextafter(high, 0.0) - high)
    counts = {True: 0, False: 0}
    for spacing, side in ((outward, 1), (inward, -1)):
        for share in (0.0, 0.25, 0.49, 0.5 - 2.0**-8, 0.5 - 2.0**-20):
            for power in range(-20, 1):
                error = spacing * 2.0**power
                found, sure = handed_out(high, math.copysign(side * share * spacing, side * high), error)
                assert found == high
                counts[sure] += 1
                farthest = Fraction(share) * Fraction(spacing) + Fraction(error)
                assert not sure or farthest <= MOST * Fraction(spacing), (share, power)
    assert min(counts.values()) > 20


@pytest.mark.parametrize("high", [1.0, 1.5, -math.pi])
def test_an_error_far_below_an_ulp_leaves_no_doubt(high: float) -> None:
    """Else every value would be computed one by one: a polynomial's error is 2^-25 of an ulp."""
    ulp = math.ulp(high)
    for share in (0.0, 0.2, -0.2, 0.24):
        assert handed_out(high, share * ulp, 2.0**-25 * ulp) == (high, True)
