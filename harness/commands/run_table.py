"""The table that `gnomon run` prints at its end: one row a series, or one an integrator if there are many series."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import CANNOT_RUN, NOT_BROKEN, SCORED, Status, is_from_outside
from gnomon.harness.results import summary
from gnomon.harness.results.best import bound_text, find_ways, is_below_reference
from gnomon.harness.results.number_text import error_text, problem_name, time_text
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

Row = Mapping[str, Any]
"""A measurement, as `reading.rows` gives it."""
MOST_SERIES = 40
"""With more series than these the table has one row an integrator, with medians over its series."""
REASON = 100
"""The number of characters of a reason that are shown."""
NAMED = 3
"""The largest number of trials that are named."""
NOTE = (
    "time to {:g}: of a solve at the loosest setting with at most this error, without preparation; least error: of all"
    " settings, with its time; \\[events]: the method with the location of events"
)


def run_table(rows: Sequence[Row], error: float | None = None) -> Table:
    """Least error, measured order, time and preparation time at that error, statuses, and the first setting that failed.

    With an `error` that is wanted on one problem also the time to it, and the fastest method first. A column is left out
    if it says nothing.
    """
    series = summary.series(rows)
    orders = summary.orders(series)
    many = len(series) > MOST_SERIES
    lines: dict[tuple[str, str], list[tuple[str, ...]]] = {}
    for key in series:
        *problem, _, name = key
        lines.setdefault((name, "" if many else problem_name(*problem)), []).append(key)
    problems = {where for _, where in lines}
    alone = escape(problems.pop()) if len(problems) == 1 and not many else None
    times = {} if error is None else {way.timed.integrator_id: way.cost.each for way in find_ways(rows, error)}
    table = Table(box=SIMPLE_HEAD, padding=(0, 1), title=alone, title_justify="left")
    table.caption, table.caption_justify = None if error is None else NOTE.format(error), "left"
    for head in ("integrator", *([] if alone else ["series" if many else "case"])):
        table.add_column(head, no_wrap=True)
    middle = (*(() if error is None else (f"time to {error:g}",)), "least error", *(("order",) if orders else ()))
    for head in (*middle, "its time", "preparation"):
        table.add_column(head, justify="right", no_wrap=True)
    for head in ("statuses", "first failure"):
        table.add_column(head)
    for name, where in sorted(lines, key=lambda line: times.get(line[0], math.inf)):
        keys = lines[name, where]
        own = [series[key] for key in keys]
        least, order, *rest = _numbers(own, [orders[key] for key in keys if key in orders])
        cells = [] if error is None else [time_text(times[name]) if name in times else "–"]
        cells += [least, *([order] if orders else []), *rest]
        if not alone:
            cells = [escape(where or str(len(keys))), *cells]
        table.add_row(escape(name), *cells, *_words([row for group in own for row in group]))
    return table


def _numbers(series: Sequence[Sequence[Row]], orders: Sequence[float]) -> tuple[str, str, str, str]:
    good = [[row for row in rows if row["status"] == Status.OK and row["error_max"] is not None] for rows in series]
    best = [min(rows, key=lambda row: row["error_max"]) for rows in good if rows]
    if not best:
        return "–", "–", "–", "–"
    columns = ([row[name] for row in best] for name in ("error_max", "seconds_median", "prepare_seconds"))
    error, seconds, prepare = (float(np.median(np.array(column, dtype=float))) for column in columns)
    order = f"{np.median(orders):.2f}" if orders else "–"
    hidden = len(best) == 1 and is_below_reference(best[0])
    least = bound_text(best[0]["floor"]) if hidden else error_text(error)
    return least, order, time_text(seconds), time_text(prepare)


def _words(rows: Sequence[Row]) -> tuple[str, str]:
    counts = ", ".join(f"{count} {status.replace('_', ' ')}" for status, count in statuses(rows))
    broken = [row for row in rows if row["status"] not in (*NOT_BROKEN, *CANNOT_RUN)]
    if not broken:
        return counts, ""
    first = broken[0]
    setting = "" if first["setting"] is None else f"{first['setting']:.3g}: "
    return counts, escape(f"{setting}{' '.join(first['reason'].split())}"[:REASON])


def statuses(rows: Iterable[Row]) -> list[tuple[str, int]]:
    """The statuses with their counts, the most frequent first."""
    return Counter(row["status"] for row in rows).most_common()


def shortcomings(rows: Sequence[Row], own: Sequence[Integrator]) -> list[str]:
    """The reasons why a run fails, a line each: nothing was measured, or a user's integrator never succeeded."""
    why = summary.nothing_ran((row["status"], row["reason"] or "") for row in rows)
    if why is not None:
        return [f"nothing ran ({why})"]
    if not any(row["status"] in SCORED for row in rows):
        counts = ", ".join(f"{n} {status}" for status, n in statuses(rows))
        return [f"nothing was measured: {counts}; see the reasons above"]
    reasons = []
    for integrator in own:
        ended = Counter((row["status"], row["reason"]) for row in rows if row["integrator_id"] == integrator.id)
        if not any(status == Status.OK for status, _ in ended):
            ((status, reason), _), *_ = ended.most_common(1) or [(("", ""), 0)]
            reasons.append(f"{integrator.id} never succeeded ({f'{status}: {reason}'[:REASON]})")
    return reasons


def list_interrupted(rows: Sequence[Row]) -> list[Row]:
    """The rows of interrupted launches that a repeated run would measure: no machine has measured them.

    Launches after the first repeat only trials that the first launch scored.
    """
    rest = [row for row in rows if row["status"] != Status.INTERRUPTED]
    measured = {_launch(row) for row in rest}
    scored = {_launch(row) for row in rest if row["launch"] == 1 and row["status"] in SCORED}
    return [
        row
        for row in rows
        if row["status"] == Status.INTERRUPTED
        and _launch(row) not in measured
        and (row["launch"] == 1 or (*_launch(row)[:2], 1) in scored)
    ]


def _launch(row: Row) -> tuple[Any, ...]:
    return row["series"], row["setting"], row["launch"]


def explain_outside_end(rows: Iterable[Row]) -> str | None:
    """A sentence that names trials which a cause outside the integrator may have ended; None if there are none."""
    ended = [row for row in rows if is_from_outside(row["status"], row["reason"])]
    if not ended:
        return None
    trials = {
        f"{row['series']} at {math.nan if row['setting'] is None else row['setting']:.3g}": row["status"]
        for row in ended
    }
    counts = ", ".join(f"{count} {status}" for status, count in Counter(trials.values()).most_common())
    more = f" and {len(trials) - NAMED} more" if len(trials) > NAMED else ""
    return f"a cause outside may have ended {len(trials)} trials ({counts}): {', '.join([*trials][:NAMED])}{more}"
