"""Merges results files, such as shards, into a new one; trials measured twice are refused, or counted as launches.

Outstanding trials stay outstanding: planned trials are copied too, and an interrupted trial is copied if no other file has
measured it.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from gnomon.harness.contract.status import Status
from gnomon.harness.registry.environment import VERSIONS
from gnomon.harness.results import opening, schema
from gnomon.harness.results.outstanding import SHARD, Shards, shards, shards_text
from gnomon.harness.results.reading import LAST_PLANNED, NOT_SUPERSEDED
from gnomon.harness.results.visible import visible
from gnomon.reference.storage import diskcache

KEYS = {
    "runs": "run", "environment": "run", "trials": "trial_key", "measurements": "measurement",
    "settings_changed": "measurement", "sampled_states": "measurement",
}  # fmt: skip
"""The tables that are copied, with the column that selects their rows; `planned` is made anew."""
_MEASURED = f"{NOT_SUPERSEDED} AND measurements.status != '{Status.INTERRUPTED.value}'"
"""The measurements that may exist once: an interrupted trial was not measured."""
ROWS = 1000
"""Number of rows that are copied at a time."""

Place = tuple[str, float | None, int]
"""A series, a setting and a launch, which may be measured once."""


def merge(sources: Sequence[Path], target: Path, count: bool = False, command: str = "gnomon merge") -> int:
    """Write the measurements of all `sources` into the new file `target`; return their number.

    A trial that two files measured is refused. With `count` the second measurement becomes another launch of the trial; on
    another machine it is another trial. Raises ValueError, which names the file, for a refused trial, for files of other
    versions or sources, for a target that exists or cannot be written, and for a file without results. After an error
    nothing is written.
    """
    files = [opening.results_file(source) for source in sources]
    if target.exists():
        raise ValueError(f"--out {target}: exists already; name a new file")
    target.parent.mkdir(parents=True, exist_ok=True)
    with (
        diskcache.whole(target) as part,
        _writing(target),
        closing(schema.with_checksums(sqlite3.connect(part))) as db,
    ):
        schema.create(db)
        with db:
            merged = _Merged(db, target, count)
            for source in files:
                with opening.reading(source, schema.TABLES) as own:
                    merged.add(source, own)
            measurements = merged.end(command)
            for table in schema.TABLES:
                schema.seal_all(db, table)
    return measurements


@contextmanager
def _writing(target: Path) -> Iterator[None]:
    """Raises ValueError, which names the new file, if SQLite cannot write it: the disk may be full."""
    try:
        yield
    except sqlite3.Error as error:
        raise ValueError(
            f"--out {target}: cannot be written ({error}); free some space or name another place"
        ) from None


@dataclass
class _Merged:
    """The new file, with the data to compare the next source with."""

    db: sqlite3.Connection
    target: Path
    count: bool
    versions: tuple[Path, dict[str, str | None]] | None = None
    """The first file and its versions."""
    measured: dict[Place, dict[str, tuple[str, Path]]] = field(default_factory=dict)
    """By place and machine, the key of each trial and the file that has it."""
    trials: dict[str, tuple[str, float | None]] = field(default_factory=dict)
    """Series and setting by key of a trial."""
    launches: dict[str, int] = field(default_factory=dict)
    """The number of launches of each trial so far."""
    suites: dict[str, None] = field(default_factory=dict)
    shards: Shards = field(default_factory=dict)
    unfinished: bool = False

    def add(self, path: Path, own: sqlite3.Connection) -> None:
        """Copy the rows that count in a verified file."""
        self._compare_versions(path, own)
        self._compare_keys(path, own)
        added = self._added(path, own)
        ((runs, measurements),) = self.db.execute(
            "SELECT (SELECT coalesce(max(run), 0) FROM runs), (SELECT coalesce(max(measurement), 0) FROM measurements)"
        )
        for table, key in KEYS.items():
            names = list(schema.TABLES[table])
            columns, marks = ", ".join(f'"{name}"' for name in names), ", ".join("?" * len(names))
            counting = LAST_PLANNED if table == "trials" else f"SELECT {key} FROM measurements WHERE {NOT_SUPERSEDED}"
            cursor = own.execute(
                f"SELECT {schema.list_columns(table)} FROM {table} WHERE {key} IN ({counting}) ORDER BY {table}.rowid"
            )
            insert = f"INSERT {'OR IGNORE' if table == 'trials' else ''} INTO {table} ({columns}) VALUES ({marks})"
            while rows := cursor.fetchmany(ROWS):
                with _writing(self.target):  # `reading` would take it for an error of the file that is read
                    self.db.executemany(insert, _renumber(rows, names, runs, measurements, added))
        for suite, ended in own.execute("SELECT suite, ended FROM runs ORDER BY run").fetchall()[-1:]:
            self.suites[suite] = None
            self.unfinished |= ended is None
        for plan, places in shards(own).items():
            self.shards.setdefault(plan, set()).update(places)

    def _compare_versions(self, path: Path, own: sqlite3.Connection) -> None:
        """Raise ValueError if versions or sources of a run differ from the first file."""
        used = f"SELECT DISTINCT run FROM measurements WHERE {_MEASURED}"
        for (run,) in own.execute(used).fetchall():
            every = dict(own.execute("SELECT name, value FROM environment WHERE run = ?", (run,)))
            versions = {name: every.get(name) for name in VERSIONS}
            self.versions = self.versions or (path, versions)
            first, known = self.versions
            for name in VERSIONS:
                if versions[name] != known[name]:
                    raise ValueError(
                        f"{path}: measured with {name} {_show(versions[name])}, {first} with {_show(known[name])};"
                        " merge files of the same versions and sources"
                    )

    def _compare_keys(self, path: Path, own: sqlite3.Connection) -> None:
        """Raise ValueError if the key of a trial belongs to another trial in an earlier file."""
        query = f"SELECT trial_key, series, setting FROM trials WHERE trial_key IN ({LAST_PLANNED})"
        for key, series, setting in own.execute(query):
            if self.trials.setdefault(key, (series, setting)) != (series, setting):
                text = f"{visible(series)} at {setting}"
                raise ValueError(f"{path}: {text}, has the key of another trial in another file; leave one out")

    def _added(self, path: Path, own: sqlite3.Connection) -> dict[str, int]:
        """By trial, the number of launches in earlier files. Raises ValueError for a trial that is measured twice."""
        before = dict(self.launches)
        query = (
            "SELECT series, setting, launch, machine, trial_key FROM measurements JOIN trials USING (trial_key)"
            f" WHERE {_MEASURED}"
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
            known[machine] = key, path
            self.launches[key] = max(self.launches.get(key, 0), before.get(key, 0) + launch)
        return before

    def end(self, command: str) -> int:
        """Record the merging as the last run, which has planned all trials that were copied, so that they count.

        Remove interrupted trials that another file has measured; return the number of measurements.
        """
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        row = (now, None if self.unfinished else now, ", ".join(self.suites), command)
        run = self.db.execute("INSERT INTO runs (started, ended, suite, command) VALUES (?, ?, ?, ?)", row).lastrowid
        if self.shards:
            text = shards_text(self.shards)
            self.db.execute("INSERT INTO environment (run, name, value) VALUES (?, ?, ?)", (run, SHARD, text))
        self.db.execute("INSERT INTO planned (run, series, trial_key) SELECT ?, series, trial_key FROM trials", (run,))
        places = (
            "SELECT series, setting, launch, measurement FROM measurements JOIN trials USING (trial_key) WHERE status"
        )
        measured = {row[:3] for row in self.db.execute(f"{places} != '{Status.INTERRUPTED.value}'")}
        interrupted = self.db.execute(f"{places} = '{Status.INTERRUPTED.value}'").fetchall()
        elsewhere = [row[3:] for row in interrupted if row[:3] in measured]
        for table in ("sampled_states", "settings_changed", "measurements"):
            self.db.executemany(f"DELETE FROM {table} WHERE measurement = ?", elsewhere)
        ((measurements,),) = self.db.execute("SELECT count(*) FROM measurements")
        return int(measurements) - len(interrupted) + len(elsewhere)


def _renumber(
    rows: Iterable[Sequence[Any]], names: Sequence[str], runs: int, measurements: int, added: Mapping[str, int]
) -> Iterator[list[Any]]:
    """The rows of a file with numbers that continue the numbers of the files before it.

    An interrupted launch keeps its number, because another file may have measured it.
    """
    places = {name: place for place, name in enumerate(names)}
    run, measurement, launch = (places.get(name) for name in ("run", "measurement", "launch"))
    for row in rows:
        values = list(row)
        if run is not None:
            values[run] += runs
        if measurement is not None:
            values[measurement] += measurements
        if launch is not None and values[places["status"]] != Status.INTERRUPTED:
            values[launch] += added.get(values[places["trial_key"]], 0)
        yield values


def _show(value: str | None) -> str:
    return "none" if value is None else visible(str(value))
