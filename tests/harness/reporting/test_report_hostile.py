"""A results file is data: a report imports nothing that it names, and writes and removes nothing outside its folder."""

import json
import sqlite3
from pathlib import Path

import pytest
import synthetic
from gnomon.harness.reporting.report import write_report
from gnomon.harness.reporting.report_charts import MANIFEST, slug
from gnomon.harness.results import schema

MODULE = """
import pathlib, sys
pathlib.Path(__file__).with_name("ran").touch()
sys.exit(0)
"""


@pytest.fixture
def hostile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a results file whose cases name a module in the working directory, and paths outside the report."""
    place = tmp_path / "theirs"
    place.mkdir()
    (place / "evilmod.py").write_text(MODULE)
    monkeypatch.chdir(place)
    monkeypatch.syspath_prepend(str(place))
    path = synthetic.write(place / "results.sqlite")
    with sqlite3.connect(path) as db:
        schema.with_checksums(db)
        for old, new in (
            ("kepler_orbit", "evilmod:Case"),
            ("bouncing_ball", f"{tmp_path}/elsewhere/mine.x"),
            ("pendulum_simple", "../../victim/x"),
        ):
            db.execute('UPDATE trials SET "case" = ? WHERE "case" = ?', (new, old))
        schema.seal_all(db, "trials")
    return path


def _earlier(target: Path) -> None:
    """Fill the folder before the report: figures of an earlier report, listed in its manifest, and files of the user.

    The manifest is data too: entries that are not plain names are ignored.
    """
    figures = target / "figures"
    figures.mkdir(parents=True)
    (target / "mine.svg").touch()
    for name in ("holiday.png", "thesis.svg", "old.svg", "old.png"):
        (figures / name).touch()
    (figures / MANIFEST).write_text(json.dumps(["old", "../mine", 3]))


def test_a_report_imports_writes_and_removes_nothing_that_a_file_names(hostile: Path, tmp_path: Path) -> None:
    for name in ("elsewhere", "victim"):
        (tmp_path / name).mkdir()
    target = tmp_path / "reports" / "report"
    _earlier(target)
    page = write_report(hostile, target, figures=True)
    assert page.is_file()
    assert not (hostile.parent / "ran").exists()
    assert not [*(tmp_path / "elsewhere").iterdir(), *(tmp_path / "victim").iterdir()]
    written = {path for path in tmp_path.rglob("*") if path.is_file() and path.suffix in (".svg", ".png", ".html")}
    assert written
    assert all(target.resolve() in path.resolve().parents for path in written)
    kept = {path.name for path in (target / "figures").iterdir()}
    assert {"holiday.png", "thesis.svg"} <= kept
    assert not {"old.svg", "old.png"} & kept
    assert (target / "mine.svg").exists()


def test_every_text_has_a_file_name_of_its_own() -> None:
    texts = ["pendulum_simple", "Pendulum_simple", "../x", "x", "a/b", "a.b", "a:b", "", "arc length"]
    texts += ["é" * 300, "a" * 300]
    names = [slug(text) for text in texts]
    assert len(set(names)) == len(texts)
    assert all(set(name) <= set("abcdefghijklmnopqrstuvwxyz0123456789_") and 0 < len(name) < 80 for name in names)
    assert slug("pendulum_simple") == "pendulum_simple"
    assert slug("arc length") == "arc_length"
