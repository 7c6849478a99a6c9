"""Runs an integrator on a problem of a panel, through its public contract only."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solution
from gnomon.harness.scoring.prepared import Prepared


def solved(integrator: Integrator, problem: Problem, setting: float, starts: Floats) -> Solution:
    """The solution from initial states (n, dim), by one `prepare` and one `solve`. Exceptions pass through."""
    with Prepared(integrator, problem, setting) as solver:
        return solver(starts)


def multiples(count: int, interval: float = 1.0) -> Floats:
    """`count` sample times, exact multiples of the interval."""
    return np.arange(1, count + 1, dtype=np.float64) * interval


def processor_seconds(run: Callable[[], object]) -> float:
    """Processor time of a call in this process."""
    began = time.process_time()
    run()
    return time.process_time() - began
