"""File locks that are released when their process ends, in any way, and temporary folders held by such a lock."""

import atexit
import contextlib
import errno
import os
import shutil
import struct
import sys
import tempfile
import weakref
from collections.abc import Callable, Sequence
from multiprocessing import process
from pathlib import Path
from typing import Any

from gnomon.harness.system.limitations import need_fork

PREFIX = "gnomon-run-"
"""Prefix of temporary folders. The next run of a user removes folders that a killed process left behind."""
SOCKET_BYTES = 108 if sys.platform == "linux" else 104
"""Largest size of the path of a socket, in bytes, with a zero byte at its end."""
_SOCKET = "/listener-12345678"
"""A socket's name in the form of multiprocessing's server."""


def _lock_whole(descriptor: int) -> None:
    import fcntl  # absent on Windows, where no run reaches this

    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _lock_byte(descriptor: int) -> None:
    """Lock one byte behind the content of a file that SQLite has open, whose own locks are on other bytes; Linux only.

    On NFS flock would lock all bytes of the file.
    """
    import fcntl

    if sys.platform == "linux":
        try:
            fcntl.fcntl(descriptor, fcntl.F_OFD_SETLK, struct.pack("hhqqi0q", fcntl.F_WRLCK, os.SEEK_SET, 2**62, 1, 0))
        except OSError as error:
            if error.errno != errno.EINVAL:  # a kernel that has no such locks
                raise


class Lock:
    """An advisory lock on a file or folder, held until `release` or the end of this process."""

    descriptor = -1

    def __init__(self, path: Path, flags: int, lock: Callable[[int], None] = _lock_whole) -> None:
        """Raises BlockingIOError if it is held, OSError if the path cannot be opened or locked."""
        self.path = path
        if find_held(path) is not None:
            raise BlockingIOError(errno.EAGAIN, "locked by this process", str(path))
        _HELD.add(self)
        while not self._holds(path):  # the last holder may remove the path while this one opens it
            self.release()
            self.descriptor = os.open(path, flags | os.O_NOFOLLOW | os.O_CLOEXEC, 0o644)
            try:
                lock(self.descriptor)
            except OSError:
                self.release()
                raise

    def _holds(self, path: Path) -> bool:
        with contextlib.suppress(FileNotFoundError):
            return self.descriptor >= 0 and os.path.samestat(os.fstat(self.descriptor), os.lstat(path))
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
    """Release all locks in a forked child, whose inherited descriptors would hold them after the parent has ended."""
    for lock in list(_HELD):
        lock.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


def find_held(path: Path) -> int | None:
    """The descriptor of a file that this process has locked, to read it by; None without a lock.

    Another descriptor of the file, when it is closed, would end SQLite's own locks of this process on it.
    """
    return next((lock.descriptor for lock in list(_HELD) if lock._holds(path)), None)


def lock_results(path: Path) -> Sequence[Lock]:
    """The locks that a run holds while it writes the results file `path`, which is made if it is missing.

    The first is on `path`.lock, the second on the file itself, which may have further names (hard links). SQLite's own
    locks end with each transaction, so that two runs would each do all trials. Raises ValueError if another run holds a
    lock.
    """
    side = path.with_name(f"{path.name}.lock")
    held: list[Lock] = []
    try:
        held.append(Lock(side, os.O_RDWR | os.O_CREAT))
        held.append(Lock(path, os.O_RDWR | os.O_CREAT, _lock_byte))
    except BlockingIOError:
        holder = "" if held else side.read_text()
        release_results(held)
        raise ValueError(
            f"{path}: in use by another run{f' (process {holder})' if holder else ''}; wait for its end, or give"
            " another --out"
        ) from None
    except OSError:
        release_results(held)
        raise
    with contextlib.suppress(OSError):  # a full disk: the number is only for messages of others
        os.truncate(held[0].descriptor, 0)
        os.write(held[0].descriptor, str(os.getpid()).encode())
    return held


def release_results(held: Sequence[Lock]) -> None:
    """Release locks from `lock_results` and remove the file of the first lock; the next run makes another."""
    if held and held[0].descriptor >= 0:
        held[0].path.unlink(missing_ok=True)
    for lock in held:
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
    """Remove the folders that ended processes of this user left behind."""
    for path in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):  # of another user, a file, a link, or in use
            if os.lstat(path).st_uid != os.getuid():
                continue
            lock = Lock(path, os.O_RDONLY | os.O_DIRECTORY)
            shutil.rmtree(path, ignore_errors=True)
            lock.release()
