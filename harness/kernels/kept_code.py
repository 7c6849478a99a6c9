"""The folder of kept machine code, and announcements of compilations."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import platformdirs
from gnomon.harness.system.streams import has_terminal

WATCHERS: list[Callable[[bool], None]] = []
"""Functions that are called with True before each compilation in this process and with False after it."""


@contextmanager
def announce() -> Iterator[None]:
    """A context for a compilation: calls the watchers before it and after it, also after a compilation that fails."""
    for watcher in WATCHERS:
        watcher(True)
    try:
        yield
    finally:
        for watcher in WATCHERS:
            watcher(False)


@contextmanager
def show(name: str) -> Iterator[None]:
    """A context in which a terminal shows that `name` is solving, or is compiled, while it is."""
    if not has_terminal():
        yield
        return
    from rich.console import Console  # 50 ms, for terminals only

    with Console(stderr=True).status(f"solving by {name}") as status:

        def watch(begins: bool) -> None:
            status.update(f"compiling {name}, once on this machine" if begins else f"solving by {name}")

        WATCHERS.append(watch)
        try:
            yield
        finally:
            WATCHERS.remove(watch)


def cache_folder() -> Path:
    """The folder of kept machine code: under NUMBA_CACHE_DIR if that is set, else in the user's cache folder."""
    return Path(os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_dir("gnomon")) / "kernels"
