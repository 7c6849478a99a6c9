"""The fastest integrators: rows of `analysis.equal_error`, ranked if the launches separate them.

A cell is a problem at one error. In each cell, the integrator with the least time is compared with every other one; a
claim says that it is faster. By chance any contender can have the least time, so that a p value is multiplied by their
number.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.contract.status import NOT_BROKEN, Status
from gnomon.harness.results.analysis import NEVER_RAN, PROBLEM, hard, records
from gnomon.harness.results.contenders import (
    ALONE,
    CONTENDER,
    LARGEST_NULL,
    MOST_LAUNCHES,
    ONE_LAUNCH,
    OWN,
    RANKED,
    THIRD,
    TOO_SHORT,
    YOURS,
    division,
    kind,
    p_values,
)
from gnomon.harness.results.separation import discoveries, paired

SAME_COUNT = 1.1
"""Largest ratio of two counts of evaluations that are tied: counts are interpolated between settings of a sweep."""
EXACT = 1e-12
"""An error at the loosest setting of at most this, or CONDITIONED times the conditioning, is round-off. The method is
then exact by construction, as on Kepler's orbits a method that moves bodies on them."""
FEWEST = 5
"""Smallest number of cases for a statement about integrators, as variants of one case are not independent."""
SOLVED, CONDITIONED = 1e-6, 1e3
"""A setting solves a hard variant if its error is at most SOLVED, or CONDITIONED times a larger conditioning."""


def ranked(equal: pd.DataFrame) -> pd.DataFrame:
    """The rows with the columns `ratio`, `cell`, `slower`, `tied` and `leaders`.

    `ratio`: the time over the least of the cell. `cell`: the kind of the cell. `slower`: whether the launches separate
    the integrator from the one with the least time. `tied`: in a ranked cell, whether it is not separated; in another
    cell, whether it is a contender. `leaders`: the number of tied integrators of the cell.
    """
    least = equal.groupby([*PROBLEM, "target"])["seconds"].transform("min")
    table = equal.assign(ratio=equal["seconds"] / least, cell=ONE_LAUNCH).reset_index(drop=True)
    p, cells = np.ones(len(table)), table["cell"].to_numpy(dtype=object)
    every = list(records(table, ("ratio", "times", "null_share")))
    for places in table.groupby([*PROBLEM, "target"]).indices.values():
        rows = [every[place] for place in places.tolist()]
        cells[places] = kind(rows)
        if cells[places[0]] == RANKED:
            p[places] = p_values(rows)
    tested = cells == RANKED
    slower = np.zeros(len(table), dtype=bool)
    others = tested & (table["ratio"].to_numpy() > 1)
    slower[others] = discoveries(p[others])
    tied = np.where(tested, ~slower, table["ratio"] < CONTENDER)
    table = table.assign(cell=cells, slower=slower, tied=tied.astype(bool))
    return table.assign(leaders=table.groupby([*PROBLEM, "target"])["tied"].transform("sum"))


def undecided(table: pd.DataFrame) -> list[tuple[str, str, str, float, str, str]]:
    """Pairs for further launches: case, variant, formulation, error, the integrator with the least time, a contender.

    The contender is not separated in fewer than MOST_LAUNCHES. `table`: `ranked`.
    """
    found = []
    for key, rows in table[table["cell"] != TOO_SHORT].groupby([*PROBLEM, "target"]):
        first = rows.loc[rows["ratio"].idxmin()]
        near = rows[(rows["ratio"] < CONTENDER) & ~rows["slower"] & (rows["launches"] < MOST_LAUNCHES)]
        pairs = [name for name in near["integrator_id"] if name != first["integrator_id"]]
        found += [(*key, first["integrator_id"], name) for name in pairs]
    return found


def counted(equal: pd.DataFrame) -> pd.DataFrame:
    """The rows with the columns of `ranked`, ranked by the evaluations of the equations; rows without a count are left out.

    Counts are the same in every launch, so that no test is needed; closer than SAME_COUNT they are tied.
    """
    table = equal[equal["calls"] > 0].reset_index(drop=True)
    cells = table.groupby([*PROBLEM, "target"])["calls"]
    ratio = table["calls"] / cells.transform("min")
    alone = cells.transform("size") == 1
    tied = ratio <= SAME_COUNT
    table = table.assign(ratio=ratio, cell=np.where(alone, ALONE, RANKED), slower=~tied, tied=tied)
    return table.assign(leaders=table.groupby([*PROBLEM, "target"])["tied"].transform("sum"))


def divisions(equal: pd.DataFrame, rank: Callable[[pd.DataFrame], pd.DataFrame] = ranked) -> pd.DataFrame:
    """The rows ranked by `rank` among those of their `division` alone, third parties first.

    `against`: the time of a row of another division over the least time of third parties at the same problem and error
    (by `counted`, the evaluations), nan where they do not reach it. `apart`: whether the launches separate the two.
    """
    of = equal["library"].map(division)
    parts = [rank(equal[of == name]).assign(division=name) for name in (THIRD, YOURS, OWN) if (of == name).any()]
    table = pd.concat(parts, ignore_index=True) if parts else rank(equal).assign(division="")
    cost = "calls" if rank is counted else "seconds"
    keys = list(zip(*(table[name] for name in (*PROBLEM, "target")), strict=True))
    first: dict[tuple[Any, ...], dict[str, Any]] = {}
    near: dict[tuple[Any, ...], int] = {}
    rows = list(records(table, ("division", cost, "ratio", "times", "null_share")))
    for key, row in zip(keys, rows, strict=True):
        if row["division"] == THIRD:
            near[key] = near.get(key, 0) + (row["ratio"] < CONTENDER)
            if key not in first or row[cost] < first[key][cost]:
                first[key] = row
    ratio, p = np.full(len(table), math.nan), np.ones(len(table))
    for place, (key, row) in enumerate(zip(keys, rows, strict=True)):
        if row["division"] != THIRD and key in first:
            best = first[key]
            ratio[place] = row[cost] / best[cost]
            if max(best["null_share"], row["null_share"]) <= LARGEST_NULL:
                both = best["times"].keys() & row["times"].keys()
                chosen = near[key] if ratio[place] > 1 else 1  # any of the contenders could have had the least time
                p[place] = min(1.0, chosen * paired([math.log(row["times"][n] / best["times"][n]) for n in both]))
    other = np.isfinite(ratio)
    apart = np.zeros(len(table), dtype=bool)
    apart[other] = discoveries(p[other]) if rank is ranked else abs(np.log(ratio[other])) > math.log(SAME_COUNT)
    return table.assign(against=ratio, apart=apart)


def _within(rows: pd.DataFrame, error: float) -> pd.Series:
    """Whether settings have at most this error, or CONDITIONED times a larger conditioning."""
    enough = np.maximum(error, CONDITIONED * rows["conditioning"].fillna(0.0))
    return (rows["status"] == Status.OK) & (rows["error_max"] <= enough)


def solved(reduced: pd.DataFrame) -> pd.DataFrame:
    """A row for each hard variant that was run (case, variant), a column for each integrator, with 1 where it solves it.

    An entry is nan if an integrator was not run, or if its settings do not solve the variant and others were left out.
    `reduced`: `analysis.settings`.
    """
    ran = hard(reduced[~reduced["status"].isin(NEVER_RAN)])
    left_out = ran["status"].isin(set(NOT_BROKEN) - {Status.OK})
    named = ran.assign(right=_within(ran, SOLVED).astype(float), known=1.0 - left_out)
    named = named.groupby(["case", "variant", "integrator_id"])
    most, all_known = named["right"].max(), named["known"].min() == 1.0
    return most.where((most == 1.0) | all_known).unstack("integrator_id")
