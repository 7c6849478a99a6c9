"""Runs jobs in processes of their own that a hang or a crash ends. A process is a fork, so that the user's objects need
not be found again by name, and answers in JSON: the user's code runs in it, and what it sends is data."""

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
    """The parts without an answer, in sequence."""
    limit: float
    """Processor seconds within which the next message is to come, see `TimeLimit`."""

    @abstractmethod
    def work(self, send: Send) -> None:
        """Send the messages of the pending parts; called in the process."""

    @abstractmethod
    def receive(self, message: Any) -> None:
        """Take a message, and the part that it answers from `pending`."""

    @abstractmethod
    def lose(self, why: str) -> None:
        """Take the first part from `pending`, which hangs or ends the process; the others are tried in a new one."""

    def late(self, why: str) -> None:
        """The first part has no answer in time: take it from `pending`, or leave it there to be tried again."""
        self.lose(why)

    def stop(self) -> None:
        """Take all parts from `pending`: the time of `run` is over."""
        self.pending.clear()


class Lost(Exception):  # noqa: N818 - an answer, not an error of this program
    """No more messages come from a process; the message says why."""


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
        """The next message is to come within so many seconds from now."""
        self.limit = TimeLimit(self.process.pid, seconds)

    def messages(self) -> Iterator[Any]:
        """The messages that have come. Raises Lost if no more will."""
        try:
            while self.connection.poll():
                yield json.loads(self.connection.recv_bytes(LONGEST_MESSAGE))
        except (EOFError, OSError):
            self.process.join(1.0)  # a process that sent too long a message is still there
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
    """In the child process: what the user's code prints is discarded."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    job.work(lambda message: connection.send_bytes(json.dumps(message).encode()))


def run(jobs: Sequence[Job], workers: int, ends: float = math.inf) -> None:
    """Run jobs in up to `workers` processes, until all have an answer to each part or the clock `monotonic` is at `ends`."""
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
