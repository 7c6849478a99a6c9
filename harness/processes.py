"""How child processes are started, and how they end when their parent does."""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import os
import signal
import sys
import threading
import types
from collections.abc import Iterator
from multiprocessing import forkserver
from typing import Any


def context(method: str = "forkserver") -> Any:
    """The multiprocessing context of workers: forks of a server that has imported what they need."""
    found = multiprocessing.get_context(method)
    if method == "forkserver":
        found.set_forkserver_preload(["gnomon.harness.preload"])
        with interrupts_ignored():
            forkserver.ensure_running()
    return found


@contextlib.contextmanager
def interrupts_ignored() -> Iterator[None]:
    """Programs started within never see Ctrl-C, not even while they import: an ignored signal stays ignored."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def main_hidden(hidden: bool) -> Iterator[None]:
    """Children started within import gnomon and not the script that runs, which then needs no `__main__` guard.

    Not where `hidden` is False: what a child needs may be defined in that script.
    """
    main = sys.modules["__main__"]
    if hidden:
        sys.modules["__main__"] = types.ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def die_with_parent() -> None:
    """Ask the kernel to kill this process when its parent ends, however it ends."""
    if sys.platform == "linux":
        PR_SET_PDEATHSIG = 1
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        return
    parent = os.getppid()

    def watch() -> None:
        pause = threading.Event()
        while os.getppid() == parent:
            pause.wait(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def quiet_child() -> None:
    """Of a child process: it ends with its parent, and leaves Ctrl-C for that to handle."""
    die_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
