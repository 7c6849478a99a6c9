"""The origin of the files beside a page: of files of earlier revisions too; and the processors of all times."""

import json
from pathlib import Path

from gnomon.harness.reporting.provenance import origins, processors_text
from gnomon.harness.reporting.report_words import _beside
from planted_sidecars import CERTIFICATE, ORDER

RUN = {"revision": "abc123", "sources": "hash", "cpu": "Invented"}


def test_a_file_of_other_sources_is_older_and_one_of_another_commit_of_the_same_sources_is_not(tmp_path: Path) -> None:
    """A commit of documents changes the revision alone; a file without an environment names it in its rows."""
    (tmp_path / "certificates.json").write_text(json.dumps([CERTIFICATE | {"revision": "old"}]))
    for name, made_by in (("orders", {"revision": "later", "sources": "hash"}), ("benchmarks", {"sources": "another"})):
        rows = [ORDER] if name == "orders" else []
        (tmp_path / f"{name}.json").write_text(json.dumps({"launches": 5, "environment": made_by, "rows": rows}))
    found = {one.part: one for one in origins([tmp_path / "nowhere", tmp_path], RUN)}
    assert {name: one.older for name, one in found.items()} == {
        "certificates": True,
        "orders": False,
        "benchmarks": True,
    }
    assert found["certificates"].revision == "old"


def test_uncommitted_changes_are_never_the_same_revision(tmp_path: Path) -> None:
    (tmp_path / "certificates.json").write_text(json.dumps([CERTIFICATE | {"revision": "abc123+"}]))
    assert origins([tmp_path], RUN | {"revision": "abc123+", "sources": None})[0].older


def test_each_processor_model_of_a_time_is_named() -> None:
    one, two = {"cpu": "A", "cores": "2"}, {"cpu": "B", "cores": "4"}
    assert "one processor model, A (2 cores)" in processors_text([one, {}, one])
    assert all(word in processors_text([one, two]) for word in ("2 processor models", "A (2 cores)", "B (4 cores)"))


def test_the_head_of_a_page_names_the_processor_of_older_times_beside_it(tmp_path: Path) -> None:
    """Times of another processor stand on the page: it may not say that all are of one."""
    rows = {"launches": 5, "rows": []}
    (tmp_path / "benchmarks.json").write_text(json.dumps(rows | {"environment": {"cpu": "Another", "cores": "2"}}))
    assert "2 processor models" in _beside([tmp_path], [RUN])["processors"]
    (tmp_path / "benchmarks.json").write_text(json.dumps(rows | {"environment": RUN}))
    assert "one processor model" in _beside([tmp_path], [RUN])["processors"]
