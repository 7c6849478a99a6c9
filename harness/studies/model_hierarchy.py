"""What each rung of a ladder of models is worth, and what it costs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd
from gnomon.cases.core.case import Case

COST_AT = 1e-6
"""The error at which the cost of a model is taken."""

NOT_RUN = {"ratio": math.nan, "integrators": 0, "fastest": "", "seconds": math.nan}


def worth(full: Case) -> list[dict[str, Any]]:
    """One row a rung, crudest first: the error of its exact motion, projected, against that of the full case.

    `error` is over the whole span, `early` over the first 2 pi characteristic times, about one period. `lacks` is the
    effect that the next rung adds: what a user does without who stops here.
    """
    levels = full.hierarchy
    if not levels:
        return []
    period = min(2 * math.pi * full.time_scale, float(full.times[-1]))
    early = np.asarray(np.arange(1, 65) * period / 64, dtype=np.float64)
    effects = [level.effect for level in levels[1:]] + ["the full model"]
    names = [level.case.name for level in levels]
    rows = []
    for place, (level, lacks) in enumerate(zip(levels, effects, strict=True)):
        again = f" ({names[: place + 1].count(level.case.name)})" if names.count(level.case.name) > 1 else ""
        row: dict[str, Any] = {"hierarchy": full.name, "model": level.case.name, "effect": level.effect, "lacks": lacks}
        row["label"] = level.case.name + again
        for name, times in (("error", full.times), ("early", early)):
            model = level.project(level.case.sample(times))
            row[name] = float(np.max(full.metric.distance(model, full.sample(times))))
        row["error"] = max(row["error"], row["early"])  # the first period is part of the span
        rows.append(row)
    return rows


def cost(full: str, model: str, equal: pd.DataFrame, reduced: pd.DataFrame) -> dict[str, Any]:
    """Time with the rung's model against time with the full one, over the integrators that reached 1e-6 on both.

    Times are taken on the two cases as the run has them, each for one of its own characteristic times, so that
    different spans compare. `ratio` is the median over integrators of model over full; nan where none ran both.
    """
    reference = reduced[reduced["variant"] == ""].groupby("case")[["span", "time_scale"]].first()
    at = equal[(equal["variant"] == "") & (equal["formulation"] == "") & np.isclose(equal["target"], COST_AT)]
    found = dict(NOT_RUN)
    if model not in reference.index or full not in reference.index:
        return found
    times = {}
    for name in (model, full):
        lengths = reference.loc[name, "span"] / reference.loc[name, "time_scale"]
        times[name] = at[at["case"] == name].set_index("integrator_id")["seconds"] / lengths
    ratios = (times[model] / times[full]).dropna()
    if len(times[model]):
        found |= {"fastest": str(times[model].idxmin()), "seconds": float(times[model].min())}
    if len(ratios):
        found |= {"ratio": float(ratios.median()), "integrators": len(ratios)}
    return found


def hierarchies(cases: Iterable[Case], equal: pd.DataFrame, reduced: pd.DataFrame) -> pd.DataFrame:
    """Worth and cost of every rung of the ladders of these cases; the full model is the last row of each."""
    rows = []
    for case in cases:
        found = worth(case)
        for row in found:
            # A rung that is the case itself with other numbers was not run with these.
            measured = {} if row["model"] == case.name else cost(case.name, row["model"], equal, reduced)
            rows.append(row | NOT_RUN | measured)
        if found:
            last: dict[str, Any] = {
                "hierarchy": case.name,
                "model": case.name,
                "label": case.name,
                "effect": "the full model",
            }
            last |= {"lacks": "", "error": 0.0, "early": 0.0}
            rows.append(last | cost(case.name, case.name, equal, reduced))
    return pd.DataFrame(rows)
