"""One type states the outcome of a trial; memory, files and pages hold the same words."""

import ast
import json
import re
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pandas
import pytest
from gnomon.harness.contract import status
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting import tables
from gnomon.harness.results import store

HARNESS = Path(status.__file__).parents[1]
OTHERS = {
    ("reporting/report_words.py", "not_installed"): "what the templates call the libraries that are not installed",
    ("results/opening.py", "ok"): "what SQLite's integrity check says of a sound file",
    ("studies/drift.py", "diverged"): "how a size grows over time, beside the laws",
    ("verification/verification_report.py", "skipped"): "an element of JUnit XML",
}
"""Where a word of a status means something else, by file."""
WORDS = {
    "ok", "inaccurate", "diverged", "refused", "timeout", "crashed", "out_of_memory", "interrupted", "skipped",
    "unsupported", "not_installed",
}  # fmt: skip
"""The words in results files: a word that is renamed here would make every older file unreadable."""
QUOTED = re.compile(rf"['\"]({'|'.join(WORDS)})['\"]")


def bare(path: Path) -> Iterator[tuple[str, str]]:
    """File and word of each text that is a status, or that quotes one as SQL and Vega do; docstrings aside."""
    name = path.relative_to(HARNESS).as_posix()
    tree = ast.parse(path.read_text())
    alone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in alone:
            for word in [node.value] if node.value in WORDS else QUOTED.findall(node.value):
                yield name, word


def test_no_status_is_a_bare_text() -> None:
    """One that is misspelt would match nothing, and no tool would see it."""
    sources = [path for path in HARNESS.rglob("*.py") if path.name != "status.py"]
    found = {each for path in sources for each in bare(path)}
    assert found - set(OTHERS) == set()
    assert set(OTHERS) - found == set(), "these exceptions are not needed any more"


def test_bare_texts_are_found_in_code_and_in_queries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "HARNESS", tmp_path)
    source = tmp_path / "a.py"
    source.write_text("'''Gives \"ok\".'''\nif f(x == 'ok', g=\"WHERE status = 'skipped'\", h='oklahoma'): pass\n")
    assert list(bare(source)) == [("a.py", "ok"), ("a.py", "skipped")]


def test_statuses_are_the_words_of_the_files_and_each_is_explained() -> None:
    assert {str(each) for each in Status} == WORDS
    assert set(tables.MEANINGS) == set(Status)
    groups = (status.SCORED, status.STOPPED, status.NOT_BROKEN, status.CANNOT_RUN)
    assert all(set(group) <= set(Status) for group in groups)


def test_files_hold_the_words(tmp_path: Path) -> None:
    """Readers of a results file, of a table and of JSON know no Status: each is a plain text."""
    names = (
        *("case", "variant", "formulation", "library", "integrator", "policy", "integrator_id", "setting_kind"),
        "machine",
    )
    trials = [dict.fromkeys(names, "x") | {"trial_key": each.name, "series": "s", "setting": 0.1} for each in Status]
    with store.Store(tmp_path / "results.sqlite") as results:
        run = results.begin_run("quick", "", {})
        results.plan(run, trials)
        for each in Status:
            results.add(run, {"trial_key": each.name, "launch": 1, "status": each})
        known = results.history()
    assert all(known[each.name, 1].status is each for each in Status)
    with sqlite3.connect(tmp_path / "results.sqlite") as db:
        rows = db.execute("SELECT status, typeof(status) FROM measurements").fetchall()
    assert rows == [(each.value, "text") for each in Status]
    frame = store.load(tmp_path)
    assert {type(word) for word in frame["status"]} == {str}
    assert frame["status"].isin(status.SCORED).sum() == len(status.SCORED)
    for form in ("json", "parquet"):
        store.export(tmp_path, tmp_path / form, form)
    assert [row["status"] for row in json.loads((tmp_path / "json").read_text())] == [each.value for each in Status]
    assert list(pandas.read_parquet(tmp_path / "parquet")["status"]) == [each.value for each in Status]
