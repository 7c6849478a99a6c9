"""The one way to run an integrator: prepare it, reset it, call it from copies of the starts, validate its solution, free it."""

import os
import warnings
from time import perf_counter_ns
from typing import Self

import numpy as np
from gnomon.harness.contract import validation
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solution, solver_of
from gnomon.harness.system.child_process import run_delays

RESOLUTION = 1e-9
"""Seconds: a call may take none on a coarse clock."""


class Prepared:
    """An integrator prepared for a problem at a setting. As a context manager it frees the solver at the end.

    `prepare_seconds` is the time of `prepare`; `solver` is its result. Passes on the exceptions of the integrator.
    """

    def __init__(self, integrator: Integrator, problem: Problem, setting: float) -> None:
        self.problem = problem
        began = perf_counter_ns()
        self.solver = solver_of(integrator, problem, setting)
        self.prepare_seconds = (perf_counter_ns() - began) * 1e-9

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.solver.close()

    def __call__(self, starts: Floats) -> Solution:
        """The solution from starts (n, dim), which stay as they are.

        Passes on the exceptions of the integrator, and raises Unusable for an answer that is not a valid Solution.
        """
        return self.given(starts.copy())

    def given(self, starts: Floats) -> Solution:
        """The solution from the array `starts` (n, dim) itself, which a faulty integrator may change."""
        if self.solver.reset is not None:
            self.solver.reset()
        with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore"):  # motions beyond a limit overflow
            answer = self.solver.solve(starts)
        return validation.check(answer, (len(starts), len(self.problem.times), self.problem.dimension))

    def counted(self, starts: Floats) -> tuple[Solution, int]:
        """The solution, and the number of its right-hand sides where the problem counts them, else 0."""
        before = self.problem.buffer[-1]
        return self(starts), validation.count(self.problem.buffer[-1] - before, "right-hand sides")

    def timed(self, start: Floats, keep: bool = True) -> "Call":
        """A timed call from one start (dim,); its states are validated and copied only if `keep`."""
        return Call(self, start, keep)


class Call:
    """One call of `solve` from one start, timed; its states are copied before anything can overwrite them.

    `delay_seconds`: how long the threads of this process, and of a program that it drives, were ready to run while other
    processes had the processor, summed over threads; None where the system does not tell. It is read outside of the timed
    interval. `solution` and its `states` (samples, dim) are there if the call is to `keep` them.
    """

    def __init__(self, prepared: Prepared, start: Floats, keep: bool) -> None:
        state, solver, problem = start[None].copy(), prepared.solver, prepared.problem
        solve, self.reset_seconds = solver.solve, None
        if solver.reset is not None:
            began = perf_counter_ns()
            solver.reset()
            self.reset_seconds = (perf_counter_ns() - began) * 1e-9
        process, before = os.getpid(), run_delays()
        began = perf_counter_ns()
        solution = solve(state)
        self.seconds = (perf_counter_ns() - began) * 1e-9
        if os.getpid() != process:
            os._exit(1)  # this process is a copy that the integrator forked: it would repeat the trial, and fork again
        self.delay_seconds = _find_wait(before, run_delays())
        if keep:
            self.solution = validation.check(solution, (1, len(problem.times), problem.dimension))
            self.states = self.solution.states[0]

    @property
    def waited(self) -> float:
        """The share of its time that it waited for a processor; 0 where that is not known."""
        return (self.delay_seconds or 0.0) / max(self.seconds, RESOLUTION)


def _find_wait(before: dict[str, int] | None, after: dict[str, int] | None) -> float | None:
    """The seconds between two readings; a thread that began in between has all of its own."""
    if before is None or after is None:
        return None
    return 1e-9 * sum(delay - before.get(thread, 0) for thread, delay in after.items())
