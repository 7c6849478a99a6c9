"""How much memory a worker may take: its share of what the machine, or the cgroup of this process, has."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

SHARE = 0.8
"""Of the memory, for all workers together: the rest is for the run itself and for what else is there."""


def worker_bytes(workers: int) -> int:
    """What each of several workers may take beyond what it starts with."""
    return int(SHARE * memory_bytes() / workers)


def memory_bytes(cgroups: Path = Path("/sys/fs/cgroup"), own: Path = Path("/proc/self/cgroup")) -> int:
    """The memory of the machine, or the least limit of the cgroups above this process where that is less."""
    machine = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return min(machine, *_limits(cgroups, own), machine)


def _limits(cgroups: Path, own: Path) -> Iterator[int]:
    """The limits in force by version 2 (one hierarchy) and version 1 (one a controller) of cgroups.

    In a container the path may be that outside it: what exists of it counts, up to the root.
    """
    lines = []
    with contextlib.suppress(OSError):
        lines = own.read_text().splitlines()
    for line in lines:
        _, controllers, path = line.split(":", 2)
        if controllers == "":
            folder, name = cgroups, "memory.max"
        elif "memory" in controllers.split(","):
            folder, name = cgroups / "memory", "memory.limit_in_bytes"
        else:
            continue
        below = Path(path.lstrip("/"))
        for one in (below, *below.parents):
            with contextlib.suppress(OSError, ValueError):  # not there, or "max"
                yield int((folder / one / name).read_text())


def address_space_bytes() -> int:
    """The address space of this process now: libraries reserve gigabytes that they never touch. 0 where unknown."""
    with contextlib.suppress(OSError):
        return int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    return 0
