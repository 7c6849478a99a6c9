"""Child processes and Ctrl-C."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

import pytest
from gnomon.harness.system import child_process


@pytest.mark.skipif(sys.platform != "linux", reason="reads what signals a process ignores from /proc")
def test_the_server_of_workers_ignores_ctrl_c_from_its_first_line() -> None:
    """An interruption while it still imports would print its traceback into the terminal."""
    from multiprocessing import forkserver

    child_process.context()
    server = forkserver._forkserver._forkserver_pid  # type: ignore[attr-defined]
    status = Path(f"/proc/{server}/status").read_text()
    (mask,) = (line.split()[1] for line in status.splitlines() if line.startswith("SigIgn"))
    assert int(mask, 16) >> (signal.SIGINT - 1) & 1


def test_the_parent_handles_ctrl_c_again() -> None:
    before = signal.getsignal(signal.SIGINT)
    with child_process.interrupts_ignored():
        assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    assert signal.getsignal(signal.SIGINT) == before
