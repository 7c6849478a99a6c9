"""The results file: rows are read as they were written, and other files are rejected."""

import csv
import json
from pathlib import Path
from typing import TextIO

import numpy as np
import pandas
import pytest
from gnomon.harness.contract.status import Status
from gnomon.harness.results import store

COLUMNS = [
    "case", "variant", "formulation", "library", "integrator", "policy", "setting_kind", "setting", "launch", "status",
    "reason", "error_max", "error_end", "error_rms", "floor", "conditioning", "rhs_calls", "steps", "seconds_median",
    "seconds_low", "seconds_high", "prepare_seconds", "trial_key", "machine", "title", "integrator_id",
    "order_declared", "sampling", "error_phase", "error_shape", "turns", "invariant_drift", "events_missing",
    "events_extra", "events_time_error", "settings_changed", "reset_seconds", "suite", "work",
]  # fmt: skip


def trial(key: str, series: str = "s") -> dict[str, object]:
    names = (
        "case", "variant", "formulation", "library", "integrator", "policy", "integrator_id", "setting_kind", "machine",
    )  # fmt: skip
    return dict.fromkeys(names, "x") | {"trial_key": key, "series": series, "setting": 0.1}


def test_load_gives_one_row_a_measurement_with_the_promised_columns(synthetic_results: Path) -> None:
    frame = store.load(synthetic_results)
    assert set(COLUMNS) <= set(frame.columns)
    assert frame.groupby(["trial_key", "launch"]).size().eq(1).all()
    assert {"ok", "diverged", "timeout", "skipped", "unsupported"} <= set(frame["status"])
    assert frame.loc[frame["policy"] == "configured", "settings_changed"].map(json.loads).map(bool).all()


def test_a_folder_means_its_results_file(synthetic_results: Path) -> None:
    assert len(store.load(synthetic_results.parent)) == len(store.load(synthetic_results))


def test_states_are_read_with_the_same_bits(tmp_path: Path) -> None:
    states = np.random.default_rng(1).normal(size=(64, 3))
    with store.Store(tmp_path / "results.sqlite") as results:
        run = results.begin_run("quick", "", {})
        results.plan(run, [trial("k")])
        results.add(run, {"trial_key": "k", "launch": 1, "status": "ok"}, {}, states)
    (found,) = store.states(tmp_path).values()
    assert found.tobytes() == states.tobytes()


def test_measurements_that_a_later_run_replaced_are_left_out(tmp_path: Path) -> None:
    with store.Store(tmp_path / "results.sqlite") as results:
        for key in ("before", "after"):
            run = results.begin_run("quick", "", {})
            results.plan(run, [trial(key), trial("other", "t")] if key == "before" else [trial(key)])
            results.add(run, {"trial_key": key, "launch": 1, "status": "ok"})
        results.add(run, {"trial_key": "other", "launch": 1, "status": "timeout", "limit_seconds": 1.0})
        known = results.history()
    assert set(known) == {("before", 1), ("after", 1), ("other", 1)}
    assert known["before", 1].settles(2.0)
    assert known["other", 1].settles(1.0)
    assert not known["other", 1].settles(2.0), "a higher limit reopens a timeout"
    assert set(store.load(tmp_path)["trial_key"]) == {"after", "other"}
    assert set(store.load(tmp_path, superseded=True)["trial_key"]) == {"before", "after", "other"}


@pytest.mark.parametrize("form", ["csv", "json", "parquet"])
def test_export_holds_every_row_and_full_digits(synthetic_results: Path, tmp_path: Path, form: str) -> None:
    target = tmp_path / f"rows.{form}"
    store.export(synthetic_results, target, form)
    reader = {"csv": pandas.read_csv, "json": pandas.read_json, "parquet": pandas.read_parquet}[form]
    expected, found = store.load(synthetic_results), reader(target)
    assert len(found) == len(expected)
    # repr round-trips; the readers of pandas may be one unit off in the last place
    np.testing.assert_allclose(found["error_max"], expected["error_max"], rtol=4e-16)


def test_a_write_that_fails_names_the_file_and_the_way_out(tmp_path: Path) -> None:
    """If the disk is full during a run, earlier measurements stay, and the same command continues from them."""
    path = tmp_path / "results.sqlite"
    said = rf"{path}: cannot be written \(database or disk is full\).*stays in it"
    with store.Store(path) as results:
        number = results.begin_run("quick", "gnomon run", {})
    results = store.Store(path)
    results._connection.execute("PRAGMA max_page_count = 1")  # as small as it is now
    rows = [{"trial_key": "k" * 9000, "launch": i, "status": "ok"} for i in range(9)]
    with pytest.raises(ValueError, match=said), results:
        results.add_all(number, rows)
    assert [run["suite"] for run in store.runs(path)] == ["quick"]


def test_a_table_that_cannot_be_written_completely_leaves_the_former_file(
    synthetic_results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An incomplete table could not be told from a complete one."""

    class FullDisk:
        def __init__(self, file: TextIO, **_: object) -> None:
            self.file = file

        def writerow(self, _: object) -> None:
            self.file.write("half")
            raise OSError(28, "No space left on device")

    target = tmp_path / "tables" / "results.csv"
    target.parent.mkdir()
    target.write_text("before")
    monkeypatch.setattr(csv, "writer", FullDisk)
    with pytest.raises(OSError, match="No space left"):
        store.export(synthetic_results, target, "csv")
    assert {path.name: path.read_text() for path in target.parent.iterdir()} == {"results.csv": "before"}


@pytest.mark.parametrize("status", Status)
def test_what_a_limit_ended_runs_again_under_a_higher_one(status: Status) -> None:
    """An interrupted trial runs again in any case; a status that the integrator determined stays."""
    known = store.Known(status, 4, 1.0, 0.1)
    assert known.settles(0.5) == known.settles(1.0) == (status != "interrupted")
    assert known.settles(2.0) == (status not in ("interrupted", "timeout", "skipped"))
