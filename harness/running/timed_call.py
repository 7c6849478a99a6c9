"""One timed call of `solve`, and its wait for a processor."""

import os
from time import perf_counter_ns

from gnomon.harness.contract import validation
from gnomon.harness.contract.integrator import Floats, Solver
from gnomon.harness.system.child_process import run_delays

RESOLUTION = 1e-9
"""Seconds: on a coarse clock a call may take no time."""


class Call:
    """One call of `solve`, timed; its states are copied before anything can overwrite them.

    `delay_seconds`: the time that the threads of this process, and of a program that it drives, were ready to run while
    other processes had the processor, summed over threads; None if the system does not tell. It is read outside of the
    timed interval. `shape`: the shape of the states.
    """

    def __init__(self, solver: Solver, start: Floats, shape: tuple[int, int], keep: bool = True) -> None:
        state = start[None].copy()
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
        self.delay_seconds = _waited(before, run_delays())
        if keep:
            self.solution = validation.checked(solution, (1, *shape))
            self.states = self.solution.states[0]

    @property
    def waited(self) -> float:
        """The share of its time that the call waited for a processor; 0 if unknown."""
        return (self.delay_seconds or 0.0) / max(self.seconds, RESOLUTION)


def _waited(before: dict[str, int] | None, after: dict[str, int] | None) -> float | None:
    """The seconds of waiting between two readings; for a thread that began in between, all of them."""
    if before is None or after is None:
        return None
    return 1e-9 * sum(delay - before.get(thread, 0) for thread, delay in after.items())
