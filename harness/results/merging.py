"""Merges results files, as those of shards, into a new one; what was measured twice is refused, or counted as launches."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from gnomon.harness.contract.environment import VERSIONS
from gnomon.harness.contract.status import Status
from gnomon.harness.results import opening, schema
from gnomon.harness.results.reading import NOT_SUPERSEDED
from gnomon.harness.results.visible import visible
from gnomon.reference.storage import diskcache

KEYS = {
    "runs": "run", "environment": "run", "trials": "trial_key", "measurements": "measurement",
    "settings_changed": "measurement", "sampled_states": "measurement",
}  # fmt: skip
"""The tables that are copied, with the column of `measurements` that says which of their rows. `planned` is made anew."""
_CURRENT = f"{NOT_SUPERSEDED} AND measurements.status != '{Status.INTERRUPTED.value}'"
"""The measurements that are copied: superseded ones do not count, and an interrupted trial was not measured."""

Place = tuple[str, float | None, int]
"""What is measured once: a series, a setting, a launch."""


def merge(sources: Sequence[Path], target: Path, count: bool = False, command: str = "gnomon merge") -> int:
    """Write the measurements of all `sources` into the new file `target`; returns their number.

    A trial that two files measured is refused; with `count` it is a further launch of the trial or, from another
    machine, a trial of its own. Raises ValueError, which names the file, for that, for files of other versions or
    sources, for a target that exists, and for what is no results file; nothing is written then.
    """
    found = [opening.results_file(source) for source in sources]
    if target.exists():
        raise ValueError(f"--out {target}: exists already; name a new file")
    target.parent.mkdir(parents=True, exist_ok=True)
    with diskcache.whole(target) as part, closing(schema.with_checksums(sqlite3.connect(part))) as db:
        schema.create(db)
        with db:
            merged = _Merged(db, count)
            for source in found:
                with opening.reading(source, schema.TABLES) as own:
                    merged.add(source, own)
            merged.end(command)
            for table in schema.TABLES:
                schema.seal_all(db, table)
    return merged.measurements


@dataclass
class _Merged:
    """The new file, with what is needed to compare the next one."""

    db: sqlite3.Connection
    count: bool
    measurements: int = 0
    versions: tuple[Path, dict[str, str | None]] | None = None
    """Those of the first file."""
    measured: dict[Place, dict[str, tuple[str, Path]]] = field(default_factory=dict)
    """By machine, the key of each trial and the file that has it."""
    trials: dict[str, tuple[str, float | None]] = field(default_factory=dict)
    """Series and setting by key."""
    launches: dict[str, int] = field(default_factory=dict)
    """The number of launches of each trial so far."""
    suites: dict[str, None] = field(default_factory=dict)
    unfinished: bool = False

    def add(self, path: Path, own: sqlite3.Connection) -> None:
        """Copy what counts in a verified file."""
        self._compare_versions(path, own)
        added = self._added(path, own)
        ((runs, measurements),) = self.db.execute(
            "SELECT (SELECT coalesce(max(run), 0) FROM runs), (SELECT coalesce(max(measurement), 0) FROM measurements)"
        )
        for table, key in KEYS.items():
            names = list(schema.TABLES[table])
            columns, marks = ", ".join(f'"{name}"' for name in names), ", ".join("?" * len(names))
            rows = own.execute(
                f"SELECT {schema.selected(table, schema.version(own))} FROM {table} WHERE {table}.{key} IN"
                f" (SELECT measurements.{key} FROM measurements WHERE {_CURRENT}) ORDER BY {table}.rowid"
            )
            insert = f"INSERT {'OR IGNORE' if table == 'trials' else ''} INTO {table} ({columns}) VALUES ({marks})"
            self.db.executemany(insert, _renumbered(rows, names, runs, measurements, added))
        for suite, ended in own.execute("SELECT suite, ended FROM runs ORDER BY run").fetchall()[-1:]:
            self.suites[suite] = None
            self.unfinished |= ended is None
        ((self.measurements,),) = self.db.execute("SELECT count(*) FROM measurements")

    def _compare_versions(self, path: Path, own: sqlite3.Connection) -> None:
        """Raise ValueError if versions or sources of a run differ from those of the first file."""
        used = f"SELECT DISTINCT run FROM measurements WHERE {_CURRENT}"
        for (run,) in own.execute(used).fetchall():
            every = dict(own.execute("SELECT name, value FROM environment WHERE run = ?", (run,)))
            found = {name: every.get(name) for name in VERSIONS}
            self.versions = self.versions or (path, found)
            first, known = self.versions
            for name in VERSIONS:
                if found[name] != known[name]:
                    raise ValueError(
                        f"{path}: measured with {name} {_shown(found[name])}, {first} with {_shown(known[name])};"
                        " merge files of the same versions and sources"
                    )

    def _added(self, path: Path, own: sqlite3.Connection) -> dict[str, int]:
        """By trial, how many launches come before those of this file. Raises ValueError for what is measured twice."""
        before = dict(self.launches)
        query = (
            "SELECT series, setting, launch, machine, trial_key FROM measurements JOIN trials USING (trial_key)"
            f" WHERE {_CURRENT}"
        )
        for series, setting, launch, machine, key in own.execute(query):
            known = self.measured.setdefault((series, setting, launch), {})
            twice = known.get(machine) or next(iter(known.values()), None)
            text = f"{visible(series)} at {setting}, launch {launch}"
            if twice is not None and not self.count:
                raise ValueError(f"{path}: {text}, is measured in {twice[1]} too; leave one out, or give --count")
            if machine in known and known[machine][0] != key:
                raise ValueError(
                    f"{path}: {text}, was measured with other sources or libraries than in {known[machine][1]}"
                )
            if self.trials.setdefault(key, (series, setting)) != (series, setting):
                raise ValueError(f"{path}: {text}, has the key of another trial in another file; leave one out")
            known[machine] = key, path
            self.launches[key] = max(self.launches.get(key, 0), before.get(key, 0) + launch)
        return before

    def end(self, command: str) -> None:
        """Record the merging as the last run, which has planned all that was copied: none of it is superseded."""
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        row = (now, None if self.unfinished else now, ", ".join(self.suites), command)
        run = self.db.execute("INSERT INTO runs (started, ended, suite, command) VALUES (?, ?, ?, ?)", row).lastrowid
        self.db.execute("INSERT INTO planned (run, series, trial_key) SELECT ?, series, trial_key FROM trials", (run,))


def _renumbered(
    rows: sqlite3.Cursor, names: Sequence[str], runs: int, measurements: int, added: Mapping[str, int]
) -> Iterator[list[Any]]:
    """The rows of a file with the numbers that follow those of the files before it."""
    places = {name: place for place, name in enumerate(names)}
    run, measurement, launch = (places.get(name) for name in ("run", "measurement", "launch"))
    for row in rows:
        values = list(row)
        if run is not None:
            values[run] += runs
        if measurement is not None:
            values[measurement] += measurements
        if launch is not None:
            values[launch] += added.get(values[places["trial_key"]], 0)
        yield values


def _shown(value: str | None) -> str:
    return "none" if value is None else visible(str(value))
