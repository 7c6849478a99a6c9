"""The null call of a series: the same calls, over almost no time span.

It measures the cost of a call apart from the integration: entering the library, allocating arrays, delivering samples,
and, if the library is called once for each sample, those 64 calls. It is measured through `prepare` and `solve` only,
on the problem with its sample times multiplied by 2^-30, which every step control crosses in one step. It therefore
includes the first step of an adaptive method, or one step for each sample if the method stops at samples. A method of
fixed steps takes one step for each sample too; there the time with two steps is measured as well, and the difference,
which is the time of the steps, is subtracted.
"""

import contextlib
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from time import perf_counter_ns

import numpy as np
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solver, Steps, solver_of

SHRUNK = 2.0**-30
"""A power of two: the scaled times are exact, and multiples of their interval if the original times are."""
FEWEST, MOST, BLOCK_SECONDS = 5, 40, 0.002
"""Minimum and maximum number of timed calls, and seconds after which no further call is timed."""


def null_seconds(
    integrator: Integrator, problem: Callable[[], Problem], setting: float, starts: Iterator[Floats]
) -> float | None:
    """Seconds of the null call, the median over calls from different `starts`; None if the integrator fails on it."""
    shrunk = replace(problem(), times=problem().times * SHRUNK)
    settings = [setting]
    if isinstance(integrator.sweep, Steps):
        settings = [shrunk.interval, shrunk.interval / 2]
    solvers: list[Solver] = []
    try:
        for each in settings:
            solvers.append(solver_of(integrator, replace(shrunk, times=shrunk.times.copy()), each))
            _seconds(solvers[-1], next(starts))
        rows: list[list[float]] = []
        while len(rows) < FEWEST or (len(rows) < MOST and float(np.sum(rows)) < BLOCK_SECONDS):
            rows.append([_seconds(solver, next(starts)) for solver in solvers])
    except MemoryError:
        raise
    except Exception:  # a failure on this artificial problem is not a result of the integrator
        return None
    finally:
        for solver in solvers:
            with contextlib.suppress(Exception):
                solver.close()
    once, *twice = np.median(np.array(rows), axis=0).tolist()
    return max(2 * once - twice[0], 0.0) if twice else float(once)


def _seconds(solver: Solver, start: Floats) -> float:
    state, solve = start[np.newaxis].copy(), solver.solve
    if solver.reset is not None:
        solver.reset()
    process = os.getpid()
    began = perf_counter_ns()
    solve(state)
    seconds = (perf_counter_ns() - began) * 1e-9
    if os.getpid() != process:
        os._exit(1)  # this process is a copy that the integrator forked
    return seconds
