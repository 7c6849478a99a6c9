"""The fastest integrators of each cell: rows of `analysis.equal_error` with their factor to it and its interval."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.contract.status import NOT_BROKEN, Status
from gnomon.harness.results import analysis
from gnomon.harness.results.analysis import NEVER_RAN, PROBLEM, hard, records
from gnomon.harness.results.contenders import (
    ALONE,
    ANSWERED,
    OWN,
    THIRD,
    YOURS,
    division,
    judge,
    list_launched,
    scatters,
)
from gnomon.harness.results.reading import MORE_SCATTER
from gnomon.harness.results.time_ratios import (
    EQUAL,
    FASTEST,
    NEAR,
    SLOWER,
    Compared,
    Scatter,
    Timed,
    compare,
    discoveries,
    state,
)

SAME_COUNT = 1.1
"""Largest ratio of two counts of evaluations that are tied: counts are interpolated between settings of a sweep."""
FEWEST = 5
"""Smallest number of cases for a statement about integrators, as variants of one case are not independent."""
SOLVED, CONDITIONED = 1e-6, 1e3
"""A setting solves a hard variant if its error is at most SOLVED, or CONDITIONED times a larger conditioning."""


def scatter(frame: pd.DataFrame) -> dict[str, Scatter]:
    """The scatter between launches in the rows of `analysis.tidy` by division, see `contenders.scatters`."""
    columns = ("case", "variant", "formulation", "integrator_id", "machine", "setting", "run", "launch")
    timed = frame[frame["seconds_median"].notna()]
    return scatters(list_launched(records(timed, (*columns, "status", "seconds_median", "delay_seconds"))))


def rank_methods(equal: pd.DataFrame, scatter: Scatter) -> pd.DataFrame:
    """The rows with the columns `ratio`, `low`, `high`, `state` and `cell`.

    `ratio`: the time over the least of the cell, between `low` and `high` with 95 % confidence, which the choice of the
    fastest widens. `state`: "fastest", "slower", "equal" or "open", see `time_ratios`. `cell`: its kind.
    """
    table = equal.reset_index(drop=True)
    places = [at.tolist() for at in table.groupby([*PROBLEM, "target"]).indices.values()]
    timed = _list_times(table)
    judged = judge([[timed[place] for place in at] for at in places], scatter)
    ranks: list[tuple[float, float, float, str, str]] = [(math.nan, math.nan, math.nan, "", "")] * len(table)
    for at, (rows, states_, kind) in zip(places, judged, strict=True):
        for place, row, of in zip(at, rows, states_, strict=True):
            ranks[place] = row.ratio, row.low, row.high, of, kind
    return _with(table, ranks, ("ratio", "low", "high", "state", "cell"))


def _list_times(table: pd.DataFrame) -> list[Timed]:
    return [Timed(*row) for row in zip(table["integrator_id"], table["times"], strict=True)]


def _with(table: pd.DataFrame, rows: Sequence[tuple[Any, ...]], names: Sequence[str]) -> pd.DataFrame:
    """The table with these columns, which `rows` has in its order."""
    columns = zip(*rows, strict=True) if rows else ((),) * len(names)
    texts = {"state", "cell", "against_state"}
    return table.assign(
        **{
            name: pd.Series(list(column), index=table.index, dtype=object if name in texts else float)
            for name, column in zip(names, columns, strict=True)
        }
    )


def rank_by_counts(equal: pd.DataFrame, scatter: Scatter | None = None) -> pd.DataFrame:
    """The rows with the columns of `rank_methods`, ranked by the evaluations of the equations; rows without a count are left out.

    Counts do not differ between launches, so they have no interval; two counts within the factor SAME_COUNT are equal.
    """
    table = equal[equal["calls"] > 0].reset_index(drop=True)
    cells = table.groupby([*PROBLEM, "target"])["calls"]
    ratio = table["calls"] / cells.transform("min")
    of = np.select([ratio == 1, ratio <= SAME_COUNT], [FASTEST, EQUAL], SLOWER).astype(object)
    alone = cells.transform("size") == 1
    return table.assign(ratio=ratio, low=ratio, high=ratio, state=of, cell=np.where(alone, ALONE, ANSWERED))


def divisions(
    equal: pd.DataFrame, scatter: Mapping[str, Scatter], rank: Callable[..., pd.DataFrame] = rank_methods
) -> pd.DataFrame:
    """The rows, third parties first, each ranked by `rank` among the rows of its `division`.

    `against` is a ratio for rows of other divisions: their time (by `rank_by_counts`, their evaluations) over the least of
    third parties at this problem and error. `against_low`, `against_high` and `against_state` are as in `rank_methods`. They
    are nan and "" for third parties, and if no third party reaches the error.
    """
    of = equal["library"].map(division)
    parts = [
        rank(equal[of == name], scatter[name]).assign(division=name)
        for name in (THIRD, YOURS, OWN)
        if (of == name).any()
    ]
    table = pd.concat(parts, ignore_index=True) if parts else rank(equal, scatter[OWN]).assign(division="")
    against = _against(table, scatter[OWN]) if rank is rank_methods else _compare_counts(table)
    return _with(table, against, ("against", "against_low", "against_high", "against_state"))


def one_more_period(equal: pd.DataFrame, scatter: Mapping[str, Scatter]) -> pd.DataFrame:
    """`divisions` by the time of one more pass over the span, where it was measured: see `analysis.one_more_period`."""
    wider = {name: spread.scaled(MORE_SCATTER) for name, spread in scatter.items()}
    return divisions(analysis.one_more_period(equal), wider)


def _against(table: pd.DataFrame, scatter: Scatter) -> list[tuple[float, float, float, str]]:
    """Each row of another division against the fastest third party of its cell."""
    timed, kinds = _list_times(table), table["division"].tolist()
    against: list[tuple[float, float, float, str]] = [(math.nan, math.nan, math.nan, "")] * len(table)
    rows: list[tuple[int, Compared]] = []
    ratios = table["ratio"].tolist()
    for at in table.groupby([*PROBLEM, "target"]).indices.values():
        third = [place for place in at.tolist() if kinds[place] == THIRD]
        others = [place for place in at.tolist() if kinds[place] != THIRD]
        if third and others:
            best = min(third, key=lambda place: ratios[place])
            near = sum(ratios[place] < NEAR for place in third)  # any of them could have had the least time
            compared = compare([timed[place] for place in (best, *others)], scatter, 0, near)
            rows += zip(others, compared[1:], strict=True)
    for (place, row), holds in zip(rows, discoveries([row.p for _, row in rows]), strict=True):
        against[place] = row.ratio, row.low, row.high, _either(row, bool(holds))
    return against


def _either(row: Compared, claimed: bool) -> str:
    """The state of a row against the fastest third party; the row may also be the faster one."""
    of = state(row, claimed)
    return FASTEST if of == SLOWER and row.ratio < 1 else of


def _compare_counts(table: pd.DataFrame) -> list[tuple[float, float, float, str]]:
    """As `_against`, by counts."""
    least = table[table["division"] == THIRD].groupby([*PROBLEM, "target"])["calls"].min()
    keys = zip(*(table[name] for name in (*PROBLEM, "target")), strict=True)
    against = []
    for key, row in zip(keys, records(table, ("division", "calls")), strict=True):
        other = row["division"] != THIRD and key in least.index
        ratio = row["calls"] / float(least[key]) if other else math.nan
        is_equal = other and abs(math.log(ratio)) <= math.log(SAME_COUNT)
        of = "" if not other else EQUAL if is_equal else SLOWER if ratio > 1 else FASTEST
        against.append((ratio, ratio, ratio, of))
    return against


def _within(rows: pd.DataFrame, error: float) -> pd.Series:
    """Whether a setting is ok and has at most this error, or CONDITIONED times the conditioning if that is larger."""
    enough = np.maximum(error, CONDITIONED * rows["conditioning"].fillna(0.0))
    return (rows["status"] == Status.OK) & (rows["error_max"] <= enough)


def find_solved(reduced: pd.DataFrame) -> pd.DataFrame:
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
