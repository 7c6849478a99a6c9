"""How child processes are started, and how they end when their parent does."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
from typing import Any


def context(method: str = "forkserver") -> Any:
    """The multiprocessing context of workers: forks of a server that has imported what they need."""
    found = multiprocessing.get_context(method)
    if method == "forkserver":
        found.set_forkserver_preload(["gnomon.harness.preload"])
    return found


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
