"""Ctrl-C: acknowledged at once and obeyed within seconds, whatever this process is busy with."""

from __future__ import annotations

import os
import select
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

ENDING_SECONDS = 3.0
"""What work has to end after Ctrl-C, before the process ends without it. Results files are whole at any moment."""
INTERRUPTED = 130
"""The exit code: 128 and the number of the signal, as shells have it."""


@contextmanager
def acknowledged(seconds: float = ENDING_SECONDS) -> Iterator[threading.Event]:
    """Within, the first Ctrl-C prints "stopping ..." and raises KeyboardInterrupt in the main thread; `seconds` after it,
    or at a second one, the process ends. The event says whether there was one.

    A thread of its own sees to it, woken by the system: a compiler or a renderer may keep the main thread from it.
    """
    asked, told = threading.Event(), threading.Lock()
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN  # as shells start what runs in the background
    if ignored or threading.current_thread() is not threading.main_thread():
        yield asked
        return

    def acknowledge() -> None:
        """Called by both threads: whichever comes first, for the other one may not come at all."""
        asked.set()
        if told.acquire(blocking=False):
            os.write(2, b"\nstopping ...\n" if os.isatty(2) else b"stopping ...\n")  # a terminal shows ^C before it

    def interrupt(*_: object) -> None:
        acknowledge()
        raise KeyboardInterrupt

    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    woken = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    before = signal.signal(signal.SIGINT, interrupt)
    threading.Thread(target=_watch, args=(reading, acknowledge, seconds), daemon=True).start()
    try:
        yield asked
    finally:
        if not asked.is_set():  # else the watch goes on: the end of the interpreter may take long too
            signal.signal(signal.SIGINT, before)
            signal.set_wakeup_fd(woken)
            os.close(writing)


def _watch(reading: int, acknowledge: Callable[[], None], seconds: float) -> None:
    if not _interrupted(reading, None):
        os.close(reading)
        return
    acknowledge()
    _interrupted(reading, time.monotonic() + seconds)
    os._exit(INTERRUPTED)


def _interrupted(reading: int, deadline: float | None) -> bool:
    """Wait until the pipe tells of a SIGINT; False at the deadline, or where the pipe is closed."""
    while True:
        left = None if deadline is None else max(0.0, deadline - time.monotonic())
        if not select.select([reading], [], [], left)[0]:
            return False
        told = os.read(reading, 1)
        if not told or told[0] == signal.SIGINT:
            return bool(told)
