"""A results file of many measurements: invented ones, copied under further names of cases and integrators."""

import sqlite3
from contextlib import closing
from pathlib import Path

import synthetic
from gnomon.harness.results import schema

COPIED = ("trials", "planned", "measurements", "settings_changed", "sampled_states")
METHODS = 4
"""Copies of an integrator: a run of all suites has some dozens of them."""


def write(path: Path, least: int) -> Path:
    """Write a file with at least this number of measurements, all of one launch, and return its path."""
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
