"""Solutions of chaotic motions, judged against the conditioning along the way and not at the end.

Near the horizon, where the conditioning reaches 1, the errors of all methods are alike, and so is the largest of their errors.
The error over the conditioning at each sample says how far a method is from what rounding of the numbers allows there.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.measuring.score import CONDITIONED, Scorer
from gnomon.harness.studies.scored_states import read_scored_states


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
    valid = len(ratios) if len(lost) == 0 else int(lost[0])
    return Along(float(reference.times[valid - 1]) if valid else 0.0, float(np.max(ratios)))


def judge(path: Path) -> pd.DataFrame:
    """The measurements of chaotic cases in a results file: case, variant, integrator_id, order_declared, setting, work,
    error_max, horizon (s), valid_share of the horizon, times_conditioning, to_the_end (whether the last sample is valid)."""
    return pd.DataFrame([_judge(*scored) for scored in read_scored_states(path, lambda case: case.horizon is not None)])


def _judge(scorer: Scorer, row: dict[str, Any], states: Floats) -> dict[str, Any]:
    assert scorer.case.horizon is not None
    result, horizon = along(scorer, states), scorer.case.horizon
    names = ("case", "variant", "integrator_id", "order_declared", "setting", "work", "error_max")
    return (
        {name: row[name] for name in names}
        | {"horizon": horizon, "valid_share": result.valid_time / horizon}
        | {
            "times_conditioning": result.times_conditioning,
            "to_the_end": result.valid_time == scorer.reference.times[-1],
        }
    )
