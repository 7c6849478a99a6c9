"""The table of a case: what each integrator takes to reach each error, in its division."""

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import pandas as pd
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.reporting.page.representing import label
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.reporting.tables import share_text
from gnomon.harness.results import contenders
from gnomon.harness.results.advice import engine_facts
from gnomon.harness.results.analysis import NEVER_RAN, PROBLEM, preparations, records
from gnomon.harness.results.contenders import ALONE, ANSWERED, OWN, THIRD, YOURS
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.number_text import ratio_text, time_text
from gnomon.harness.results.profiles import OURS
from gnomon.harness.results.time_ratios import EQUAL, FASTEST, OPEN
from markupsafe import escape

HEADS = {
    YOURS: "yours: × is over the least of a third party",
    THIRD: "third parties, ranked among themselves",
    OWN: "gnomon’s own: × is over the least of a third party",
}
WAYS = {
    "compiled": "equations compiled in",
    "direct": "calls compiled equations",
    "python": "calls Python",
    "own": "own equations",
    "engine": "engine, on a scene",
}
Tables = dict[str, dict[str, str]]
"""By case and problem, the body of its table as HTML."""


def way(name: str) -> str:
    """How an integrator evaluates the equations, which is part of its times, in words; "" for a user's own integrator."""
    library, _, method = name.partition(":")
    if library == OURS:
        return WAYS["compiled"]
    calls = WAYS.get(LIBRARIES[library].way(method), "") if library in LIBRARIES else ""
    return " · ".join(filter(None, (calls, engine_facts.python_texts().get(name))))


def case_tables(run: Run) -> Tables:
    """For every problem with an answer a table: yours first, then third parties, then gnomon's own methods."""
    by_axis = {axis: _by_key(rows) for axis, rows in (("time", run.equal), ("calls", run.counted))}
    ran = run.frame[~run.frame["status"].isin(NEVER_RAN)]
    preparing = preparations(ran).droplevel("library").to_dict()
    tables: Tables = {}
    for (case, variant, formulation), part in ran.groupby(PROBLEM, sort=False):
        label_ = (variant or "default") + (f" · {formulation}" if formulation else "")
        names = {
            row.integrator_id: contenders.division(row.library)
            for row in part.drop_duplicates("integrator_id").itertuples()
        }
        cells = {
            name: [
                [by_axis[axis].get((case, variant, formulation, name, target)) for axis in by_axis]
                for target in TARGETS
            ]
            for name in names
        }
        times = {name: preparing.get((case, variant, formulation, name), math.nan) for name in names}
        tables.setdefault(str(case), {})[label_] = "".join(_bodies(names, cells, times))
    return tables


def _by_key(rows: pd.DataFrame) -> dict[tuple[Any, ...], dict[str, Any]]:
    columns = (*PROBLEM, "integrator_id", "target")
    return {tuple(row[name] for name in columns): row for row in records(rows)}


def _bodies(names: Mapping[str, str], cells: Mapping[str, Any], times: Mapping[str, float]) -> Iterator[str]:
    """A body of the table for each division; the least time to 1e-6 is first."""
    for division, head in HEADS.items():
        members = [name for name, of in names.items() if of == division]
        if not members:
            continue
        yield f'<tbody class="{division}"><tr class="group"><th>{head}</th>'
        yield "".join(
            f"<th>{_kind(cells[name][k] for name in members) if division == THIRD else ''}</th>"
            for k in range(len(TARGETS))
        )
        yield "</tr>"
        for name in sorted(members, key=lambda name: _place(cells[name])):
            notes = [way(name), f"prepared in {time_text(times[name])}" if math.isfinite(times[name]) else ""]
            note = " · ".join(filter(None, notes))
            yield f"<tr><th>{escape(label(name))}<small>{escape(note)}</small></th>"
            yield "".join(_cell(*at) for at in cells[name])
            yield "</tr>"
        yield "</tbody>"


def _kind(column: Iterable[Any]) -> str:
    """Whether the cell of a column is open, or has one integrator alone; empty else, or if nobody reaches the error."""
    kinds = {str(time["cell"]) for time, _ in column if time is not None}
    return "".join(kinds - {ANSWERED})


def _place(cells: Any) -> tuple[float, ...]:
    seconds = [at["seconds"] if at is not None else math.inf for at, _ in cells]
    return (seconds[1], seconds[0], *seconds[2:])


def _cell(time: Mapping[str, Any] | None, calls: Mapping[str, Any] | None) -> str:
    if time is None:
        return '<td class="none">–</td>'
    bound = "≤ " if time["at_loosest"] else ""
    first = f'<b data-axis="time">{bound}{time_text(time["seconds"])}{_note(time)}</b>'
    number = "not counted" if calls is None else f"{bound}{calls['calls']:.0f}{_note({**calls, 'null_share': 0.0})}"
    best = ' class="best"' if time["cell"] != ALONE and time["state"] == FASTEST and time["division"] == THIRD else ""
    return f'<td{best}>{first}<b data-axis="calls">{number}</b></td>'


def _note(at: Mapping[str, Any]) -> str:
    """The comparison of a number with the least of third parties, and how much of a time is the null call."""
    words = []
    if at["division"] != THIRD:
        if math.isfinite(at["against"]):
            words.append(_factor(at["against"], at["against_low"], at["against_high"], at["against_state"]))
    elif at["state"] == FASTEST:
        words.append("alone" if at["cell"] == ALONE else "fastest")
    else:
        words.append(_factor(at["ratio"], at["low"], at["high"], at["state"]))
    if at["null_share"] >= SHOWN_SHARE:
        words.append(share_text(at["null_share"]))
    return f"<small>{' · '.join(words)}</small>" if words else ""


SHOWN_SHARE = 0.1
"""Share of the null call in a time from which it is written beside it."""


def _factor(ratio: float, low: float, high: float, state: str) -> str:
    """A factor with its interval, and its state where it is not clear from them."""
    interval = f" ({_ratio(low)} – {_ratio(high)})" if low < high else ""
    return f"{_ratio(ratio)} ×{interval}" + (f" {state}" if state in (EQUAL, OPEN) else "")


def _ratio(value: float) -> str:
    return ratio_text(value) if value >= 0.995 else f"{value:.2g}"
