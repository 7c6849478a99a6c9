"""File locks that are released when their process ends, however it ends, and temporary folders held by such a lock."""

import atexit
import contextlib
import os
import shutil
import sys
import tempfile
import weakref
from multiprocessing import process
from pathlib import Path
from typing import Any

from gnomon.harness.system.limitations import need_fork

PREFIX = "gnomon-run-"
"""Prefix of temporary folders. The next run of the same user removes those that a killed process left behind."""
SOCKET_BYTES = 108 if sys.platform == "linux" else 104
"""The most bytes of the path of a socket, with a zero byte at its end."""
_SOCKET = "/listener-12345678"
"""As the server of multiprocessing names its socket."""


class Lock:
    """An advisory lock (flock) on a file or folder, held until `release` or the end of this process."""

    descriptor = -1

    def __init__(self, path: Path, flags: int) -> None:
        """Raises BlockingIOError where another process holds it, OSError where the path cannot be opened or locked."""
        import fcntl  # absent on Windows, where no run reaches this

        self.path = path
        _HELD.add(self)
        while not self._still_there():  # the last holder may remove the path while this one opens it
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
        """Release the lock; a second call does nothing."""
        descriptor, self.descriptor = self.descriptor, -1
        if descriptor >= 0:
            os.close(descriptor)

    def __del__(self) -> None:
        self.release()


_HELD: weakref.WeakSet[Lock] = weakref.WeakSet()


def _leave_to_parent() -> None:
    """Called in a forked child: inherited descriptors would hold the locks after the parent has ended."""
    for lock in list(_HELD):
        lock.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


def lock_results(path: Path) -> Lock:
    """The lock on `path`.lock that a run holds while it writes the results file `path`.

    SQLite's own locks end with each transaction, so two runs would each do all trials. Raises ValueError where another
    run holds it.
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
    with contextlib.suppress(OSError):  # a full disk: the number is only for messages of others
        os.truncate(lock.descriptor, 0)
        os.write(lock.descriptor, str(os.getpid()).encode())
    return lock


def release_results(lock: Lock) -> None:
    """Release a lock from `lock_results` and remove its file; the next run makes another."""
    if lock.descriptor >= 0:
        lock.path.unlink(missing_ok=True)
    lock.release()


_OWN: dict[int, tuple[Path, Lock]] = {}
"""The temporary folder and its lock by process number: a forked child, which has another number, makes its own."""


def temporary_folder() -> Path:
    """The folder for all temporary files of this process, made and locked on the first call.

    It is removed at the end of the process; after kill -9 the next process that calls this removes it.
    """
    need_fork()
    if os.getpid() not in _OWN or not _OWN[os.getpid()][0].exists():
        folder = tempfile.gettempdir()
        excess = len(os.fsencode(f"{folder}/{PREFIX}12345678{_SOCKET}")) + 1 - SOCKET_BYTES
        if excess > 0:
            raise ValueError(
                f"TMPDIR={folder}: {excess} bytes too long for the path of a socket in it; name a shorter one"
            )
        _remove_abandoned()
        while True:
            path = Path(tempfile.mkdtemp(prefix=PREFIX))
            with contextlib.suppress(OSError):  # another process removed it before it was locked
                _OWN[os.getpid()] = path, Lock(path, os.O_RDONLY | os.O_DIRECTORY)
                break
        atexit.register(_remove, os.getpid())
        current: Any = process.current_process()
        current._config["tempdir"] = str(path)  # also for the socket of multiprocessing's server
    return _OWN[os.getpid()][0]


def _remove(owner: int) -> None:
    if os.getpid() == owner and owner in _OWN:
        path, lock = _OWN.pop(owner)
        shutil.rmtree(path, ignore_errors=True)
        lock.release()


def _remove_abandoned() -> None:
    """Remove the folders of ended processes of this user."""
    for path in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):  # of another user, a file, a link, or in use
            if os.lstat(path).st_uid != os.getuid():
                continue
            lock = Lock(path, os.O_RDONLY | os.O_DIRECTORY)
            shutil.rmtree(path, ignore_errors=True)
            lock.release()
