"""`gnomon plot` draws a diagram for each case of a run; `gnomon export --schema` explains every column of an export."""

import json
from pathlib import Path
from typing import Any

import pytest
import synthetic
from command_line import gnomon
from gnomon.harness.reporting import images
from gnomon.harness.results import store
from gnomon.harness.system import extras


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return synthetic.write(tmp_path / "results.sqlite")


def titles(specification: dict[str, Any]) -> list[str]:
    return [panel["title"]["text"] for panel in specification["vconcat"]]


def test_a_picture_has_a_diagram_for_each_case_with_its_own_points(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[dict[str, Any]] = []
    save = images.save
    monkeypatch.setattr(images, "save", lambda drawing, path: (written.append(drawing), save(drawing, path)))
    assert gnomon("plot", str(run), "--out", str(run.with_suffix(".svg"))) == 0
    assert run.with_suffix(".svg").read_text().startswith("<svg")
    (whole,) = written
    assert titles(whole) == [f"{name}, default" for name in synthetic.CASES]
    named = json.dumps(whole["vconcat"])
    for name, rows in whole["datasets"].items():
        assert json.dumps(name) in named, "every diagram has its data"
        assert rows or not name.startswith("points")
    (case, (_, _, _, variants)), *_ = synthetic.CASES.items()
    variant = next(variant for variant in variants if variant != "default")
    assert gnomon("plot", str(run), "--case", f"{case}/{variant}", "--out", str(run.with_suffix(".svg"))) == 0
    assert titles(written[1]) == [f"{case}, {variant}"]


def test_a_case_that_the_run_lacks_is_named(run: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (case, *_) = synthetic.CASES
    assert gnomon("plot", str(run), "--case", case[:-2]) == 2
    assert f"did you mean {case}" in capfd.readouterr().err


@pytest.mark.parametrize("command", [("plot", "RUN", "--out", "a.png"), ("show", "pendulum_simple", "--plot", "a.png")])
def test_without_a_library_of_charts_the_extra_is_named(
    command: tuple[str, ...], run: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    monkeypatch.chdir(run.parent)
    assert gnomon(*(str(run) if word == "RUN" else word for word in command)) == 2
    assert "pip install 'gnomon[report]'" in capfd.readouterr().err


def test_every_column_of_an_export_is_explained(run: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("export", "--schema") == 0
    lines = capfd.readouterr().out.splitlines()
    explained = [line.split()[0] for line in lines if line[:3].strip() and not line.startswith(" ─")][1:]
    assert explained == list(store.load(run).columns)
