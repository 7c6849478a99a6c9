"""A program that runs beside this process and answers each line that it is sent with one line."""

import atexit
import contextlib
import os
import select
import signal
import subprocess
import sys
from collections.abc import Sequence

from gnomon.harness.contract.validation import Unusable
from gnomon.harness.system.child_process import KEPT, TimeLimit, die_with_parent, into_guarded_child, needs_guard

MOST_BYTES = 2**22
"""The longest line that a program may write."""
ENDING_SECONDS = 0.5
"""Seconds in which a program must end after its standard input is closed."""


class ProgramProcess:
    """One running program. It ends when this process ends, in any way, on Linux with all processes that it started."""

    def __init__(self, command: Sequence[str], folder: str) -> None:
        """Start `command` in `folder`. Raises Unusable if it cannot be started."""
        self._guarded = needs_guard()
        prepare = into_guarded_child if self._guarded else die_with_parent
        try:
            self._program = subprocess.Popen(
                list(command),
                cwd=folder,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                bufsize=0,
                preexec_fn=prepare if sys.platform == "linux" else None,
            )
        except (OSError, ValueError, subprocess.SubprocessError) as error:
            raise Unusable(f"{command[0]} cannot be started ({getattr(error, 'strerror', None) or error})") from None
        self._owner, self._unread = os.getpid(), b""
        KEPT.add(self._program.pid)
        atexit.register(self.close)

    @property
    def usable(self) -> bool:
        """Whether the program runs, as a child of this process: a fork must not talk to it."""
        return self._owner == os.getpid() and self._program.poll() is None

    def ask(self, line: str, seconds: float | None = None) -> str:
        """Send a line to the program and return its answer, one line.

        The program is killed after `seconds` of processor time, if given (see `TimeLimit`), and after any invalid
        answer. Raises Unusable for a missing or invalid answer, and TimeoutError.
        """
        try:
            if self._unread:
                raise Unusable("wrote more than one line for a problem")
            self._write(line.encode() + b"\n")
            return self._read(None if seconds is None else TimeLimit(self._program.pid, seconds))
        except BaseException:
            self.kill()
            raise

    def _write(self, data: bytes) -> None:
        assert self._program.stdin is not None
        view = memoryview(data)
        try:
            while view:
                view = view[os.write(self._program.stdin.fileno(), view) :]
        except BrokenPipeError:
            raise Unusable(f"{self._end()} before it read a problem") from None

    def _read(self, limit: TimeLimit | None) -> str:
        assert self._program.stdout is not None
        descriptor = self._program.stdout.fileno()
        pieces: list[bytes] = []
        length = 0
        while True:
            while limit is not None and not select.select([descriptor], [], [], min(limit.seconds, 1.0))[0]:
                over = limit.over()
                if over is not None:
                    raise TimeoutError(over)
            piece = os.read(descriptor, 2**16)
            if not piece:
                cut = " within a line" if pieces else ""
                raise Unusable(f"{self._end()}{cut} before it answered")
            before, newline, after = piece.partition(b"\n")
            pieces.append(before)
            length += len(before)
            if length > MOST_BYTES:
                raise Unusable(f"wrote a line of more than {MOST_BYTES} bytes")
            if newline:
                self._unread = after
                try:
                    return b"".join(pieces).decode()
                except UnicodeDecodeError:
                    raise Unusable("wrote a line that is not UTF-8") from None

    def _end(self) -> str:
        """How the program ended, as text, or that it closed its output."""
        try:
            code = self._program.wait(ENDING_SECONDS)
        except subprocess.TimeoutExpired:
            return "the program closed its standard output"
        if code < 0:
            return f"the program died of {signal.Signals(-code).name}"
        return f"the program ended with exit code {code}"

    def close(self) -> None:
        """Close the program's input so that it ends, and kill it if it does not."""
        atexit.unregister(self.close)
        if self._owner != os.getpid():
            return
        assert self._program.stdin is not None
        with contextlib.suppress(OSError):
            self._program.stdin.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._program.wait(ENDING_SECONDS)
        self.kill()

    def kill(self) -> None:
        atexit.unregister(self.close)
        if self._owner != os.getpid():
            return
        if self._guarded:
            self._program.terminate()  # the guard kills the program and its children
        else:
            self._program.kill()
        self._program.wait()
        KEPT.discard(self._program.pid)
        for pipe in (self._program.stdin, self._program.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError):
                pipe.close()
