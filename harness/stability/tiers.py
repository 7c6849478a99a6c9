"""Tiers of methods: each method of a tier is worse, beyond chance, than the mean of the tier before."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.results.time_ratios import above
from gnomon.harness.stability.digits import bounds, find_levelled

LEVEL = 0.02
"""Level of significance of a tier, shared by its comparisons, one for each method. As the order of methods comes from
these scores too, 60 identical methods are in more than one tier in 2 to 3 of 100 tables."""
FEWEST = 8
"""Smallest number of cases of a method in a tier. With 8 cases a factor of 10 makes two tiers in nine of ten tables at
a scatter of 0.25 decades, the median of the methods by calls; with fewer the correction for many methods leaves too
little."""
CENSORED = 3.0
"""Score of a failure, as log10 of the ratio to the fewest calls: a thousand times the calls."""
ROUNDS = 50
"""Rounds of the fit of means of methods and means of cases, because not all methods have all cases."""


Scores = Mapping[str, Mapping[str, float]]
"""The score by method and case, lower being better; cases without a measurement are absent."""


def is_separated(better: Floats, worse: Floats, comparisons: int = 1) -> bool:
    """Whether the scores (cases,) of one method are above the scores of another beyond chance; nan is no measurement.

    Student's t of the differences over the cases, at the level of `LEVEL` over the number of comparisons (Bonferroni).
    """
    shared = (worse - better)[np.isfinite(better) & np.isfinite(worse)]
    return len(shared) >= FEWEST and bool(np.mean(shared) > 0) and above(shared) < LEVEL / comparisons


def tiers(scores: Scores, least: Scores | None = None) -> list[list[str]]:
    """Methods by tier.

    If scores are known within bounds, `scores` are the upper bounds, and `least` the lower bounds by which a method is
    called worse. A tier begins with the best method. It takes each next method that is not separated from the mean of
    the better ones, up to the first that is, and then all later methods that are not separated from the mean of these.
    The others begin the next tier. A tier is sorted by name. Methods with fewer than `FEWEST` cases are left out.
    """
    table = _table({method: row for method, row in scores.items() if len(row) >= FEWEST})
    low = table if least is None else _table({method: least[method] for method in table})
    tiers, left = [], _order_methods(table)
    while left:
        core = left[:1]
        for method in left[1:]:
            if is_separated(_mean(table, core), low[method], len(table)):
                break
            core.append(method)
        middle = _mean(table, core)
        tier = [method for method in left if method in core or not is_separated(middle, low[method], len(table))]
        tiers.append(sorted(tier))
        left = [method for method in left if method not in tier]
    return tiers


def _table(scores: Scores) -> dict[str, Floats]:
    """Scores (cases,) by method, nan without a score."""
    cases = sorted({case for row in scores.values() for case in row})
    return {method: np.array([row.get(case, math.nan) for case in cases]) for method, row in sorted(scores.items())}


def _mean(table: Mapping[str, Floats], methods: Sequence[str]) -> Floats:
    """The mean of methods on each case, nan without a measurement."""
    with warnings.catch_warnings(action="ignore", category=RuntimeWarning):
        return np.asarray(np.nanmean([table[method] for method in methods], axis=0))


def _order_methods(table: Mapping[str, Floats]) -> list[str]:
    """Methods from the best on, by the mean over their cases, each case relative to its mean over the methods."""
    values = np.array(list(table.values()))
    own = np.zeros(len(values))
    for _ in range(ROUNDS if len(values) else 0):
        own = np.nanmean(values - np.nanmean(values - own[:, None], axis=0), axis=1)
    return [method for _, method in sorted(zip(own.tolist(), table, strict=True))]


def summary(panels: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Tiers by lost digits and by calls, for JSON, from the data of the panel `digits` by method."""
    most, least = by_lost_digits(panels)
    calls = by_calls(panels)
    rankings = {"lost_digits": tiers(most, least), "calls": tiers(calls)}
    return {name: {"tiers": each} for name, each in rankings.items() if sum(map(len, each)) > 1}


def by_lost_digits(panels: Mapping[str, Mapping[str, Any]], censored: float = 16.0) -> tuple[Scores, Scores]:
    """Upper and lower scores for `tiers`, from the data of the panel `digits` by method.

    They are the means, over each case's variants, of the most and the least digits lost; `censored` for failures.
    Methods whose sweeps level off on fewer than `FEWEST` cases are left out, because their errors show where the sweeps
    end.
    """
    variants = {method: data.get("variants", {}) for method, data in panels.items()}
    settled = _by_case({method: find_levelled(rows) for method, rows in variants.items()})
    known = {method: bounds(variants[method]) for method, row in settled.items() if len(row) >= FEWEST}
    most, least = (
        _by_case(
            {method: {name: min(censored, ends[end]) for name, ends in rows.items()} for method, rows in known.items()}
        )
        for end in (1, 0)
    )
    return most, least


def by_calls(panels: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, float]]:
    """Scores for `tiers`: log10 of the calls at an error of 1e-6 over the fewest calls of all methods, at most 3.

    A failure has the score 3. Methods whose calls are not counted are left out, and variants that no method solves.
    """
    calls = {
        method: {name: row["calls"] for name, row in _complete(data).items()}
        for method, data in panels.items()
        if any(row["calls"] for row in _complete(data).values())
    }
    counted = [(name, count) for row in calls.values() for name, count in row.items() if count]
    fewest = dict(sorted(counted, key=lambda each: -each[1]))
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
    """The variants with known calls or a complete sweep: a sweep that ends for lack of time is not a failure."""
    rows = data.get("variants", {})
    return {name: row for name, row in rows.items() if row["calls"] or row["complete"]}


def _by_case(scores: Scores) -> dict[str, dict[str, float]]:
    """Means over the variants `case/variant` of each case, so that a case with many variants counts once."""
    means: dict[str, dict[str, float]] = {}
    for method, row in scores.items():
        cases: dict[str, list[float]] = {}
        for name, value in row.items():
            cases.setdefault(name.partition("/")[0], []).append(value)
        means[method] = {case: float(np.mean(values)) for case, values in cases.items()}
    return means
