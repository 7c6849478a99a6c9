"""Runs series in child processes: kills a worker whose stage passes its deadline, and starts another in its place."""

from __future__ import annotations

import contextlib
import os
import signal
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection, wait
from pathlib import Path
from time import monotonic  # a user's own module may replace that of `time`
from typing import Any, Protocol

from gnomon.harness.results.values import TRIES
from gnomon.harness.running.messages import Garbled, Inbox, Message
from gnomon.harness.running.worker import Order, Task, outcome_of, serve, take_output
from gnomon.harness.scoring.outcome import Outcome
from gnomon.harness.system.child_process import context, main_hidden, queued_seconds
from gnomon.harness.system.locks import temporary_folder
from gnomon.harness.system.memory import worker_bytes

PREPARE_SECONDS = 60.0
"""The deadline of one preparation: compiling with cold caches on a busy machine takes several seconds."""
GRACE_SECONDS = 0.15
"""What a stage may take beyond the trial's limit before it is killed: start of the call, message, scheduling."""
QUEUED_SECONDS = 0.001
"""A wait for the processor above this is taken off the time of a stage: it is the load of the machine."""
AGAIN_SECONDS = 0.5
"""Trials with a limit below this are tried TRIES times: the machine can stand still for a fifth of a second."""


FAILURES = ("refused", "crashed", "not_installed", "out_of_memory", "interrupted")
"""What a worker may say of a trial without an outcome; after all but the first the series goes on in a new worker."""


LOST = 255
"""The exit code of a worker whose server of processes is gone, by which nobody can learn how it ended itself."""
OUTSIDE = tuple(-number for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGQUIT))
"""Exit codes of processes that were ended from outside: by a user, a scheduler, a machine without memory."""
ENDING_SECONDS = 5.0
"""What a guard has to end its worker and what that left behind, before it is killed itself."""


class Job(Protocol):
    """One launch of one series, as the pool sees it."""

    task: Task
    limit_seconds: float

    def next(self) -> Order | None:
        """The next trial to run, or None when the series is finished."""

    def done(self, outcome: Outcome) -> None:
        """The order that was handed out last has this outcome."""

    def failed(self, status: str, reason: str, output: str, tries: int | None = None) -> None:
        """The order that was handed out last failed; a timeout says how often it was tried."""


@dataclass
class _Slot:
    """A worker at work on one job."""

    job: Job
    process: Any
    connection: Connection
    order: Order
    deadline: float
    stage: str = "prepare"
    seconds: float = 0.0
    queued: float = 0.0
    """What its process had waited for the processor when the deadline was set."""
    interrupted: tuple[str, float] | None = None
    """The stage in which something is being compiled, and its seconds."""
    again: bool = False
    """Whether the order is repeated because the server of its process was lost."""
    tries: int = 1
    """How often the order was tried, this time included."""
    inbox: Inbox = field(default_factory=Inbox)


class Pool:
    """`workers` child processes at a time. `method` is how they are started, see `gnomon.harness.system.child_process`."""

    def __init__(self, workers: int = 2, method: str = "forkserver", prepare_seconds: float = PREPARE_SECONDS) -> None:
        self.workers = workers
        self.prepare_seconds = prepare_seconds
        self._context = context(method)
        self._folder = tempfile.TemporaryDirectory(dir=temporary_folder())
        self._slots: list[_Slot] = []
        self._started = 0
        self._ordered = 0
        self._dying: list[Any] = []

    def run(self, jobs: Iterable[Job]) -> None:
        """Run all jobs. An exception (Ctrl-C too) kills the workers and goes on to the caller."""
        waiting = iter(jobs)
        exhausted = False
        try:
            while True:
                while not exhausted and len(self._slots) < self.workers:
                    job = next(waiting, None)
                    exhausted = job is None
                    if job is not None:
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
        """Start a worker on the next order of a job, if there is one."""
        order = job.next()
        if order is not None:
            self._launch(job, order)

    def _launch(self, job: Job, order: Order, again: bool = False, tries: int = 1) -> None:
        self._started += 1
        path = Path(self._folder.name) / str(self._started)
        path.touch()
        job.task = replace(job.task, output=str(path), memory_bytes=worker_bytes(self.workers))
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=serve, args=(theirs, job.task), daemon=True)
        with main_hidden(not job.task.spec.in_main):
            process.start()
        theirs.close()
        slot = _Slot(job, process, ours, order, 0.0, again=again, tries=tries)
        self._slots.append(slot)
        self._send(slot, order)

    def _send(self, slot: _Slot, order: Order) -> None:
        self._ordered += 1
        slot.order = replace(order, number=self._ordered)
        self._stage(slot, "prepare", self.prepare_seconds)
        with contextlib.suppress(OSError):  # it died between two orders: the end of its pipe says so to _listen
            slot.connection.send(slot.order)

    def _stage(self, slot: _Slot, stage: str, seconds: float) -> None:
        slot.stage, slot.seconds, slot.deadline = stage, seconds, monotonic() + seconds
        slot.queued = queued_seconds(slot.process.pid)

    def _listen(self) -> None:
        """Wait for messages until the nearest deadline; drain what came before judging deadlines."""
        patience = max(0.0, min(slot.deadline for slot in self._slots) - monotonic())
        wait([slot.connection for slot in self._slots], patience)
        for slot in list(self._slots):
            self._drain(slot)
        now = monotonic()
        for slot in list(self._slots):
            if now > slot.deadline and not slot.connection.poll():
                self._late(slot)

    def _late(self, slot: _Slot) -> None:
        """Try the order of a worker that passed its deadline again where that may be the machine's fault, or fail it."""
        limit = slot.job.limit_seconds
        waited = queued_seconds(slot.process.pid) - slot.queued
        if waited > QUEUED_SECONDS:
            slot.deadline += waited
            slot.queued += waited
            return
        if slot.stage == "prepare":
            self._fail(slot, "timeout", f"not prepared within {self.prepare_seconds:g} s")
        elif slot.tries >= TRIES or limit >= AGAIN_SECONDS:
            self._fail(slot, "timeout", f"no answer within {limit:g} s")
        else:
            self._end(slot)
            self._launch(slot.job, slot.order, again=slot.again, tries=slot.tries + 1)

    def _drain(self, slot: _Slot) -> None:
        try:
            while slot.connection.poll():
                piece = os.read(slot.connection.fileno(), 2**20)
                if not piece:
                    raise EOFError
                for message in slot.inbox.take(piece):
                    # another number: an answer to an order before, by a process that the integrator left behind
                    if message.order == slot.order.number and not self._handle(slot, message):
                        return
        except (EOFError, OSError):
            slot.process.join()
            self._died(slot)
        except Garbled as error:
            self._fail(slot, "crashed", f"its process sent {error}")

    def _died(self, slot: _Slot) -> None:
        """Its process ended by itself, by a signal from outside, or because the server of all workers was lost."""
        code = slot.process.exitcode
        if code == LOST and not slot.again:
            self._end(slot)
            self._launch(slot.job, slot.order, again=True, tries=slot.tries)
        elif code == LOST:
            self._fail(slot, "interrupted", "the server of the worker processes was lost, twice")
        else:
            self._fail(slot, "interrupted" if code in OUTSIDE else "crashed", _death(code))

    def _handle(self, slot: _Slot, message: Message) -> bool:
        """Act on one message; False where the slot is no longer in use."""
        stage = message.stage
        limit, order = slot.job.limit_seconds, slot.order
        if stage in ("prepared", "turning"):
            self._stage(slot, "run", limit + GRACE_SECONDS)
            return True
        if stage in ("counted", "null"):
            self._stage(slot, "prepare", self.prepare_seconds)
            return True
        if stage == "ran":
            # the timed calls together take the block, or one call that may be as slow as the limit
            self._stage(slot, "time", limit + 4 * order.block_seconds + GRACE_SECONDS)
            return True
        if stage == "compiling":
            if slot.stage != "prepare":  # where one compilation asks for another, the first says what was interrupted
                slot.interrupted = (slot.stage, slot.seconds)
            self._stage(slot, "prepare", self.prepare_seconds)
            return True
        if stage == "compiled" and slot.interrupted is not None:
            self._stage(slot, *slot.interrupted)
            return True
        if stage == "failed":
            status, reason = str(message.content.get("status")), str(message.content.get("reason"))
            if status not in FAILURES:
                raise Garbled(f"the status {status!r}")
            if status != "refused":
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

    def _fail(self, slot: _Slot, status: str, reason: str) -> None:
        """Record a failure, end the worker, and go on with the rest of the series in a new one."""
        self._end(slot)
        tries = slot.tries if status == "timeout" else None
        slot.job.failed(status, reason, take_output(slot.job.task.output), tries)
        self._start(slot.job)

    def _end(self, slot: _Slot) -> None:
        """End a worker through its guard, without waiting for it: that takes the kernel tens of milliseconds."""
        self._slots.remove(slot)
        if slot.process.is_alive():
            slot.process.terminate()
        slot.connection.close()
        self._dying = [process for process in (*self._dying, slot.process) if process.is_alive()]


def _death(exitcode: int | None) -> str:
    if exitcode is not None and exitcode < 0:
        return f"the process died of {signal.Signals(-exitcode).name}"
    return f"the process ended with exit code {exitcode}"
