"""Runs series in child processes and kills a worker that passes its deadline; no failure of a worker ends the run."""

import math
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from signal import Signals
from time import monotonic
from typing import Protocol

from gnomon.harness.contract.status import THROUGHOUT, TRIES, Status
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.running.messages import Message, decode
from gnomon.harness.running.sweep import GRACE_SECONDS as GRACE_SECONDS
from gnomon.harness.running.worker import (
    FLOODED,
    MOST_PRINTED,
    Request,
    Task,
    count_printed_bytes,
    outcome_of,
    serve,
    take_output,
)
from gnomon.harness.system.locks import temporary_folder
from gnomon.harness.system.memory import worker_bytes
from gnomon.harness.system.progress import Interlude
from gnomon.harness.system.supervisor import NEVER, Child, Ended, Garbled, Limit, Supervisor, events

PREPARE_SECONDS = 60.0
"""The deadline of one preparation: compiling with cold caches on a busy machine takes several seconds."""
LOOK_SECONDS = 0.1
"""Longest time between two comparisons of the workers' output with the size that they may print."""
RETRY_SECONDS = 0.5
"""A trial with a limit below this is tried TRIES times, because a stall of the machine, up to 0.2 s, is not a timeout.

If the processor served the process all the time, the machine did not stall, and the trial has one try: further tries
would take a fifth of a run.
"""


ANSWERS = (Status.REFUSED, Status.UNSUPPORTED)
"""Failures that an integrator states itself: its worker then runs the next trial of the series."""
FAILURES = (*ANSWERS, Status.CRASHED, Status.NOT_INSTALLED, Status.OUT_OF_MEMORY, Status.INTERRUPTED)
"""Statuses that a worker may send instead of an outcome. After all but ANSWERS the series continues in a new worker."""


STAGES = {"prepared": "run", "calling": "run", "counted": "prepare", "extra": "prepare", "compiling": "prepare"}
"""The stage that begins with a message."""
LOST = 255
"""The exit code reported for a worker if its fork server is gone; the worker's own exit code is then unknown."""
OUTSIDE = tuple(-number for number in Signals if number.name in ("SIGKILL", "SIGTERM", "SIGHUP", "SIGINT", "SIGQUIT"))
"""Exit codes of processes ended from outside: by a user, a scheduler, or the kernel when memory runs out."""


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
    child: Child
    request: Request
    stage: str = "prepare"
    interrupted: bool = False
    """Whether a compilation has interrupted the stage `run`."""
    again: bool = False
    """Whether the request is repeated because the fork server was lost."""
    tries: int = 1
    """The number of attempts at this request, the current one included."""
    held: bool = False
    """Whether the request is held back until an interlude has ended; the worker waits for it."""
    late: bool = False
    """Whether the request has passed its deadline and the worker may still answer, as a new one would cost more."""
    began: float = 0.0
    costs: float | None = None
    """Seconds from the start of the process to the end of its first preparation: the cost of a new process."""


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
        self._supervisor = Supervisor(method)
        self._folder = tempfile.TemporaryDirectory(dir=temporary_folder())
        self._slots: dict[Child, _Slot] = {}
        self._started = 0
        self._requested = 0
        self._pausing = False

    def run(self, jobs: Iterable[Job | None], interlude: Interlude | None = None) -> None:
        """Run all jobs. None among `jobs` means that the next job can begin only after a job that is under way.

        After an exception, also Ctrl-C, the workers are killed and the exception is raised. When the `interlude` is due,
        the pool waits until all workers have answered, does the work of the interlude, and then sends further requests.
        """
        waiting = iter(jobs)
        with self._folder, self._supervisor:
            while True:
                self._pausing = self._pausing or (interlude is not None and interlude.due())
                if interlude is not None and self._pausing and all(slot.held for slot in self._slots.values()):
                    interlude.take()
                    self._resume()
                while not self._pausing and len(self._slots) < self.workers:
                    job = next(waiting, None)
                    if job is None:
                        break
                    self._start(job)
                if not self._slots:
                    return
                self._listen()

    def _start(self, job: Job) -> None:
        """Start a worker for the next request of a job, if there is one."""
        request = job.next()
        if request is not None:
            self._launch(job, request)

    def _launch(self, job: Job, request: Request, again: bool = False, tries: int = 1) -> None:
        self._started += 1
        path = Path(self._folder.name) / str(self._started)
        path.touch()
        memory = int(min(worker_bytes(self.workers), self.memory))
        task = job.task = replace(job.task, output=str(path), memory_bytes=memory)
        child = self._supervisor.start(partial(serve, task), decode, task.output, memory, task.spec.in_main)
        slot = self._slots[child] = _Slot(job, child, request, again=again, tries=tries, began=monotonic())
        self._send(slot, request)

    def _send(self, slot: _Slot, request: Request) -> None:
        self._requested += 1
        slot.late = False
        slot.request = replace(request, number=self._requested)
        slot.held = self._pausing
        if slot.held:
            slot.child.limit = NEVER
        else:
            self._stage(slot, "prepare")
            slot.child.send(slot.request)

    def _resume(self) -> None:
        """Send the requests that were held."""
        self._pausing = False
        for slot in self._slots.values():
            self._send(slot, slot.request)

    def _stage(self, slot: _Slot, stage: str, times: int = 1) -> None:
        """Set the worker's deadline for a stage; `times` multiplies the deadline of the stage `run`."""
        slot.stage, limit = stage, slot.job.limit_seconds
        seconds, why = times * (limit + GRACE_SECONDS), f"no answer within {limit:g} s"
        if stage == "prepare":
            seconds, why = self.prepare_seconds, f"not prepared within {self.prepare_seconds:g} s"
        slot.child.limit = Limit(slot.child.process.pid, seconds, why)

    def _listen(self) -> None:
        """Handle the messages that come until the nearest deadline, for at most LOOK_SECONDS."""
        for child, message in events(self._slots, LOOK_SECONDS):
            slot = self._slots[child]
            if isinstance(message, Ended):
                self._ended(slot, message)
            elif message.request == slot.request.number:  # else a process that the integrator left running answers
                try:
                    self._handle(slot, message)
                except Garbled as error:
                    self._fail(slot, Status.CRASHED, f"its process sent {error}")
        for slot in list(self._slots.values()):
            if count_printed_bytes(slot.job.task.output) > MOST_PRINTED:
                self._fail(slot, Status.CRASHED, FLOODED)

    def _ended(self, slot: _Slot, end: Ended) -> None:
        """Act on a worker that passed its deadline, ended by itself or from outside, or lost the fork server.

        A trial that may be tried again gets a new worker. If a new worker costs more than the time of all tries that
        are left, the old worker gets this time to answer. If it answers, the trial is tried again in the old worker; if
        it does not, the trial has timed out.
        """
        may_retry = slot.stage == "run" and slot.tries < TRIES and slot.job.limit_seconds < RETRY_SECONDS
        left = TRIES - slot.tries
        if end.late and slot.late:
            slot.tries = TRIES
            self._fail(slot, Status.TIMEOUT, f"no answer within {slot.job.limit_seconds:g} s")
        elif end.late and may_retry and slot.child.limit.busy():
            self._fail(slot, Status.TIMEOUT, f"{end}{THROUGHOUT}")
        elif end.late and may_retry and (slot.costs or 0.0) > left * (slot.job.limit_seconds + GRACE_SECONDS):
            self._stage(slot, "run", times=left)
            slot.late = True
        elif end.late and may_retry:
            self._end(slot)
            self._launch(slot.job, slot.request, again=slot.again, tries=slot.tries + 1)
        elif end.late:
            self._fail(slot, Status.TIMEOUT, str(end))
        elif end.code == LOST and not slot.again:
            self._end(slot)
            self._launch(slot.job, slot.request, again=True, tries=slot.tries)
        elif end.code == LOST:
            self._fail(slot, Status.INTERRUPTED, "the server of the worker processes was lost, twice")
        elif end.code is None:
            self._fail(slot, Status.CRASHED, f"its process {end}")
        else:
            self._fail(slot, Status.INTERRUPTED if end.code in OUTSIDE else Status.CRASHED, f"the process {end}")

    def _handle(self, slot: _Slot, message: Message) -> None:
        """Act on one message."""
        stage = message.stage
        if stage == "prepared" and slot.costs is None:
            slot.costs = monotonic() - slot.began
        if slot.late and stage != "compiling":
            slot.tries += 1
            self._send(slot, slot.request)  # an answer to the request before has another number
            return
        if stage in STAGES:
            slot.interrupted = slot.interrupted or (stage == "compiling" and slot.stage == "run")
            self._stage(slot, STAGES[stage])
            return
        if stage == "compiled" and slot.interrupted:
            self._stage(slot, "run")
            return
        if stage == "failed":
            word, reason = str(message.content.get("status")), str(message.content.get("reason"))
            if word not in FAILURES:
                raise Garbled(f"the status {word!r}")
            status = Status(word)
            if status not in ANSWERS:
                self._fail(slot, status, reason)
                return
            slot.job.failed(status, reason, take_output(slot.job.task.output))
        elif stage == "done":
            slot.job.done(outcome_of(message, slot.job.task))
        else:
            raise Garbled(f"the stage {stage!r}")
        following = slot.job.next()
        if following is None:
            self._end(slot)
        else:
            slot.again, slot.tries = False, 1
            self._send(slot, following)

    def _fail(self, slot: _Slot, status: Status, reason: str) -> None:
        """Record a failure, end the worker, and continue the series in a new worker."""
        printed = take_output(slot.job.task.output)  # read now: a worker that loses its connection prints an error
        self._end(slot)
        slot.job.failed(status, reason, printed, slot.tries if status == Status.TIMEOUT else None)
        self._start(slot.job)

    def _end(self, slot: _Slot) -> None:
        del self._slots[slot.child]
        self._supervisor.end(slot.child)
        Path(slot.job.task.output).unlink(missing_ok=True)  # later output then takes no space
