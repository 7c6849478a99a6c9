"""A report is written again if something that it depends on has changed, and only then."""

import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from gnomon.harness.reporting import report, up_to_date
from gnomon.harness.reporting.up_to_date import refresh
from gnomon.harness.results import schema


@pytest.fixture
def written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How often a report was written, as the length of a list; each has another text."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    times: list[int] = []

    def write_report(_database: Path, folder: Path, *_: Any) -> Path:
        times.append(len(times))
        folder.mkdir(exist_ok=True)
        for name in ("index.html", "summary.md"):
            (folder / name).write_text(f"{name} {len(times)}")
        return folder / "index.html"

    monkeypatch.setattr(report, "write_report", write_report)
    return times


def test_what_has_not_changed_is_not_written_again(written: list[int], synthetic_results: Path, tmp_path: Path) -> None:
    for _ in range(3):
        assert refresh(synthetic_results, tmp_path / "page", {}) == tmp_path / "page" / "index.html"
    assert len(written) == 1


def _measurement(results: Path, _page: Path) -> None:
    with sqlite3.connect(results) as db:
        db.execute("UPDATE measurements SET steps = 7 WHERE measurement = 1")
        schema.seal_all(schema.with_checksums(db), "measurements")


def _figures(_results: Path, page: Path) -> None:
    """Figures of an earlier report, which this one would contradict."""
    (page / "figures").mkdir()
    (page / "figures" / "figures.json").write_text("[]")


CHANGES: dict[str, Callable[[Path, Path], Any]] = {
    "a measurement": _measurement,
    "certificates": lambda results, page: (results.parent / "certificates.json").write_text("[]"),
    "stability": lambda results, page: (results.parent / "stability.json").write_text("{}"),
    "another page": lambda results, page: (page / "index.html").write_text("another page"),
    "no summary": lambda results, page: (page / "summary.md").unlink(),
    "figures": _figures,
}


@pytest.mark.parametrize("change", CHANGES)
def test_what_has_changed_is_written_again(
    written: list[int], synthetic_results: Path, tmp_path: Path, change: str
) -> None:
    page = tmp_path / "page"
    refresh(synthetic_results, page, {})
    CHANGES[change](synthetic_results, page)
    refresh(synthetic_results, page, {})
    assert len(written) == 2


def test_other_sources_write_it_again(
    written: list[int], synthetic_results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    refresh(synthetic_results, tmp_path / "page", {})
    edited = tmp_path / "edited.py"
    edited.write_text("new code")
    sources = [*up_to_date._sources(), edited]
    monkeypatch.setattr(up_to_date, "_sources", lambda: iter(sources))
    refresh(synthetic_results, tmp_path / "page", {})
    assert len(written) == 2
    assert any(path.name == "report.html.j2" for path in sources)
    assert any(path.name == "kepler_orbit.py" for path in sources)
