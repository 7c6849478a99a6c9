"""The report's page in a real browser: the system's Chromium, driven by Playwright."""

import json
import shutil
import sqlite3
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
import synthetic
from axe_core_python.sync_playwright import Axe
from gnomon.cases import case_class
from gnomon.harness.reporting.report import write_report
from gnomon.harness.results import schema
from playwright.sync_api import Browser, ConsoleMessage, Page, Request, expect, sync_playwright

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium found: install the system's package `chromium`"),
]


@dataclass
class Visit:
    """A page, errors and warnings of its console with its exceptions, and the addresses of all that it asked for."""

    page: Page
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.page.on("console", self._hear)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", self._note)

    def _hear(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning", "assert"):
            self.complaints.append(message.text)

    def _note(self, request: Request) -> None:
        if not request.url.startswith(("data:", "blob:")):
            self.requests.append(request.url)

    def open(self, path: Path) -> Page:
        """The page, once its script has started."""
        self.page.goto(path.resolve().as_uri())
        _wait_until_ready(self.page)
        return self.page


def _wait_until_ready(page: Page) -> None:
    page.wait_for_function("gnomonCharts.ready || gnomonCharts.failed")


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM)
        yield browser
        browser.close()


@pytest.fixture
def visit(chromium: Browser) -> Iterator[Callable[..., Visit]]:
    """Makes visits of this width and height, with this preferred colour scheme."""
    contexts = []

    def begin(width: int = 1400, height: int = 900, scheme: str = "light") -> Visit:
        size = {"width": width, "height": height}
        context = chromium.new_context(viewport=size, is_mobile=width < 600, color_scheme=scheme)  # type: ignore[arg-type]
        contexts.append(context)
        return Visit(context.new_page())

    yield begin
    for context in contexts:
        context.close()


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a run in which every trial on the long pendulum failed."""
    folder = tmp_path_factory.mktemp("reports")
    results = synthetic.write(folder / "results.sqlite")
    with sqlite3.connect(results) as db:
        db.execute(
            "UPDATE measurements SET status = 'timeout', error_max = NULL, seconds_median = NULL, rhs_calls = NULL"
            " WHERE trial_key LIKE 'pendulum_simple/long%'"
        )
        schema.seal_all(schema.with_checksums(db), "measurements")
    return write_report(results, folder)


OPENED = """() => {
  document.documentElement.style.scrollBehavior = "auto";
  document.querySelectorAll("details:not([open]) > summary, .map button[aria-expanded=false]").forEach((part) => part.click());
}"""

DRAWN = """() => {
  const waiting = [...document.querySelectorAll(".chart")].find(
    (figure) => !["built", "failed"].includes(figure.dataset.state));
  if (waiting) waiting.scrollIntoView();
  return !waiting;
}"""


def scroll(page: Page) -> int:
    """Open all that is closed and scroll until each figure is drawn; returns their number."""
    page.evaluate(OPENED)
    page.wait_for_function(DRAWN)
    return page.locator(".chart").count()


@pytest.mark.parametrize(("width", "height"), [(1400, 900), (390, 844)])
def test_page_in_a_browser(visit: Callable[..., Visit], report: Path, tmp_path: Path, width: int, height: int) -> None:
    here = visit(width, height)
    page = here.open(report)
    assert here.complaints == []
    assert page.evaluate("document.documentElement.scrollWidth") == width

    shown = scroll(page)
    assert shown == 3, "kinds of system, work-precision and tolerances"
    assert page.evaluate("gnomonCharts") == {"built": shown, "failed": 0, "ready": True}
    drawn = """[...document.querySelectorAll('.chart[data-state="built"]')].every(
        (figure) => figure.querySelectorAll("svg path, svg line").length > 30)"""
    assert page.evaluate(drawn)
    cells = """[...document.querySelectorAll("[data-map]")].map((map) => map.querySelectorAll("td").length)"""
    variants = {(name, variant.name) for name in synthetic.CASES for variant in case_class(name).variants}
    problems = variants | {(name, label) for name, (*_, labels) in synthetic.CASES.items() for label in labels}
    assert page.evaluate(cells) == [3 * 7 + 2, (2 + 3 + len(problems)) * 7], (
        "rows of defaults; of chapters, cases, problems"
    )
    assert page.evaluate("document.documentElement.scrollWidth") == width

    # Typing finds a case and opens its chapter; nothing typed shows all.
    chapters, find = page.locator("details.chapter:not([hidden])"), page.locator('[data-role="find"]')
    find.fill("orbit 7.12")
    expect(chapters.locator("summary strong")).to_have_text(["7 Momentum, work and energy"])
    links = chapters.locator("tr[data-words] a:visible")
    assert [link.get_attribute("href") for link in links.all()] == ["#case-kepler_orbit"]
    find.fill("")
    expect(chapters).to_have_count(2)

    # Another case, its last variant, the other axis and all integrators replace the diagram.
    panel = page.locator("#panel")
    panel.locator('[data-role="case"]').select_option(index=1)
    problem = panel.locator('[data-role="problem"]')
    problem.select_option(index=problem.locator("option").count() - 1)
    panel.get_by_role("button", name="against right-hand sides").click()
    panel.get_by_role("button", name="all", exact=True).click()
    page.wait_for_function("wanted => gnomonCharts.built + gnomonCharts.failed >= wanted", arg=shown + 4)
    assert page.locator('[data-table="times"] th').first.text_content() == "integrator"
    assert page.evaluate("gnomonCharts.failed") == 0
    assert len(page.screenshot(path=tmp_path / f"page_{width}.png")) > 20_000

    assert here.complaints == []
    assert here.requests == [report.resolve().as_uri()]


@pytest.mark.parametrize(("problem", "shown"), [("long", [False, True]), ("separatrix", [True, False])])
def test_an_empty_diagram_is_not_shown_but_said(
    visit: Callable[..., Visit], report: Path, problem: str, shown: list[bool]
) -> None:
    here = visit()
    panel = here.open(report).locator("#panel")
    panel.locator('[data-role="case"]').select_option("pendulum_simple")
    panel.locator('[data-role="problem"]').select_option(problem)
    assert [panel.locator(part).is_visible() for part in ("figure", '[data-role="nothing"]')] == shown
    assert here.complaints == []


def test_a_heading_sorts_its_column_both_ways(visit: Callable[..., Visit], report: Path) -> None:
    table = visit().open(report).locator(".sortable:visible").first
    headings = table.locator("thead button").all_text_contents()
    column = next(k for k, text in enumerate(headings) if text.startswith("digits"))

    def sort() -> list[str]:
        table.locator("thead button").nth(column).click()
        cells = "(table, column) => [...table.tBodies[0].rows].map((row) => row.cells[column].dataset.value)"
        found: list[str] = table.evaluate(cells, column)
        return found

    up, down = sort(), sort()
    assert len(set(up)) > 3
    assert up == sorted(up, key=float)
    assert down == up[::-1]


OWN_NAMES = """(() => {
  const shown = (element) => element.checkVisibility();
  const cells = [...document.querySelectorAll("main tbody :is(th, td), main li, main svg text, main .map th")].filter(shown);
  return cells.map((cell) => cell.textContent).filter((text) => text.includes("gnomon:"));
})()"""


def test_in_house_methods_can_be_hidden_on_the_whole_page_and_stay_hidden(
    visit: Callable[..., Visit], report: Path
) -> None:
    """The times of third parties are then compared with each other: some third party is the fastest of each column."""
    here = visit()
    page = here.open(report)
    scroll(page)
    assert page.evaluate(OWN_NAMES)
    page.locator("#own").click()
    scroll(page)
    assert page.evaluate(OWN_NAMES) == []
    notes = page.locator("#panel .times td small").all_text_contents()
    assert any(note.startswith("fastest") for note in notes)
    page.reload()
    _wait_until_ready(page)
    assert page.locator("#own").get_attribute("aria-pressed") == "true"
    assert page.evaluate(OWN_NAMES) == []
    page.locator("#own").click()
    scroll(page)
    assert page.evaluate(OWN_NAMES)
    assert here.complaints == []


def test_a_search_that_finds_nothing_says_so(visit: Callable[..., Visit], report: Path) -> None:
    page = visit().open(report)
    for words, nothing in (("orbit", False), ("no such case", True)):
        page.locator('[data-role="find"]').fill(words)
        assert page.locator('[data-role="found-none"]').is_visible() == nothing


def test_a_link_to_a_case_shows_its_diagram(visit: Callable[..., Visit], report: Path) -> None:
    here = visit()
    page = here.open(report)
    for name in synthetic.CASES:
        page.evaluate(f"location.hash = 'case-{name}'")
        expect(page.locator('#panel [data-role="case"]')).to_have_value(name)
        expect(page.locator('[data-role="permanent"]')).to_have_attribute("href", f"#case-{name}")
    assert here.complaints == []


STABILITY = {
    "schema": 1, "depth": "normal", "environment": {}, "panels": {"linear": "Linear stability", "events": "Events"},
    "figures": {
        "linear": {"cells": False, "columns": [{"id": "limit", "title": "h w", "decades": True, "ends": [0.1, 60]}]},
        "events": {"cells": True, "columns": [{"id": "found", "title": "found", "decades": False, "ends": None}]},
    },
    "rows": [
        {"integrator": name, "panel": panel, "data": {}, "sentences": [f"Use {name}."], "marks": [
            {"column": column, "at": 0.9, "low": 0.1, "high": 1.5, "text": "9/10"}]}
        for panel, column in (("linear", "limit"), ("events", "found")) for name in ("gnomon:RK4", "scipy:RK45")
    ],
}  # fmt: skip


def test_a_link_into_a_closed_part_opens_it(visit: Callable[..., Visit], tmp_path: Path) -> None:
    (tmp_path / "stability.json").write_text(json.dumps(STABILITY))
    here = visit()
    page = here.open(write_report(synthetic.write(tmp_path / "results.sqlite"), tmp_path))
    page.evaluate("document.querySelectorAll('details').forEach((part) => (part.open = false))")
    part = page.locator("details[id]").first
    page.evaluate(f"location.hash = '{part.get_attribute('id')}'")
    expect(part).to_have_attribute("open", "")
    assert here.complaints == []


def test_the_page_can_be_read_by_all(visit: Callable[..., Visit], tmp_path: Path) -> None:
    """By axe-core's rules of WCAG 2, A and AA: contrast, alternative texts, names, scrolling by the keyboard."""
    (tmp_path / "stability.json").write_text(json.dumps(STABILITY))
    report = write_report(synthetic.write(tmp_path / "results.sqlite"), tmp_path)
    for scheme, width in (("light", 1400), ("light", 390), ("dark", 1400)):
        page = visit(width, scheme=scheme).open(report)
        page.evaluate("document.querySelectorAll('details').forEach((part) => (part.open = true))")
        scroll(page)
        found = Axe().run(page, options={"runOnly": ["wcag2a", "wcag2aa"], "resultTypes": ["violations"]})
        violations = [(one["id"], len(one["nodes"]), one["nodes"][0]["target"]) for one in found["violations"]]
        assert violations == [], (scheme, width)


def test_the_switch_works_where_the_browser_stores_nothing(visit: Callable[..., Visit], report: Path) -> None:
    here = visit()
    forbidden = "Object.defineProperty(window, 'localStorage', { get() { throw new DOMException('no storage') } })"
    here.page.add_init_script(forbidden)
    page = here.open(report)
    page.locator("#own").click()
    assert page.evaluate(OWN_NAMES) == []
    assert here.complaints == []


PAINTED = """["body", ".panel", ".summary b", "thead th"].map((one) => {
  const style = getComputedStyle(document.querySelector(one));
  return [style.color, style.backgroundColor];
})"""


def test_who_prefers_the_dark_gets_it(visit: Callable[..., Visit], report: Path) -> None:
    found = [visit(scheme=scheme).open(report).evaluate(PAINTED) for scheme in ("light", "dark")]
    for light, dark in zip(*found, strict=True):
        assert _brightness(light[0]) < 0.5 < _brightness(dark[0]), "letters"
    assert [_brightness(one[1]) > 0.5 for one in found[0][:2]] == [True, True], "paper"
    assert [_brightness(one[1]) > 0.5 for one in found[1][:2]] == [False, False]


def _brightness(colour: str) -> float:
    red, green, blue = (float(part) for part in colour.partition("(")[2].rstrip(")").split(",")[:3])
    return (0.2126 * red + 0.7152 * green + 0.0722 * blue) / 255


def test_the_browser_sees_what_it_must_not(visit: Callable[..., Visit], tmp_path: Path) -> None:
    """A console error, an exception and a request to the network are found; otherwise the test above could not fail."""
    bad = tmp_path / "bad.html"
    bad.write_text(
        '<link rel="icon" href="data:,"><img src="http://gnomon.invalid/a.png">'
        "<script>console.error('planted'); undefined_function();</script>"
    )
    here = visit()
    here.page.goto(bad.as_uri())
    complaints = " ".join(here.complaints)
    assert "planted" in complaints
    assert "undefined_function" in complaints
    assert "http://gnomon.invalid/a.png" in here.requests
