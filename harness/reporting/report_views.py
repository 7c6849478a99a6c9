"""The tables that compare integrators, twice: with all of them, and without those of gnomon itself.

The page has a switch between the two. Without in-house integrators every ratio is to the fastest third-party one.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from gnomon.harness.reporting import findings, report_card, tables
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import rankings
from gnomon.harness.results.analysis import TARGETS
from gnomon.harness.results.profiles import OURS

ALL, OTHERS = "all", "others"


def views(
    run: Run, problems: Sequence[tuple[str, str]], growth: Mapping[str, Any] | None, orders: Mapping[str, Any] | None
) -> dict[str, dict[str, Any]]:
    """The tables by view. There is one view if all integrators, or none, are gnomon's own.

    `problems`: case and formulation of the rows of the table of cases; `growth` and `orders`: see `report_card.card`.
    """
    found = {ALL: _view(run, False, problems, growth, orders)}
    if run.equal["library"].eq(OURS).nunique() > 1:
        found[OTHERS] = _view(run, True, problems, None, None)
    return found


def _view(
    run: Run,
    third: bool,
    problems: Sequence[tuple[str, str]],
    growth: Mapping[str, Any] | None,
    orders: Mapping[str, Any] | None,
) -> dict[str, Any]:
    equal, changed = run.equal, run.changed
    matrix, trusted, slopes = run.matrix, run.trusted, run.orders
    if third:
        matrix, trusted, slopes = (table[table["library"] != OURS] for table in (matrix, trusted, slopes))
        equal, changed = rankings.third_party(equal), {key: rankings.without_ours(one) for key, one in changed.items()}
    kinds = report_card.kind_rows(equal, matrix, run.kinds)
    return {
        "findings": findings.findings(equal, run.policies, kinds, matrix, trusted, changed),
        "kinds": kinds,
        "lines": report_card.lines_of(kinds),
        "overall": tables.overall(equal),
        "card": report_card.card(equal, trusted, slopes, matrix, growth, orders),
        "fastest": tables.fastest(equal, problems),
        "libraries": tables.libraries(equal),
        "changes": _changes(equal, changed),
    }


def _changes(equal: pd.DataFrame, changed: rankings.Alternatives) -> list[dict[str, Any]]:
    """For each kind of change of the comparison: Kendall's tau at each error, and who is then fastest on most cases."""
    found = rankings.taus(rankings.comparison(equal), changed, TARGETS[:3])
    rows = []
    for change, part in found.groupby("change", sort=False):
        cells = [
            tables.Cell(f"{row['tau']:.2f}", row["worst"] if row["count"] > 1 else "")
            if pd.notna(row["tau"])
            else tables.Cell("–", kind="none")
            for row in part.to_dict("records")
        ]
        firsts = {rankings.winner(one.get(TARGETS[1], ())) for (kind, _), one in changed.items() if kind == change}
        rows.append({"head": change, "cells": cells, "first": ", ".join(sorted(filter(None, firsts))) or "–"})
    return rows
