"""The sample times of a case, and its exact states at given times, rounded to binary64."""

import math
from fractions import Fraction

import numpy as np
from gnomon.cases.core.interface import SolvedCase
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SAMPLES = 64
INTERVAL_BITS = 20


def sample_times(case: SolvedCase) -> Floats:
    """64 equally spaced times up to the span (s): multiples of an interval of 20 significant bits, so exact in binary64.

    In a hybrid case the interval is reduced by units of its 20th bit until no sample is closer to an event than 1e-3 of
    the time between the events around it. The variants `engines` are sampled at the multiples of 0.01 s nearest to
    k span/64 instead, because engines are usually run at decimal steps.
    """
    if case.variant is not None and case.variant.startswith("engines"):
        return np.array([round(k * case.span / SAMPLES * 100) / 100 for k in range(1, SAMPLES + 1)], dtype=np.float64)
    mantissa, exponent = _interval(case.span / SAMPLES)
    if case.hybrid is not None:
        _check_last_flight(case)
    while case.hybrid is not None and not _clear(case, Fraction(mantissa) * Fraction(2) ** exponent):
        mantissa -= 1
    return np.arange(1, SAMPLES + 1, dtype=np.float64) * math.ldexp(mantissa, exponent)


def _interval(length: Fraction) -> tuple[int, int]:
    """(mantissa, exponent): the length as mantissa * 2**exponent, its mantissa of 20 bits rounded to nearest."""
    exponent = math.frexp(float(length))[1] - INTERVAL_BITS
    return round(length / Fraction(2) ** exponent), exponent


def _check_last_flight(case: SolvedCase) -> None:
    """Raise ArithmeticError if the span ends so soon after its last event that every sample is too close to it."""
    end = case.between(float(case.span))
    if end.past and end.last < float(case.span) / (2 * SAMPLES) and float(case.span) - end.last < end.gap / 1000:
        raise ArithmeticError("its samples cannot stay clear of its last event; give a longer span")


def _clear(case: SolvedCase, interval: Fraction) -> bool:
    for k in range(1, SAMPLES + 1):
        t = float(k * interval)
        near = case.between(t)
        if (near.past > 0 and t - near.last < near.gap / 1000) or near.next - t < near.gap / 1000:
            return False
    return True
