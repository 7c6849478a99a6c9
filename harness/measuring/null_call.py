"""The null call of a series: the series' calls over almost no time span, without the work of steps.

It is the cost of a call apart from the integration: entering the library, allocating arrays, delivering samples, and
the 64 calls of a library that is called once for each sample. It is measured through `prepare` and `solve` only, on the
problem with its sample times multiplied by 2^-30. These calls still take steps, which cost time in every method: 64
steps if a method stops at each sample, one or a few if samples are interpolated.

A method of fixed steps is timed with one step and with two steps for each sample, and the difference, which is the time
of the steps, is subtracted here. An adaptive method crosses each interval in one step at any setting. Its work there is
counted instead, and `results.analysis` subtracts it at the cost that the series measured over the whole span.
"""

import contextlib
from collections.abc import Iterator
from dataclasses import replace
from typing import Protocol

import numpy as np
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Steps
from gnomon.harness.measuring.prepared import Prepared

SHRUNK = 2.0**-30
"""A power of two: the scaled times are exact, and multiples of their interval if the original times are."""
FEWEST, MOST, BLOCK_SECONDS = 5, 40, 0.002
"""Minimum and maximum number of timed calls, and seconds after which no further call is timed."""


class Problems(Protocol):
    """Makes a new problem at each call, whose equations count their calls or not."""

    def __call__(self, *, counted: bool) -> Problem: ...


def null_call(
    integrator: Integrator, problem: Problems, setting: float, starts: Iterator[Floats]
) -> tuple[float | None, int | None]:
    """Seconds of the null call, the median over calls from different `starts`, and the work in it.

    The work is the number of right-hand sides, or of steps if right-hand sides are not counted; 0 for fixed steps, None
    if unknown. Both results are None if the integrator fails.
    """

    def shrunk(counted: bool) -> Problem:
        whole = problem(counted=counted)
        return replace(whole, times=whole.times * SHRUNK)

    plain, fixed = shrunk(counted=False), isinstance(integrator.sweep, Steps)
    try:
        with contextlib.ExitStack() as opened:
            solvers = [
                opened.enter_context(Prepared(integrator, replace(plain, times=plain.times.copy()), each))
                for each in ((plain.interval, plain.interval / 2) if fixed else (setting,))
            ]
            steps = [solver.timed(next(starts)).solution.steps for solver in solvers][-1]
            rows: list[list[float]] = []
            while len(rows) < FEWEST or (len(rows) < MOST and float(np.sum(rows)) < BLOCK_SECONDS):
                rows.append([solver.timed(next(starts), keep=False).seconds for solver in solvers])
            once, *twice = np.median(np.array(rows), axis=0).tolist()
            if fixed:
                return max(2 * once - twice[0], 0.0), 0
            if not integrator.counts_rhs:
                return once, steps
            counted = opened.enter_context(Prepared(integrator, shrunk(counted=True), setting))
            return once, counted.counted(next(starts)[np.newaxis])[1]
    except MemoryError:
        raise
    except Exception:  # a failure on this artificial problem is not a result of the integrator
        return None, None
