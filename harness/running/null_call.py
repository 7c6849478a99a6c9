"""The null call of a series: the same calls, with next to nothing to integrate.

It tells what a call costs before and beside the integration: the way into the library, arrays made, samples delivered,
and, where the library is called once for each sample, those 64 calls. It is measured through `prepare` and `solve`
alone, on the problem with its sample times shrunk to 2^-30 of what they are, which every step control crosses at once:
so it includes the first step of an adaptive method, or one for each sample where the method stops at samples. A method
of fixed steps takes one for each sample too; there the time of two steps is measured as well, and what one step takes
is taken off again.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from time import perf_counter_ns
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Integrator, Problem, Solve, Steps
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SHRUNK = 2.0**-30
"""A power of two: shrunk times are exact, and multiples of their interval where the times were."""
FEWEST, MOST, BLOCK_SECONDS = 5, 40, 0.002
"""Calls that are timed: at least, at most, and for how long."""


def null_seconds(
    integrator: Integrator, problem: Callable[[], Problem], setting: float, starts: Iterator[Floats]
) -> float | None:
    """Seconds of the null call, the median over calls from ever new `starts`; None where the integrator fails on it."""
    shrunk = replace(problem(), times=problem().times * SHRUNK)
    settings = [setting]
    if isinstance(integrator.sweep, Steps):
        settings = [shrunk.interval, shrunk.interval / 2]
    solves: list[Solve] = []
    try:
        for each in settings:
            solves.append(integrator.prepare(replace(shrunk, times=shrunk.times.copy()), each))
            _seconds(solves[-1], next(starts))
        rows: list[list[float]] = []
        while len(rows) < FEWEST or (len(rows) < MOST and float(np.sum(rows)) < BLOCK_SECONDS):
            rows.append([_seconds(solve, next(starts)) for solve in solves])
    except MemoryError:
        raise
    except Exception:  # whatever it does on a problem that nobody asked it to solve is no result
        return None
    finally:
        for solve in solves:
            with contextlib.suppress(Exception):
                getattr(solve, "close", _nothing)()
    once, *twice = np.median(np.array(rows), axis=0).tolist()
    return max(2 * once - twice[0], 0.0) if twice else float(once)


def _nothing() -> None:
    pass


def _seconds(solve: Any, start: Floats) -> float:
    state = start[np.newaxis].copy()
    reset = getattr(solve, "reset", None)
    if reset is not None:
        reset()
    process = os.getpid()
    began = perf_counter_ns()
    solve(state)
    seconds = (perf_counter_ns() - began) * 1e-9
    if os.getpid() != process:
        os._exit(1)  # a copy that the integrator forked
    return seconds
