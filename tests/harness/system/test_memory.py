"""The memory of a worker is a share of the machine's memory or of its cgroup's limit, whichever is less."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from gnomon.harness.system import memory

MACHINE = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def limited(folder: Path, path: str, limits: dict[str, str], line: str) -> int:
    """The result where /proc gives `line` for this process, and the files under `path` contain `limits`."""
    for name, value in limits.items():
        file = folder / path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(value)
    own = folder / "own"
    own.write_text(f"3:cpu:/x\n{line}\n")
    return memory.memory_bytes(folder, own)


@pytest.mark.parametrize(
    ("limits", "found"),
    [
        ({"a/b/memory.max": "max\n", "a/memory.max": "5000000\n"}, 5_000_000),
        ({"a/b/memory.max": "4000000\n", "a/memory.max": "5000000\n"}, 4_000_000),
        ({"memory.max": "3000000"}, 3_000_000),
        ({"a/b/memory.max": "max"}, MACHINE),
        ({"a/b/memory.max": str(2**62)}, MACHINE),
        ({}, MACHINE),
    ],
)
def test_the_smallest_limit_above_the_process_counts(tmp_path: Path, limits: dict[str, str], found: int) -> None:
    assert limited(tmp_path, "", limits, "0::/a/b") == found


def test_version_1_has_its_own_hierarchy_and_a_container_sees_only_its_root(tmp_path: Path) -> None:
    limits = {"memory.limit_in_bytes": "7000000", "elsewhere/memory.limit_in_bytes": "1"}
    assert limited(tmp_path, "memory", limits, "4:cpuset,memory:/docker/0123") == 7_000_000


def test_without_cgroups_it_is_the_memory_of_the_machine(tmp_path: Path) -> None:
    assert memory.memory_bytes(tmp_path, tmp_path / "absent") == MACHINE


def test_all_workers_together_take_a_share() -> None:
    assert 3 * memory.worker_bytes(3) <= 0.8 * memory.memory_bytes() < 3 * (memory.worker_bytes(3) + 1)


LIMITED = """
from gnomon.harness.system.memory import limit_memory
import numpy
kept = bytearray(2**28)
limit_memory(2**27)
fits = bytearray(2**26)
try:
    bytearray(2**27)
except MemoryError:
    print("limited")
"""


def test_the_memory_of_a_worker_at_its_start_is_not_in_its_share() -> None:
    """Libraries reserve gigabytes of addresses: with a small share alone they could not start."""
    ran = subprocess.run([sys.executable, "-c", LIMITED], capture_output=True, text=True, timeout=120, check=True)
    assert ran.stdout == "limited\n"
