"""Rocking of a block: the flights that Housner's linearised block has in closed form."""

from itertools import pairwise

import mpmath
from gnomon.cases import get


def test_flights_from_rest():
    """First impact at acosh(1/(1 - theta0/alpha))/p, then flights of 2 atanh(c r^n)/p."""
    block = get("rocking_block")
    times = [event.time for event in block.events(40)]
    with mpmath.workdps(50):
        p, alpha, r, theta = (mpmath.mpf(x) / y for x, y in ((22, 10), (1, 4), (9, 10), (2, 10)))
        share = 1 - theta / alpha
        assert abs(times[0] - mpmath.acosh(1 / share) / p) < mpmath.mpf("1e-38")
        c = mpmath.sqrt(1 - share**2)
        for n, (before, after) in enumerate(pairwise(times), start=1):
            assert abs(after - before - 2 * mpmath.atanh(c * r**n) / p) < mpmath.mpf("1e-38")
