"""Let time pass by the clock of a test (see `turned_clock`), in the process that the test supervises."""

import contextlib
import math
import os
import signal
import socket
import struct
import tempfile
from typing import NoReturn

PLACE = os.environ.setdefault("GNOMON_TURNED_CLOCK", os.path.join(tempfile.gettempdir(), f"gnomon-clock-{os.getpid()}"))
"""The socket by which a process says how much time is to pass: named after the process that runs the tests, also in
its workers."""
TIME = struct.Struct("d")
"""The seconds that are to pass."""


def pass_time(seconds: float) -> None:
    """Return when this time has passed by the turned clock. Raises OSError if there is no such clock."""
    with socket.socket(socket.AF_UNIX) as clock:
        clock.connect(PLACE)
        clock.sendall(TIME.pack(seconds))
        clock.recv(1)


def say_hanging() -> None:
    """Let the turned clock go to the limit that ends this process."""
    with contextlib.suppress(OSError):
        pass_time(math.inf)


def wait_for_ever() -> NoReturn:
    """Never return; the clock does not turn."""
    while True:
        signal.pause()


def hang() -> NoReturn:
    """Never return; the turned clock, if there is one, goes to the limit that ends this process."""
    say_hanging()
    wait_for_ever()
