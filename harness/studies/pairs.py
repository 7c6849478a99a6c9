"""Times two integrators at equal error, in pairs in one process: the basis of claims of speed between them.

Each integrator runs at several tolerances and is scored as in a run. Its time at an error is interpolated between
neighbouring settings by the rule of the report's tables (`equal_error.time_at`), by which an error that is small by chance
does not count. Tighter settings that were timed count too, if they take less time. Calls of the two integrators
alternate, so that a slow phase of the machine affects both. Their null calls alternate with them; these are over almost
no span, with at most one step from sample to sample, and their time is the overhead of a call.
"""

import gc
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter_ns

import numpy as np
from gnomon.cases.core.case import Case
from gnomon.cases.core.formulation import Formulation
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solver
from gnomon.harness.contract.problem import find_accepted_form
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.results.equal_error import time_at

SHRUNK = 2.0**-40
"""Span of a null call over the span of the call: at most 1e-9 of a time scale. A power of two keeps times exact."""


@dataclass(frozen=True)
class Side:
    """One integrator of a pair: errors and solvers of its settings, loosest first, null call, preparation times."""

    errors: list[float]
    solvers: list[Solver]
    null: Solver
    prepares: list[float] = field(default_factory=list)

    def near(self, targets: Sequence[float]) -> list[int]:
        """Indices of the settings between which the times at these errors are interpolated."""
        indices: set[int] = set()
        for target in targets:
            # With the indices of the settings as times, the time at the target is its place between two settings.
            place, _ = time_at(self.errors, range(1, len(self.errors) + 1), target)
            if math.isfinite(place):
                indices |= {math.ceil(place) - 2, math.ceil(place) - 1}
        return sorted(indices - {-1})

    def time(self, known: dict[int, float], target: float) -> float | None:
        """Seconds at an error, from the seconds `known` by index of setting; None if no setting reaches the error."""
        seconds, _ = time_at(self.errors, [known.get(k, math.nan) for k in range(len(self.errors))], target)
        return seconds if math.isfinite(seconds) else None


def swept(
    integrator: Integrator, case: Case, formulation: Formulation | None, tolerances: Sequence[float]
) -> tuple[Side, Floats]:
    """(side of an integrator on a case of binary64 numbers, start (1, dim)).

    The side has each tolerance at which the integrator reaches the end of the span.
    """
    scorer = Scorer.of(case, formulation)
    problem = scorer.problem(find_accepted_form(case, integrator.accepts, formulation))
    start = scorer.reference.start[None]
    side = Side([], [], null_call(integrator, problem, tolerances[0]))
    for tolerance in tolerances:
        prepared = Prepared(integrator, problem, tolerance)
        side.prepares.append(prepared.prepare_seconds)
        solution = prepared(start)
        if solution.stopped is None:
            side.errors.append(scorer.largest_error(scorer.decoded(solution.states[0])))
            side.solvers.append(prepared.solver)
    return side, start


def null_call(integrator: Integrator, problem: Problem, tolerance: float) -> Solver:
    """The solver of the problem over almost no span."""
    return Prepared(integrator, replace(problem, times=problem.times * SHRUNK), tolerance).solver


def at_equal_error(
    pair: tuple[Side, Side], start: Floats, targets: Sequence[float], repeats: int
) -> tuple[list[tuple[float | None, float | None]], tuple[float, float]]:
    """Seconds of both sides at each target, None if a side does not reach it, and the seconds of their null calls."""
    chosen = [side.near(targets) for side in pair]
    solvers = [[*(side.solvers[k] for k in near), side.null] for side, near in zip(pair, chosen, strict=True)]
    times = time_interleaved(solvers, start, repeats)
    first, second = (
        [side.time(dict(zip(near, own[:-1], strict=True)), target) for target in targets]
        for side, near, own in zip(pair, chosen, times, strict=True)
    )
    return list(zip(first, second, strict=True)), (times[0][-1], times[1][-1])


def time_interleaved(sides: Sequence[Sequence[Solver]], start: Floats, repeats: int) -> list[list[float]]:
    """Median seconds of each solver; calls of the sides alternate, and the first call of each is not counted."""
    times: list[list[list[int]]] = [[[] for _ in side] for side in sides]
    gc.collect()
    gc.disable()
    try:
        for repeat in range(repeats + 1):
            for k in range(max(map(len, sides))):
                for side, side_times in zip(sides, times, strict=True):
                    if k < len(side):
                        own, solve = start.copy(), side[k].solve
                        begin = perf_counter_ns()
                        solve(own)
                        elapsed = perf_counter_ns() - begin
                        if repeat:
                            side_times[k].append(elapsed)
    finally:
        gc.enable()
    return [[float(np.median(t)) * 1e-9 for t in side] for side in times]
