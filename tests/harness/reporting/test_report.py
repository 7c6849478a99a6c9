"""The report as files: page, summary, figures, from results with rows of every kind."""

import io
import math
import re
import shutil
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import planted_sidecars
import pytest
import synthetic
import vl_convert
from gnomon.cases import case_class
from gnomon.harness.reporting.figures_work import EXACT, draw, front, work_precision
from gnomon.harness.reporting.images import leaner, smaller
from gnomon.harness.reporting.report import write_report
from gnomon.harness.reporting.report_charts import work_problems
from gnomon.harness.reporting.report_pack import pack_json
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.reporting.report_words import page_words
from gnomon.harness.results.analysis import not_run
from gnomon.harness.results.store import Store
from page_parts import carried, read_page
from PIL import Image

LARGEST_PAGE = 3_000_000
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reports")
    planted_sidecars.write(folder)
    return write_report(synthetic.write(folder / "results.sqlite"), folder, figures=True)


class _References(HTMLParser):
    """Collects the addresses that a browser would fetch, and the ids that links point to."""

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
    text = read_page(written)
    assert written.name == "index.html"
    assert len(text.encode()) < LARGEST_PAGE
    found = _References()
    found.feed(text)
    assert all(reference.startswith("data:") for reference in found.fetched)
    inside = {anchor for anchor in found.anchors if anchor.startswith("#")}
    assert {anchor[1:] for anchor in inside} <= found.ids
    for anchor in found.anchors - inside:
        assert anchor.startswith("https://") or (written.parent / anchor).is_file(), anchor
    style = text[text.index("<style>") : text.index("</style>")]
    assert not re.search(r"@import|url\(", style)


def test_the_documentation_is_linked_where_the_page_is_in_a_copy_of_the_repository(
    written: Path, tmp_path: Path
) -> None:
    """And nowhere else: a link into nothing is worse than none. The summary is linked although it is written last."""
    (tmp_path / "docs").mkdir()
    for name in ("libraries", "index", "cases", "integrator", "solve"):
        (tmp_path / "docs" / f"{name}.md").touch()
    (tmp_path / "README.md").touch()
    page = write_report(written.parent / "results.sqlite", tmp_path / "reports" / "mine")
    found = _References()
    found.feed(read_page(page))
    files = {anchor for anchor in found.anchors if not anchor.startswith(("#", "https:"))}
    assert {"summary.md", "../../README.md", "../../docs/libraries.md", "../../docs/solve.md"} <= files
    assert all((page.parent / anchor).is_file() for anchor in files)
    outside = _References()
    outside.feed(read_page(written))
    assert "summary.md" in outside.anchors
    assert not any(anchor.startswith(("../", "docs/")) for anchor in outside.anchors)


def test_the_parts_of_the_page_are_in_sequence_and_show_every_integrator(written: Path) -> None:
    """Pictures come before needs and cases, and how to reproduce them last, as the menu at the head says."""
    text = read_page(written)
    menu = re.findall(r'href="#(\w+)"', text[text.index("<nav") : text.index("</nav>")])
    assert re.findall(r'<section id="(\w+)">', text) == menu
    assert {"overview", "cases", "integrators", "stability", "failures", "reproduce"} <= set(menu)
    multiples = text[text.index('<section id="integrators">') : text.index('<section id="stability">')]
    pictures = {name for name in _ids(multiples) if name.startswith("of-")}
    assert len(pictures) == len(synthetic.INTEGRATORS)
    for words in ("Invented CPU", "gnomon run", "a note", "46.1"):
        assert words in text
    data = carried(written)
    tables = "".join(text for part in ("times", "stability") for text in data[part].values())
    for words in ("order 4.00", "declared 4", "× tolerance", "phase", "shape", "events: all", "12 turns off"):
        assert words in tables
    for forbidden in ("nan<", ">nan", "None<", "inf<"):
        assert forbidden not in text + tables


def _ids(text: str) -> set[str]:
    found = _References()
    found.feed(text)
    return found.ids


def test_the_first_pictures_stand_in_the_page_before_its_data_and_need_no_script(written: Path) -> None:
    """At once, in print, and without JavaScript: drawings, not figures that a script builds later."""
    text = read_page(written)
    overview = text[text.index('<section id="overview">') : text.index('<section id="cases">')]
    assert overview.count("<svg") == 4, "two axes, for two widths of the page"
    assert 'class="chart"' not in overview
    assert overview.index("<figure") < overview.index("<p class")
    assert text.index("</main>") < text.index('id="data"')


def test_panels_of_stability_have_links_and_say_what_follows(written: Path) -> None:
    text = read_page(written)
    start = text.index('id="panel-linear"')
    assert text.index('<section id="stability">') < start < text.index('<section id="failures">')
    panel = text[start : text.index("</details>", start)]
    for words in ("Linear stability", "1 integrator<", "refused: not here (1)"):
        assert words in panel
    assert 'data-chart="stability_linear"' in panel
    assert "stability_linear" in carried(written)["others"]


def test_every_integrator_has_a_card_that_says_what_follows_and_links_to_its_panels(written: Path) -> None:
    text = read_page(written)
    found = _References()
    found.feed(text)
    assert {name for name in found.ids if name.startswith("card-")} == {"card-gnomon:RK4", "card-heyoka:Taylor"}
    assert "#panel-linear" in found.anchors
    cards = text[text.index('<article class="method"') :]
    assert "Use it up to h w &lt; 2.828." in cards
    assert "refused: not here" in cards


def test_charts_have_every_problem(written: Path) -> None:
    charts = carried(written)
    assert {name: set(problems) for name, problems in charts["work"]["cases"].items()} == {
        "pendulum_simple": {"default", "separatrix", "long"},
        "kepler_orbit": {"default", "e09"},
        "bouncing_ball": {"default"},
    }
    points = charts["work"]["cases"]["kepler_orbit"]["default"]["points"]
    assert len({len(points[name]) for name in ("setting", "time", "calls", "error", "failed")}) == 1
    assert "tolerance" in charts["others"]
    assert {len(cells) for _, _, cells in charts["map"]["rows"]} == {len(charts["map"]["series"])}
    ran = {(name, label) for name, problems in charts["work"]["cases"].items() for label in problems}
    assert {(name, label) for name, label, _ in charts["map"]["rows"]} == ran


def test_variants_that_nobody_ran_are_listed_beside_those_that_ran(written: Path) -> None:
    """A reader who chooses one must learn that it was not run, and not see the diagram of another."""
    for name, about in carried(written)["about"].items():
        declared = {variant.name for variant in case_class(name).variants}
        ran = set(about["stresses"]) - {"default"}
        assert set(about["unrun"]) == declared - ran


def test_an_error_of_exactly_zero_is_drawn_below_every_floor(written: Path) -> None:
    points = carried(written)["work"]["cases"]["bouncing_ball"]["default"]["points"]
    assert min(error for error in points["error"] if error is not None) == 100 * EXACT


def test_numbers_that_json_does_not_have_are_refused() -> None:
    with pytest.raises(ValueError, match="JSON"):
        pack_json({"error": -math.inf})


def test_the_front_has_the_fastest_of_each_kind_at_each_error() -> None:
    sweeps = {  # seconds and errors in decades
        "fast": [(-5, -2), (-4, -7)],
        "slow but accurate": [(-3, -4), (-2.9, -13)],
        "slow": [(-3, -2), (-2, -7)],
        "other, never there": [(-3, -1), (-2, -2)],
        "third, diverged": [(-6, math.inf), (-5, math.inf)],
        "patchy": [(-7, -8), (-6, math.inf), (-2, -9)],
    }
    rows = [(name, time, error) for name, points in sweeps.items() for time, error in points]
    kinds = {name: name.partition(",")[0] if "," in name else "one" for name in sweeps}
    kept = pd.DataFrame(rows, columns=["series", "time", "error"])
    assert front(kept, kinds) == {"fast", "slow but accurate", "other, never there"}


def test_what_was_not_run_on_a_hard_variant_is_not_broken_there() -> None:
    """`a` ran on both hard variants, `b` on one of them, `c` on none; none ran `third`; `d` does not accept the case."""
    ran = [
        ("", "a", "ok"), ("first", "a", "ok"), ("second", "a", "partly"), ("", "b", "ok"), ("first", "b", "ok"),
        ("", "c", "ok"), ("", "d", "unsupported"), ("first", "d", "unsupported"), ("second", "b", "unsupported"),
    ]  # fmt: skip
    matrix = pd.DataFrame(ran, columns=["variant", "integrator_id", "verdict"])
    matrix = matrix.assign(case="x", formulation="", library="l", ok=1, best=1e-9)
    for variants, missing in (((), {("second", "c"), ("first", "c")}), (("third",), {("third", "a"), ("third", "b")})):
        found = not_run(matrix, {"x": variants})
        pairs = set(found[["variant", "integrator_id"]].itertuples(index=False, name=None))
        assert pairs >= missing
        assert not pairs & {("first", "b"), ("second", "b"), ("third", "d")}
    assert len(not_run(matrix, {})) == 2


def _written(pixels: np.ndarray) -> bytes:
    found = io.BytesIO()
    Image.fromarray(pixels).save(found, "PNG", compress_level=0)
    return found.getvalue()


def _shown(png: bytes) -> np.ndarray:
    """The colours of a picture (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))


def test_pictures_of_few_colours_get_smaller_without_loss() -> None:
    pixels = np.repeat(np.random.default_rng(1).integers(0, 256, (5, 7, 4), dtype=np.uint8), 40, axis=1)
    pixels[:, :, 3] = 255
    picture = _written(pixels)
    found = smaller(picture)
    assert len(found) < len(picture)
    np.testing.assert_array_equal(_shown(found), pixels[:, :, :3])
    assert smaller(found) == found


def test_a_picture_with_a_transparent_part_stays() -> None:
    """A palette has no colour for a partly transparent pixel."""
    pixels = np.full((5, 7, 4), 255, dtype=np.uint8)
    pixels[2, 3, 3] = 0
    picture = _written(pixels)
    assert smaller(picture) == picture


def test_in_pictures_of_many_colours_the_rare_ones_take_the_nearest() -> None:
    shades = np.linspace(0, 255, 256).astype(np.uint8)
    pixels = np.full((256, 100, 4), 255, dtype=np.uint8)
    pixels[:, :50, :3] = shades[:, np.newaxis, np.newaxis]  # greys, and paper
    found = _shown(smaller(_written(pixels))).astype(int)
    # 256 greys among 63 colours: the farthest is half of 256 / 63 away, were they spread evenly
    assert np.max(np.abs(found - pixels[:, :, :3])) < 8
    np.testing.assert_array_equal(found[:-8, 50:], 255)


def test_a_run_in_which_all_failed_is_reported(written: Path, tmp_path: Path) -> None:
    """Its figure shows the failed trials; with an empty legend it had a width of 1.8e308, which no PNG has."""
    run = Run.read(written.parent / "results.sqlite")
    points = work_problems(run)["pendulum_simple"]["default"]["points"]
    failed = points.assign(failed=True, front=False, status="diverged")
    svg = vl_convert.vegalite_to_svg(draw(work_precision(run.look, "time"), failed, {}))
    width = re.search(r'width="([^"]*)"', svg)
    assert width is not None
    assert 300 < float(width[1]) < 3000


def test_a_diagram_has_a_mark_for_each_setting_and_a_line_for_each_limit_above_zero(written: Path) -> None:
    run = Run.read(written.parent / "results.sqlite")
    points = work_problems(run)["pendulum_simple"]["default"]["points"]
    found = draw(work_precision(run.look, "time"), points, {"conditioning": 1e-12, "floor": 0.0})
    assert found["datasets"]["limits"] == [{"limit": "conditioning", "at": -12.0}]
    marks = pd.DataFrame(found["datasets"]["points"])[["time", "error"]]
    np.testing.assert_allclose(marks.astype(float), points[["time", "error"]].astype(float), atol=1e-3)  # of a decade
    places = [layer["encoding"] for layer in found["layer"] if layer["mark"]["type"] == "point"]
    assert [(place["x"]["field"], place["y"]["field"]) for place in places] == [("time", "error")] * 2


def test_drawings_get_leaner_and_look_the_same() -> None:
    rows = [{"x": k % 7, "y": k / 3, "kind": "ab"[k % 2]} for k in range(40)]
    encoding = {"x": {"field": "x", "type": "quantitative"}, "y": {"field": "y", "type": "quantitative"}}
    encoding["color"] = {"field": "kind", "type": "nominal"}
    layers = [{"mark": "line"}, {"mark": {"type": "point", "filled": True}}, {"mark": "rect"}]
    svg = vl_convert.vegalite_to_svg({"data": {"values": rows}, "encoding": encoding, "layer": layers})
    lean = leaner(svg)
    assert len(lean) < len(svg) / 2
    before, after = (_shown(vl_convert.svg_to_png(text)).astype(float) for text in (svg, lean))
    assert before.shape == after.shape
    # a tenth of a pixel shifts the shading of an edge, no more
    assert np.mean(np.abs(before - after)) < 1
    assert np.std(before) > 10


def test_summary_and_figures(written: Path) -> None:
    summary = (written.parent / "summary.md").read_text(encoding="utf-8")
    assert len(summary.encode()) < 1_000_000  # the limit of a CI job summary
    tables = [line for line in summary.splitlines() if line.startswith("|")]
    assert any("kepler_orbit" in line for line in tables)
    page = read_page(written)
    for said in ("7.60", "1.00 (0.98 to 1.02)", "128 steps a period"):
        assert said in page
    pair = "| Gauss and heyoka:Taylor | pendulum_simple/speed | 1e-6 | 100 µs | 765 µs | 7.60 ("
    assert any(line.startswith(pair) for line in tables), "the geometric mean of its five ratios, with an interval"
    assert "| RK4 | pendulum_simple | binary64 | as it runs | 3.95 | 4 | symplectic form, momentum |" in tables
    assert "3.95" in page[page.index("<h3>The order of each method") :]
    assert "| RK4 | pendulum_simple | 128 steps a period | 1e5 | 1.0e-3 | 1.00 (0.98 to 1.02) | t | t |" in tables
    figures = written.parent / "figures"
    names = {path.stem for path in figures.iterdir() if path.suffix != ".json"}
    assert {"pendulum_simple", "kepler_orbit", "bouncing_ball", "tolerance"} <= names
    for name in names:
        assert ET.parse(figures / f"{name}.svg").getroot().tag.endswith("svg")
        assert (figures / f"{name}.png").read_bytes().startswith(PNG)


def test_the_cost_of_one_solve_and_of_many_stands_in_page_and_summary(tmp_path: Path) -> None:
    """With the first use; of a run without it nothing is said."""
    names = ("pendulum_simple", "kepler_orbit", "harmonic_oscillator", "duffing_unforced", "euler_top")
    cases = {name: ("Title", "1", 2, ("default",)) for name in names}
    methods = [("scipy", "RK45", "", 5, "tolerance", 4e-7, ""), ("rebound", "IAS15", "", 15, "tolerance", 1e-7, "")]
    used = {"rebound": 0.5, "scipy": 0.1}

    def with_first_use(trial: dict[str, Any], launch: int, row: dict[str, Any]) -> dict[str, Any]:
        first = trial["case"] == names[0] and trial["setting"] == 0.1 and launch == 1
        return row | ({"first_seconds": used[trial["library"]]} if first else {})

    write_report(synthetic.write(tmp_path / "results.sqlite", cases, methods, with_first_use), tmp_path)
    summary, page = ((tmp_path / name).read_text(encoding="utf-8") for name in ("summary.md", "index.html"))
    rows = [line.split(" | ") for line in summary.splitlines() if line.startswith("| 1e-6 |")]
    assert [(name, reached) for _, name, reached, *_ in rows] == [("SciPy", "5"), ("REBOUND", "5")]
    assert [[cost.strip(" |").endswith("least") for cost in costs] for _, _, _, *costs in rows] == [
        [True, False, False],
        [False, True, True],
    ]
    assert 'id="break-even"' in page
    own = Run.read(tmp_path)
    assert (
        page_words(replace(own, frame=own.frame.assign(first_seconds=math.nan)), (), work_problems(own))["break_even"]
        == []
    )


def test_a_page_without_figures_removes_those_that_it_would_contradict(written: Path, tmp_path: Path) -> None:
    """Figures of an earlier report, listed in its manifest, are removed; a file of the user stays."""
    figures = tmp_path / "figures"
    shutil.copytree(written.parent / "figures", figures)
    (figures / "own.svg").touch()
    write_report(written.parent / "results.sqlite", tmp_path)
    assert [path.name for path in figures.iterdir()] == ["own.svg"]


def test_results_without_measurements_are_refused_with_the_way_out(tmp_path: Path) -> None:
    Store(tmp_path / "results.sqlite").close()
    with pytest.raises(ValueError, match="gnomon run"):
        write_report(tmp_path, tmp_path / "reports")
