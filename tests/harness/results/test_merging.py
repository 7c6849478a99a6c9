"""Files of shards merge into the file of one run; trials that two shards measured are refused or counted, not mixed."""

import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon
from gnomon.harness.results import analysis, schema, store
from gnomon.harness.results.merging import merge
from gnomon.harness.results.store import Store

ENVIRONMENT = {"python": "3.11.7", "gnomon": "0.1.0", "sources": "abc", "numba": "0.65.1", "cpu": "A", "machine": "m"}


def write(path: Path, series: str = "a", machine: str = "m", error: float = 1e-3, **environment: str) -> Path:
    """A file with one series of three settings, as a run on this machine writes it."""
    trial = {
        "series": series, "case": "c", "variant": "default", "formulation": "standard", "library": "l",
        "integrator": series, "policy": "", "integrator_id": f"l:{series}", "setting_kind": "step", "machine": machine,
    }  # fmt: skip
    trials = [trial | {"setting": 0.5**k, "trial_key": f"{series} {k} {machine}"} for k in range(3)]
    with Store(path) as db:
        run = db.begin_run("quick", "gnomon run", ENVIRONMENT | environment)
        db.plan(run, trials)
        for each in trials:
            measurement = {"trial_key": each["trial_key"], "launch": 1, "status": "ok", "error_max": error}
            db.add(run, measurement | {"seconds_median": 1.0}, {"option": "1"}, None)
        db.end_run(run)
    return path


def rows(path: Path, *columns: str) -> Any:
    return store.load(path).sort_values(["series", "setting", "launch"])[list(columns)].to_numpy().tolist()


def test_all_that_counts_is_in_the_merged_file(tmp_path: Path) -> None:
    """Each file with its runs, environments, trials, options; it reads as any results file does."""
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite", "b", cpu="B")
    target = tmp_path / "both.sqlite"
    assert merge([a, b], target) == 6
    columns = ("series", "setting", "launch", "error_max", "settings_changed")
    assert rows(target, *columns) == sorted(rows(a, *columns) + rows(b, *columns))
    assert [run["environment"].get("cpu") for run in store.runs(target)] == ["A", "B", None]
    with Store(target) as db:
        assert len(db.history()) == 6, "a run into it continues"


def test_what_two_files_measured_is_refused(tmp_path: Path) -> None:
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite", machine="other")
    for twice in (a, b):
        with pytest.raises(ValueError, match=rf"{twice.name}: a at 1\.0, launch 1, is measured in \S+a.sqlite too"):
            merge([a, twice], tmp_path / "both.sqlite")
    assert sorted(path.name for path in tmp_path.glob("*both*")) == [], "no part of a file stays"


def test_what_two_files_measured_is_counted_as_launches_on_request(tmp_path: Path) -> None:
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite", error=2e-3)
    merge([a, b], tmp_path / "both.sqlite", count=True)
    assert rows(tmp_path / "both.sqlite", "launch", "error_max") == [[1, 1e-3], [2, 2e-3]] * 3


def test_counted_launches_from_two_machines_stay_apart(tmp_path: Path) -> None:
    """Each machine has its own trials, and the times of one alone are compared."""
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite", machine="other")
    merge([a, b], tmp_path / "both.sqlite", count=True)
    frame = store.load(tmp_path / "both.sqlite")
    assert sorted(frame[["machine", "launch"]].value_counts().items()) == [(("m", 1), 3), (("other", 1), 3)]
    timed = analysis.tidy(frame)
    assert set(timed.loc[timed["seconds_median"].notna(), "machine"]) == {"m"}
    assert timed["error_max"].notna().all()


def test_the_same_trial_of_other_sources_is_never_counted(tmp_path: Path) -> None:
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite")
    with sqlite3.connect(b) as db:
        for table in ("trials", "planned", "measurements"):
            db.execute(f"UPDATE {table} SET trial_key = trial_key || ' edited'")
            schema.seal_all(schema.with_checksums(db), table)
    with pytest.raises(ValueError, match=r"b\.sqlite: a at .*, was measured with other sources or libraries than in"):
        merge([a, b], tmp_path / "both.sqlite", count=True)


@pytest.mark.parametrize("name", ["numba", "sources", "python"])
def test_files_of_other_versions_are_refused_by_name(tmp_path: Path, name: str) -> None:
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite", "b", **{name: "9.9"})
    with pytest.raises(
        ValueError, match=rf"b\.sqlite: measured with {name} 9\.9, .*a\.sqlite with {ENVIRONMENT[name]}"
    ):
        merge([a, b], tmp_path / "both.sqlite")


def test_an_interrupted_trial_was_not_measured(tmp_path: Path) -> None:
    """It may be in another file, and a run into the merged file measures it else."""
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite")
    with Store(a) as db:
        db.add(1, {"trial_key": "a 0 m", "launch": 1, "status": "interrupted", "reason": "SIGKILL"})
    with pytest.raises(ValueError, match=r"a at 0\.5, launch 1"):  # not the setting 1, which a lost
        merge([a, b], tmp_path / "both.sqlite")
    assert merge([a], tmp_path / "one.sqlite") == 2


def damaged(path: Path) -> None:
    with sqlite3.connect(path) as db:
        db.execute("UPDATE measurements SET error_max = 0.0")


def no_results(path: Path) -> None:
    path.write_text("hello")


@pytest.mark.parametrize(
    ("change", "reason"), [(damaged, "do not match its checksum"), (no_results, "not a readable results file")]
)
def test_files_are_data_that_is_verified(tmp_path: Path, change: Callable[[Path], None], reason: str) -> None:
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite", "b")
    change(b)
    with pytest.raises(ValueError, match=rf"b\.sqlite: .*{reason}"):
        merge([a, b], tmp_path / "both.sqlite")


def test_a_file_is_never_merged_into(tmp_path: Path) -> None:
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite", "b")
    with pytest.raises(ValueError, match="exists already; name a new file"):
        merge([a], b)


def test_a_forged_key_does_not_give_a_trial_the_measurements_of_another(tmp_path: Path) -> None:
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite", "b")
    with sqlite3.connect(b) as db:
        for table in ("trials", "planned", "measurements"):
            db.execute(f"UPDATE {table} SET trial_key = replace(trial_key, 'b', 'a')")
            schema.seal_all(schema.with_checksums(db), table)
    with pytest.raises(ValueError, match="has the key of another trial"):
        merge([a, b], tmp_path / "both.sqlite")


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A refusal is one line and exit code 2; a folder is made where the results go."""
    a, b = write(tmp_path / "a.sqlite"), write(tmp_path / "b.sqlite", "b")
    assert gnomon("merge", str(a), str(a), "--out", str(tmp_path / "twice")) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert gnomon("merge", str(a), str(b), "--out", str(tmp_path / "both")) == 0
    assert "6 measurements of 2 files" in capsys.readouterr().out
    assert len(store.load(tmp_path / "both")) == 6
