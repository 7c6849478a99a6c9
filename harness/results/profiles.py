"""Performance profiles: the share of problems on which a method, or a library's best, is close to the fastest.

After Dolan and Moré, Mathematical Programming 91, 201 (2002). A method that fails, takes too long or does not accept a
problem is never left out: its time is infinite, so that it lowers the profile at every factor.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.status import Status
from gnomon.harness.results.analysis import hard, own
from gnomon.harness.results.contenders import OURS as OURS

DRAWS = 1000
SEED = 20260101
LEVEL = 0.95
"""Bands hold pointwise at this level, over bootstrap samples of the cases, whose variants stay together."""
LARGEST_DIGITS = 16.0
THIRD_PARTY = "best third-party"


@dataclass(frozen=True)
class Profile:
    """The share of problems at each of `points`, with its band: each of shape (len(points),)."""

    name: str
    points: Floats
    share: Floats
    low: Floats
    high: Floats


def times(equal: pd.DataFrame, target: float) -> pd.DataFrame:
    """Seconds at an error: a row for each default case that some method brings to it, a column for each integrator.

    The time is inf if an integrator does not reach the error. Tied integrators take the least time. `equal`:
    `rankings.ranked`.
    """
    rows = own(equal[equal["target"] == target])
    rows = rows.assign(seconds=rows["seconds"].where(~rows["tied"], rows["seconds"] / rows["ratio"]))
    return rows.pivot(index="case", columns="integrator_id", values="seconds").fillna(np.inf)


def digits(reduced: pd.DataFrame) -> pd.DataFrame:
    """Decimal digits that each integrator reaches at its best setting on each hard variant; 0 without an ok setting.

    The table has a row for each (case, variant) that was run, a column for each integrator. `reduced`:
    `analysis.settings`.
    """
    rows = hard(reduced)
    good = rows["error_max"].where(rows["status"] == Status.OK)
    reached = (-np.log10(good.clip(lower=10**-LARGEST_DIGITS))).clip(lower=0.0).fillna(0.0)
    table = rows.assign(digits=reached).pivot_table("digits", ["case", "variant"], "integrator_id", aggfunc="max")
    return table.fillna(0.0)


def by_library(table: pd.DataFrame, library: Callable[[str], str], best: str = "min") -> pd.DataFrame:
    """The best of each library's columns, and the best of all libraries but gnomon, as columns."""
    libraries = [library(name) for name in table.columns]
    found = table.T.groupby(libraries).agg(best).T
    others = [name for name, own in zip(table.columns, libraries, strict=True) if own != OURS]
    if others:
        found[THIRD_PARTY] = table[others].agg(best, axis=1)
    return found


def ratios(table: pd.DataFrame) -> pd.DataFrame:
    """Times over the least of their row; rows that no method solves are left out."""
    least = table.min(axis=1)
    solved = np.isfinite(least)
    return table[solved].div(least[solved], axis=0)


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
