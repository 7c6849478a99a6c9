"""A clock of runs and verifications that turns only while integrators pass time, so that no limit measures the machine.

A limit of a process begins and ends by the clock of the supervisor. Here this clock stands still, however slow the
machine is, until the process that is supervised calls `pass_time` or `hang`; one process is supervised at a time.
"""

import contextlib
import math
import os
import socket
from collections.abc import Iterator
from multiprocessing import connection
from typing import Any

import pytest
from passing_time import PLACE, TIME
from waiting import LIMIT_SECONDS

STOPPED = "no message came, and no process said that time is to pass"


class Clock:
    """The time `now` of the supervisor, in seconds. `hanging`: the connection to the process that has said that it hangs."""

    def __init__(self, listener: socket.socket) -> None:
        self.now = 0.0
        self.hanging: Any = None
        self.burning = False
        """Whether the processes use the processor all the time that passes."""
        self._listener = listener
        self._asleep: tuple[socket.socket, Any] | None = None

    def wait(self, connections: list[Any], timeout: float) -> None:
        """In place of the wait for a message of any process, up to the nearest limit."""
        if self._asleep is not None:
            sleeper, process = self._asleep
            if process in connections:  # else its limit has ended it
                sleeper.sendall(b".")
            sleeper.close()
            self._asleep = None
        if self.hanging is None or connections != [self.hanging]:
            assert connection.wait([*connections, self._listener], LIMIT_SECONDS), STOPPED
            if any(one.poll() for one in connections):  # a process passes time after its last message
                return
            sleeper, _ = self._listener.accept()
            (seconds,) = TIME.unpack(sleeper.recv(TIME.size, socket.MSG_WAITALL))
            (process,) = connections
            if seconds < math.inf:
                self.now += seconds
                self._asleep = sleeper, process
                return
            sleeper.close()
            self.hanging = process
        self.now += timeout + 1e-6


@contextlib.contextmanager
def turned_clock() -> Iterator[Clock]:
    """A block in which pools and verifications use a turned clock, and no process ever waits for the processor."""
    from gnomon.harness.running import pool
    from gnomon.harness.system import supervisor

    with socket.socket(socket.AF_UNIX) as listener, pytest.MonkeyPatch.context() as patch:
        listener.bind(PLACE)
        listener.listen()
        clock = Clock(listener)
        for module in (supervisor, pool):
            patch.setattr(module, "monotonic", lambda: clock.now)
            patch.setattr(module, "LOOK_SECONDS", math.inf)
        patch.setattr(supervisor, "wait", clock.wait)
        patch.setattr(supervisor, "read_scheduled_seconds", lambda _process: (0.0, 0.0))
        patch.setattr(supervisor, "processor_time", lambda _process: clock.now * clock.burning)
        try:
            yield clock
        finally:
            os.unlink(PLACE)
