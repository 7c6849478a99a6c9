"""Modules of generated text: their names, how one is loaded, where their machine code is kept, who is told of compiling."""

from __future__ import annotations

import hashlib
import linecache
import os
import sys
import types
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import platformdirs

WATCHERS: list[Callable[[bool], None]] = []
"""Each is called with True before something is compiled in this process and with False after."""


@contextmanager
def announced() -> Iterator[None]:
    """Around what is compiled: the watchers hear of both ends, however it ends."""
    for watcher in WATCHERS:
        watcher(True)
    try:
        yield
    finally:
        for watcher in WATCHERS:
            watcher(False)


def cache_folder() -> Path:
    """Where machine code is kept; NUMBA_CACHE_DIR is honoured."""
    root = os.environ.get("NUMBA_CACHE_DIR")
    return Path(root or platformdirs.user_cache_dir("gnomon")) / "kernels"


def module_name(source: str) -> str:
    return "gnomon_" + hashlib.sha256(source.encode()).hexdigest()[:24]


@cache
def load_module(source: str) -> types.ModuleType:
    """A module of this text, under a name that is its hash. It lies in no file: an edited one would be run."""
    name = module_name(source)
    path, content = f"<{name}>", f"from __future__ import annotations\n{source}"
    linecache.cache[path] = (len(content), None, content.splitlines(keepends=True), path)
    module = types.ModuleType(name)
    sys.modules[name] = module
    exec(compile(content, path, "exec"), module.__dict__)
    return module
