"""Supervises processes that can be killed: starts them, hears them, limits their time, and tells why each ended."""

from __future__ import annotations

import contextlib
import json
import math
import os
import pickle
import signal
import struct
import subprocess
import sys
import threading
import traceback
from collections import deque
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from multiprocessing import Pipe, process
from multiprocessing.connection import Connection, wait
from time import monotonic, sleep  # a user's own module may replace `time.monotonic`
from typing import IO, Any, Protocol, Self, TypeVar

from gnomon.harness.system import child_process
from gnomon.harness.system.child_process import processor_time, read_scheduled_seconds
from gnomon.harness.system.memory import limit_memory
from gnomon.harness.system.streams import redirect_output

Item = TypeVar("Item")

ASLEEP = 10.0
"""Multiple of its processor time that a process may take by the clock, for example asleep."""
QUEUED_SECONDS = 0.001
"""If a process waited longer than this for the processor, its deadline is extended by the wait."""
BUSY = 0.9
"""Share of the time of a limit that a process ran, without waits, from which on the machine did not stall."""
ENDING_SECONDS = 5.0
"""Seconds in which a guard must end its process and all that this one started, before the guard itself is killed."""
TICK_SECONDS = 0.002
"""Time between two looks at a process that is about to end."""
LOOK_SECONDS = 1.0
"""Longest time between two looks at the limits."""
MOST_BYTES = 2**28
"""Maximum size of a message: the states of the largest trial take a thousandth of it."""
_HEADER = struct.Struct("<4sQQ")
"""The mark of a message, and the numbers of bytes of its two parts."""
_MARK = b"gnom"


class Garbled(Exception):  # noqa: N818 (it describes a message)
    """Bytes arrived that are not a valid message."""


class Ended(Exception):  # noqa: N818 (it names the event)
    """A process sends no more; the message says why. `code`: its exit code if it ended by itself; `late`: by its limit."""

    def __init__(self, why: str, code: int | None = None, late: bool = False) -> None:
        super().__init__(why)
        self.code, self.late = code, late


def frame(text: bytes, raw: bytes = b"") -> bytes:
    """A message of two parts, as an `Inbox` reads it."""
    return _HEADER.pack(_MARK, len(text), len(raw)) + text + raw


def write(descriptor: int, content: bytes) -> None:
    """Write the whole content to a pipe."""
    rest = memoryview(content)
    while rest:
        rest = rest[os.write(descriptor, rest) :]


class Inbox:
    """Reads messages from `frame`. The parent never waits for the rest of a message, and `decode` reads data only."""

    def __init__(self, decode: Callable[[bytes, bytes], Any]) -> None:
        self._content, self._decode = bytearray(), decode

    def take(self, piece: bytes) -> Iterator[Any]:
        """The messages that `piece` completes. Raises Garbled for bytes that are not a message."""
        self._content += piece
        while len(self._content) >= _HEADER.size:
            mark, text, raw = _HEADER.unpack_from(self._content)
            if mark != _MARK or text + raw > MOST_BYTES:
                raise Garbled("something that is not a message of a worker")
            end = _HEADER.size + text + raw
            if len(self._content) < end:
                return
            content = bytes(self._content[_HEADER.size : end])
            del self._content[:end]
            try:
                yield self._decode(content[:text], content[text:])
            except (ValueError, TypeError, AttributeError, RecursionError) as error:
                raise Garbled(f"a message that cannot be read ({type(error).__name__})") from None


class Limit:
    """The limit of a process by the clock, from now on, without the time that it waits for the processor.

    With `processor` it is also a limit of the processor time.
    """

    def __init__(self, process: int, seconds: float, why: str, processor: float = math.inf) -> None:
        self._process, self._why, self._processor = process, why, processor
        self._began = monotonic()
        self._ends = self._began + seconds
        self._ran, self._queued = read_scheduled_seconds(process)
        self._waited = 0.0
        self._used = 0.0 if processor == math.inf else processor_time(process)

    def left(self) -> float:
        """Seconds after which the limit may have been passed."""
        return min(self._processor, self._ends - monotonic())

    def over(self) -> str | None:
        """The limit that was passed, in words; None while there is time."""
        if self._processor < math.inf and processor_time(self._process) - self._used > self._processor:
            return f"no answer within {self._processor:g} s of processor time"
        if monotonic() <= self._ends:
            return None
        waited = read_scheduled_seconds(self._process)[1] - self._queued
        self._ends += waited
        self._queued += waited
        self._waited += waited
        return None if waited > QUEUED_SECONDS else self._why

    def busy(self) -> bool:
        """Whether the process ran for BUSY of the time that it did not wait; False where the system does not tell."""
        ran = read_scheduled_seconds(self._process)[0] - self._ran
        return ran > BUSY * (monotonic() - self._began - self._waited)


NEVER = Limit(0, math.inf, "")
"""The limit of a process that waits for a request."""


@contextlib.contextmanager
def within(seconds: float, error: BaseException) -> Iterator[None]:
    """Raise `error` in the block after `seconds` of processor time of this process, as soon as Python code runs.

    Compiled code is not stopped. Outside the main thread, where no signal arrives, there is no limit.
    """
    if math.isinf(seconds) or threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        raise error

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


@dataclass(eq=False)
class Child:
    """A process, the pipes from it and to it, and the limit of its next message.

    With `guarded`, `process` is the guard of the process that does the work. `reader` assembles messages from the
    pieces in which they arrive. `patience`: seconds in which the process must end after it has closed its pipe.
    """

    process: Any
    source: Connection
    sink: Connection
    reader: Any
    guarded: bool = True
    patience: float = ENDING_SECONDS
    limit: Limit = NEVER

    def allow(self, seconds: float, asleep: float = ASLEEP) -> None:
        """Expect the next message within this processor time from now, and within `asleep` times as long by the clock."""
        longest = asleep * seconds
        self.limit = Limit(self.process.pid, longest, f"no answer within {longest:g} s", seconds)

    def send(self, message: Any) -> None:
        """Send a message, unless the process has ended: the end of its pipe tells why."""
        with contextlib.suppress(OSError):
            self.sink.send(message)

    def messages(self, waits: bool = False) -> Iterator[Any]:
        """The messages that have come, until the child is ended; with `waits` also those that will come, in any time.

        Raises Ended if no more will come.
        """
        try:
            while not self.source.closed and (waits or self.source.poll()):
                piece = os.read(self.source.fileno(), 2**16)
                if not piece:
                    raise EOFError
                for message in self.reader.take(piece):
                    yield message
                    if self.source.closed:
                        return
        except (EOFError, OSError):
            raise self.ended() from None
        except Garbled as error:
            raise Ended(f"sent {error}") from None
        over = None if self.source.closed else self.limit.over()
        if over is not None and not self.source.poll():
            raise Ended(over, late=True)

    def wait(self, seconds: float) -> int | None:
        """The exit code, for which this waits at most `seconds`; None while the process runs.

        Where several processes want each processor, it may take as many times as long. The method `join` of
        multiprocessing waits without a limit for a process that has closed all its files.
        """
        for _ in range(round(seconds * child_process.crowding() / TICK_SECONDS)):
            if self.process.exitcode is not None:
                break
            sleep(TICK_SECONDS)
        code: int | None = self.process.exitcode
        return code

    def ended(self) -> Ended:
        """Why a process that closed its pipe ended, if it does so soon."""
        code = self.wait(self.patience)
        if code is None:
            return Ended("closed its pipe")
        if code >= 0:
            return Ended(f"ended with exit code {code}", code)
        return Ended(f"died of {_NAMES.get(-code, f'signal {-code}')}", code)

    def end(self) -> None:
        """End the process, without waiting for its end, which takes tens of milliseconds (see `reap`)."""
        if self.process.exitcode is None:  # a guard kills the process and all that this one started
            (self.process.terminate if self.guarded else self.process.kill)()
        self.source.close()
        self.sink.close()

    def reap(self) -> None:
        """Wait until a process that was told to end has ended; a guard that was stopped is killed."""
        if self.wait(ENDING_SECONDS) is None:
            self.process.kill()
            self.wait(ENDING_SECONDS)


_NAMES = {int(number): number.name for number in signal.Signals}


def listen(children: Collection[Child], longest: float = LOOK_SECONDS) -> None:
    """Wait for a message of any child up to the nearest limit, at most `longest` seconds."""
    timeout = min([longest, *(child.limit.left() for child in children)])
    wait([child.source for child in children], max(0.0, timeout))


def events(children: Collection[Child], longest: float = LOOK_SECONDS) -> Iterator[tuple[Child, Any]]:
    """Listen to children; yields each child with a message that has come, or with Ended."""
    listen(children, longest)
    for child in list(children):
        try:
            for message in child.messages():
                yield child, message
        except Ended as end:
            yield child, end


class Supervisor:
    """Children that run at the same time. At the end of its block all are ended, with all that they started.

    `method`: how multiprocessing starts them, see `child_process.context`.
    """

    def __init__(self, method: str) -> None:
        self.children: list[Child] = []
        self._ending: list[Child] = []
        self._context = child_process.context(method)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for child in list(self.children):
            self.end(child)
        for child in self._ending:
            child.reap()

    def start(
        self,
        work: Callable[[Connection], object],
        decode: Callable[[bytes, bytes], Any],
        output: str | None = None,
        memory: int | None = None,
        main: bool = True,
    ) -> Child:
        """Start a process that calls `work` with its pipe; `decode` reads its messages.

        `output`: the file to which it prints. `memory`: bytes that it may allocate. `main`: see `starting`.
        """
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=_begin, args=(theirs, work, output, memory), daemon=True)
        with child_process.starting(main):
            process.start()
        theirs.close()
        self.children.append(Child(process, ours, ours, Inbox(decode)))
        return self.children[-1]

    def end(self, child: Child) -> None:
        """End a child, without waiting for its end."""
        self.children.remove(child)
        child.end()
        self._ending = [ending for ending in (*self._ending, child) if ending.process.exitcode is None]


def _begin(
    connection: Connection, work: Callable[[Connection], object], output: str | None, memory: int | None
) -> None:
    """In a new process: become a guard, and do the work in its child."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles it
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    if output is not None:
        redirect_output(output)
    child_process.into_guarded_child()
    os.setpgid(0, 0)  # else a terminal's Ctrl-C reaches libraries with a handler of their own, such as REBOUND
    child_process.adopt_orphans()
    child_process.leave_server(connection.fileno())
    current: Any = process.current_process()
    current._config["daemon"] = False  # which may have no children; the children of this process end with it
    if memory is not None:
        limit_memory(memory)
    work(connection)
    os._exit(0)


class _Program(subprocess.Popen[bytes]):
    """A program that has an exit code as multiprocessing's processes have it."""

    @property
    def exitcode(self) -> int | None:
        return self.poll()


def start_program(command: Sequence[str], folder: str, reader: Any, patience: float, errors: IO[bytes]) -> Child:
    """Start `command` in `folder`, with pipes for its standard input and output, and standard error to a file.

    It ends when this process ends, in any way, on Linux with all processes that it started. Within `patience` seconds
    it must end after it has closed its output. Raises OSError, ValueError or SubprocessError.
    """
    guarded = child_process.needs_guard()
    prepare = child_process.into_guarded_child if guarded else child_process.die_with_parent
    (reading, sink), (source, writing) = Pipe(duplex=False), Pipe(duplex=False)
    with reading, writing:
        program = _Program(
            list(command),
            cwd=folder,
            stdin=reading.fileno(),
            stdout=writing.fileno(),
            stderr=errors.fileno(),
            preexec_fn=prepare if sys.platform == "linux" else None,
        )
    return Child(program, source, sink, reader, guarded, patience)


def calls(
    function: Callable[[Item], Any],
    items: Iterable[Item],
    workers: int,
    method: str = "forkserver",
    main: bool = True,
    attempts: int = 1,
) -> Generator[tuple[Item, Any], None, None]:
    """Call a function of each item in several processes; yields each item with the result, in the order of their ends.

    A result may be the exception of the call. It is ChildProcessError if the call ended its process in each attempt.
    """
    waiting, busy = deque((item, attempts) for item in items), dict[Child, tuple[Item, int]]()
    idle, work = list[Child](), partial(_call, function)
    with Supervisor(method) as supervisor:
        while waiting or busy:
            while waiting and len(busy) < workers:
                child = idle.pop() if idle else supervisor.start(work, lambda _, raw: pickle.loads(raw), main=main)
                busy[child] = waiting.popleft()
                child.send(busy[child][0])
            for child, answer in events(busy):
                item, left = busy.pop(child)
                if not isinstance(answer, Ended):
                    idle.append(child)
                    yield item, answer
                    continue
                supervisor.end(child)
                if left > 1:
                    waiting.appendleft((item, left - 1))
                else:
                    yield item, ChildProcessError(f"its process {answer}")


def _call(function: Callable[[Any], Any], connection: Connection) -> None:
    with contextlib.suppress(EOFError, ConnectionError):  # the parent has ended, or needs no more
        while True:
            item = connection.recv()
            try:
                answer = function(item)
            except BaseException as error:
                error.add_note("".join(traceback.format_exception(error)))
                answer = error
            write(connection.fileno(), frame(b"", pickle.dumps(answer)))


def require(result: Any) -> Any:
    """The result of a call; raises it if it is an exception."""
    if isinstance(result, BaseException):
        raise result
    return result


Send = Callable[[Any], None]


class Job(Protocol):
    """Work in several parts, each answered by a message in JSON: the user's code does the work, and messages are data."""

    pending: list[str]
    """The parts without an answer, in order."""
    limit: float
    """Processor seconds within which the next message must come, see `Child.allow`."""

    def work(self, send: Send) -> None:
        """Send the messages of the pending parts; called in the process."""

    def receive(self, message: Any) -> None:
        """Take a message, and remove the part that it answers from `pending`."""

    def lose(self, why: str, late: bool = False) -> None:
        """Remove the first part from `pending`: it ends the process or is `late`, and then may stay for another try.

        A new process tries the parts that are left.
        """

    def stop(self) -> None:
        """Remove all parts from `pending`: the time of `run` is over."""
        self.pending.clear()

    def serve(self, connection: Connection) -> None:
        """Do the work in the process; the output of the user's code is discarded."""
        self.work(sender(connection))

    def process(self) -> tuple[str, Callable[[Connection], object]]:
        """How its process starts (see `child_process.context`), and the work in it, which a fork need not pickle."""
        return "fork", self.serve


def sender(connection: Connection) -> Send:
    """A function that sends a message as JSON."""
    return lambda message: write(connection.fileno(), frame(json.dumps(message).encode()))


AnyJob = TypeVar("AnyJob", bound=Job)


def run(
    jobs: Sequence[AnyJob], workers: int, ends: float = math.inf, enough: Callable[[], bool] = lambda: False
) -> list[AnyJob]:
    """Run jobs in up to `workers` processes, until each part has an answer or the clock `monotonic` is at `ends`.

    No job begins once there is `enough`; those that have begun are completed. Returns the jobs that have not begun, of
    which none is left when the time is over. The processes of all jobs start in one way. Most are forks, so that the
    user's objects need not be found again by name.
    """
    waiting, again, running = [job for job in jobs if job.pending], list[AnyJob](), dict[Child, AnyJob]()
    with Supervisor(waiting[0].process()[0] if waiting else "fork") as supervisor:
        while (running or again or (waiting and not enough())) and monotonic() <= ends:
            while len(running) < workers and (again or (waiting and not enough())):
                job = (again or waiting).pop(0)
                child = supervisor.start(job.process()[1], lambda text, _: json.loads(text), os.devnull)
                child.allow(job.limit)
                running[child] = job
            for child, message in events(running, min(LOOK_SECONDS, ends - monotonic())):
                job = running[child]
                if not isinstance(message, Ended):
                    job.receive(message)
                    child.allow(job.limit)
                    if job.pending:
                        continue
                del running[child]
                supervisor.end(child)
                if not isinstance(message, Ended) or not job.pending:
                    continue
                job.lose(str(message) if message.late else f"its process {message}", message.late)
                if job.pending:
                    again.append(job)
    if monotonic() <= ends:
        return waiting
    for job in (*running.values(), *again, *waiting):
        job.stop()
    return []
