"""Expensive results kept on disk: arrays and JSON under a key; a damaged entry counts as absent."""

from __future__ import annotations

import hashlib
import io
import json
import multiprocessing
import os
import threading
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from gnomon.reference.storage import cachefolder
from gnomon.reference.storage.version import VERSION
from numpy.typing import NDArray

_NOTES = "notes"
_CODE_BYTES = 16
"""Length of the code before each content of a pack."""


@dataclass(frozen=True)
class Entry:
    """A result: named arrays, and notes that JSON can express."""

    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    notes: Any = None


def folder() -> Path:
    """Where entries live, in the user's cache folder (XDG_CACHE_HOME is honoured on Linux)."""
    return Path(platformdirs.user_cache_dir("gnomon")) / "results"


def cached(key: str, build: Callable[[], Entry], pack: Path | None = None) -> Entry:
    """The entry under `key`, from the folder or a pack; built and kept where there is none, or where its file is damaged.

    `key` names everything that the result depends on; the version of gnomon is added to it. If the folder cannot be
    written, the entry is returned and not kept. Raises ValueError for a folder that another user could write.
    """
    entry = load(key, pack)
    if entry is None:
        entry = build()
        store_or_warn(key, entry)
    return entry


def store_or_warn(key: str, entry: Entry) -> None:
    """Keep an entry, or warn that the folder cannot be written."""
    cachefolder.store_or_warn(folder(), _name(key), _content(entry))


def load(key: str, pack: Path | None = None) -> Entry | None:
    """The entry under `key`; None where there is none, or where its file is damaged or written by somebody else.

    `pack` is a file of `write_pack` that is part of the package; it is looked up after the folder.
    """
    content = cachefolder.load(folder(), _name(key))
    if content is None and pack is not None:
        content = _packed(pack).get(_name(key))
    try:
        return None if content is None else _entry(content)
    except Exception:  # numpy and zipfile raise exceptions of many classes for files that are not entries
        return None


def store(key: str, entry: Entry) -> None:
    """Keep an entry."""
    cachefolder.store(folder(), _name(key), _content(entry))


def write_pack(path: Path, entries: Mapping[str, Entry]) -> None:
    """One file with all entries, by their keys; the same entries give the same bytes."""
    with whole(path) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for name, content in sorted((_name(key), _content(entry)) for key, entry in entries.items()):
            file.writestr(zipfile.ZipInfo(name), _code(name, content) + content, zipfile.ZIP_DEFLATED)


@cache
def _packed(pack: Path) -> dict[str, bytes]:
    """The contents of a pack by name. One that cannot be read, or that has the code of another name or content, is left
    out with a warning, and is computed."""
    contents: dict[str, bytes] = {}
    damage: Exception | None = None
    try:
        with zipfile.ZipFile(pack) as file:
            for name in file.namelist():
                try:
                    coded = file.read(name)
                    content = coded[_CODE_BYTES:]
                    if coded != _code(name, content) + content:
                        raise ValueError(f"{name} holds something else")
                    contents[name] = content
                except Exception as error:  # zipfile raises exceptions of many classes, RuntimeError among them
                    damage = error
    except FileNotFoundError:
        pass
    except Exception as error:
        damage = error
    if damage is not None and multiprocessing.parent_process() is None:
        warnings.warn(f"{pack}: damaged ({damage}); missing entries are computed; install gnomon again", stacklevel=2)
    return contents


def _code(name: str, content: bytes) -> bytes:
    """Binds the content of a pack to its name."""
    return hashlib.sha256(name.encode() + content).digest()[:_CODE_BYTES]


def _entry(content: bytes) -> Entry:
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    notes = json.loads(arrays.pop(_NOTES).tobytes())
    return Entry(arrays, notes)


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
    """A file beside the target to write to, renamed to it at the end: a failure leaves no partial file."""
    # The name is unique to this thread and keeps its ending, because pandas compresses files that end in .gz.
    part = target.with_name(f".part.{os.getpid()}.{threading.get_ident()}.{target.name}")
    try:
        yield part
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def _name(key: str) -> str:
    return hashlib.sha256(f"gnomon {VERSION}\n{key}".encode()).hexdigest()[:40] + ".bin"
