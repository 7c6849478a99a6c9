"""Code that ends the process when it is imported, and surroundings that a run cannot use: one line that names them."""

import os
import random
import socket
import sys
import tempfile
import threading
from contextlib import suppress
from multiprocessing import process
from multiprocessing.connection import arbitrary_address
from pathlib import Path

import pytest
from command_line import gnomon
from gnomon.harness.system import locks

pytestmark = pytest.mark.usefixtures("no_hang")


def ended(folder: Path, *arguments: str) -> tuple[int, list[str]]:
    """The exit code of a command in a process of its own, a fork of this one, and the lines that it wrote."""
    told = folder / "told"
    child = os.fork()
    if child == 0:
        code = 70
        try:
            descriptor = os.open(told, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(descriptor, 1)
            os.dup2(descriptor, 2)
            sys.stdout, sys.stderr = (open(number, "w", closefd=False) for number in (1, 2))  # noqa: SIM115
            code = gnomon(*arguments)
        finally:
            with suppress(OSError):
                sys.stdout.flush()
                sys.stderr.flush()
            os._exit(code)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), told.read_text(errors="replace").splitlines()


ENDINGS = {
    "os._exit": ("import os\nos._exit(0)", r"os._exit(0)"),
    "from os import _exit": ("from os import _exit\n_exit(0)", r"os._exit(0)"),
    "its own exception": ("class Stop(BaseException): pass\nraise Stop('enough')", "Stop: enough"),
    "the end of a generator": ("raise GeneratorExit", "GeneratorExit"),
    "when it is made": (
        "import os\nfrom planted import Sound\nclass Thing(Sound):\n    def __init__(self): os._exit(0)\n",
        "os._exit(0)",
    ),
    "when it is looked for": ("import os\ndef __getattr__(name): os._exit(0)", "os._exit(0)"),
}


@pytest.mark.parametrize("how", ENDINGS)
def test_a_module_that_ends_the_process_is_named(how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source, words = ENDINGS[how]
    (tmp_path / "ends_at_once.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    commands = [["run", "--case", "pendulum_simple", "--integrator"], ["verify"], ["show"], ["run", "--case"]]
    for command in commands[:2] if "Thing" in source else commands:
        code, lines = ended(tmp_path, *command, "ends_at_once:Thing")
        assert (code, len(lines)) == (2, 1), (command, lines)
        assert lines[0].startswith("error: ends_at_once:Thing: ")
        assert words in lines[0]


def test_processes_and_threads_of_a_module_end_as_they_want(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A module may start a child while it is imported; Ctrl-C ends a command, from a thread, while a module hangs."""
    source = (
        "import os, threading\n"
        "child = os.fork()\n"
        "if child == 0:\n    os._exit(7)\n"
        "assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7\n"
        "threading.Thread(target=os._exit, args=(9,)).start()\n"
        "threading.Event().wait()\n"
    )
    (tmp_path / "starts_others.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    assert ended(tmp_path, "show", "starts_others:Thing") == (9, [])


@pytest.mark.parametrize("more", [-1, 0, 1, 40])
def test_a_folder_too_long_for_a_socket_is_named(more: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Refused are the folders in which the system cannot bind the socket of multiprocessing's server, and no others."""
    monkeypatch.setitem(process.current_process()._config, "tempdir", str(tmp_path))  # type: ignore[attr-defined]
    monkeypatch.setattr(locks, "_OWN", {})  # this process makes a new folder, and has its own again after the test
    inside = f"{locks.PREFIX}12345678/{Path(arbitrary_address('AF_UNIX')).name}"
    with tempfile.TemporaryDirectory(dir="/tmp") as short, socket.socket(socket.AF_UNIX) as listener:
        folder = Path(short, "x" * (locks.SOCKET_BYTES - 1 + more - len(f"{short}//{inside}")))
        (folder / inside).parent.mkdir(parents=True)
        monkeypatch.setattr(tempfile, "tempdir", str(folder))
        if more > 0:
            with pytest.raises(OSError, match="too long"):
                listener.bind(str(folder / inside))
            with pytest.raises(ValueError, match=rf"^TMPDIR={folder}: {more} bytes too long .*; name a shorter one$"):
                locks.temporary_folder()
        else:
            listener.bind(str(folder / inside))
            assert locks.temporary_folder().parent == folder
            locks._remove(os.getpid())


class Babbler:
    """Answers each connection with bytes, and reads the bytes that come."""

    def __init__(self, answer: bytes) -> None:
        self.answer = answer
        self.socket = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp://127.0.0.1:{self.socket.getsockname()[1]}"
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                connection, _ = self.socket.accept()
                with suppress(OSError):
                    connection.sendall(self.answer)


ANSWERS = {
    "a web server": b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n",
    "random bytes": random.Random(5).randbytes(5000),
    "zeros": bytes(5000),
    "nothing": b"",
}


@pytest.mark.parametrize("answer", [*ANSWERS, "nobody"])
def test_a_port_without_a_scheduler_ends_with_one_line(
    answer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from gnomon.harness.cluster import connection

    monkeypatch.setattr(connection, "CONNECT_SECONDS", 0.5)
    babbler = Babbler(ANSWERS.get(answer, b""))
    address = babbler.address if answer in ANSWERS else "tcp://127.0.0.1:9"
    named = ("--case", "pendulum_simple", "--integrator", "gnomon:RK4", "--out", str(tmp_path / "a.sqlite"))
    code, lines = ended(tmp_path, "run", *named, "--dask", address)
    babbler.socket.close()
    assert (code, len(lines)) == (2, 1), lines[-20:]
    assert lines[0].startswith(f"error: --dask {address}: no scheduler answers there")
