"""Child processes and Ctrl-C."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from gnomon.harness.system import child_process
from waiting import wait_until


@pytest.mark.skipif(sys.platform != "linux", reason="reads what signals a process ignores from /proc")
def test_the_server_of_workers_ignores_ctrl_c_from_its_first_line() -> None:
    """An interruption while it still imports would print its traceback into the terminal."""
    from multiprocessing import forkserver

    child_process.context()
    server = forkserver._forkserver._forkserver_pid  # type: ignore[attr-defined]
    status = Path(f"/proc/{server}/status").read_text()
    (mask,) = (line.split()[1] for line in status.splitlines() if line.startswith("SigIgn"))
    assert int(mask, 16) >> (signal.SIGINT - 1) & 1


def test_the_run_and_the_wait_of_a_guards_child_are_read_from_the_kernel() -> None:
    guard = subprocess.Popen(["sh", "-c", "read _line & read _line; :"], stdin=subprocess.PIPE)
    try:
        child = Path(f"/proc/{guard.pid}/task/{guard.pid}/children")
        wait_until(child.read_text, "the guard has a child")
        times = Path(f"/proc/{child.read_text().split()[0]}/schedstat")
        # A child is listed before it has run; the kernel counts its time when it stops at its first line.
        wait_until(lambda: float(times.read_text().split()[0]) > 0, "the child has run")
        ran, waited = map(float, times.read_text().split()[:2])
        found = child_process.read_scheduled_seconds(guard.pid)
        assert found[0] >= ran * 1e-9
        assert found[1] >= waited * 1e-9
    finally:
        guard.kill()
        guard.communicate()
    assert child_process.read_scheduled_seconds(guard.pid) == (0.0, 0.0)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_delays_are_read_for_each_thread_and_for_programs_that_are_driven(monkeypatch: pytest.MonkeyPatch) -> None:
    ended = threading.Event()
    thread = threading.Thread(target=ended.wait)
    thread.start()
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as program:
        monkeypatch.setattr(child_process, "KEPT", {program.pid})
        found = child_process.run_delays()
        assert program.stdin is not None
        program.stdin.write(b"\n")
    ended.set()
    thread.join()
    assert found is not None
    assert {str(os.getpid()), str(thread.native_id), str(program.pid)} <= found.keys()
    assert min(found.values()) >= 0


def test_where_the_system_has_no_delays_they_are_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(path: str) -> list[str]:
        raise FileNotFoundError(path)

    monkeypatch.setattr(os, "listdir", fail)
    assert child_process.run_delays() is None


def test_the_parent_handles_ctrl_c_again() -> None:
    before = signal.getsignal(signal.SIGINT)
    with child_process.interrupts_ignored():
        assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    assert signal.getsignal(signal.SIGINT) == before
