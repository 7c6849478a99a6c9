"""Solutions of chaotic motions, judged against the conditioning along the way and not at the end.

Near the horizon, where the conditioning reaches 1, the errors of all methods are alike, and so is the largest of their errors.
The error over the conditioning at each sample says how far a method is from what rounding of the numbers allows there.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from gnomon.cases.core.case import Case
from gnomon.cases.core.registry import case_class, installed_names
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.measuring.score import CONDITIONED, Scorer
from gnomon.harness.results import reading
from gnomon.harness.studies.drift import rebuilt


@dataclass(frozen=True)
class Along:
    """`valid_time` (s): the last sample up to which no error is above ten times the conditioning; 0 if the first one is.

    `times_conditioning`: the largest error over the conditioning, of all samples.
    """

    valid_time: float
    times_conditioning: float


def along(scorer: Scorer, states: Floats) -> Along:
    """Sampled states (64, dim) of a case, judged along the way. The conditioning is the largest up to each sample."""
    reference = scorer.reference
    with np.errstate(all="ignore"):  # very large finite states overflow in the metric
        errors = scorer.metric.distance(states, reference.exact, reference.times)
    allowed = np.maximum.accumulate(np.maximum(reference.conditioning, reference.floor))
    ratios = np.where(np.isfinite(errors), errors, np.inf) / allowed
    lost = np.flatnonzero(ratios > CONDITIONED)
    kept = len(ratios) if len(lost) == 0 else int(lost[0])
    return Along(float(reference.times[kept - 1]) if kept else 0.0, float(np.max(ratios)))


def judged(path: Path) -> pd.DataFrame:
    """The measurements of chaotic cases in a results file: case, variant, integrator_id, order_declared, setting, work,
    error_max, horizon (s), valid_share of the horizon, times_conditioning, to_the_end (whether the last sample is valid)."""
    installed, scorers = set(installed_names()), dict[tuple[str, str, str], Scorer | None]()
    chosen: list[tuple[Scorer, dict[str, Any]]] = []
    for row in reading.rows(path):
        if row["case"] in installed and row["formulation"] == "standard" and _chaotic(case_class(row["case"])):
            key = row["case"], row["variant"], row["numbers"]
            if key not in scorers:
                scorers[key] = _scorer(row)
            scorer = scorers[key]
            if scorer is not None:
                chosen.append((scorer, row))
    states = reading.states(path, [row["measurement"] for _, row in chosen])
    kept = [(scorer, row, states.get(row["measurement"])) for scorer, row in chosen]
    return pd.DataFrame([_judged(scorer, row, found) for scorer, row, found in kept if found is not None])


def _chaotic(kind: type[Case]) -> bool:
    return kind.default_horizon is not None or any(variant.horizon is not None for variant in kind.variants)


def _judged(scorer: Scorer, row: dict[str, Any], states: Floats) -> dict[str, Any]:
    assert scorer.case.horizon is not None
    result, horizon = along(scorer, states), scorer.case.horizon
    kept = ("case", "variant", "integrator_id", "order_declared", "setting", "work", "error_max")
    return (
        {name: row[name] for name in kept}
        | {"horizon": horizon, "valid_share": result.valid_time / horizon}
        | {
            "times_conditioning": result.times_conditioning,
            "to_the_end": result.valid_time == scorer.reference.times[-1],
        }
    )


def _scorer(row: dict[str, Any]) -> Scorer | None:
    """The scorer of the case of a row; None if the case is not chaotic."""
    case = rebuilt(
        case_class(row["case"]),
        "" if row["variant"] == "default" else row["variant"],
        json.loads(row["numbers"]),
        float(row["span"]),
    )
    return None if case.horizon is None else Scorer.of(case)
