"""The scatter of launches, for simulations of the separation of two integrators; and rows of times that are ranked."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.results.rankings import ranked

MODES = 0.12
"""Launches of one program run in modes of 10 to 13 % apart."""


def measured(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Differences of the logarithms of two launches: within 1.2 times of each other in half of all pairs, within 1.8 in 90 %
    (the run of revision ec1a549248b9). Student's t with 3 degrees of freedom has these quantiles, 1.2 and 1.75."""
    return 0.238 * rng.standard_t(3, shape)


def modes(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Differences of launches in one of two modes each, with little noise within a mode."""
    return MODES * (rng.integers(0, 2, shape) - rng.integers(0, 2, shape)) + 0.005 * rng.standard_normal(shape)


def timed(rows: Sequence[Mapping[str, Any]], launches: int = 5) -> pd.DataFrame:
    """`ranked` of rows with a case, an integrator, its `seconds`, an error: each launch has these, within 2 %."""
    table = pd.DataFrame(rows).assign(variant="", formulation="", null_share=0.01, launches=launches)
    table["times"] = [{n: x * (1 + 0.01 * (n % 3 - 1)) for n in range(launches)} for x in table["seconds"]]
    return ranked(table)
