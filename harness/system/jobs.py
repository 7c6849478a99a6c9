"""Runs jobs in processes of their own, so that a hang or a crash ends one process.

A process is a fork, so that the user's objects need not be found again by name. It answers in JSON: the user's code
runs in it, and its messages are data.
"""

from __future__ import annotations

import json
import math
import multiprocessing
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from multiprocessing.connection import Connection, wait
from time import monotonic
from typing import Any

from gnomon.harness.system.child_process import TimeLimit, guarded

LONGEST_MESSAGE = 2**24
Send = Callable[[Any], None]


class Job(ABC):
    """Work in several parts, each answered by a message."""

    pending: list[str]
    """The parts without an answer, in order."""
    limit: float
    """Processor seconds within which the next message must come, see `TimeLimit`."""

    @abstractmethod
    def work(self, send: Send) -> None:
        """Send the messages of the pending parts; called in the process."""

    @abstractmethod
    def receive(self, message: Any) -> None:
        """Take a message, and remove the part that it answers from `pending`."""

    @abstractmethod
    def lose(self, why: str) -> None:
        """Remove the first part from `pending`: it hangs or ends the process. A new process tries the others."""

    def late(self, why: str) -> None:
        """Handle a first part without an answer in time: remove it from `pending`, or leave it for another try."""
        self.lose(why)

    def stop(self) -> None:
        """Remove all parts from `pending`: the time of `run` is over."""
        self.pending.clear()


class Lost(Exception):  # noqa: N818 - an answer, not an error of this program
    """A process sends no more messages; the message says why."""


class Late(Lost):
    """The next message does not come in time."""


class _Child:
    """The process of a job."""

    def __init__(self, job: Job) -> None:
        context = multiprocessing.get_context("fork")
        self.connection, theirs = context.Pipe(duplex=False)
        process: Any = context.Process(target=guarded, args=(partial(_work, job, theirs),))  # type: ignore[attr-defined]
        process.start()
        theirs.close()
        self.process = process
        self.allow(job.limit)

    def allow(self, seconds: float) -> None:
        """Expect the next message within this time from now."""
        self.limit = TimeLimit(self.process.pid, seconds)

    def messages(self) -> Iterator[Any]:
        """The messages that have come. Raises Lost if no more will come."""
        try:
            while self.connection.poll():
                yield json.loads(self.connection.recv_bytes(LONGEST_MESSAGE))
        except (EOFError, OSError):
            self.process.join(1.0)  # a process that sent too long a message still runs
            raise Lost(f"its process ended with exit code {self.process.exitcode}") from None
        over = self.limit.over()
        if over is not None:
            raise Late(over)

    def end(self) -> None:
        if self.process.is_alive():
            self.process.terminate()
        self.process.join()
        self.connection.close()


def _work(job: Job, connection: Connection) -> None:
    """Do the work in the child process; the output of the user's code is discarded."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    job.work(lambda message: connection.send_bytes(json.dumps(message).encode()))


def run(jobs: Sequence[Job], workers: int, ends: float = math.inf) -> None:
    """Run jobs in up to `workers` processes, until each part has an answer or the clock `monotonic` is at `ends`."""
    waiting, running = [job for job in jobs if job.pending], list[tuple[Job, _Child]]()
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                job = waiting.pop(0)
                running.append((job, _Child(job)))
            pause = min([ends - monotonic(), 1.0, *(child.limit.seconds for _, child in running)])
            wait([child.connection for _, child in running], max(0.0, pause))
            for job, child in list(running):
                lost = None
                try:
                    for message in child.messages():
                        job.receive(message)
                        child.allow(job.limit)
                except Lost as why:
                    lost = why
                if job.pending and lost is None and monotonic() <= ends:
                    continue
                running.remove((job, child))
                child.end()
                if job.pending and lost is not None:
                    (job.late if isinstance(lost, Late) else job.lose)(str(lost))
                if job.pending and monotonic() > ends:
                    job.stop()
                elif job.pending:
                    waiting.insert(0, job)
            if monotonic() > ends:
                for job in waiting:
                    job.stop()
                waiting.clear()
    finally:
        for _, child in running:
            child.end()
