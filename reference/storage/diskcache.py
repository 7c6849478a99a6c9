"""Dear results kept on disk: arrays and JSON under a key, sound or absent."""

from __future__ import annotations

import hashlib
import io
import json
import os
import threading
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from gnomon.reference.storage import cachefolder
from numpy.typing import NDArray

from gnomon import __version__

_NOTES = "notes"


@dataclass(frozen=True)
class Entry:
    """What is kept: named arrays, and notes that JSON can express."""

    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    notes: Any = None


def folder() -> Path:
    """Where entries live, in the user's cache folder (XDG_CACHE_HOME is honoured on Linux)."""
    return Path(platformdirs.user_cache_dir("gnomon")) / "results"


def cached(key: str, build: Callable[[], Entry]) -> Entry:
    """The entry under `key`, built and kept where there is none or where its file is damaged.

    `key` names everything that the result depends on; the version of gnomon is added to it. A folder that cannot be
    written costs the keeping, not the result. Raises ValueError for a folder that another user could write.
    """
    found = load(key)
    if found is not None:
        return found
    entry = build()
    store_or_warn(key, entry)
    return entry


def store_or_warn(key: str, entry: Entry) -> None:
    """Keep an entry, or warn that the folder cannot be written."""
    cachefolder.store_or_warn(folder(), _name(key), _content(entry))


def load(key: str) -> Entry | None:
    """The entry under `key`, None where there is none or where its file is damaged or made by somebody else."""
    payload = cachefolder.load(folder(), _name(key))
    if payload is None:
        return None
    try:
        with np.load(io.BytesIO(payload), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        notes = json.loads(arrays.pop(_NOTES).tobytes())
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None  # written by another format of this file under the same version
    return Entry(arrays, notes)


def store(key: str, entry: Entry) -> None:
    """Keep an entry."""
    cachefolder.store(folder(), _name(key), _content(entry))


def _content(entry: Entry) -> bytes:
    if _NOTES in entry.arrays:
        raise ValueError(f"an array may not be called {_NOTES!r}")
    notes = np.frombuffer(json.dumps(entry.notes).encode(), dtype=np.uint8)
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **{_NOTES: notes, **entry.arrays})
    return buffer.getvalue()


def replace(path: Path, content: bytes) -> None:
    """Write a file; readers see the old one or the whole new one."""
    with whole(path) as part:
        part.write_bytes(content)


@contextmanager
def whole(target: Path) -> Iterator[Path]:
    """A file beside the target to write to, put in its place at the end: where writing fails, nothing is half there."""
    # Of this thread alone; the name ends as it did, for pandas compresses what ends in .gz.
    part = target.with_name(f".part.{os.getpid()}.{threading.get_ident()}.{target.name}")
    try:
        yield part
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def _name(key: str) -> str:
    return hashlib.sha256(f"gnomon {__version__}\n{key}".encode()).hexdigest()[:40] + ".bin"
