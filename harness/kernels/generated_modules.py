"""Name and load modules of generated source text, find the folder of their machine code, and announce compilations."""

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
from gnomon.reference.storage import cachefolder

WATCHERS: list[Callable[[bool], None]] = []
"""Functions that are called with True before each compilation in this process and with False after it."""


@contextmanager
def announced() -> Iterator[None]:
    """A context for a compilation: calls the watchers before it and after it, also after a compilation that fails."""
    for watcher in WATCHERS:
        watcher(True)
    try:
        yield
    finally:
        for watcher in WATCHERS:
            watcher(False)


def cache_folder() -> Path:
    """The folder of kept machine code: under NUMBA_CACHE_DIR if that is set, else in the user's cache folder."""
    root = os.environ.get("NUMBA_CACHE_DIR")
    return Path(root or platformdirs.user_cache_dir("gnomon")) / "kernels"


def module_name(source: str) -> str:
    return "gnomon_" + hashlib.sha256(source.encode()).hexdigest()[:24]


@cache
def load_module(source: str, path: str = "") -> types.ModuleType:
    """Load this text as a module that is named by its hash; tracebacks and numba's errors show its lines.

    The text is also written to the cache folder, for readers, debuggers and profilers. It is never read from there or
    from `path`, as someone could edit the file.
    """
    name, content = module_name(source), f"from __future__ import annotations\n{source}"
    folder, file = cache_folder(), f"{name}.py"
    if not path:
        path = str(folder / file) if cachefolder.show(folder, file, content.encode()) else f"<{name}>"
    linecache.cache[path] = (len(content), None, content.splitlines(keepends=True), path)
    module = types.ModuleType(name)
    sys.modules[name] = module
    exec(compile(content, path, "exec"), module.__dict__)
    return module
