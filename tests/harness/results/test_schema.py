"""Files of older schemas are refused; a value changed in a file is detected when the file is read."""

import re
import sqlite3
from pathlib import Path

import pytest
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import schema, store
from gnomon.harness.results.merging import merge

READERS = {
    "load": store.load,
    "runs": store.runs,
    "a run that continues it": store.Store,
    "report": Run.read,
    "merge": lambda path: merge([path], path.with_name("merged.sqlite")),
}


@pytest.mark.parametrize("name", READERS)
def test_a_file_of_an_older_schema_is_refused_with_its_schema_and_the_way_out(
    synthetic_results: Path, name: str
) -> None:
    """It lacks columns; a null for them would say that a null call, a wait or a first use was not there."""
    version = schema.SCHEMA_VERSION - 1
    with store.Store(synthetic_results) as results:
        results.begin_run("quick", "", {"gnomon": "0.1.0", "revision": "ec1a549"})
    with sqlite3.connect(synthetic_results) as db:
        db.execute(f"PRAGMA user_version = {version}")
    before = synthetic_results.read_bytes()
    with pytest.raises(ValueError, match=re.escape(f"{synthetic_results}: written with schema {version}")) as caught:
        READERS[name](synthetic_results)
    said = str(caught.value)
    assert f"reads schema {schema.SCHEMA_VERSION}" in said
    assert "run it again" in said
    assert "gnomon 0.1.0 of revision ec1a549" in said, "the version that reads it"
    assert "\n" not in said
    assert synthetic_results.read_bytes() == before


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
