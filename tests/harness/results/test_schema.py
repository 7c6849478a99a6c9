"""Files of older schemas are read and migrated; a value changed in a file is detected when the file is read."""

import re
import sqlite3
from pathlib import Path

import numpy as np
import pandas
import pytest
from gnomon.harness.results import schema, store

SCHEMA_1 = """
CREATE TABLE runs (run INTEGER PRIMARY KEY, started TEXT NOT NULL, ended TEXT, suite TEXT NOT NULL, command TEXT);
CREATE TABLE environment (run INTEGER NOT NULL REFERENCES runs, name TEXT NOT NULL, value TEXT,
    PRIMARY KEY (run, name));
CREATE TABLE trials (trial_key TEXT PRIMARY KEY, series TEXT NOT NULL, section TEXT, title TEXT, "case" TEXT NOT NULL,
    variant TEXT NOT NULL, stresses TEXT, formulation TEXT NOT NULL, form TEXT, library TEXT NOT NULL,
    integrator TEXT NOT NULL, policy TEXT NOT NULL, integrator_id TEXT NOT NULL, order_declared INTEGER, sampling TEXT,
    conserves TEXT, setting_kind TEXT NOT NULL, setting REAL, dimension INTEGER, span REAL, time_scale REAL,
    numbers TEXT, floor REAL, conditioning REAL, machine TEXT NOT NULL);
CREATE TABLE planned (run INTEGER NOT NULL REFERENCES runs, series TEXT NOT NULL,
    trial_key TEXT NOT NULL REFERENCES trials, PRIMARY KEY (run, trial_key));
CREATE TABLE measurements (measurement INTEGER PRIMARY KEY, trial_key TEXT NOT NULL REFERENCES trials,
    run INTEGER NOT NULL REFERENCES runs, launch INTEGER NOT NULL, recorded TEXT NOT NULL, status TEXT NOT NULL,
    reason TEXT, error_max REAL, error_end REAL, error_rms REAL, error_phase REAL, error_shape REAL,
    error_over_tolerance REAL, turns INTEGER, invariant_drift TEXT, events_missing INTEGER, events_extra INTEGER,
    events_time_error REAL, rhs_calls INTEGER, steps INTEGER, repeats INTEGER, seconds_median REAL, seconds_low REAL,
    seconds_high REAL, prepare_seconds REAL, reset_seconds REAL, limit_seconds REAL, output TEXT);
CREATE INDEX measured ON measurements (trial_key, launch);
CREATE TABLE settings_changed (measurement INTEGER NOT NULL REFERENCES measurements, name TEXT NOT NULL, value TEXT,
    PRIMARY KEY (measurement, name));
CREATE TABLE sampled_states (measurement INTEGER PRIMARY KEY REFERENCES measurements, dimension INTEGER NOT NULL,
    states BLOB NOT NULL);
PRAGMA application_id = 0x676E6F6D;
PRAGMA user_version = 1;
"""
"""The tables of schema 1, as revision 2a1f7fd creates them."""
SCHEMA_2 = """
ALTER TABLE measurements ADD COLUMN null_seconds REAL; ALTER TABLE measurements ADD COLUMN turned_starts INTEGER;
ALTER TABLE measurements ADD COLUMN error_low REAL; ALTER TABLE measurements ADD COLUMN error_high REAL;
ALTER TABLE measurements ADD COLUMN error_unturned REAL; ALTER TABLE measurements ADD COLUMN error_start REAL;
ALTER TABLE runs ADD COLUMN checksum INTEGER; ALTER TABLE environment ADD COLUMN checksum INTEGER;
ALTER TABLE trials ADD COLUMN checksum INTEGER; ALTER TABLE planned ADD COLUMN checksum INTEGER;
ALTER TABLE measurements ADD COLUMN checksum INTEGER; ALTER TABLE settings_changed ADD COLUMN checksum INTEGER;
ALTER TABLE sampled_states ADD COLUMN checksum INTEGER;
PRAGMA user_version = 2;
"""
"""How revision cc04ee6 migrates these tables to schema 2."""
LACKING = [name for tables in schema.SINCE.values() for name in tables["measurements"]]


@pytest.fixture(params=[1, 2])
def older(synthetic_results: Path, tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    """The synthetic results in a file of an older schema."""
    path = tmp_path / "older.sqlite"
    with sqlite3.connect(path) as db:
        db.executescript(SCHEMA_1)
        db.execute("ATTACH ? AS new", (str(synthetic_results),))
        for table in schema.TABLES:
            names = ", ".join(f'"{row[1]}"' for row in db.execute(f"PRAGMA main.table_info({table})"))
            db.execute(f"INSERT INTO main.{table} ({names}) SELECT {names} FROM new.{table}")
        if request.param == 2:
            db.executescript(SCHEMA_2)
            for table in schema.TABLES:
                rows = db.execute(f"SELECT rowid, * FROM {table}").fetchall()
                sums = [(schema._row_checksum(*values), row) for row, *values, _ in rows]
                db.executemany(f"UPDATE {table} SET checksum = ? WHERE rowid = ?", sums)
    db.close()
    return path


def without(frame: pandas.DataFrame) -> pandas.DataFrame:
    return frame.drop(columns=LACKING)


def test_a_file_of_an_older_schema_is_read_with_null_for_what_it_lacks(older: Path, synthetic_results: Path) -> None:
    found, expected = store.load(older), store.load(synthetic_results)
    assert list(found.columns) == list(expected.columns)
    assert found[LACKING].isna().all(axis=None)
    pandas.testing.assert_frame_equal(without(found), without(expected))
    assert store.runs(older) == store.runs(synthetic_results)
    assert len(store.states(older)) == len(store.states(synthetic_results)) > 0


def test_a_run_that_continues_a_file_of_an_older_schema_migrates_it(older: Path) -> None:
    before, states = store.load(older), store.states(older)
    with store.Store(older) as results:
        number = results.begin_run("quick", "", {})
        key = str(before["trial_key"][0])
        results.add(number, {"trial_key": key, "launch": 9, "status": "ok", "null_seconds": 1e-6})
    after = store.load(older)
    kept = after[after["launch"] != 9].reset_index(drop=True)
    pandas.testing.assert_frame_equal(without(kept), without(before), check_dtype=False)
    assert list(after.loc[after["launch"] == 9, "null_seconds"]) == [1e-6]
    for number, found in store.states(older).items():
        np.testing.assert_array_equal(found, states[number])
    with sqlite3.connect(older) as db:
        db.execute("UPDATE measurements SET error_max = error_max * 2 WHERE measurement = 5")
    with pytest.raises(ValueError, match="table measurements, row 5"):
        store.load(older)


def test_a_migration_that_fails_leaves_the_file_as_it_was(older: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_arguments: object) -> None:
        raise sqlite3.OperationalError("the disk is full")

    content, before = store.load(older), sqlite3.connect(older)
    kept = schema.version(before), [row[1] for row in before.execute("PRAGMA table_info(runs)")]
    before.close()
    monkeypatch.setattr(schema, "seal_all", fail)
    with pytest.raises(ValueError, match="cannot be written"):
        store.Store(older)
    monkeypatch.undo()
    with sqlite3.connect(older) as db:
        assert (schema.version(db), [row[1] for row in db.execute("PRAGMA table_info(runs)")]) == kept
    pandas.testing.assert_frame_equal(store.load(older), content)


CHANGES = {
    "runs": "suite = 'other'",
    "trials": "setting = setting * (1 + 1e-15)",
    "planned": "series = 's'",
    "measurements": "error_max = nullif(error_max, error_max)",
    "settings_changed": "value = value || ' '",
}


@pytest.mark.parametrize("table", CHANGES)
def test_a_value_changed_in_a_file_is_refused_with_file_and_row(synthetic_results: Path, table: str) -> None:
    with sqlite3.connect(synthetic_results) as db:
        ((row,),) = db.execute(f"SELECT max(rowid) FROM {table}")
        if table == "measurements":
            ((row,),) = db.execute("SELECT max(rowid) FROM measurements WHERE error_max IS NOT NULL")
        if table == "trials":
            ((row,),) = db.execute("SELECT max(rowid) FROM trials WHERE setting IS NOT NULL")
        db.execute(f"UPDATE {table} SET {CHANGES[table]} WHERE rowid = ?", (row,))
    said = rf"{re.escape(str(synthetic_results))}: damaged \(table {table}, row {row}: .*checksum"
    with pytest.raises(ValueError, match=said) as caught:
        store.load(synthetic_results)
    assert "\n" not in str(caught.value)
    with pytest.raises(ValueError, match=said):
        store.Store(synthetic_results)


def test_a_missing_checksum_is_an_error(synthetic_results: Path) -> None:
    with sqlite3.connect(synthetic_results) as db:
        db.execute("UPDATE trials SET checksum = NULL WHERE rowid = 3")
    with pytest.raises(ValueError, match="table trials, row 3"):
        store.load(synthetic_results)


def test_changed_states_and_a_changed_environment_are_refused_where_they_are_read(synthetic_results: Path) -> None:
    with sqlite3.connect(synthetic_results) as db:
        db.execute("UPDATE sampled_states SET dimension = dimension + 1 WHERE measurement = 2")
        db.execute("UPDATE environment SET value = 'other' WHERE name = 'cpu'")
    with pytest.raises(ValueError, match="table sampled_states, row 2"):
        store.states(synthetic_results)
    with pytest.raises(ValueError, match="table sampled_states, row 2"):
        store.states(synthetic_results, [1, 2])
    with pytest.raises(ValueError, match="table environment"):
        store.runs(synthetic_results)


@pytest.mark.parametrize("name", ["a#b", "a?b", "a%20b"])
def test_a_file_is_found_with_special_characters_in_its_name(tmp_path: Path, name: str) -> None:
    path = tmp_path / name / "results.sqlite"
    with store.Store(path) as results:
        results.begin_run("quick", "", {})
    assert len(store.runs(path)) == 1
    store.Store(path).close()


def test_a_first_write_that_fails_leaves_a_file_that_can_be_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "results.sqlite"
    connect = sqlite3.connect

    def full(*given: object, **named: object) -> sqlite3.Connection:
        db = connect(*given, **named)  # type: ignore[call-overload]
        db.execute("PRAGMA max_page_count = 2")
        return db  # type: ignore[no-any-return]

    monkeypatch.setattr(store.sqlite3, "connect", full)
    with pytest.raises(ValueError, match="is full"):
        store.Store(path)
    monkeypatch.undo()
    with store.Store(path) as results:
        results.begin_run("quick", "", {})
    assert len(store.runs(path)) == 1
