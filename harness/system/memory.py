"""The memory limit of a worker: its share of the memory of the machine or of the cgroup of this process."""

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

SHARE = 0.8
"""Share of the memory for all workers together: the rest is for the run itself and for other processes."""


def worker_bytes(workers: int) -> int:
    """Bytes that each of several workers may allocate beyond its memory at the start."""
    return int(SHARE * memory_bytes() / workers)


def memory_bytes(cgroups: Path = Path("/sys/fs/cgroup"), own: Path = Path("/proc/self/cgroup")) -> int:
    """Bytes of memory of the machine, or the smallest limit of the cgroups above this process if it is less."""
    machine = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return min(machine, *_limits(cgroups, own), machine)


def _limits(cgroups: Path, own: Path) -> Iterator[int]:
    """The limits, in bytes, of cgroups of version 2 (one hierarchy) and version 1 (a hierarchy for each controller).

    In a container the path may lead outside: only those folders of it that exist are read, up to the root.
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
        for group in (below, *below.parents):
            with contextlib.suppress(OSError, ValueError):  # no such file, or "max"
                yield int((folder / group / name).read_text())


def address_space_bytes() -> int:
    """Bytes of address space of this process now, with gigabytes that libraries reserve and never use; 0 if unknown."""
    with contextlib.suppress(OSError):
        return int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    return 0


def limit_memory(more: int) -> None:
    """Let this process allocate `more` bytes beyond its memory now, where the system enforces such a limit (Linux)."""
    import resource  # absent on Windows

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # a core dump of an aborted worker takes seconds
    if sys.platform != "linux":
        return  # macOS enforces no limit of the address space
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    most = address_space_bytes() + more
    resource.setrlimit(resource.RLIMIT_AS, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
