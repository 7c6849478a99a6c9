"""Files of a cache, in a folder that only this user can write: a file is read back as it was stored, or not at all.

Each file begins with a code (HMAC-SHA-256, RFC 2104) over its name and its content, by a random key in the same folder
that only this user can read. A file that is damaged, renamed, or written by somebody without that key has another code
and counts as absent. Files are opened relative to the open folder whose owner and mode were verified, so that nobody
can exchange the folder in between.
"""

from __future__ import annotations

import errno
import hashlib
import hmac
import multiprocessing
import os
import secrets
import stat
import threading
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

KEY = "key"
PRIVATE_FOLDER, PRIVATE_FILE = 0o700, 0o600
KEEPS = os.open in os.supports_dir_fd
"""Whether this system opens files relative to an open folder; where it does not (Windows), nothing is kept."""
MOST_BYTES = 2**30
"""A larger file is neither read nor written: the largest table of a motion takes a tenth of it."""
_LENGTH = 32
"""Length of the key, and of a code, in bytes."""
_BLOCK = 4096
_warned: set[Path] = set()


def load(folder: Path, name: str) -> bytes | None:
    """The content stored under a name; None where there is none, where its code is wrong, and above MOST_BYTES.

    Raises ValueError where another user could write the folder.
    """
    if not KEEPS:
        return None
    try:
        with _opened(folder) as descriptor:
            key, content = _read(descriptor, KEY), _read(descriptor, name)
    except OSError:
        return None
    sound = len(key) == _LENGTH and hmac.compare_digest(_code(key, name, content[_LENGTH:]), content[:_LENGTH])
    return content[_LENGTH:] if sound else None


def store(folder: Path, name: str, content: bytes) -> None:
    """Keep a file if KEEPS; readers see the old one or the whole new one. Folders that do not exist are made, mode 0700.

    A content above MOST_BYTES is not kept. Raises OSError where the folder cannot be written, ValueError where another
    user could.
    """
    if not KEEPS or len(content) > MOST_BYTES - _LENGTH:
        return
    _make(folder)
    with _opened(folder) as descriptor:
        _write(descriptor, name, _code(_key(descriptor), name, content) + content)


def show(folder: Path, name: str, content: bytes) -> bool:
    """Put a file there for people, without a code: `load` refuses it. Gives whether it is there.

    Raises ValueError where another user could write the folder.
    """
    if not KEEPS:
        return False
    try:
        _make(folder)
        with _opened(folder) as descriptor:
            _write(descriptor, name, content)
    except OSError:
        return False
    return True


def store_or_warn(folder: Path, name: str, content: bytes) -> None:
    """Keep a file, or warn that the folder cannot be written. Raises ValueError where another user could write it."""
    try:
        store(folder, name, content)
    except OSError as error:
        _warn({folder: error})


def prepare(*folders: Path) -> None:
    """Make the folders; warn of those that cannot be written. Raises ValueError where another user could write one."""
    failed = {}
    for folder in folders if KEEPS else ():
        name = f".probe.{os.getpid()}"
        try:
            store(folder, name, bytes(_BLOCK))
            with _opened(folder) as descriptor:
                os.unlink(name, dir_fd=descriptor)
        except OSError as error:
            failed[folder] = error
    _warn(failed)


def _warn(failed: Mapping[Path, OSError]) -> None:
    """Warn once in a process, and not in child processes: their parent has verified the folders."""
    new = {folder: error for folder, error in failed.items() if folder not in _warned}
    if not new or multiprocessing.parent_process() is not None:
        return
    _warned.update(new)
    what = ", ".join(f"{folder} cannot be written ({error.strerror})" for folder, error in new.items())
    text = "nothing is kept there, and each process computes its own; free some space, or set XDG_CACHE_HOME"
    warnings.warn(f"{what}: {text} to a folder of your own", stacklevel=4)


def _make(folder: Path) -> None:
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    for path in reversed(missing):
        with suppress(FileExistsError):  # another process was faster, or a link to nowhere, which is refused later
            path.mkdir(mode=PRIVATE_FOLDER)


@contextmanager
def _opened(folder: Path) -> Iterator[int]:
    """A descriptor of the folder, after it (and the folder above, if that is gnomon's own) was found safe."""
    for path in (folder.parent, folder) if folder.parent.name == "gnomon" else (folder,):
        _refuse_unsafe(path, os.lstat(path))
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        _refuse_unsafe(folder, os.fstat(descriptor))
        yield descriptor
    finally:
        os.close(descriptor)


def _refuse_unsafe(path: Path, status: os.stat_result) -> None:
    if stat.S_ISLNK(status.st_mode):
        what, way_out = "is a symbolic link", "replace it by a folder"
    elif status.st_uid != os.geteuid():
        what, way_out = f"belongs to another user ({status.st_uid}, you are {os.geteuid()})", "remove it"
    elif status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        # their codes refuse files written by others, but these may know the key
        what, way_out = f"can be written by other users (mode {stat.S_IMODE(status.st_mode):04o})", "remove it"
    else:
        return
    raise ValueError(
        f"{path} {what}, so code and numbers of the cache could be theirs; {way_out}, or set XDG_CACHE_HOME to a folder"
        " of your own"
    )


def _key(descriptor: int) -> bytes:
    """The key of a folder, made where there is no valid one."""
    with suppress(FileNotFoundError):
        key = _read(descriptor, KEY)
        if len(key) == _LENGTH:
            return key
    _write(descriptor, KEY, secrets.token_bytes(_LENGTH))
    return _read(descriptor, KEY)  # perhaps another process wrote it; entries with an older code are computed anew


def _code(key: bytes, name: str, content: bytes) -> bytes:
    return hmac.digest(key, hashlib.sha256(name.encode()).digest() + content, "sha256")


def _read(folder: int, name: str) -> bytes:
    descriptor = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=folder)
    with open(descriptor, "rb") as file:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "not a regular file", name)
        if status.st_size > MOST_BYTES:
            raise OSError(errno.EFBIG, "larger than all that gnomon keeps", name)
        return file.read()


def _write(folder: int, name: str, content: bytes) -> None:
    part = f".part.{os.getpid()}.{threading.get_ident()}.{name}"
    try:
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW
        with open(os.open(part, flags, PRIVATE_FILE, dir_fd=folder), "wb") as file:
            file.write(content)
        os.replace(part, name, src_dir_fd=folder, dst_dir_fd=folder)
    finally:
        with suppress(FileNotFoundError):
            os.unlink(part, dir_fd=folder)
