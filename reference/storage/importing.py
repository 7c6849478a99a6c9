"""Imports the modules of users, which may raise anything and may try to end the process."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn


@contextmanager
def confined() -> Iterator[None]:
    """Within the block `os._exit`, which would end a command without a word, raises SystemExit in the thread that calls this.

    Other threads, which end an interrupted command, and processes that a module forks end as they want.
    """
    here, end = (os.getpid(), threading.get_ident()), os._exit

    def refuse(status: int) -> NoReturn:
        if (os.getpid(), threading.get_ident()) != here:
            end(status)
        raise SystemExit(f"os._exit({status})")

    os._exit = refuse
    try:
        yield
    finally:
        os._exit = end
