"""What a trial measured, before it is scored: what the worker sends and the scorer takes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass
class Outcome:
    """What a trial measured. `states` (64, dim_y) is the answer to the unperturbed initial state.

    `turned` (n, 64, dim_y) are the answers to the turned starts, None where those were not asked for.
    """

    states: Floats
    stopped: str | None
    events: tuple[tuple[float, str], ...] | None
    steps: int | None
    rhs_calls: int | None
    seconds: tuple[float, ...]
    prepare_seconds: float
    reset_seconds: float | None
    settings: dict[str, str] = field(default_factory=dict)
    output: str = ""
    null_seconds: float | None = None
    turned: Floats | None = None
