"""The error and the computing time of each level of a model hierarchy."""

import json
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from gnomon.cases.core.case import Case
from gnomon.harness.measuring.reference_solution import PACK, CaseSpec
from gnomon.harness.results.analysis import own
from gnomon.harness.results.contenders import THIRD, division
from gnomon.reference.storage import diskcache
from gnomon.reference.storage.import_closure import closure

COST_AT = 1e-6
"""The error at which the times of models are compared."""

NO_COST = {"ratio": math.nan, "integrators": 0} | dict.fromkeys(("third", "fastest"), "")
NO_COST |= dict.fromkeys(("third_seconds", "seconds"), math.nan)
"""The columns of `cost` for a model that was not run."""


def model_errors(full: Case) -> list[dict[str, Any]]:
    """One row for each level, crudest first: the error of its exact motion, projected to the full case's coordinates.

    `error` is over the whole span, `early` over the first 2 pi characteristic times, about one period. `lacks` is the
    effect that the next level adds, and that this level neglects. The rows come with gnomon, and are kept on disk until a
    source of a level changes.
    """
    if not full.hierarchy:
        return []
    key = _key(full)
    return _model_errors(full) if key is None else list(diskcache.cached(key, lambda: _entry(full), PACK).notes)


def make_entry(full: Case) -> tuple[str, diskcache.Entry]:
    """The key and the content under which the rows of a case are kept. Raises ValueError without a key."""
    key = _key(full)
    if key is None:
        raise ValueError(f"{full.name} has no source in a file")
    return key, diskcache.load(key) or _entry(full)


def _entry(full: Case) -> diskcache.Entry:
    return diskcache.Entry(notes=_model_errors(full))


def _key(full: Case) -> str | None:
    """The key of the rows on disk; None if a source is not in a file, or was edited after it was loaded."""
    modules = sorted({type(case).__module__ for case in (full, *(level.case for level in full.hierarchy))})
    code, own = closure(*modules), closure(__name__, within=())
    if code is None or own is None:
        return None
    spec = CaseSpec.of(full)
    numbers = json.dumps([getattr(spec, name) for name in spec.__dataclass_fields__])
    return f"model hierarchy 1\n{code}{own}\n{numbers}"


def _model_errors(full: Case) -> list[dict[str, Any]]:
    levels = full.hierarchy
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


def times_of(equal: pd.DataFrame, reduced: pd.DataFrame) -> dict[str, pd.Series]:
    """By case the times to an error of 1e-6 for one characteristic time, by integrator and machine."""
    spans = reduced[reduced["variant"] == ""].groupby("case")[["span", "time_scale"]].first()
    lengths = spans["span"] / spans["time_scale"]
    at = own(equal[np.isclose(equal["target"], COST_AT)])
    by_machine = at.set_index(["integrator_id", "machine"])
    rows = dict(list(by_machine.groupby("case")["seconds"]))
    return {str(name): rows.get(name, by_machine["seconds"][:0]) / length for name, length in lengths.items()}


def cost(full: str, model: str, times: Mapping[str, pd.Series]) -> dict[str, Any]:
    """The computing time of a level's model and its ratio to the full model, at an error of 1e-6.

    `seconds` is the least time of the model, by the integrator `fastest`; `third_seconds` and `third` are those of third
    parties. `ratio` is the median of model over full for the `integrators` that reached the error on both, on one
    machine; nan without any. `times`: see `times_of`.
    """
    row: dict[str, Any] = dict(NO_COST)
    if model not in times or full not in times:
        return row
    ratios = (times[model] / times[full]).dropna()
    names = times[model].index.get_level_values("integrator_id")
    third = times[model][[division(name.partition(":")[0]) == THIRD for name in names]]
    for key, part in (("fastest", times[model]), ("third", third)):
        if len(part):
            row |= {key: str(part.idxmin()[0]), "third_seconds" if key == "third" else "seconds": float(part.min())}
    if len(ratios):
        row |= {"ratio": float(ratios.median()), "integrators": len(ratios)}
    return row


def hierarchies(cases: Iterable[Case], equal: pd.DataFrame, reduced: pd.DataFrame) -> pd.DataFrame:
    """Error and cost of every level of the model hierarchies of these cases; the full model is the last row of each."""
    rows, times = [], times_of(equal, reduced)
    for case in cases:
        levels = model_errors(case)
        for row in levels:
            # A level that is the case itself with other parameters was not run with these parameters.
            measured = {} if row["model"] == case.name else cost(case.name, row["model"], times)
            rows.append(row | NO_COST | measured)
        if levels:
            last: dict[str, Any] = dict.fromkeys(("hierarchy", "model", "label"), case.name)
            last |= {"effect": "the full model", "lacks": "", "error": 0.0, "early": 0.0}
            rows.append(last | cost(case.name, case.name, times))
    return pd.DataFrame(rows)
