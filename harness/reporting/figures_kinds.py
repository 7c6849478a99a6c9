"""Small multiples: a row for each integrator, a column for each kind of system, how far its times are from the fastest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import altair as alt
import numpy as np
import pandas as pd
from gnomon.harness.contract.status import CANNOT_RUN
from gnomon.harness.reporting.report_stability import intervals
from gnomon.harness.results.rankings import MOST, third_party

TARGET, WIDTH = 1e-6, 104


def kinds_charts(
    equal: pd.DataFrame, matrix: pd.DataFrame, members: Mapping[str, Sequence[str]]
) -> dict[str, alt.TopLevelMixin]:
    """By name: `kinds`, and `kinds_others` without in-house methods; empty if nothing reaches the error.

    `equal`: `analysis.equal_error`, `matrix`: `analysis.status_matrix`, `members`: the cases of each kind.
    """
    charts = {}
    for name, rows in (("kinds", equal), ("kinds_others", third_party(equal))):
        tried = matrix if name == "kinds" else matrix[matrix["library"].isin(set(rows["library"]))]
        marks = kind_marks(rows, tried, members)
        columns = [
            {"id": kind, "title": kind.partition(":")[0], "decades": True, "ends": (1.0, MOST)}
            for kind in members
            if any(mark["column"] == kind for mark in marks)
        ]
        if columns:
            charts[name] = intervals(columns, marks, WIDTH)
    return charts


def kind_marks(equal: pd.DataFrame, matrix: pd.DataFrame, members: Mapping[str, Sequence[str]]) -> list[dict[str, Any]]:
    """For each integrator and kind: the median, least and largest ratio of its time to the fastest's at 1e-6, over the
    default cases that it reaches, and of how many that it can run; no mark where it can run none."""
    kind_of = {case: kind for kind, cases in members.items() for case in cases}
    own = equal[(equal["variant"] == "") & (equal["formulation"] == "") & (equal["target"] == TARGET)]
    tried = matrix[(matrix["variant"] == "") & (matrix["formulation"] == "") & ~matrix["verdict"].isin(CANNOT_RUN)]
    cases = Counter(
        (name, kind_of[case])
        for name, case in zip(tried["integrator_id"], tried["case"], strict=True)
        if case in kind_of
    )
    ratios: dict[tuple[str, str], list[tuple[float, bool]]] = {}
    for name, case, ratio, tied in zip(*(own[key] for key in ("integrator_id", "case", "ratio", "tied")), strict=True):
        if case in kind_of:
            ratios.setdefault((name, kind_of[case]), []).append((float(ratio), bool(tied)))
    found = []
    for (name, kind), count in sorted(cases.items()):
        known = ratios.get((name, kind), [])
        values = [ratio for ratio, _ in known]
        mark = {"integrator": name, "column": kind, "at": None, "low": None, "high": None, "text": f"none of {count}"}
        if known:
            mark |= {"at": float(np.median(values)), "low": min(values), "high": max(values)}
            mark["text"] = (
                f"{mark['at']:.3g} times the fastest in the median of the {len(known)} of {count} cases on which it reaches"
                f" the error ({min(values):.3g} to {max(values):.3g}); fastest or on a par on {sum(tied for _, tied in known)}"
            )
        found.append(mark)
    return found
