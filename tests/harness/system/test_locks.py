"""Only one run at a time writes a results file; the next run removes the temporary folder of a killed one."""

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from multiprocessing.process import current_process
from pathlib import Path
from typing import Any

import pytest
from gnomon.harness.results import store
from gnomon.harness.system import locks

HOLDS = """
import signal, sys
from pathlib import Path
from gnomon.harness.system import locks
from gnomon.harness.system import child_process
from gnomon.harness.results.store import Store
results = Store(Path(sys.argv[1]))
folder = locks.temporary_folder()
(folder / "output").write_text("printed")
child_process.context()  # the socket of multiprocessing's server
print(folder, flush=True)
signal.pause()
"""


def holder(path: Path, temporary: Path) -> tuple[subprocess.Popen[str], Path]:
    """A process that has a results file open and a temporary folder, and that folder."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDS, str(path)],
        env=os.environ | {"TMPDIR": str(temporary)},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    return process, Path(process.stdout.readline().strip())


@pytest.fixture
def temporary(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A separate temporary folder with a short name: the path of a socket has at most 107 characters."""
    with tempfile.TemporaryDirectory() as folder:
        monkeypatch.setattr(tempfile, "tempdir", folder)
        monkeypatch.setitem(vars(current_process())["_config"], "tempdir", folder)  # for a server that starts later
        monkeypatch.setattr(locks, "_OWN", {})
        yield Path(folder)


def test_a_second_run_says_that_the_file_is_in_use_until_the_first_is_killed(tmp_path: Path, temporary: Path) -> None:
    """Otherwise both would do all trials, or one would fail to create a table that the other creates."""
    path = tmp_path / "results.sqlite"
    process, folder = holder(path, temporary)
    try:
        with pytest.raises(ValueError, match=rf"in use by another run \(process {process.pid}\); wait") as caught:
            store.Store(path)
        assert "\n" not in str(caught.value)
        locks._remove_abandoned()
        assert (folder / "output").exists(), "a folder in use is not a remainder"
        assert [one.name for one in temporary.iterdir()] == [folder.name], "multiprocessing's own is in it"
    finally:
        process.send_signal(signal.SIGKILL)
        process.communicate()
    with store.Store(path):
        assert path.with_name("results.sqlite.lock").read_text() == str(os.getpid())
    assert not path.with_name("results.sqlite.lock").exists()
    assert folder.exists()
    own = locks.temporary_folder()
    assert list(temporary.iterdir()) == [own]
    locks._remove(os.getpid())
    assert list(temporary.iterdir()) == []


def test_two_stores_of_one_process_exclude_each_other_too(tmp_path: Path) -> None:
    path = tmp_path / "results.sqlite"
    with store.Store(path), pytest.raises(ValueError, match="in use by another run"):
        store.Store(path)
    store.Store(path).close()


def test_a_forked_child_does_not_keep_the_lock(tmp_path: Path) -> None:
    """A worker that outlives its killed run by a moment must not stop the next."""
    path = tmp_path / "results.sqlite"
    results = store.Store(path)
    heard, say = os.pipe()
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        os.write(say, b"forked")
        signal.pause()
        os._exit(0)
    try:
        os.read(heard, 6)
        results._connection.close()
        for lock in results._locks:  # as the end of the process does
            lock.release()
        store.Store(path).close()
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


def test_folders_of_other_users_and_running_processes_are_not_removed(
    temporary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine, other, link, target = (temporary / name for name in ("gnomon-run-a", "gnomon-x", "gnomon-run-b", "target"))
    for folder in (mine, other, target):
        folder.mkdir()
        (folder / "content").write_text("kept")
    link.symlink_to(target)
    with monkeypatch.context() as patch:
        patch.setattr(locks.os, "getuid", lambda: 12345)
        locks._remove_abandoned()
    assert mine.exists(), "the folder of another user"
    locks._remove_abandoned()
    assert {path.name for path in temporary.iterdir()} == {"gnomon-x", "gnomon-run-b", "target"}
    assert (target / "content").read_text() == "kept"


def test_a_lock_file_that_was_removed_while_it_was_opened_is_opened_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between opening and locking, the last holder may end and remove the file: that lock would exclude no other run."""
    path, opened, true_open = tmp_path / "a", [], os.open

    def open_and_lose(name: Any, *arguments: Any) -> int:
        descriptor = true_open(name, *arguments)
        opened.append(descriptor)
        if len(opened) == 1:
            path.unlink()
        return descriptor

    monkeypatch.setattr(locks.os, "open", open_and_lose)
    lock = locks.Lock(path, os.O_RDWR | os.O_CREAT)
    assert len(opened) == 2
    assert os.path.samestat(os.fstat(lock.descriptor), path.stat())
