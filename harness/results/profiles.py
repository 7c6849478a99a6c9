"""Performance profiles: the share of problems on which a method, or a library's best, is close to the fastest.

After Dolan and Moré, Mathematical Programming 91, 201 (2002). A method that fails, takes too long or does not accept a
problem is never left out: its time is infinite, so that it lowers the profile at every factor.
"""

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.results.contenders import OURS as OURS

DRAWS = 1000
SEED = 20260101
LEVEL = 0.95
"""Bands hold pointwise at this level, over bootstrap samples of the cases, whose variants stay together."""


@dataclass(frozen=True)
class Profile:
    """The share of problems at each of `points`, with its band: each of shape (len(points),)."""

    name: str
    points: Floats
    share: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True)
class Median:
    """A median over independent systems, with an interval."""

    value: float
    low: float
    high: float
    count: int
    """The number of systems."""
    confident: bool
    """Whether `low` and `high` are a confidence interval at LEVEL; else, with few systems, they are the range."""


def median(values: Sequence[float]) -> Median:
    """The median of at least one value, with its order-statistics interval at LEVEL.

    The ends are the k-th value from below and from above, with the largest k that holds for any distribution: each value
    is above the median with probability 1/2, so that their numbers are binomial. With fewer than 6 values there is none.

    Examples
    --------
    >>> median([5.0, 1.0, 2.0, 9.0, 3.0, 4.0, 7.0, 8.0, 6.0])
    Median(value=5.0, low=2.0, high=8.0, count=9, confident=True)
    """
    ordered = sorted(values)
    count = len(ordered)
    k, below = 0, 0.5**count  # the probability that at most k values are below the median
    while below <= (1 - LEVEL) / 2:
        k += 1
        below += math.comb(count, k) * 0.5**count
    place = max(k - 1, 0)
    return Median(statistics.median(ordered), ordered[place], ordered[-1 - place], count, k > 0)


def profiles(values: pd.DataFrame, points: Sequence[float], above: bool = False) -> list[Profile]:
    """For each column the share of rows with a value of at most each of `points`, or with `above` of at least it."""
    codes, names = pd.factorize(values.index.get_level_values(0))
    held = np.stack([values.to_numpy() >= x if above else values.to_numpy() <= x for x in points])  # (points, rows, n)
    sums = np.stack([held[:, codes == case].sum(axis=1) for case in range(len(names))], axis=1)  # (points, cases, n)
    counts = np.bincount(codes)
    draws = np.random.default_rng(SEED).multinomial(len(names), np.full(len(names), 1 / len(names)), DRAWS)
    drawn = np.tensordot(draws.astype(float), sums.astype(float), (1, 1)) / (draws @ counts)[:, None, None]
    low, high = np.quantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], axis=0)
    share, at = held.mean(axis=1), np.asarray(points, dtype=float)
    return [Profile(str(name), at, share[:, k], low[:, k], high[:, k]) for k, name in enumerate(values.columns)]
