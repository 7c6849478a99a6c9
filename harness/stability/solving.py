"""Runs an integrator on a problem of a panel, through its public contract only."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

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


@contextmanager
def within(seconds: float, error: BaseException) -> Iterator[None]:
    """Raise `error` in the block after `seconds` of processor time, as soon as Python code runs.

    Compiled code is not stopped. Outside the main thread, where no signal arrives, there is no limit.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(number: int, frame: FrameType | None) -> None:
        raise error

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
