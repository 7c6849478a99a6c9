"""The report as files: page, summary, figures, from results with rows of every kind."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path

import pytest
from gnomon.harness.report import write_report
from gnomon.harness.store import Store

LARGEST_PAGE = 3_000_000
CERTIFICATE = {"case": "kepler_orbit", "variant": "", "ways": {"taylor": 48.2, "residual": 46.1}, "note": "a note"}


@pytest.fixture
def written(synthetic_results: Path, tmp_path: Path) -> Path:
    folder = tmp_path / "reports"
    folder.mkdir()
    (folder / "certificates.json").write_text(json.dumps([CERTIFICATE | {"digits": 46.1, "passed": True}]))
    return write_report(synthetic_results, folder)


class _References(HTMLParser):
    """Collects whatever a browser would fetch, and the ids that links point to."""

    def __init__(self) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.anchors: set[str] = set()
        self.ids: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("src", "srcset", "data", "poster") or (name == "href" and tag == "link"):
                self.fetched.append(str(value))
            elif name == "href" and tag == "a":
                self.anchors.add(str(value))
            elif name == "id":
                self.ids.add(str(value))


def test_page_is_one_small_file_without_references(written: Path) -> None:
    text = written.read_text(encoding="utf-8")
    assert written.name == "index.html"
    assert len(text.encode()) < LARGEST_PAGE
    found = _References()
    found.feed(text)
    assert all(reference.startswith("data:") for reference in found.fetched)
    assert {anchor for anchor in found.anchors if anchor.startswith("#")} == found.anchors
    assert {anchor[1:] for anchor in found.anchors} <= found.ids
    style = text[text.index("<style>") : text.index("</style>")]
    assert not re.search(r"@import|url\(", style)


def test_page_answers_the_five_questions_and_shows_every_series(written: Path) -> None:
    text = written.read_text(encoding="utf-8")
    ids = ("fastest", "trust", "breaks", "effects", "reproduce")
    places = [text.index(f'<section id="{name}">') for name in ids]
    assert places == sorted(places)
    for words in ("Invented CPU", "gnomon run", "a note", "46.1", "RK4", "IAS15", "separatrix"):
        assert words in text
    for forbidden in ("nan<", ">nan", "None<", "inf<"):
        assert forbidden not in text


def test_charts_carry_every_scene(written: Path) -> None:
    text = written.read_text(encoding="utf-8")
    data = re.search(r'<script type="application/json" id="charts">(.*?)</script>', text, re.DOTALL)
    assert data is not None
    charts = json.loads(data[1])
    assert {name: set(scenes) for name, scenes in charts["work"]["cases"].items()} == {
        "pendulum_simple": {"default", "separatrix", "long"},
        "kepler_orbit": {"default", "e09"},
        "bouncing_ball": {"default"},
    }
    points = charts["work"]["cases"]["kepler_orbit"]["default"]["points"]
    assert len({len(points[name]) for name in ("setting", "time", "calls", "error", "failed")}) == 1
    assert {"status", "trust", "tolerance"} <= set(charts["others"])


def test_summary_and_figures(written: Path) -> None:
    summary = (written.parent / "summary.md").read_text(encoding="utf-8")
    assert len(summary.encode()) < 1_000_000  # what a CI job summary takes
    tables = [line for line in summary.splitlines() if line.startswith("|")]
    assert any("kepler_orbit" in line for line in tables)
    figures = written.parent / "figures"
    names = {path.stem for path in figures.iterdir()}
    assert {"pendulum_simple", "kepler_orbit", "bouncing_ball", "status", "trust"} <= names
    for name in names:
        assert ET.parse(figures / f"{name}.svg").getroot().tag.endswith("svg")
        assert (figures / f"{name}.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")


def test_results_without_measurements_are_refused_with_the_way_out(tmp_path: Path) -> None:
    Store(tmp_path / "results.sqlite").close()
    with pytest.raises(ValueError, match="gnomon run"):
        write_report(tmp_path, tmp_path / "reports")
