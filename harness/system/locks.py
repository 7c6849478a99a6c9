"""Locks that end with their process, however it ends, and the temporary folder that such a lock keeps."""

from __future__ import annotations

import atexit
import contextlib
import fcntl
import os
import shutil
import tempfile
import weakref
from multiprocessing import process
from pathlib import Path
from typing import Any

PREFIX = "gnomon-run-"
"""Of temporary folders: one of a process that ended without tidying up is removed by the next run of its user."""


class Lock:
    """An advisory lock (flock) on a file or folder, until `release` or the end of this process."""

    descriptor = -1

    def __init__(self, path: Path, flags: int) -> None:
        """Raises BlockingIOError where another holds it, OSError where the path cannot be opened or locked."""
        self.path = path
        _HELD.add(self)
        while not self._still_there():  # its holder before may remove the path while this one opens it
            self.release()
            self.descriptor = os.open(path, flags | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
            try:
                fcntl.flock(self.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                self.release()
                raise

    def _still_there(self) -> bool:
        with contextlib.suppress(FileNotFoundError):
            return self.descriptor >= 0 and os.path.samestat(os.fstat(self.descriptor), os.lstat(self.path))
        return False

    def release(self) -> None:
        """Give the lock up; a second time does nothing."""
        descriptor, self.descriptor = self.descriptor, -1
        if descriptor >= 0:
            os.close(descriptor)

    def __del__(self) -> None:
        self.release()


_HELD: weakref.WeakSet[Lock] = weakref.WeakSet()


def _leave_to_parent() -> None:
    """In a forked child: what it inherits would keep the locks of a parent that ended."""
    for lock in list(_HELD):
        lock.release()


os.register_at_fork(after_in_child=_leave_to_parent)


def lock_results(path: Path) -> Lock:
    """The lock of the one run that may write a results file, on `path`.lock beside it.

    SQLite's own locks last a transaction, and two runs would each do all trials. Raises ValueError where a run has it.
    """
    side = path.with_name(f"{path.name}.lock")
    try:
        lock = Lock(side, os.O_RDWR | os.O_CREAT)
    except BlockingIOError:
        holder = side.read_text()
        raise ValueError(
            f"{path}: in use by another run{f' (process {holder})' if holder else ''}; wait for its end, or give"
            " another --out"
        ) from None
    with contextlib.suppress(OSError):  # a full disk: the number is only told to others, the lock holds without
        os.truncate(lock.descriptor, 0)
        os.write(lock.descriptor, str(os.getpid()).encode())
    return lock


def release_results(lock: Lock) -> None:
    """Give up what `lock_results` gave, and remove its file: the next run makes another."""
    if lock.descriptor >= 0:
        lock.path.unlink(missing_ok=True)
    lock.release()


_OWN: dict[int, tuple[Path, Lock]] = {}
"""The temporary folder of this process by its number, which a forked child does not share."""


def temporary_folder() -> Path:
    """The folder of this process for all that it leaves in the temporary folder, made and locked on the first call.

    It is removed at the end of the process, after kill -9 by the next process that calls this.
    """
    if os.getpid() not in _OWN or not _OWN[os.getpid()][0].exists():
        _sweep()
        while True:
            path = Path(tempfile.mkdtemp(prefix=PREFIX))
            with contextlib.suppress(OSError):  # another's sweep took it before it was locked
                _OWN[os.getpid()] = path, Lock(path, os.O_RDONLY | os.O_DIRECTORY)
                break
        atexit.register(_remove, os.getpid())
        current: Any = process.current_process()
        current._config["tempdir"] = str(path)  # the socket of multiprocessing's server too
    return _OWN[os.getpid()][0]


def _remove(owner: int) -> None:
    if os.getpid() == owner and owner in _OWN:
        path, lock = _OWN.pop(owner)
        shutil.rmtree(path, ignore_errors=True)
        lock.release()


def _sweep() -> None:
    """Remove the folders of ended processes of this user."""
    for path in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):  # another's, a file, a link, or in use
            if os.lstat(path).st_uid != os.getuid():
                continue
            lock = Lock(path, os.O_RDONLY | os.O_DIRECTORY)
            shutil.rmtree(path, ignore_errors=True)
            lock.release()
