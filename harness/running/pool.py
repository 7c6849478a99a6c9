"""Runs series in child processes and kills a worker that passes its deadline; no failure of a worker ends the run."""

import contextlib
import math
import os
import signal
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection, wait
from pathlib import Path
from time import monotonic  # a user's own module may replace `time.monotonic`
from typing import Any, Protocol

from gnomon.harness.contract.status import Status
from gnomon.harness.results.values import TRIES
from gnomon.harness.running.messages import Garbled, Inbox, Message
from gnomon.harness.running.progress import Interlude
from gnomon.harness.running.worker import (
    FLOODED,
    MOST_PRINTED,
    Request,
    Task,
    outcome_of,
    printed_bytes,
    serve,
    take_output,
)
from gnomon.harness.scoring.outcome import Outcome
from gnomon.harness.system.child_process import context, main_hidden, queued_seconds, server_failure_named
from gnomon.harness.system.locks import temporary_folder
from gnomon.harness.system.memory import worker_bytes

PREPARE_SECONDS = 60.0
"""The deadline of one preparation: compiling with cold caches on a busy machine takes several seconds."""
GRACE_SECONDS = 0.15
"""Seconds beyond the trial's limit before a worker is killed, for the start of the call, its message and scheduling."""
QUEUED_SECONDS = 0.001
"""If a worker waited longer than this for the processor, its deadline is extended by the wait."""
LOOK_SECONDS = 0.1
"""Longest time between two comparisons of the workers' output with the size that they may print."""
RETRY_SECONDS = 0.5
"""Trials with a limit below this are tried TRIES times: a stall of the machine, up to 0.2 s, is not a timeout."""


ANSWERS = (Status.REFUSED, Status.UNSUPPORTED)
"""Failures that an integrator states itself: the series continues in the same worker."""
FAILURES = (*ANSWERS, Status.CRASHED, Status.NOT_INSTALLED, Status.OUT_OF_MEMORY, Status.INTERRUPTED)
"""Statuses that a worker may send instead of an outcome. After all but ANSWERS the series continues in a new worker."""


LOST = 255
"""The exit code reported for a worker if its fork server is gone; the worker's own exit code is then unknown."""
OUTSIDE = tuple(
    -number for number in signal.Signals if number.name in ("SIGKILL", "SIGTERM", "SIGHUP", "SIGINT", "SIGQUIT")
)
"""Exit codes of processes ended from outside: by a user, a scheduler, or the kernel when memory runs out."""
ENDING_SECONDS = 5.0
"""Seconds in which a guard must end its worker and the worker's child processes, before the guard itself is killed."""


class Job(Protocol):
    """One launch of one series, in the form that the pool needs."""

    task: Task
    limit_seconds: float

    def next(self) -> Request | None:
        """The request for the next trial, or None if the series is finished."""

    def done(self, outcome: Outcome) -> None:
        """Record the outcome of the last request."""

    def failed(self, status: Status, reason: str, output: str, tries: int | None = None) -> None:
        """Record the failure of the last request; `tries` is the number of attempts before a timeout."""


@dataclass
class _Slot:
    """A worker process and the job that it works on."""

    job: Job
    process: Any
    connection: Connection
    request: Request
    deadline: float
    stage: str = "prepare"
    seconds: float = 0.0
    queued: float = 0.0
    """Seconds that its process had waited for the processor when the deadline was set."""
    interrupted: tuple[str, float] | None = None
    """The stage that a compilation interrupted, and the time limit of that stage in seconds."""
    again: bool = False
    """Whether the request is repeated because the fork server was lost."""
    tries: int = 1
    """The number of attempts at this request, the current one included."""
    held: bool = False
    """Whether the request is held back until an interlude has ended; the worker waits for it."""
    inbox: Inbox = field(default_factory=Inbox)


class Pool:
    """Runs jobs in `workers` child processes at a time. `method`: their start method, see `system.child_process`.

    Each process may allocate `memory` bytes, at most its share of the machine's memory.
    """

    def __init__(
        self,
        workers: int = 2,
        method: str = "forkserver",
        prepare_seconds: float = PREPARE_SECONDS,
        memory: float = math.inf,
    ) -> None:
        self.workers = workers
        self.memory = memory
        self.prepare_seconds = prepare_seconds
        self._context = context(method)
        self._folder = tempfile.TemporaryDirectory(dir=temporary_folder())
        self._slots: list[_Slot] = []
        self._started = 0
        self._requested = 0
        self._dying: list[Any] = []
        self._pausing = False

    def run(self, jobs: Iterable[Job | None], interlude: Interlude | None = None) -> None:
        """Run all jobs; at None the next job waits for one that is under way.

        After an exception, also Ctrl-C, the workers are killed and the exception is raised. If the `interlude` is due,
        no further request is sent until all workers have answered and its work is done.
        """
        waiting = iter(jobs)
        exhausted = False
        try:
            while True:
                self._pausing = self._pausing or (interlude is not None and interlude.due())
                if interlude is not None and self._pausing and all(slot.held for slot in self._slots):
                    interlude.take()
                    self._resume()
                while not (exhausted or self._pausing) and len(self._slots) < self.workers:
                    try:
                        job = next(waiting)
                    except StopIteration:
                        exhausted = True
                        break
                    if job is None:
                        break
                    self._start(job)
                if not self._slots:
                    return
                self._listen()
        finally:
            for slot in list(self._slots):
                self._end(slot)
            for process in self._dying:
                process.join(ENDING_SECONDS)
                if process.is_alive():
                    process.kill()
                    process.join()
            self._folder.cleanup()

    def _start(self, job: Job) -> None:
        """Start a worker for the next request of a job, if there is one."""
        request = job.next()
        if request is not None:
            self._launch(job, request)

    def _launch(self, job: Job, request: Request, again: bool = False, tries: int = 1) -> None:
        self._started += 1
        path = Path(self._folder.name) / str(self._started)
        path.touch()
        job.task = replace(job.task, output=str(path), memory_bytes=int(min(worker_bytes(self.workers), self.memory)))
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=serve, args=(theirs, job.task), daemon=True)
        with main_hidden(not job.task.spec.in_main), server_failure_named():
            process.start()
        theirs.close()
        slot = _Slot(job, process, ours, request, 0.0, again=again, tries=tries)
        self._slots.append(slot)
        self._send(slot, request)

    def _send(self, slot: _Slot, request: Request) -> None:
        self._requested += 1
        slot.request = replace(request, number=self._requested)
        slot.held = self._pausing
        if slot.held:
            slot.deadline = math.inf
            return
        self._stage(slot, "prepare", self.prepare_seconds)
        with contextlib.suppress(OSError):  # the worker died between two requests: _listen sees the end of its pipe
            slot.connection.send(slot.request)

    def _resume(self) -> None:
        """Send the requests that were held."""
        self._pausing = False
        for slot in self._slots:
            self._send(slot, slot.request)

    def _stage(self, slot: _Slot, stage: str, seconds: float) -> None:
        slot.stage, slot.seconds, slot.deadline = stage, seconds, monotonic() + seconds
        slot.queued = queued_seconds(slot.process.pid)

    def _listen(self) -> None:
        """Wait for messages until the nearest deadline, at most LOOK_SECONDS; read all before comparing deadlines."""
        timeout = min(LOOK_SECONDS, max(0.0, min(slot.deadline for slot in self._slots) - monotonic()))
        wait([slot.connection for slot in self._slots], timeout)
        for slot in list(self._slots):
            self._drain(slot)
        now = monotonic()
        for slot in list(self._slots):
            if printed_bytes(slot.job.task.output) > MOST_PRINTED:
                self._fail(slot, Status.CRASHED, FLOODED)
            elif now > slot.deadline and not slot.connection.poll():
                self._late(slot)

    def _late(self, slot: _Slot) -> None:
        """Handle a passed deadline: extend it by waits for the processor, retry the request, or record a timeout."""
        limit = slot.job.limit_seconds
        waited = queued_seconds(slot.process.pid) - slot.queued
        if waited > QUEUED_SECONDS:
            slot.deadline += waited
            slot.queued += waited
            return
        if slot.stage == "prepare":
            self._fail(slot, Status.TIMEOUT, f"not prepared within {self.prepare_seconds:g} s")
        elif slot.tries >= TRIES or limit >= RETRY_SECONDS:
            self._fail(slot, Status.TIMEOUT, f"no answer within {limit:g} s")
        else:
            self._end(slot)
            self._launch(slot.job, slot.request, again=slot.again, tries=slot.tries + 1)

    def _drain(self, slot: _Slot) -> None:
        try:
            while slot.connection.poll():
                piece = os.read(slot.connection.fileno(), 2**20)
                if not piece:
                    raise EOFError
                for message in slot.inbox.take(piece):
                    # another number: an earlier request answered by a process that the integrator left running
                    if message.request == slot.request.number and not self._handle(slot, message):
                        return
        except (EOFError, OSError):
            slot.process.join()
            self._died(slot)
        except Garbled as error:
            self._fail(slot, Status.CRASHED, f"its process sent {error}")

    def _died(self, slot: _Slot) -> None:
        """The worker ended by itself, by a signal from outside, or because the fork server was lost."""
        code = slot.process.exitcode
        if code == LOST and not slot.again:
            self._end(slot)
            self._launch(slot.job, slot.request, again=True, tries=slot.tries)
        elif code == LOST:
            self._fail(slot, Status.INTERRUPTED, "the server of the worker processes was lost, twice")
        else:
            self._fail(slot, Status.INTERRUPTED if code in OUTSIDE else Status.CRASHED, _death(code))

    def _handle(self, slot: _Slot, message: Message) -> bool:
        """Act on one message; returns False if the slot is no longer in use."""
        stage = message.stage
        limit = slot.job.limit_seconds
        if stage in ("prepared", "calling"):
            self._stage(slot, "run", limit + GRACE_SECONDS)
            return True
        if stage in ("counted", "extra"):
            self._stage(slot, "prepare", self.prepare_seconds)
            return True
        if stage == "compiling":
            if slot.stage != "prepare":  # in nested compilations the outermost one has the interrupted stage
                slot.interrupted = (slot.stage, slot.seconds)
            self._stage(slot, "prepare", self.prepare_seconds)
            return True
        if stage == "compiled" and slot.interrupted is not None:
            self._stage(slot, *slot.interrupted)
            return True
        if stage == "failed":
            word, reason = str(message.content.get("status")), str(message.content.get("reason"))
            if word not in FAILURES:
                raise Garbled(f"the status {word!r}")
            status = Status(word)
            if status not in ANSWERS:
                self._fail(slot, status, reason)
                return False
            slot.job.failed(status, reason, take_output(slot.job.task.output))
        elif stage == "done":
            slot.job.done(outcome_of(message, slot.job.task))
        else:
            raise Garbled(f"the stage {stage!r}")
        following = slot.job.next()
        if following is None:
            self._end(slot)
            return False
        slot.again, slot.tries = False, 1
        self._send(slot, following)
        return True

    def _fail(self, slot: _Slot, status: Status, reason: str) -> None:
        """Record a failure, end the worker, and continue the series in a new worker."""
        printed = take_output(slot.job.task.output)  # read now: a worker that loses its connection prints an error
        self._end(slot)
        slot.job.failed(status, reason, printed, slot.tries if status == Status.TIMEOUT else None)
        self._start(slot.job)

    def _end(self, slot: _Slot) -> None:
        """End a worker through its guard, without waiting for its end, which takes tens of milliseconds."""
        self._slots.remove(slot)
        if slot.process.is_alive():
            slot.process.terminate()
        slot.connection.close()
        Path(slot.job.task.output).unlink(missing_ok=True)  # later output then takes no space
        self._dying = [process for process in (*self._dying, slot.process) if process.is_alive()]


def _death(exitcode: int | None) -> str:
    if exitcode is not None and exitcode < 0:
        return f"the process died of {signal.Signals(-exitcode).name}"
    return f"the process ended with exit code {exitcode}"
