"""The tables of a results file: their columns, the checksum of each row, and the migration of older files."""

from __future__ import annotations

import sqlite3
import struct
import zlib
from collections.abc import Iterator

SCHEMA_VERSION = 2
OLDEST_VERSION = 1
"""The oldest schema that can be read; a run that continues such a file migrates it."""
APPLICATION_ID = 0x676E6F6D  # "gnom": distinguishes results files from other SQLite files

TRIAL_COLUMNS = {
    "trial_key": "TEXT PRIMARY KEY",
    "series": "TEXT NOT NULL",
    "section": "TEXT",
    "title": "TEXT",
    "case": "TEXT NOT NULL",
    "variant": "TEXT NOT NULL",
    "stresses": "TEXT",
    "formulation": "TEXT NOT NULL",
    "form": "TEXT",
    "library": "TEXT NOT NULL",
    "integrator": "TEXT NOT NULL",
    "policy": "TEXT NOT NULL",
    "integrator_id": "TEXT NOT NULL",
    "order_declared": "INTEGER",
    "sampling": "TEXT",
    "conserves": "TEXT",
    "setting_kind": "TEXT NOT NULL",
    "setting": "REAL",
    "dimension": "INTEGER",
    "span": "REAL",
    "time_scale": "REAL",
    "numbers": "TEXT",
    "floor": "REAL",
    "conditioning": "REAL",
    "machine": "TEXT NOT NULL",
}
"""The columns of a trial. `numbers` is the JSON of every exact number by name, as fractions; `floor` and `conditioning`
are the maxima over the samples."""

MEASUREMENT_COLUMNS = {
    "measurement": "INTEGER PRIMARY KEY",
    "trial_key": "TEXT NOT NULL REFERENCES trials",
    "run": "INTEGER NOT NULL REFERENCES runs",
    "launch": "INTEGER NOT NULL",
    "recorded": "TEXT NOT NULL",
    "status": "TEXT NOT NULL",
    "reason": "TEXT",
    "error_max": "REAL",
    "error_end": "REAL",
    "error_rms": "REAL",
    "error_phase": "REAL",
    "error_shape": "REAL",
    "error_over_tolerance": "REAL",
    "turns": "INTEGER",
    "invariant_drift": "TEXT",
    "events_missing": "INTEGER",
    "events_extra": "INTEGER",
    "events_time_error": "REAL",
    "rhs_calls": "INTEGER",
    "steps": "INTEGER",
    "repeats": "INTEGER",
    "seconds_median": "REAL",
    "seconds_low": "REAL",
    "seconds_high": "REAL",
    "prepare_seconds": "REAL",
    "reset_seconds": "REAL",
    "limit_seconds": "REAL",
    "output": "TEXT",
    "null_seconds": "REAL",
    "turned_starts": "INTEGER",
    "error_low": "REAL",
    "error_high": "REAL",
    "error_unturned": "REAL",
    "error_start": "REAL",
}
"""The result of one launch of a trial. `invariant_drift` is JSON by name of the invariant; `output` is what the
worker's libraries printed. `repeats` is the number of timed calls, or of attempts before a timeout. `seconds_low` and
`seconds_high` are the 10 and 90 % quantiles of the timed calls; `null_seconds` is the time of the series' null call
(`gnomon.harness.running.null_call`), which those times include.

If the case has a rotational symmetry, `turned_starts` is the number of turned initial states. All errors are then those
of the turned start with the median `error_max`; `error_low` and `error_high` are the smallest and the largest
`error_max` of these starts, and `error_unturned` is that of the timed call.

`error_start` is the largest error over the first four samples."""

SINCE_2 = {
    "measurements": ("null_seconds", "turned_starts", "error_low", "error_high", "error_unturned", "error_start"),
}
"""The columns that schema 1 lacks, apart from the checksums."""

TABLES = {
    "runs": {
        "run": "INTEGER PRIMARY KEY",
        "started": "TEXT NOT NULL",
        "ended": "TEXT",
        "suite": "TEXT NOT NULL",
        "command": "TEXT",
    },
    "environment": {"run": "INTEGER NOT NULL REFERENCES runs", "name": "TEXT NOT NULL", "value": "TEXT"},
    "trials": TRIAL_COLUMNS,
    "planned": {
        "run": "INTEGER NOT NULL REFERENCES runs",
        "series": "TEXT NOT NULL",
        "trial_key": "TEXT NOT NULL REFERENCES trials",
    },
    "measurements": MEASUREMENT_COLUMNS,
    "settings_changed": {
        "measurement": "INTEGER NOT NULL REFERENCES measurements",
        "name": "TEXT NOT NULL",
        "value": "TEXT",
    },
    "sampled_states": {
        "measurement": "INTEGER PRIMARY KEY REFERENCES measurements",
        "dimension": "INTEGER NOT NULL",
        "states": "BLOB NOT NULL",
    },
}
"""The columns of every table, without the `checksum` that each has too."""

_PRIMARY_KEYS = {
    "environment": "run, name",
    "planned": "run, trial_key",
    "settings_changed": "measurement, name",
}


class Damaged(Exception):  # noqa: N818 (it names what a file is)
    """A file that was changed after it was written; the message names the table and the row."""


def create(db: sqlite3.Connection) -> None:
    """Create all tables in an empty file, in one transaction."""
    with db:
        db.execute("BEGIN IMMEDIATE")
        if version(db) == SCHEMA_VERSION:
            return  # another process was faster
        for _, _, statement in made():
            db.execute(statement)
        db.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        db.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")


def made(version: int = SCHEMA_VERSION) -> Iterator[tuple[str, str, str]]:
    """The structure of a file of this version: kind, name and SQL of its tables and its index."""
    for table in TABLES:
        kinds = [f'"{name}" {TABLES[table][name]}' for name in columns(table, version)]
        kinds += ["checksum INTEGER"] if version > 1 else []
        kinds += [f"PRIMARY KEY ({_PRIMARY_KEYS[table]})"] if table in _PRIMARY_KEYS else []
        yield "table", table, f"CREATE TABLE {table} ({', '.join(kinds)})"
    yield "index", "measured", "CREATE INDEX measured ON measurements (trial_key, launch)"


def columns(table: str, version: int) -> list[str]:
    """The columns of a table in a file of this version, without the checksum."""
    lacking = SINCE_2.get(table, ()) if version < SCHEMA_VERSION else ()
    return [name for name in TABLES[table] if name not in lacking]


def migrate(db: sqlite3.Connection) -> None:
    """Convert a file of an older schema to this one, in one transaction: completely or not at all."""
    with db:
        db.execute("BEGIN IMMEDIATE")
        if version(db) == SCHEMA_VERSION:
            return  # another process was faster
        for table in TABLES:
            for name in SINCE_2.get(table, ()):
                db.execute(f"ALTER TABLE {table} ADD COLUMN {name} {TABLES[table][name]}")
            db.execute(f"ALTER TABLE {table} ADD COLUMN checksum INTEGER")
            seal_all(db, table)
        db.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")


def version(db: sqlite3.Connection) -> int:
    return int(db.execute("PRAGMA user_version").fetchone()[0])


def selected(table: str, version: int) -> str:
    """The columns of a table as a list for SELECT; null for those that a file of this `version` lacks."""
    known = columns(table, version)
    return ", ".join(f'{table}."{name}"' if name in known else f"NULL AS {name}" for name in TABLES[table])


def with_checksums(db: sqlite3.Connection) -> sqlite3.Connection:
    """The connection, with the function `row_checksum` that the statements of this module use."""
    db.create_function("row_checksum", -1, _row_checksum, deterministic=True)
    return db


def seal(db: sqlite3.Connection, table: str, row: int) -> None:
    """Store the checksum of the row with this rowid, computed from the values in the file."""
    db.execute(f"UPDATE {table} SET checksum = {_checksum_of(table)} WHERE rowid = ?", (row,))


def seal_all(db: sqlite3.Connection, table: str) -> None:
    """Store the checksum of every row of a table."""
    db.execute(f"UPDATE {table} SET checksum = {_checksum_of(table)}")


def verify(db: sqlite3.Connection, table: str) -> None:
    """Raise Damaged if values of a row do not match its checksum; names the first one. Schema 1 has no checksums."""
    if version(db) < SCHEMA_VERSION:
        return
    damaged = db.execute(f"SELECT rowid FROM {table} WHERE checksum IS NOT {_checksum_of(table)} LIMIT 1").fetchone()
    if damaged is not None:
        raise Damaged(f"table {table}, row {damaged[0]}: its values do not match its checksum")


def _checksum_of(table: str) -> str:
    names = ", ".join(f'"{name}"' for name in TABLES[table])
    return f"row_checksum({names})"


def _row_checksum(*values: object) -> int:
    """CRC-32 of the values with their types. It detects damage, and does not protect against a forged file."""
    found = 0
    for value in values:
        if value is None:
            kind, content = b"n", b""
        elif isinstance(value, int):
            kind, content = b"i", str(value).encode()
        elif isinstance(value, float):
            kind, content = b"f", struct.pack("<d", value)
        elif isinstance(value, bytes):
            kind, content = b"b", value
        else:
            kind, content = b"t", str(value).encode("utf-8", "surrogatepass")
        found = zlib.crc32(content, zlib.crc32(kind + struct.pack("<q", len(content)), found))
    return found
