"""Processes of the system: guards, which end all that a process started, and times; `supervisor` uses them."""

import contextlib
import ctypes
import multiprocessing
import os
import signal
import sys
import threading
import types
from collections.abc import Iterator
from multiprocessing import forkserver, resource_tracker
from pathlib import Path
from typing import Any

from gnomon.harness.system.locks import temporary_folder
from gnomon.harness.system.streams import open_standard_streams

SERVER_FAILURE = "GNOMON_SERVER_FAILURE"
"""The environment variable that names the file in which the server writes why it cannot start."""


class ServerFailed(RuntimeError):  # noqa: N818 (it names the event)
    """The server of the worker processes cannot start; the message says why."""


def context(method: str = "forkserver") -> Any:
    """The multiprocessing context of workers: forks of a server that has already imported their modules."""
    open_standard_streams()  # the server and all workers inherit the streams of this process
    if method != "forkserver":
        return multiprocessing.get_context(method)
    os.environ[SERVER_FAILURE] = str(_failure_file())
    processes = multiprocessing.get_context(method)
    processes.set_forkserver_preload(["gnomon.harness.running.preload"])
    with interrupts_ignored():
        forkserver.ensure_running()
    return processes


def _failure_file() -> Path:
    # This folder is made before multiprocessing makes its own, which would stay after kill -9.
    return temporary_folder() / "server"


@contextlib.contextmanager
def interrupts_ignored() -> Iterator[None]:
    """Programs started within the block ignore Ctrl-C from their start: an ignored signal stays ignored in a child."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def starting(main: bool = True) -> Iterator[None]:
    """A block in which children are started. Raises ServerFailed if the server that forks them has ended.

    With `main` False they do not import the script that runs, which then needs no `__main__` guard. With `main` they
    import it, because a child may need definitions of that script.
    """
    script = sys.modules["__main__"]
    if not main:
        sys.modules["__main__"] = types.ModuleType("__main__")
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # Ctrl-C waits, and a child inherits this
    try:
        yield
    except (EOFError, ConnectionError):
        reason = "it ended without a reason: it was killed, or a library that it imports crashed"
        with contextlib.suppress(OSError):
            failure = _failure_file().read_text(encoding="utf-8")
            reason = f"{failure}; correct this, or the environment that leads to it"
            _failure_file().unlink()
        raise ServerFailed(f"the server of the worker processes cannot start: {reason}") from None
    finally:
        sys.modules["__main__"] = script
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def die_with_parent(name: str = "SIGKILL") -> None:
    """End this process when its parent ends, in any way: on Linux by the signal `name`, else by a thread."""
    if sys.platform == "linux":
        _control(_SET_DEATH_SIGNAL, getattr(signal, name))
        return
    parent = os.getppid()

    def watch() -> None:
        pause = threading.Event()
        while os.getppid() == parent:
            pause.wait(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


_SET_DEATH_SIGNAL, _SET_CHILD_SUBREAPER = 1, 36
"""Options of prctl(2)."""


def _control(option: int, value: int) -> None:
    ctypes.CDLL(None, use_errno=True).prctl(option, value)


def adopt_orphans() -> None:
    """Make orphaned descendants children of this process, even in other sessions (Linux)."""
    if sys.platform == "linux":
        _control(_SET_CHILD_SUBREAPER, 1)


_has_guard = False
"""Whether a guard above this process ends all processes that this one starts."""


def into_guarded_child() -> None:
    """Fork, and return in the child. This process becomes the child's guard.

    The guard kills all processes that the child leaves behind, in other sessions too (Linux), and ends with the child's
    exit status. It is the parent of the child, and the server that all workers are forked from is not: an integrator
    that kills its parent ends only its own trial. SIGTERM, which the end of the guard's parent sends too (Linux), kills
    the child and its descendants. The signals of a terminal are for the parent, whose end ends the rest.
    """
    stop = {signal.SIGTERM}
    signal.pthread_sigmask(signal.SIG_BLOCK, stop)  # until there is a child to end
    die_with_parent("SIGTERM")
    adopt_orphans()
    guard = os.getpid()
    child = os.fork()
    if child == 0:
        die_with_parent()
        if os.getppid() != guard:  # the guard ended before die_with_parent was called
            os._exit(1)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, stop)
        rely_on_guard()
        return
    for ignored in (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(ignored, signal.SIG_IGN)
    signal.set_wakeup_fd(-1)  # the server's, which is closed here too
    os.closerange(0, 2**16)  # above all pipes to the parent, which must close when the child ends

    def end(*_: object) -> None:
        _kill(child)
        end_children()
        os._exit(1)

    signal.signal(signal.SIGTERM, end)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, stop)
    _, status = os.waitpid(child, 0)
    if sys.platform != "linux":
        with contextlib.suppress(OSError):
            os.killpg(child, signal.SIGKILL)  # the rest of its process group
    end_children()
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        if number != signal.SIGKILL:
            signal.signal(number, signal.SIG_DFL)  # Python ignores SIGPIPE, and nohup SIGHUP
        os.kill(guard, number)
    os._exit(os.waitstatus_to_exitcode(status) & 0xFF)


def needs_guard() -> bool:
    """Whether a program that this process starts can have a guard (Linux), and there is none above this process."""
    return sys.platform == "linux" and not _has_guard


def rely_on_guard() -> None:
    """Record that the guard above the process that started this one also ends all that this one starts."""
    global _has_guard
    _has_guard = True


def leave_server(spared: int) -> None:
    """Close the pipes to the server that forked this process and to its resource tracker, except `spared`.

    The child of a guard does not need them, and the server would end on a message that is written to one by mistake.
    """
    server: Any = forkserver
    tracker: Any = resource_tracker
    server, tracker = server._forkserver, tracker._resource_tracker
    inherited = (server._forkserver_alive_fd, tracker._fd, *(server._inherited_fds or ()))
    server._forkserver_alive_fd = tracker._fd = server._inherited_fds = None
    for descriptor in {descriptor for descriptor in inherited if descriptor is not None} - {spared}:
        with contextlib.suppress(OSError):
            os.close(descriptor)


def read_scheduled_seconds(guard: int) -> tuple[float, float]:
    """Seconds that the child of a guard ran, and that it was ready to run while other processes had the processor.

    Of its main thread. Both are 0 if the system does not provide them, or if the child has ended.
    """
    with contextlib.suppress(OSError, ValueError, IndexError):
        child = Path(f"/proc/{guard}/task/{guard}/children").read_text().split()[0]
        ran, queued = _read_scheduled(f"/proc/{child}")
        return ran * 1e-9, queued * 1e-9
    return 0.0, 0.0


def _read_scheduled(folder: str) -> tuple[int, int]:
    """Nanoseconds that a process, or a thread, ran and was ready to run while others had the processor."""
    descriptor = os.open(f"{folder}/schedstat", os.O_RDONLY)  # faster than `open`
    try:
        ran, queued = os.read(descriptor, 100).split()[:2]
        return int(ran), int(queued)
    finally:
        os.close(descriptor)


def crowding() -> float:
    """The number of processes of the machine that want to run, for each processor of this one; at least 1."""
    with contextlib.suppress(OSError, AttributeError):  # not every system tells
        return max(1.0, os.getloadavg()[0] / len(os.sched_getaffinity(0)))
    return 1.0


def run_delays() -> dict[str, int] | None:
    """Nanoseconds that each thread was ready to run while others had the processor; None if the system does not tell.

    The threads are of this process and of its children in KEPT.
    """
    delays: dict[str, int] = {}
    for process in ("self", *KEPT):
        folder = f"/proc/{process}/task"
        with contextlib.suppress(OSError):
            for thread in os.listdir(folder):
                with contextlib.suppress(OSError, ValueError, IndexError):  # a thread may just have ended
                    delays[thread] = _read_scheduled(f"{folder}/{thread}")[1]
    return delays or None


def processor_time(process: int) -> float:
    """Processor time of a process and its descendants, in seconds; 0 if the system does not list them (not Linux)."""
    seconds, waiting = 0.0, [process]
    while waiting:
        number = waiting.pop()
        with contextlib.suppress(OSError, ValueError, IndexError):  # it has ended
            fields = Path(f"/proc/{number}/stat").read_text().rpartition(") ")[2].split()
            seconds += sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
            waiting += _children(number)
    return seconds


KEPT: set[int] = set()
"""Children of this process that serve several trials: `end_children` spares them, and a guard ends them at last."""


def end_children() -> None:
    """Kill the children of this process (after `adopt_orphans` all descendants) but KEPT, and wait until they end."""
    while others := set(_children()) - KEPT:
        for child in others:
            _kill(child)
            with contextlib.suppress(ChildProcessError):
                os.waitpid(child, 0)


def _kill(process: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.kill(process, signal.SIGKILL)


def _children(process: int | str = "self") -> list[int]:
    """The children of a process, of any of its threads; empty if the system does not list them."""
    children: list[int] = []
    for path in Path(f"/proc/{process}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            children += map(int, path.read_text().split())
    return children


def quiet_child() -> None:
    """Make a child process end with its parent and ignore Ctrl-C, which the parent handles."""
    die_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
