"""The report and the comparison of 20,000 measurements: their time, their memory, and the work for each measurement."""

import cProfile
import pstats
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import synthetic
from gnomon.harness.reporting import report_pack
from gnomon.harness.reporting.report import write_report
from gnomon.harness.results import reading, schema
from gnomon.harness.results.regression import compare

MEASUREMENTS = 20_000
MOST_MEGABYTES = 300
COPIED = ("trials", "planned", "measurements", "settings_changed", "sampled_states")
METHODS = 4
"""Copies of an integrator: a run of all suites has some dozens of them."""
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


def write_many(path: Path, least: int) -> Path:
    """Write at least this number of invented measurements of one launch, copied under further names, and return the path."""
    synthetic.write(path)
    with closing(schema.with_checksums(sqlite3.connect(path))) as db, db:
        for table in ("settings_changed", "sampled_states", "measurements"):
            db.execute(
                f"DELETE FROM {table} WHERE measurement IN (SELECT measurement FROM measurements WHERE launch > 1)"
            )
        ((count, last),) = db.execute("SELECT count(*), max(measurement) FROM measurements").fetchall()
        rows = {table: db.execute(f"SELECT max(rowid) FROM {table}").fetchone()[0] for table in COPIED}
        for copy in range(1, -(-least // count)):
            other = {"measurement": f"measurement + {copy * last}"}
            other |= {name: f"{name} || ' #{copy}'" for name in ("trial_key", "series")}
            other |= {'"case"': f"\"case\" || ' {copy // METHODS}'"} if copy >= METHODS else {}
            other |= {
                name: f"{name} || ' {copy % METHODS}'" for name in ("integrator", "integrator_id") if copy % METHODS
            }
            for table in COPIED:
                names = [f'"{name}"' if name == "case" else name for name in schema.TABLES[table]]
                values = ", ".join(other.get(name, name) for name in names)
                db.execute(
                    f"INSERT INTO {table} ({', '.join(names)}) SELECT {values} FROM {table} WHERE rowid <= {rows[table]}"
                )
        for table in COPIED:
            schema.seal_all(db, table)
    return path


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_many(tmp_path_factory.mktemp("large") / "results.sqlite", MEASUREMENTS)


@pytest.mark.slow
def test_writing_a_report(benchmark: Any, large: Path, tmp_path: Path) -> None:
    benchmark.pedantic(write_report, (large, tmp_path), rounds=3, warmup_rounds=1)


@pytest.mark.slow
def test_comparing_two_files(benchmark: Any, large: Path) -> None:
    verdict = benchmark.pedantic(lambda: compare(reading.rows(large), reading.rows(large)), rounds=3)
    assert not verdict.failed


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
@pytest.mark.parametrize("command", ["report", "compare"])
def test_a_command_takes_little_memory(command: str, large: Path, tmp_path: Path) -> None:
    """The whole process, imports included. The script that draws charts is made once for each version of a library."""
    report_pack.pack_vega()
    arguments = ["--out", str(tmp_path)] if command == "report" else [str(large)]
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
        found = reading.rows(write_many(tmp_path / f"{least}.sqlite", least))
        rows.append(len(found))
        counts.append(calls(lambda: compare(found, found)))  # noqa: B023 (called at once)
    assert (counts[1] - counts[0]) / (rows[1] - rows[0]) <= CALLS
