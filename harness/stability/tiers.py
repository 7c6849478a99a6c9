"""Methods in tiers: whoever is in a later tier is worse than a method of the tier before, whichever case is left out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Floats

DRAWS, LEVEL = 2000, 0.95
FEWEST = 3
"""Cases that two methods must share to be separated."""
CENSORED = 3.0
"""log10 of the ratio to the fewest calls: a failure counts as this, a thousand times the calls."""


def separated(better: Floats, worse: Floats) -> bool:
    """Whether scores (cases,), nan where not measured, of one method are above those of another beyond chance.

    Both must hold: the 95 % bootstrap interval over cases of the mean difference is above 0, and so is the mean with
    any one case left out.
    """
    shared = (worse - better)[np.isfinite(better) & np.isfinite(worse)]
    count = len(shared)
    if count < FEWEST:
        return False
    without = (np.sum(shared) - shared) / (count - 1)
    means = shared[np.random.default_rng(count).integers(count, size=(DRAWS, count))].mean(axis=1)
    return bool(np.min(without) > 0 and np.quantile(means, (1 - LEVEL) / 2) > 0)


def tiers(scores: Mapping[str, Mapping[str, float]]) -> list[list[str]]:
    """Methods by tier from their score on each case, less being better; a case that was not measured has no score.

    The first tier are the methods from which no other is separated as better, the next one those of the others, and so on:
    each method is separated from one of the tier before, and no two of a tier are. Within a tier methods are sorted by
    name. Methods with fewer than `FEWEST` cases are left out: they cannot be separated from any.
    """
    cases = sorted({case for row in scores.values() for case in row})
    table = {
        method: np.array([row.get(case, math.nan) for case in cases])
        for method, row in sorted(scores.items())
        if len(row) >= FEWEST
    }
    better = {
        method: {other for other in table if other != method and separated(table[other], table[method])}
        for method in table
    }
    found, left = [], list(table)
    while left:
        # not empty but for methods that are better than each other in a circle, each pair on other cases
        first = [method for method in left if not better[method] & set(left)] or left
        found.append(first)
        left = [method for method in left if method not in first]
    return found


def rank_intervals(scores: Mapping[str, Mapping[str, float]]) -> dict[str, tuple[int, int]]:
    """The lowest and highest rank, from 1, that each method has in 90 % of bootstrap samples of the cases."""
    cases = sorted({case for row in scores.values() for case in row})
    table = np.array([[row.get(case, math.nan) for case in cases] for row in scores.values()])
    ranks = []
    for chosen in np.random.default_rng(len(cases)).integers(len(cases), size=(DRAWS, len(cases))):
        counts = np.sum(np.isfinite(table[:, chosen]), axis=1)
        means = np.where(counts > 0, np.nansum(table[:, chosen], axis=1) / np.maximum(counts, 1), math.inf)
        ranks.append(1 + np.argsort(np.argsort(means, kind="stable"), kind="stable"))
    low, high = np.quantile(ranks, [0.05, 0.95], axis=0, method="nearest")
    return {method: (int(a), int(b)) for method, a, b in zip(scores, low, high, strict=True)}


def summary(panels: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """For JSON: tiers and rank intervals by lost digits and by calls, from the data of the panel `digits` by method."""
    found = {}
    for name, scores in (("lost_digits", by_lost_digits(panels)), ("calls", by_calls(panels))):
        usable = {method: row for method, row in scores.items() if len(row) >= FEWEST}
        if usable:
            found[name] = {"tiers": tiers(usable), "rank_intervals": rank_intervals(usable)}
    return found


def by_lost_digits(panels: Mapping[str, Mapping[str, Any]], censored: float = 16.0) -> dict[str, dict[str, float]]:
    """Scores for `tiers` from the data of the panel `digits` by method: the mean of the lost digits of each case's
    variants, `censored` for failures."""
    return _by_case(
        {
            method: {name: min(censored, _or(row["lost"], censored)) for name, row in _complete(data).items()}
            for method, data in panels.items()
        }
    )


def by_calls(panels: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, float]]:
    """Scores for `tiers`: log10 of the calls at an error of 1e-6 over the fewest of all methods, at most 3, which is also
    the score of a failure. Methods whose calls are not counted are left out, and so are variants that nothing solves."""
    calls = {
        method: {name: row["calls"] for name, row in _complete(data).items()}
        for method, data in panels.items()
        if any(row["calls"] for row in _complete(data).values())
    }
    fewest: dict[str, float] = {}
    for row in calls.values():
        for name, count in row.items():
            if count:
                fewest[name] = min(count, fewest.get(name, math.inf))
    scores = {
        method: {
            name: min(CENSORED, math.log10(count / fewest[name])) if count else CENSORED
            for name, count in row.items()
            if name in fewest
        }
        for method, row in calls.items()
    }
    return _by_case(scores)


def _complete(data: Mapping[str, Any]) -> dict[str, Any]:
    """The variants whose calls are known or whose sweep was measured to its end: what was left out for lack of time is no
    failure."""
    rows = data.get("variants", {})
    return {name: row for name, row in rows.items() if row["calls"] or row["complete"]}


def _or(value: float | None, other: float) -> float:
    return other if value is None else value


def _by_case(scores: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """Means over the variants `case/variant` of each case, so that a case with many variants counts once."""
    found: dict[str, dict[str, float]] = {}
    for method, row in scores.items():
        cases: dict[str, list[float]] = {}
        for name, value in row.items():
            cases.setdefault(name.partition("/")[0], []).append(value)
        found[method] = {case: float(np.mean(values)) for case, values in cases.items()}
    return found
