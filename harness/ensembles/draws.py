"""Draw the numbers of samples from a case's domain: sample i has the same bits in every partition into parts.

A scrambled Sobol sequence (Owen, Journal of Complexity 14, 1998; SciPy) gives the first 32 bits of each number. Philox
(Salmon et al., SC11, 2011), with the sample's index as counter, gives the other 21: numbers of few bits are multiplied
without rounding, which would flatter a method at its round-off.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.numbers import Range, nearest
from numpy.typing import NDArray
from scipy.stats import qmc

Floats = NDArray[np.float64]
SOBOL_BITS, OTHER_BITS = 32, 21
MOST_SAMPLES = 2**30
"""The largest number of samples. Each process steps through SciPy's sequence to its first sample: 20 s to the last."""
MOST_SEED = 2**63 - 1


@dataclass(frozen=True)
class Varied:
    """A number of a case, by name, that is drawn from [low, high)."""

    name: str
    low: float
    high: float


def choose_varied(case: Case, texts: Sequence[str] = ()) -> tuple[Varied, ...]:
    """The numbers that vary: the numbers in `texts`, each NAME or NAME=LOW:HIGH, or else all numbers of the start.

    Without limits a number is drawn from the interval that its domain calls typical. Raises ValueError for an unknown
    name and for invalid limits.
    """
    numbers = [*(c.name for c in case.state), *case.parameters]
    varied: dict[str, Varied] = {}
    for text in texts or [c.name for c in case.state]:
        name, equals, limits = (part.strip() for part in text.partition("="))
        if name not in numbers:
            raise ValueError(f"--vary {text}: {case.name} has no number {name!r}; {nearest(name, numbers)}")
        if name in varied:
            raise ValueError(f"--vary {name}: given twice; give it once")
        low, high = case.domain.ranges.get(name, Range()).typical
        if equals:
            low, high = _limits(text, limits)
        varied[name] = Varied(name, low, high)
    return tuple(varied.values())


def _limits(text: str, limits: str) -> tuple[float, float]:
    low, _, high = limits.partition(":")
    try:
        interval = float(low), float(high)
    except ValueError:
        raise ValueError(f"--vary {text}: write NAME=LOW:HIGH with two numbers") from None
    if not (math.isfinite(interval[0]) and math.isfinite(interval[1] - interval[0]) and interval[0] < interval[1]):
        raise ValueError(f"--vary {text}: the limits must be finite, LOW below HIGH")
    return interval


@lru_cache(maxsize=4)
def _sequence(seed: int, dimension: int) -> qmc.Sobol:
    """The Sobol sequence, kept so that the next part continues it: SciPy steps through all points before a part."""
    return qmc.Sobol(dimension, bits=SOBOL_BITS, seed=np.random.default_rng(seed))


def unit(seed: int, dimension: int, first: int, count: int) -> Floats:
    """Samples `first` to `first + count - 1` in the unit cube, shape (count, dimension); each number is below 1."""
    sequence = _sequence(seed, dimension)
    if sequence.num_generated > first:
        sequence.reset()
    if sequence.num_generated < first:
        sequence.fast_forward(first - sequence.num_generated)
    drawn = sequence.random(1 << (count - 1).bit_length())[:count]  # SciPy warns of other numbers than powers of two
    high = (drawn * 2.0**SOBOL_BITS).astype(np.uint64)
    counters = -(-dimension // 4)  # one gives four words
    generator = np.random.Philox(key=seed).advance(first * counters)
    words = generator.random_raw(4 * counters * count).reshape(count, -1)[:, :dimension]
    low = words >> np.uint64(64 - OTHER_BITS)
    return np.asarray(((high << np.uint64(OTHER_BITS)) + low).astype(np.float64) * 2.0 ** -(SOBOL_BITS + OTHER_BITS))


def numbers(units: Floats, chosen: Sequence[Varied]) -> Floats:
    """The varied numbers of samples, shape of `units`."""
    low = np.array([number.low for number in chosen])
    return np.asarray(low + (np.array([number.high for number in chosen]) - low) * units)
