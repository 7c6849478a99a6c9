"""`gnomon stability`: tables, JSON, and files that it refuses to resume."""

import json
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon, numbers_in
from gnomon.harness.stability.panel_run import Row


def test_a_table_for_each_panel_and_the_result_as_json(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "new" / "stability.json"
    words = ["--integrator", "gnomon:RK4", "--integrator", "gnomon:DOP853", "--panel", "linear", "--out", str(file)]
    assert gnomon("stability", *words) == 0
    text = capfd.readouterr().out
    assert "Linear stability" in text
    assert "2.828" in numbers_in(text)
    assert "not applicable: it chooses its own steps" in text
    rows = json.loads(file.read_text())["rows"]
    assert [row["integrator"] for row in rows] == ["gnomon:RK4", "gnomon:DOP853"]
    assert rows[0]["data"]["imaginary"]["stable"][0][1] == pytest.approx(8**0.5, rel=1e-3)


def measured(file: Path, *integrators: str, depth: str = "normal") -> int:
    words = [word for integrator in integrators for word in ("--integrator", integrator)]
    return gnomon("stability", *words, "--panel", "linear", "--depth", depth, "--out", str(file))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A file with the linear panel of RK4."""
    assert measured(tmp_path / "stability.json", "gnomon:RK4") == 0
    return tmp_path / "stability.json"


def test_the_same_command_resumes_and_another_one_adds(file: Path) -> None:
    """Changed seconds of processor time in the file show that a row was kept."""
    whole = json.loads(file.read_text())
    whole["rows"][0]["seconds"] = 123.0
    file.write_text(json.dumps(whole))
    assert measured(file, "gnomon:Heun", "gnomon:RK4") == 0
    rows = json.loads(file.read_text())["rows"]
    kept = [(row["integrator"], row["seconds"] == 123.0) for row in rows]
    assert kept == [("gnomon:RK4", True), ("gnomon:Heun", False)]


def test_what_was_measured_before_is_no_result_of_a_command_that_measured_nothing(file: Path) -> None:
    assert measured(file, "gnomon:DOP853") == 2, "it chooses its own steps, so that the panel does not apply"
    assert len(json.loads(file.read_text())["rows"]) == 2


def test_an_interruption_keeps_what_was_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*given: Any, former: list[Any]) -> None:
        given[4](Row("gnomon:RK4", "linear", 1.0, {"refused": "planted"}, []))
        raise KeyboardInterrupt

    monkeypatch.setattr("gnomon.harness.stability.panel_run.measure_panels", interrupted)
    file = tmp_path / "stability.json"
    assert measured(file, "gnomon:RK4") != 0
    assert [row["integrator"] for row in json.loads(file.read_text())["rows"]] == ["gnomon:RK4"]


@pytest.mark.parametrize("change", ["depth", "sources", "shape", "panel", "text"])
def test_a_file_that_says_something_else_is_refused_and_stays(
    change: str, file: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    whole = json.loads(file.read_text())
    if change == "sources":
        whole["environment"]["sources"] = "0"
    if change == "shape":
        whole["rows"][0]["more"] = 1
    if change == "panel":
        whole["rows"][0]["panel"] = []
    file.write_text("a letter" if change == "text" else json.dumps(whole))
    before = file.read_bytes()
    assert measured(file, "gnomon:RK4", depth="high" if change == "depth" else "normal") == 2
    assert "name another file with --out" in capfd.readouterr().err
    assert file.read_bytes() == before


def test_nothing_measured_is_exit_code_2(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("stability", "--integrator", "gnomon:DOP853", "--panel", "linear") == 2
    assert "nothing was measured" in capfd.readouterr().err


def test_an_update_measures_named_panels_again_keeps_the_others_and_makes_all_sentences_anew(tmp_path: Path) -> None:
    """Another revision wrote the file; changed seconds show which rows were kept."""
    file = tmp_path / "stability.json"
    words = ["--integrator", "gnomon:RK4", "--integrator", "gnomon:Heun", "--out", str(file)]
    panels = ["--panel", "linear", "--panel", "stiffness"]
    assert gnomon("stability", *words, *panels) == 0
    whole = json.loads(file.read_text())
    for row in whole["rows"]:
        del row["sources"]  # as in files of before
        row |= {"seconds": 123.0, "sentences": ["Use it for all."]}
    whole["environment"] |= {"sources": "0", "numpy": "0"}
    file.write_text(json.dumps(whole))
    assert gnomon("stability", *words, *panels) == 2, "another revision measured it"

    def kept() -> set[tuple[str, str]]:
        rows = json.loads(file.read_text())["rows"]
        assert not any("Use it for all." in row["sentences"] for row in rows)
        assert all(row["sentences"] for row in rows)
        return {(row["integrator"], row["panel"]) for row in rows if row["seconds"] == 123.0}

    every = {(name, panel) for name in ("gnomon:RK4", "gnomon:Heun") for panel in ("linear", "stiffness")}
    again = ["--update", "--panel", "linear"]
    assert gnomon("stability", "--integrator", "gnomon:RK4", *again, "--out", str(file)) == 0
    assert kept() == every - {("gnomon:RK4", "linear")}
    assert gnomon("stability", *words, *again) == 0
    assert kept() == {(name, panel) for name, panel in every if panel == "stiffness"}
    measured_now = file.read_bytes()
    assert gnomon("stability", *words, *again) == 0
    assert file.read_bytes() == measured_now, "rows that this revision measured are kept: an interrupted update resumes"


def test_an_update_of_another_machine_is_refused(file: Path, capfd: pytest.CaptureFixture[str]) -> None:
    whole = json.loads(file.read_text())
    whole["environment"]["machine"] = "another"
    file.write_text(json.dumps(whole))
    assert gnomon("stability", "--integrator", "gnomon:RK4", "--update", "--out", str(file)) == 2
    assert "another machine" in capfd.readouterr().err
    assert gnomon("stability", "--update") == 2
    assert "name the file with --out" in capfd.readouterr().err
