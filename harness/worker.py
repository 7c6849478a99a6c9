"""The child process of one series: prepares and times one trial after another, as the parent orders.

For each order the parent gets messages (stage, payload): `prepared` and `counted` around the counting run, `prepared`
and `ran` around the warm-up, then one of `done` (an Outcome) or `failed` (status, reason). The parent sets a deadline
for each stage and kills what passes it. Around what a call compiles, where a method turns to another one only once it
runs, stand `compiling` and `compiled`: that is none of the trial's time, and the call is made again.
"""

from __future__ import annotations

import gc
import os
import resource
import signal
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from time import perf_counter_ns
from typing import Any, TypeVar

import numpy as np
from gnomon.harness import compile as compiling
from gnomon.harness import registry
from gnomon.harness.integrator import Problem, Refused, Solution, Solve
from gnomon.harness.moved import moved_states, probe_state
from gnomon.harness.problem import accepted_form, groups_of
from gnomon.harness.processes import die_with_parent
from gnomon.harness.truth import CaseSpec
from numpy.typing import NDArray

Floats = NDArray[np.float64]
T = TypeVar("T")

MEMORY_BYTES = 16 * 2**30
"""The address space of a worker: far above any sound trial, compiled code and reservations of libraries included."""
FEWEST_CALLS = 3
"""Timed calls of a trial that is not slow, whatever the block allows: a median of fewer is at the mercy of one."""
_OUTPUT_BYTES = 4000


@dataclass(frozen=True)
class Task:
    """What a worker needs to know of a series. The integrator is named by (module, id); output goes to a file."""

    integrator: tuple[str, str]
    spec: CaseSpec
    times: Floats
    start: Floats
    sizes: Floats
    time_scale: float
    output: str


@dataclass(frozen=True)
class Order:
    """One trial: its setting, whether to count right-hand sides, how long and how often to time it, once where it is slow."""

    setting: float
    count: bool
    block_seconds: float
    repeats: int
    slow_seconds: float


@dataclass
class Outcome:
    """What a trial measured. `states` (64, dim_y) is the answer to the unmoved initial state."""

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


class _Failure(Exception):  # noqa: N818 (it names an outcome, like Refused)
    """A trial that has no outcome: (status, reason)."""


def serve(connection: Connection, task: Task) -> None:
    """The main function of the child: one Order after another, until the parent ends it."""
    die_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.setpgid(0, 0)  # a terminal's Ctrl-C would reach libraries that put in a handler of their own, as REBOUND does
    _redirect(task.output)
    _limit_resources()
    try:
        series = _Series(task, connection)
    except BaseException as error:
        connection.recv()
        connection.send(("failed", _named(error)))
        return
    gc.freeze()  # the collection before each timing then has only the trial's own objects to walk
    while True:
        order = connection.recv()
        try:
            message: tuple[str, Any] = ("done", series.run(order))
        except BaseException as error:  # even SystemExit: nothing that an integrator does may end the series unseen
            message = ("failed", _named(error))
        connection.send(message)


class _Series:
    """The state of a series: its problem and its supply of moved initial states."""

    compilations, calling = 0, False
    """How many there have been in this process, and whether a call is under way."""

    def __init__(self, task: Task, connection: Connection) -> None:
        self.task = task
        self.connection = connection
        self.integrator = registry.dereference(*task.integrator)
        self.case, self.formulation = task.spec.build()
        self.form = accepted_form(self.case, self.integrator.accepts, self.formulation)
        self.parameters = np.array([float(value) for value in self.case.parameter_values()])
        self.moved: Iterator[Floats] = moved_states(self.case, self.formulation, task.sizes)
        compiling.WATCHERS.append(self._compiling)

    def problem(self, counted: bool) -> Problem:
        """A new one for every preparation: what an integrator does to its arrays reaches nobody else."""
        return Problem(
            self.form,  # type: ignore[arg-type]  # the plan pairs only what is accepted
            len(self.task.start),
            self.parameters.copy(),
            self.task.times.copy(),
            self.task.time_scale,
            counted,
            groups_of(self.case, self.formulation),
        )

    def run(self, order: Order) -> Outcome:
        rhs_calls, counted_seconds, others = self._count(order.setting) if order.count else (None, 0.0, None)
        problem = self.problem(counted=False)
        began = perf_counter_ns()
        solve = self.integrator.prepare(problem, order.setting)
        prepare_seconds = (perf_counter_ns() - began) * 1e-9
        self._prepared(prepare_seconds)
        try:
            seconds = counted_seconds
            if others is None or (counted_seconds < order.slow_seconds and order.repeats > 1):
                warm = self._compiled(lambda: _Call(solve, next(self.moved), self.task))
                seconds, others = warm.seconds, warm.states
            self.connection.send(("ran", seconds))
            calls, scored, others = self._timed(solve, order, seconds, others)
            if others is not None and np.array_equal(scored.states, others) and np.all(np.isfinite(others)):
                self._suspect(solve, scored.states)
            if _unmoved(scored, self.task.start, rhs_calls):
                raise Refused(scored.solution.stopped or "returned the initial state without a step taken")
            settings = {str(k): str(v) for k, v in dict(getattr(solve, "settings", {})).items()}
        finally:
            close = getattr(solve, "close", None)
            if close is not None:
                close()
        resets = [call.reset_seconds for call in calls if call.reset_seconds is not None]
        return Outcome(
            scored.states,
            scored.solution.stopped,
            None if scored.solution.events is None else tuple((float(t), str(n)) for t, n in scored.solution.events),
            None if scored.solution.steps is None else int(scored.solution.steps),
            rhs_calls,
            tuple(call.seconds for call in calls),
            prepare_seconds,
            float(np.median(resets)) if resets else None,
            settings,
            _read_output(self.task.output),
        )

    def _prepared(self, seconds: float) -> None:
        """End a preparation. What a compiler leaves behind takes .1 s and more to walk, which is none of the trial's time."""
        gc.collect()
        gc.freeze()
        self.connection.send(("prepared", seconds))

    def _compiling(self, begins: bool) -> None:
        self.compilations += begins
        if self.calling:
            self.connection.send(("compiling" if begins else "compiled", None))

    def _compiled(self, call: Callable[[], T]) -> T:
        """What a call gives in which nothing is compiled any more; of one that always compiles what the third gives."""
        for _ in range(3):
            seen, self.calling = self.compilations, True
            try:
                found = call()
            finally:
                self.calling = False
            if self.compilations == seen:
                break
        return found

    def _count(self, setting: float) -> tuple[int | None, float, Floats | None]:
        """Right-hand sides, seconds and states of an untimed run through counting equations, from a moved state."""
        if not self.integrator.counts_rhs:
            return None, 0.0, None
        problem = self.problem(counted=True)
        solve = self.integrator.prepare(problem, setting)
        self._prepared(0.0)

        def counting() -> tuple[_Call, int]:
            before = problem.buffer[-1]
            call = _Call(solve, next(self.moved), self.task)
            return call, int(problem.buffer[-1] - before)

        call, counted = self._compiled(counting)
        close = getattr(solve, "close", None)
        if close is not None:
            close()
        self.connection.send(("counted", call.seconds))
        return counted, call.seconds, call.states

    def _timed(
        self, solve: Solve, order: Order, estimate: float, others: Floats | None
    ) -> tuple[list[_Call], _Call, Floats | None]:
        """The timed calls, the scored one among them, and the states of a call from another initial state.

        A call that is slow or not to be repeated is made once, unless it is much faster than one from another state
        was: then the method met this state before, at another setting, and the calls that count are made from new ones.
        """
        slow = estimate > order.slow_seconds or order.repeats == 1
        calls: list[_Call] = []
        gc.collect()
        gc.disable()
        try:
            if not slow:
                calls.append(_Call(solve, next(self.moved), self.task))
                others = calls[0].states
            scored = self._compiled(lambda: _Call(solve, self.task.start, self.task))
            calls.append(scored)
            spent = sum(call.seconds for call in calls)
            fewest = 1 if slow and scored.seconds > estimate / 2 else FEWEST_CALLS
            while len(calls) < fewest or (not slow and spent < order.block_seconds and len(calls) < order.repeats):
                calls.append(_Call(solve, next(self.moved), self.task, keep=False))
                spent += calls[-1].seconds
        finally:
            gc.enable()
        return calls, scored, others

    def _suspect(self, solve: Solve, states: Floats) -> None:
        """Equal answers from different initial states: rounding can do that to neighbours, but not this far apart."""
        far = _Call(solve, probe_state(self.case, self.formulation, self.task.sizes), self.task)
        if np.array_equal(far.states, states) and np.any(states != 0):
            raise Refused("returned the same states from different initial states: nothing was integrated")


class _Call:
    """One call of `solve`, timed; its states are copied before anything can overwrite them."""

    def __init__(self, solve: Solve, start: Floats, task: Task, keep: bool = True) -> None:
        state = start[np.newaxis].copy()
        reset = getattr(solve, "reset", None)
        self.reset_seconds: float | None = None
        if reset is not None:
            began = perf_counter_ns()
            reset()
            self.reset_seconds = (perf_counter_ns() - began) * 1e-9
        began = perf_counter_ns()
        solution = solve(state)
        self.seconds = (perf_counter_ns() - began) * 1e-9
        if not keep:
            return
        if not isinstance(solution, Solution):
            raise _Failure("crashed", f"solve returned {type(solution).__name__}, not a Solution")
        states = np.array(solution.states, dtype=np.float64)
        wanted = (1, len(task.times), len(start))
        if states.shape != wanted:
            raise _Failure("crashed", f"returned states of shape {states.shape}, not {wanted}")
        self.states = states[0]
        self.solution = solution


def _unmoved(call: _Call, start: Floats, rhs_calls: int | None) -> bool:
    """Whether the initial state came back, with no right-hand side and no step taken."""
    return not rhs_calls and not call.solution.steps and bool(np.all(call.states == start))


def _named(error: BaseException) -> tuple[str, str]:
    """(status, reason) of an exception."""
    if isinstance(error, _Failure):
        return error.args[0], error.args[1]
    if isinstance(error, Refused):
        return "refused", str(error) or "declined without a reason"
    if isinstance(error, ModuleNotFoundError):
        return "not_installed", str(error)
    text = str(error).strip().replace("\n", " ")
    return "crashed", f"{type(error).__name__}: {text[:300]}" if text else type(error).__name__


def _limit_resources() -> None:
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # writing out the heap of an aborted worker takes seconds
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    soft = MEMORY_BYTES if hard == resource.RLIM_INFINITY else min(MEMORY_BYTES, hard)
    resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _redirect(path: str) -> None:
    """What libraries print goes to a file, from which it reaches the record."""
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(descriptor, 1)
    os.dup2(descriptor, 2)
    os.close(descriptor)


def _read_output(path: str) -> str:
    """The end of what was printed since the last trial; the file is then empty."""
    sys.stdout.flush()
    sys.stderr.flush()
    return take_output(path)


def take_output(path: str) -> str:
    """The end of an output file as text, which is emptied."""
    with open(path, "r+b") as file:
        content = file.read()
        file.truncate(0)
    return content[-_OUTPUT_BYTES:].decode(errors="replace")
