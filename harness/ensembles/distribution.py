"""The distribution of the errors of an ensemble, as counts that do not depend on the partition of the samples.

It holds integers and the few largest errors, so that the results of parts are added in any sequence without rounding.
Its size does not depend on the number of samples.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import mpmath
import numpy as np
from gnomon.harness.contract.status import Status
from gnomon.harness.ensembles.exact_formulas import NO_EXACT_STATE, OUTSIDE
from gnomon.harness.ensembles.samples import Samples
from numpy.typing import NDArray
from scipy.stats import binom

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
PER_DECADE = 64
LOWEST, HIGHEST = -20, 20
"""Limits of the decades that are divided into bins. Smaller errors, and 0, are in the first bin, larger ones in the
last."""
CELLS = 48
"""The map has CELLS by CELLS cells."""
LEVELS = (0.5, 0.9, 0.99, 0.999, 0.9999, 0.99999, 0.999999)
CONFIDENCE = 0.95
LEAST_BEYOND = 10
"""A quantile is given only if at least this number of samples is expected beyond it."""

with mpmath.workdps(30):
    EDGES: Floats = np.array(
        [
            float(mpmath.mpf(10) ** (mpmath.mpf(k) / PER_DECADE))
            for k in range(PER_DECADE * LOWEST, PER_DECADE * HIGHEST + 1)
        ]
    )
"""Edges of the bins. Bin i has the errors from EDGES[i - 1] to below EDGES[i], bin 0 has all errors below EDGES[0]."""


@dataclass(frozen=True, order=True)
class Start:
    """One sample: the negative of its error (so that the worst is first), its index, its varied numbers."""

    minus_error: float
    index: int
    numbers: tuple[float, ...]

    @property
    def error(self) -> float:
        return -self.minus_error


@dataclass(frozen=True)
class Distribution:
    """Counts of samples by status, counts of errors by bin (of samples with status ok), the worst samples, the map.

    `cells` (3, CELLS, CELLS): for each cell of two varied numbers the number of samples that are ok, the sum of their
    bins, and the number of samples that failed. `failed`: the first failed samples of each status, at most `keep`.
    """

    keep: int
    statuses: Mapping[str, int] = field(default_factory=dict)
    bins: Integers = field(default_factory=lambda: np.zeros(len(EDGES) + 1, dtype=np.int64))
    cells: Integers = field(default_factory=lambda: np.zeros((3, CELLS, CELLS), dtype=np.int64))
    worst: tuple[Start, ...] = ()
    failed: Mapping[str, tuple[Start, ...]] = field(default_factory=dict)

    def merged(self, other: Distribution) -> Distribution:
        """The distribution of the samples of both distributions."""
        failed = {
            name: tuple(sorted((*self.failed.get(name, ()), *other.failed.get(name, ())), key=lambda s: s.index))
            for name in {*self.failed, *other.failed}
        }
        return replace(
            self,
            statuses=dict(Counter(self.statuses) + Counter(other.statuses)),
            bins=self.bins + other.bins,
            cells=self.cells + other.cells,
            worst=tuple(sorted((*self.worst, *other.worst)))[: self.keep],
            failed={name: samples[: self.keep] for name, samples in failed.items()},
        )

    @property
    def scored(self) -> int:
        """The number of samples that have an error."""
        return int(self.bins.sum())

    @property
    def inside(self) -> int:
        """The number of samples that are in the domain and whose exact state is known."""
        return sum(count for name, count in self.statuses.items() if name not in (OUTSIDE, NO_EXACT_STATE))

    def quantiles(self) -> list[dict[str, float | None]]:
        """Quantiles of the error with their confidence bands; samples that failed count as the largest errors.

        A band lies between order statistics whose ranks are binomial quantiles, so it is right for any distribution of
        independent samples; Sobol points are spread more evenly. Values are rounded outward to edges of bins; None: the
        quantile lies among the samples that failed.
        """
        total, quantiles = self.inside, []
        for level in LEVELS:
            if total * (1 - level) < LEAST_BEYOND:
                break
            low, high = binom.ppf([(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2], total, level)
            ranks = math.ceil(total * level), max(int(low), 1), min(int(high) + 1, total)
            middle, lower, upper = (self._ranked(rank, k != 1) for k, rank in enumerate(ranks))
            quantiles.append({"level": level, "error": middle, "low": lower, "high": upper})
        return quantiles

    def _ranked(self, rank: int, upper: bool) -> float | None:
        """The upper or lower edge of the bin of the error with this rank from 1; None beyond all errors."""
        place = int(np.searchsorted(np.cumsum(self.bins), rank))
        if place == len(self.bins):
            return None
        if upper:
            return float(EDGES[min(place, len(EDGES) - 1)])
        return float(EDGES[place - 1]) if place else 0.0

    def tail(self) -> list[tuple[float, int]]:
        """Pairs (limit, number of errors at or above it) for the powers of ten above the median."""
        beyond = np.cumsum(self.bins[::-1])[::-1]
        pairs = [(float(EDGES[k]), int(beyond[k + 1])) for k in range(0, len(EDGES), PER_DECADE)]
        return [pair for pair in pairs if 0 < pair[1] <= self.scored / 2]


def count_samples(samples: Samples, sides: tuple[int, int], keep: int) -> Distribution:
    """The distribution of consecutive samples. `sides`: the columns of the two varied numbers of the map."""
    names, errors = np.array(samples.statuses), samples.errors
    scored = names == Status.OK
    # An error that is exactly an edge belongs to the bin above.
    bins = np.searchsorted(EDGES, errors[scored], side="right")
    places = (samples.units[:, list(sides)] * CELLS).astype(np.int64)
    cells = np.zeros((3, CELLS, CELLS), dtype=np.int64)
    np.add.at(cells[0], tuple(places[scored].T), 1)
    np.add.at(cells[1], tuple(places[scored].T), bins)
    lost = ~scored & ~np.isin(names, (OUTSIDE, NO_EXACT_STATE))
    np.add.at(cells[2], tuple(places[lost].T), 1)

    def start(i: int) -> Start:
        error = float(errors[i])
        return Start(0.0 if math.isnan(error) else -error, samples.first + i, tuple(samples.numbers[i].tolist()))

    largest = np.flatnonzero(scored)
    largest = largest[np.lexsort((largest, -errors[largest]))][:keep]
    failed = {
        str(name): tuple(start(int(i)) for i in np.flatnonzero(names == name)[:keep])
        for name in sorted(set(samples.statuses) - {Status.OK})
    }
    return Distribution(
        keep,
        dict(Counter(map(str, samples.statuses))),
        np.bincount(bins, minlength=len(EDGES) + 1).astype(np.int64),
        cells,
        tuple(start(int(i)) for i in largest),
        failed,
    )


def as_data(distribution: Distribution) -> dict[str, Any]:
    """The distribution as data for JSON, without empty bins and cells."""
    full = np.flatnonzero(distribution.bins)
    cells = np.argwhere(distribution.cells[[0, 2]].sum(axis=0))
    return {
        "statuses": dict(sorted(distribution.statuses.items())),
        "bins_per_decade": PER_DECADE,
        "bins": [[float(EDGES[i - 1]) if i else 0.0, int(distribution.bins[i])] for i in full.tolist()],
        "confidence": CONFIDENCE,
        "quantiles": distribution.quantiles(),
        "tail": [{"error": limit, "samples": count} for limit, count in distribution.tail()],
        "cells_per_side": CELLS,
        "cells": [[i, j, *distribution.cells[:, i, j].tolist()] for i, j in cells.tolist()],
    }
