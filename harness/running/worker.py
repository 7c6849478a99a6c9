"""The child process of one series: prepares and times one trial after another, as the parent orders.

For each order the parent gets messages (see `messages`): `prepared` and `counted` around the counting run, `prepared`
and `ran` around the warm-up, `turning` before each turned start, `null` before the null call, then one of `done` (an
Outcome) or `failed` (status, reason). The parent sets a deadline for each stage and kills what passes it. Around what a
call compiles, where a method turns to another one only once it runs, stand `compiling` and `compiled`: that is none of
the trial's time, and the call is made again.
"""

from __future__ import annotations

import contextlib
import errno
import gc
import os
import resource
import signal
import sys
import time
import traceback
import types
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from multiprocessing.connection import Connection
from time import perf_counter_ns
from typing import Any, TypeVar

import numpy as np
from gnomon.harness.contract import validation as answers
from gnomon.harness.contract.integrator import Problem, Refused, Solve
from gnomon.harness.contract.problem import accepted_form, groups_of
from gnomon.harness.contract.validation import TEXT, Unusable
from gnomon.harness.kernels import equations as compiling
from gnomon.harness.registry import lookup as registry
from gnomon.harness.running import messages
from gnomon.harness.running.messages import Garbled, Message
from gnomon.harness.running.null_call import null_seconds
from gnomon.harness.scoring.perturbed_starts import perturbed_states, probe_state
from gnomon.harness.scoring.reference_solution import CaseSpec
from gnomon.harness.system.child_process import adopt_orphans, end_children, guarded, leave_server
from gnomon.harness.system.memory import address_space_bytes
from numpy.typing import NDArray

Floats = NDArray[np.float64]
T = TypeVar("T")

CLOCKS = {
    name: getattr(time, name) for name in ("perf_counter_ns", "perf_counter", "monotonic", "process_time", "time")
}
"""The clocks as they were when this module was loaded, before any integrator of a user's own."""
FEWEST_CALLS = 3
"""Timed calls of a trial that is not slow, whatever the block allows: a median of fewer is at the mercy of one."""
COUNTING_ULPS = 1000
"""The unit of moves of the states that counting runs start from: timed calls, an ulp apart, do not come so far."""
_OUTPUT_BYTES = 4000


@dataclass(frozen=True)
class Task:
    """What a worker needs to know of a series. The integrator is named by (module, id); output goes to a file.

    `turned` (n, dim_y) are the turned starts of a case with a rotational symmetry.
    """

    integrator: tuple[str, str]
    spec: CaseSpec
    times: Floats
    start: Floats
    sizes: Floats
    time_scale: float
    turned: Floats
    output: str
    memory_bytes: int = 2**34
    """What the worker may take beyond what it starts with."""


@dataclass(frozen=True)
class Order:
    """One trial: its setting, whether to count right-hand sides, how long and how often to time it, once where it is slow.

    `turned`: whether to solve from the turned starts too; `null`: whether to time the null call of the series.
    """

    setting: float
    count: bool
    block_seconds: float
    repeats: int
    slow_seconds: float
    turned: bool = False
    null: bool = False
    place: int = 0
    """Where the setting stands in its sweep: the counting run of each starts from another state, the same in every run."""
    number: int = 0
    """What the answer to this order repeats, so that no other is taken for it."""


@dataclass
class Outcome:
    """What a trial measured. `states` (64, dim_y) is the answer to the unmoved initial state.

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

    def message(self, order: int) -> Message:
        """The outcome as the answer to an order."""
        content = asdict(self)
        arrays = {name: content.pop(name) for name in ("states", "turned")}
        return Message(order, "done", content, {name: array for name, array in arrays.items() if array is not None})

    @classmethod
    def of(cls, message: Message, task: Task) -> Outcome:
        """The outcome that a message holds; raises Garbled where it holds none that this task can have."""
        content, wanted = message.content, (len(task.times), len(task.start))
        states, turned = message.arrays.get("states"), message.arrays.get("turned")
        if states is None or states.shape != wanted or (turned is not None and turned.shape[1:] != wanted):
            raise Garbled("an answer without the states of its trial")
        seconds = content.get("seconds")
        if not isinstance(seconds, list) or not seconds:
            raise Garbled("an answer without times")
        times = tuple(messages.number({"seconds": each}, "seconds") for each in seconds)
        try:
            counts = {n: None if content[n] is None else answers.count(content[n], n) for n in ("steps", "rhs_calls")}
            maybe = {name: _optional(content[name], float) for name in ("reset_seconds", "null_seconds")}
            events = None if content["events"] is None else tuple((float(t), str(n)) for t, n in content["events"])
            return cls(
                states,
                _optional(content["stopped"], str),
                events,
                counts["steps"],
                counts["rhs_calls"],
                times,
                messages.number(content, "prepare_seconds"),
                maybe["reset_seconds"],
                {str(name): str(value) for name, value in dict(content["settings"]).items()},
                str(content["output"]),
                maybe["null_seconds"],
                turned,
            )
        except (KeyError, TypeError, ValueError, Unusable) as error:
            raise Garbled(f"an answer that cannot be read ({type(error).__name__})") from None


def _optional(value: Any, kind: type[T]) -> T | None:
    """The value where it is None or of this type; TypeError for another."""
    if value is not None and (not isinstance(value, kind) or isinstance(value, bool)):
        raise TypeError(f"{value!r} is no {kind.__name__}")
    return value


def serve(connection: Connection, task: Task) -> None:
    """The main function of the child: a guard, and below it the process that does the work."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _redirect(task.output)
    guarded(lambda: _work(connection, task))


def _work(connection: Connection, task: Task) -> None:
    """One Order after another, until the parent ends it; what an order leaves behind ends with it."""
    os.setpgid(0, 0)  # a terminal's Ctrl-C would reach libraries that put in a handler of their own, as REBOUND does
    adopt_orphans()
    leave_server(connection.fileno())
    _limit_resources(task.memory_bytes)
    say = _Speaker(connection, task.memory_bytes)
    try:
        series = _Series(task, say)
    except BaseException as error:
        say.order = connection.recv().number
        say.failed(error)
        return
    gc.freeze()  # the collection before each timing then has only the trial's own objects to walk
    while True:
        order = connection.recv()
        say.order = order.number
        failed: BaseException | None = None
        try:
            outcome = series.run(order)
        except BaseException as error:  # even SystemExit: nothing that an integrator does may end the series unseen
            failed = error
        say.stop_forks()
        end_children()
        if failed is not None:
            say.failed(failed)
        else:
            say.send(outcome.message(order.number))


class _Speaker:
    """Answers the order under way. A process that an integrator forked off this one says nothing: it is ended."""

    def __init__(self, connection: Connection, memory_bytes: int) -> None:
        self.order = 0
        self._memory_bytes = memory_bytes
        self._connection = connection
        self._process = os.getpid()

    def __call__(self, stage: str, **content: Any) -> None:
        self.send(Message(self.order, stage, content, {}))

    def failed(self, error: BaseException) -> None:
        status, reason = _named(error, self._memory_bytes)
        if status == "crashed" and not isinstance(error, Unusable):
            _print(error)
        self("failed", status=status, reason=reason)

    def stop_forks(self) -> None:
        """End this process if it is a copy of the worker."""
        if os.getpid() != self._process:
            os._exit(1)

    def send(self, message: Message) -> None:
        self.stop_forks()
        messages.send(self._connection.fileno(), message)


class _Series:
    """The state of a series: its problem and its supply of moved initial states."""

    compilations, calling = 0, False
    """How many there have been in this process, and whether a call is under way."""
    null: float | None = None
    """The seconds of the null call, once they are measured."""
    null_measured = False

    def __init__(self, task: Task, say: _Speaker) -> None:
        self.task = task
        self.say = say
        self.integrator = registry.dereference(*task.integrator)
        self.case, self.formulation = task.spec.build()
        self.form = accepted_form(self.case, self.integrator.accepts, self.formulation)
        self.parameters = np.array([float(value) for value in self.case.parameter_values()])
        self.moved: Iterator[Floats] = perturbed_states(self.case, self.formulation, task.sizes)
        self.counting = perturbed_states(self.case, self.formulation, task.sizes, COUNTING_ULPS)
        self.counting_starts: list[Floats] = []
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
        rhs_calls, counted_seconds, others = self._count(order) if order.count else (None, 0.0, None)
        problem = self.problem(counted=False)
        began = perf_counter_ns()
        solve = self.integrator.prepare(problem, order.setting)
        prepare_seconds = (perf_counter_ns() - began) * 1e-9
        self._prepared()
        try:
            seconds = counted_seconds
            if others is None or (counted_seconds < order.slow_seconds and order.repeats > 1):
                warm = self._compiled(lambda: _Call(solve, next(self.moved), self.task))
                seconds, others = warm.seconds, warm.states
            self.say("ran")
            calls, scored, others = self._timed(solve, order, seconds, others)
            _check_clocks()
            answers.possible(scored.solution.steps, scored.seconds, "steps")
            answers.possible(rhs_calls, max(counted_seconds, scored.seconds), "right-hand sides")
            if others is not None and np.array_equal(scored.states, others) and np.all(np.isfinite(others)):
                self._suspect(solve, scored.states)
            if _unmoved(scored, self.task.start, rhs_calls):
                raise Refused(scored.solution.stopped or "returned the initial state without a step taken")
            turned = self._turned(solve) if order.turned else None
            options = _options(solve)
        finally:
            close = getattr(solve, "close", None)
            if close is not None:
                close()
        if order.null and not self.null_measured:
            self.say("null")
            self.null_measured = True
            self.null = null_seconds(self.integrator, lambda: self.problem(False), order.setting, self.moved)
        resets = [call.reset_seconds for call in calls if call.reset_seconds is not None]
        return Outcome(
            scored.states,
            scored.solution.stopped,
            scored.solution.events,
            scored.solution.steps,
            rhs_calls,
            tuple(call.seconds for call in calls),
            prepare_seconds,
            float(np.median(resets)) if resets else None,
            options,
            _read_output(self.task.output),
            self.null,
            turned,
        )

    def _turned(self, solve: Solve) -> Floats:
        """The answers (n, 64, dim_y) to the turned starts, each by a call like the one that is timed."""
        found = []
        for start in self.task.turned:
            self.say("turning")
            found.append(_Call(solve, start, self.task).states)
        return np.array(found)

    def _prepared(self) -> None:
        """End a preparation. What a compiler leaves behind takes .1 s and more to walk, which is none of the trial's time."""
        gc.collect()
        gc.freeze()
        self.say("prepared")

    def _compiling(self, begins: bool) -> None:
        self.compilations += begins
        if self.calling:
            self.say("compiling" if begins else "compiled")

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

    def _count(self, order: Order) -> tuple[int | None, float, Floats | None]:
        """Right-hand sides, seconds and states of an untimed run through counting equations.

        From a moved state that belongs to the setting's place: a step control that starts an ulp elsewhere may take 2 %
        more right-hand sides, and how many states were used up before is a matter of the clock.
        """
        if not self.integrator.counts_rhs:
            return None, 0.0, None
        problem = self.problem(counted=True)
        solve = self.integrator.prepare(problem, order.setting)
        self._prepared()
        while len(self.counting_starts) <= order.place:
            self.counting_starts.append(next(self.counting))

        def counting() -> tuple[_Call, int]:
            before = problem.buffer[-1]
            call = _Call(solve, self.counting_starts[order.place], self.task)
            return call, answers.count(problem.buffer[-1] - before, "right-hand sides")

        call, counted = self._compiled(counting)
        close = getattr(solve, "close", None)
        if close is not None:
            close()
        self.say("counted")
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
                again = _Call(solve, next(self.moved), self.task, keep=slow)
                if slow:  # the answer of the counting run is of another preparation
                    others = again.states
                calls.append(again)
                spent += again.seconds
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
        process = os.getpid()
        began = perf_counter_ns()
        solution = solve(state)
        self.seconds = (perf_counter_ns() - began) * 1e-9
        if os.getpid() != process:
            os._exit(1)  # a copy that the integrator forked: it would go on with this trial, and fork again
        if not keep:
            return
        self.solution = answers.checked(solution, (1, len(task.times), len(start)))
        self.states = self.solution.states[0]


def _check_clocks() -> None:
    """Raise Unusable where an integrator replaced a clock: its times are none."""
    used = {"perf_counter_ns": perf_counter_ns}
    for name, clock in CLOCKS.items():
        if not (
            getattr(time, name, None) is clock is used.get(name, clock) and isinstance(clock, types.BuiltinFunctionType)
        ):
            raise Unusable(f"replaced time.{name}: what a changed clock says is no time")


def _unmoved(call: _Call, start: Floats, rhs_calls: int | None) -> bool:
    """Whether the initial state came back, with no right-hand side and no step taken."""
    return not rhs_calls and not call.solution.steps and bool(np.all(call.states == start))


def _options(solve: Solve) -> dict[str, str]:
    """The engine's options that differ from its defaults, as `solve` declares them."""
    given = getattr(solve, "options", {})
    if not isinstance(given, Mapping):
        raise Unusable(f"has options = {answers.short(given)}: they are a mapping of names to values")
    return {str(name): str(value) for name, value in given.items()}


def _print(error: BaseException) -> None:
    """Where an integrator raised, into the output of the trial: what the harness called it from is left out."""
    frames = error.__traceback__
    while frames is not None and frames.tb_frame.f_code.co_filename == __file__:
        frames = frames.tb_next
    with contextlib.suppress(Exception):  # an exception may raise where it is printed, and nothing may come of it
        print("".join(traceback.format_exception(type(error), error, frames)), file=sys.stderr, flush=True)


def _named(error: BaseException, memory_bytes: int) -> tuple[str, str]:
    """(status, reason) of an exception."""
    if isinstance(error, Unusable):
        return "crashed", str(error)
    if isinstance(error, Refused):
        return "refused", str(error) or "declined without a reason"
    if isinstance(error, ModuleNotFoundError):
        return "not_installed", str(error)
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        return "interrupted", f"the disk is full ({error.filename or error.strerror})"
    text = str(error).strip().replace("\n", " ")
    if isinstance(error, MemoryError):
        return "out_of_memory", f"needed more than {memory_bytes / 2**30:.3g} GiB ({text[:TEXT]})"
    return "crashed", f"{type(error).__name__}: {text[:TEXT]}" if text else type(error).__name__


def _limit_resources(memory_bytes: int) -> None:
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # writing out the heap of an aborted worker takes seconds
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    most = address_space_bytes() + memory_bytes
    soft = most if hard == resource.RLIM_INFINITY else min(most, hard)
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
