"""A program that runs beside this process and answers each line that it is sent with one line."""

import atexit
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from time import monotonic

from gnomon.harness.contract.validation import Unusable
from gnomon.harness.system.child_process import KEPT
from gnomon.harness.system.supervisor import ASLEEP, NEVER, Ended, listen, start_program, write
from gnomon.harness.verification import protocol

MOST_BYTES = 2**22
"""The longest line that a program may write."""
DESCRIBE_SECONDS = 60.0
"""Seconds in which a program must start and describe itself; some languages compile then."""
NOTICE_SECONDS = 10.0
"""Seconds after which a user is told that a program has not described itself yet."""
ENDING_SECONDS = 0.5
"""Seconds in which a program must end after its standard input is closed."""
LAST_LINES, LAST_BYTES = 5, 2000
"""Most lines and bytes from the end of standard error in a message: a program that stops gives its reason there."""


class _Lines:
    """Reads one line at a time; `unread` is the text after it."""

    def __init__(self) -> None:
        self.unread = b""

    def take(self, piece: bytes) -> Iterator[str]:
        line, newline, rest = (self.unread + piece).partition(b"\n")
        self.unread = rest if newline else line
        if len(line) > MOST_BYTES:
            raise Unusable(f"wrote a line of more than {MOST_BYTES} bytes")
        if newline:
            try:
                yield line.decode()
            except UnicodeDecodeError:
                raise Unusable("wrote a line that is not UTF-8") from None


class ProgramProcess:
    """One running program. It ends when this process ends, in any way, on Linux with all processes that it started."""

    def __init__(self, command: Sequence[str], folder: str) -> None:
        """Start `command` in `folder`. Raises Unusable if it cannot be started."""
        self._owner, self._lines = os.getpid(), _Lines()
        self._errors = tempfile.TemporaryFile("a+b")  # noqa: SIM115 - `close` closes it
        self._said = ""
        try:
            self._child = start_program(command, folder, self._lines, ENDING_SECONDS, self._errors)
        except (OSError, ValueError, subprocess.SubprocessError) as error:
            self._errors.close()
            raise Unusable(f"{command[0]} cannot be started ({getattr(error, 'strerror', None) or error})") from None
        KEPT.add(self._child.process.pid)
        atexit.register(self.close)

    @property
    def usable(self) -> bool:
        """Whether the program runs, as a child of this process: a fork must not talk to it."""
        return self._owner == os.getpid() and self._child.process.exitcode is None

    def describe(self, notice: Callable[[], None] = lambda: None) -> str:
        """The program's description of itself, for which it has DESCRIBE_SECONDS; calls `notice` after NOTICE_SECONDS.

        Raises as `ask` does.
        """
        return self.ask(protocol.describe_line(), DESCRIBE_SECONDS, 1.0, notice)

    def ask(
        self, line: str, seconds: float | None = None, asleep: float = ASLEEP, notice: Callable[[], None] = lambda: None
    ) -> str:
        """Send a line to the program and return its answer, one line.

        The program is killed after `seconds` of processor time, if given (see `Child.allow`, also for `asleep`), and after
        any invalid answer; `notice` is called once if there is none after NOTICE_SECONDS. Raises Unusable for a missing or
        invalid answer, and TimeoutError.
        """
        try:
            if self._lines.unread:
                raise Unusable("wrote more than one line for a problem")
            try:
                write(self._child.sink.fileno(), line.encode() + b"\n")
            except BrokenPipeError:
                raise Unusable(f"{_tell_end(self._child.ended())} before it read a problem") from None
            self._child.limit = NEVER
            if seconds is not None:
                self._child.allow(seconds, asleep)
            answer = self._answer(seconds is None, notice)
        except BaseException as error:
            self.kill()
            if isinstance(error, Unusable) and self._said:
                raise Unusable(f"{error}; its last lines on standard error:\n{self._said}") from None
            raise
        self._pass_errors()
        return answer

    def _pass_errors(self) -> None:
        """Copy the standard error of the program to the standard error of this process, and empty the file."""
        if os.fstat(self._errors.fileno()).st_size:
            self._errors.seek(0)
            sys.stderr.write(self._errors.read().decode(errors="replace"))
            sys.stderr.flush()
            self._errors.truncate(0)

    def _last_lines(self) -> str:
        """The last lines that the program wrote on standard error since its last answer."""
        self._errors.seek(max(0, os.fstat(self._errors.fileno()).st_size - LAST_BYTES))
        lines = self._errors.read().decode(errors="replace").rstrip().splitlines()
        return "\n".join(lines[-LAST_LINES:])

    def _answer(self, endless: bool, notice: Callable[[], None]) -> str:
        late = monotonic() + NOTICE_SECONDS
        try:
            while True:
                if not endless:  # it takes longer than the exchange of lines, which is part of the time of a trial
                    listen([self._child])
                for line in self._child.messages(waits=endless):
                    return str(line)
                if monotonic() > late:
                    late = math.inf
                    notice()
        except Ended as end:
            if end.late:
                raise TimeoutError(str(end)) from None
            cut = " within a line" if self._lines.unread else ""
            raise Unusable(f"{_tell_end(end)}{cut} before it answered") from None

    def close(self, seconds: float = ENDING_SECONDS) -> None:
        """Close the program's input so that it ends, and kill it if it does not within `seconds`."""
        atexit.unregister(self.close)
        if self._owner == os.getpid():
            self._child.sink.close()
            self._child.wait(seconds)
            self._child.end()
            self._child.reap()
            KEPT.discard(self._child.process.pid)
            if not self._errors.closed:
                self._said = self._last_lines()
                self._errors.close()

    def kill(self) -> None:
        self.close(0.0)


def _tell_end(end: Ended) -> str:
    return f"the program {'closed its standard output' if end.code is None else end}"
