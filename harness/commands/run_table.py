"""The table that `gnomon run` prints at its end: one row a series, or one an integrator if there are many series."""

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import CANNOT_RUN, NOT_BROKEN, SCORED, Status, from_outside
from gnomon.harness.reporting.tables import error_text, problem_name, time_text
from gnomon.harness.results import analysis
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

MOST_SERIES = 40
"""With more series than these the table has one row an integrator, with medians over its series."""
REASON = 100
"""The number of characters of a reason that are shown."""
NAMED = 3
"""The largest number of trials that are named."""


def run_table(frame: pd.DataFrame) -> Table:
    """Error, measured order, time and preparation time at that error, statuses, and the first setting that failed.

    The error is the smallest of a series. `frame`: the rows of `store.load`.
    """
    reduced = analysis.settings(analysis.tidy(frame))
    reduced["where"] = [problem_name(*names) for names in reduced[["case", "variant", "formulation"]].to_numpy()]
    orders = analysis.orders(reduced)
    many = len(reduced.drop_duplicates(analysis.SERIES)) > MOST_SERIES
    table = Table(box=SIMPLE_HEAD, padding=(0, 1))
    for name in ("integrator", "series" if many else "case"):
        table.add_column(name, no_wrap=True)
    for name in ("error", "order", "time", "preparation"):
        table.add_column(name, justify="right", no_wrap=True)
    for name in ("statuses", "broke at"):
        table.add_column(name)
    for key, rows in reduced.groupby(["integrator_id"] if many else ["where", "integrator_id"], sort=False):
        own = orders[orders["integrator_id"] == key[-1]]
        if not many:
            own = own.merge(rows[analysis.SERIES].drop_duplicates(), on=analysis.SERIES)
        where = str(rows.groupby(analysis.SERIES).ngroups) if many else key[0]
        table.add_row(escape(key[-1]), escape(where), *_numbers(rows, own["order"].dropna()), *_words(rows))
    return table


def _numbers(rows: pd.DataFrame, orders: pd.Series) -> tuple[str, str, str, str]:
    good = rows[rows["status"] == Status.OK]
    if good.empty:
        return "–", "–", "–", "–"
    best = good.loc[good.groupby(analysis.SERIES)["error_max"].idxmin()]
    error, seconds, prepare = (float(np.median(best[c])) for c in ("error_max", "seconds_median", "prepare_seconds"))
    order = float(orders.median()) if len(orders) else math.nan
    return (error_text(error), f"{order:.2f}" if math.isfinite(order) else "–", time_text(seconds), time_text(prepare))


def _words(rows: pd.DataFrame) -> tuple[str, str]:
    counts = ", ".join(f"{count} {status.replace('_', ' ')}" for status, count in Counter(rows["status"]).most_common())
    broken = rows[~rows["status"].isin((*NOT_BROKEN, *CANNOT_RUN))]
    if broken.empty:
        return counts, ""
    first = broken.iloc[0]
    setting = f"{first['setting']:.3g}: " if math.isfinite(first["setting"]) else ""
    return counts, escape(f"{setting}{' '.join(str(first['reason']).split())}"[:REASON])


def shortcomings(frame: pd.DataFrame, own: Sequence[Integrator]) -> list[str]:
    """The reasons why a run fails, a line each: nothing was measured, or a user's integrator never succeeded."""
    why = analysis.nothing_ran(frame)
    if why is not None:
        return [f"nothing ran ({why})"]
    if not frame["status"].isin(SCORED).any():
        counts: Any = frame["status"].value_counts().items()
        return [f"nothing was measured: {', '.join(f'{n} {status}' for status, n in counts)}; see the reasons above"]
    found = []
    for one in own:
        rows = frame[frame["integrator_id"] == one.id]
        if not (rows["status"] == Status.OK).any():
            status, reason = rows[["status", "reason"]].value_counts(dropna=False).index[0] if len(rows) else ("", "")
            found.append(f"{one.id} never succeeded ({f'{status}: {reason}'[:REASON]})")
    return found


def interrupted(frame: pd.DataFrame) -> pd.DataFrame:
    """The rows of interrupted launches that a repeated run would measure: no machine has measured them.

    Launches after the first repeat only trials that the first launch scored.
    """
    place = ["series", "setting", "launch"]
    ended = frame[frame["status"] == Status.INTERRUPTED]
    rest = frame[frame["status"] != Status.INTERRUPTED]
    first = rest[(rest["launch"] == 1) & rest["status"].isin(SCORED)]
    measured, scored = (set(rows[place].itertuples(index=False, name=None)) for rows in (rest, first))
    wanted = [
        one not in measured and (one[2] == 1 or (*one[:2], 1) in scored)
        for one in ended[place].itertuples(index=False, name=None)
    ]
    return ended[np.array(wanted, dtype=bool)]


def ended_from_outside(frame: pd.DataFrame) -> str | None:
    """A sentence that names trials which a cause outside the integrator may have ended; None if there are none."""
    ended = [row for row in frame.itertuples() if from_outside(row.status, row.reason)]
    if not ended:
        return None
    found = {f"{row.series} at {row.setting:.3g}": row.status for row in ended}
    counts = ", ".join(f"{count} {status}" for status, count in Counter(found.values()).most_common())
    more = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return f"a cause outside may have ended {len(found)} trials ({counts}): {', '.join([*found][:NAMED])}{more}"
