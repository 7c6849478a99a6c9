"""Whether measurements separate two integrators: tests of pairs, and the false discovery rate over all claims.

Calls within a launch are not independent: a launch gives one value. Times of a pair are compared by the t test of their
logarithms' differences, launch by launch. Simulated with the measured scatter (two launches of one setting within 1.2
times of each other in half of all pairs, within 1.8 in 90 %), the test separates identical methods in less than 5 % of
trials, and methods a factor of 1.5 apart with ten launches in more than 80 %. The signed-rank test cannot reach 5 %
with five launches.
"""

from collections.abc import Sequence

import numpy as np
from gnomon.harness.contract.integrator import Floats
from scipy.special import bdtr, stdtr

RATE = 0.05
"""The false discovery rate over the claims that are tested together."""
LEAST_SCATTER = 0.1
"""Minimum standard deviation of a pair's difference of logarithms, in the t test: launches of one program run in modes
some 10 % apart, and a few launches may show one mode alone."""


def above(differences: Floats, least_scatter: float = 0.0) -> float:
    """The p value that differences have mean zero, if larger ones are expected: Student's t; 1 for fewer than two."""
    count = len(differences)
    if count < 2:
        return 1.0
    mean, scatter = float(np.mean(differences)), max(float(np.std(differences, ddof=1)), least_scatter)
    return float(stdtr(count - 1, -mean * np.sqrt(count) / scatter)) if scatter else float(mean <= 0)


def paired(differences: Sequence[float] | Floats) -> float:
    """The p value that the differences, one a launch, have mean zero: two-sided t test; 1 for fewer than two."""
    values = np.asarray(differences, dtype=float)
    return min(1.0, 2 * above(values if np.sum(values) > 0 else -values, LEAST_SCATTER))


def signs(first: int, second: int) -> float:
    """The p value that two methods are ahead equally often, on the problems on which they differ.

    Two-sided sign test (McNemar, exact).
    """
    return float(min(1.0, 2 * bdtr(min(first, second), first + second, 0.5))) if first + second else 1.0


def discoveries(p: Sequence[float] | Floats) -> np.ndarray:
    """Whether each of these claims holds at the false discovery rate `RATE`, for claims that are tested together.

    This is the step-up procedure of Benjamini and Hochberg, Journal of the Royal Statistical Society B 57, 289 (1995).
    """
    values = np.asarray(p, dtype=float)
    ordered = np.sort(values)
    below = np.flatnonzero(ordered <= RATE * np.arange(1, len(values) + 1) / max(len(values), 1))
    return values <= (ordered[below[-1]] if len(below) else -1.0)
