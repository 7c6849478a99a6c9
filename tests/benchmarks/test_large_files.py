"""The report and the comparison of 20,000 measurements: their time, their memory, and the work for each measurement."""

import cProfile
import pstats
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import many_measurements
import pytest
from gnomon.harness.reporting import report_pack
from gnomon.harness.reporting.report import write_report
from gnomon.harness.results import store
from gnomon.harness.results.regression import compare

MEASUREMENTS = 20_000
MOST_MEGABYTES = 300
CALLS = 100
"""Python's calls for a measurement, at most: pandas would make hundreds of calls for a table of each series."""
PROGRAM = """
from gnomon.harness.commands.cli import main
try:
    main()
finally:
    print(*(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""
"""Runs a command, and prints the most memory that its process had, in units of 1024 bytes."""


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return many_measurements.write(tmp_path_factory.mktemp("large") / "results.sqlite", MEASUREMENTS)


@pytest.mark.slow
def test_writing_a_report(benchmark: Any, large: Path, tmp_path: Path) -> None:
    benchmark.pedantic(write_report, (large, tmp_path), rounds=3, warmup_rounds=1)


@pytest.mark.slow
def test_comparing_two_files(benchmark: Any, large: Path) -> None:
    verdict = benchmark.pedantic(lambda: compare(store.load(large), store.load(large)), rounds=3)
    assert not verdict.failed


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
@pytest.mark.parametrize("command", ["report", "compare"])
def test_a_command_takes_little_memory(command: str, large: Path, tmp_path: Path) -> None:
    """The whole process, imports included. The script that draws charts is made once for each version of a library."""
    report_pack.pack_vega()
    arguments = ["--to", str(tmp_path)] if command == "report" else [str(large)]
    words = [sys.executable, "-c", PROGRAM, command, str(large), *arguments]
    printed = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True).stdout
    assert int(printed.split()[-1]) / 1024 <= MOST_MEGABYTES


def calls(work: Callable[[], object]) -> int:
    profile = cProfile.Profile()
    profile.runcall(work)
    return int(pstats.Stats(profile).total_calls)  # type: ignore[attr-defined]


def test_the_work_for_a_measurement_is_small(tmp_path: Path) -> None:
    """Calls are counted: every machine makes equally many. Work that is done once, as opening a file, is left out."""
    counts, rows = [], []
    for least in (1000, 3000):
        frame = store.load(many_measurements.write(tmp_path / f"{least}.sqlite", least))
        rows.append(len(frame))
        counts.append(calls(lambda: compare(frame, frame)))  # noqa: B023 (called at once)
    assert (counts[1] - counts[0]) / (rows[1] - rows[0]) <= CALLS
