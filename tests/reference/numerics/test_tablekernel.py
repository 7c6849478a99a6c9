"""A value that the table proves is the nearest double, except next to ties, where either neighbour is allowed."""

import math
from fractions import Fraction

import numpy as np
import pytest
from gnomon.reference.numerics.tablekernel import evaluate

MOST = Fraction(51, 100)
"""Largest error of a sample, in spacings of doubles."""


def tabulated_value(high: float, low: float, error: float) -> tuple[float, bool]:
    """The value at 0 of a table whose polynomial is the constant high + low, known to `error`; whether it is proved."""
    values, proved = np.empty((1, 1)), np.empty(1, dtype=np.bool_)
    one = np.array([[1.0, 0.0]])
    evaluate(
        np.zeros(1), np.zeros(1), np.array([-1.0]), 0 * one, one, np.full((1, 1, 1), high), np.full((1, 1, 1), low),
        np.full((1, 1), error), np.zeros((1, 1)), np.zeros(3), np.zeros((1, 2)), np.empty((0, 1, 1, 1, 2)),
        np.empty((0, 1, 1, 1, 2)), np.empty((0, 1, 1), dtype=np.int64), values, proved,
    )  # fmt: skip
    return float(values[0, 0]), bool(proved[0])


@pytest.mark.parametrize("high", [1.0, 1.5, math.nextafter(2.0, 0.0), -math.pi, 2.0**-200, -(2.0**60)])
def test_a_proved_value_is_the_nearest_double_for_every_error(high: float) -> None:
    """The true value may be anywhere within the error: next to a tie it may be closer to another double."""
    outward = abs(math.nextafter(high, math.inf * high) - high)
    inward = abs(math.nextafter(high, 0.0) - high)
    counts = {True: 0, False: 0}
    for spacing, side in ((outward, 1), (inward, -1)):
        for share in (0.0, 0.25, 0.49, 0.5 - 2.0**-8, 0.5 - 2.0**-20):
            for power in range(-20, 1):
                error = spacing * 2.0**power
                found, proved = tabulated_value(high, math.copysign(side * share * spacing, side * high), error)
                assert found == high
                counts[proved] += 1
                farthest = Fraction(share) * Fraction(spacing) + Fraction(error)
                assert not proved or farthest <= MOST * Fraction(spacing), (share, power)
    assert min(counts.values()) > 20


@pytest.mark.parametrize("high", [1.0, 1.5, -math.pi])
def test_a_value_with_an_error_far_below_an_ulp_is_proved(high: float) -> None:
    """Otherwise every value would be computed one by one: the error of a polynomial is 2^-25 ulp."""
    ulp = math.ulp(high)
    for share in (0.0, 0.2, -0.2, 0.24):
        assert tabulated_value(high, share * ulp, 2.0**-25 * ulp) == (high, True)
