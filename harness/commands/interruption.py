"""Acknowledge Ctrl-C at once and end the process within seconds, even during a long call into compiled code."""

import os
import select
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

ENDING_SECONDS = 3.0
"""Seconds after Ctrl-C in which work can stop before the process ends anyway. Results files are always valid."""
INTERRUPTED = 130
"""The exit code: 128 plus the number of the signal, as in shells."""


_allowed = 0.0
"""The time of `time.monotonic` until which work may go on after Ctrl-C, if that is later than `ENDING_SECONDS`."""


def allow(seconds: float) -> None:
    """Give work that ends an interrupted command `seconds` from now. A second Ctrl-C still ends the process."""
    global _allowed
    _allowed = time.monotonic() + seconds


@contextmanager
def acknowledge(seconds: float = ENDING_SECONDS) -> Iterator[threading.Event]:
    """A context in which the first Ctrl-C prints "stopping ..." and raises KeyboardInterrupt in the main thread.

    The process ends `seconds` later, or at a second Ctrl-C. The context gives an event, which the first Ctrl-C sets. A
    separate thread does this, woken through a socket, as a compiler or a renderer may block the main thread. (Windows
    can wait for a socket, but not for a pipe.)
    """
    asked, printed = threading.Event(), threading.Lock()
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN  # as shells start background jobs
    if ignored or threading.current_thread() is not threading.main_thread():
        yield asked
        return

    def acknowledge() -> None:
        """Called by both threads; the first call prints, because the other thread may never be reached."""
        asked.set()
        if printed.acquire(blocking=False):
            os.write(2, b"\nstopping ...\n" if os.isatty(2) else b"stopping ...\n")  # a terminal shows ^C before it

    def interrupt(*_: object) -> None:
        acknowledge()
        raise KeyboardInterrupt

    reading, writing = socket.socketpair()
    writing.setblocking(False)
    woken = signal.set_wakeup_fd(writing.fileno(), warn_on_full_buffer=False)
    before = signal.signal(signal.SIGINT, interrupt)
    threading.Thread(target=_watch, args=(reading, acknowledge, seconds), daemon=True).start()
    try:
        yield asked
    finally:
        if asked.is_set():
            writing.detach()  # stays open for the thread, as the exit of the interpreter may take long too
        else:
            signal.signal(signal.SIGINT, before)
            signal.set_wakeup_fd(woken)
            writing.close()


def _watch(reading: socket.socket, acknowledge: Callable[[], None], seconds: float) -> None:
    if not _await_interrupt(reading, None):
        reading.close()
        return
    acknowledge()
    ends = time.monotonic() + seconds
    while not _await_interrupt(reading, ends) and ends < _allowed:
        ends = _allowed
    os._exit(INTERRUPTED)


def _await_interrupt(reading: socket.socket, deadline: float | None) -> bool:
    """Wait for a SIGINT from the socket; False at the deadline, or when the other end is closed."""
    while True:
        left = None if deadline is None else max(0.0, deadline - time.monotonic())
        if not select.select([reading], [], [], left)[0]:
            return False
        signals = reading.recv(1)
        if not signals or signals[0] == signal.SIGINT:
            return bool(signals)
