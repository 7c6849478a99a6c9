"""Waiting for a condition with a limit, so that a test that would wait forever fails and says for what."""

import time
from collections.abc import Callable
from pathlib import Path

import pytest

LIMIT_SECONDS = 120.0
"""No condition takes more than a second on a quiet machine."""
LONG_SECONDS = 900.0
"""The limit of trials that are to end by themselves: they take less than a second on a quiet machine."""


def wait_until(condition: Callable[[], object], what: str, seconds: float = LIMIT_SECONDS) -> None:
    """Return once `condition()` is true; fail with `what` if it is not within `seconds`."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            pytest.fail(f"not within {seconds:g} s: {what}")
        time.sleep(0.005)


def with_variable(name: str, value: object) -> list[int]:
    """Processes that have a variable in their environment, which all that a process starts inherit; ended ones have none."""
    wanted, found = f"{name}={value}".encode(), []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            if wanted in (path / "environ").read_bytes().split(b"\0"):
                found.append(int(path.name))
        except OSError:
            continue
    return found
