"""The report's page in a real browser: the system's Chromium, driven by Playwright."""

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import invented_runs
import pytest
import synthetic
from axe_core_python.sync_playwright import Axe
from browser_visits import BROWSER, LIMIT, Visit, wait_until_ready
from gnomon.cases import case_class
from gnomon.harness.reporting.report import write_report
from gnomon.harness.results import schema
from page_parts import carried, unfold
from playwright.sync_api import Page, expect

pytestmark = BROWSER


expect.set_options(timeout=LIMIT)


STABILITY = {
    "schema": 1, "depth": "normal", "environment": {}, "panels": {"linear": "Linear stability", "events": "Events"},
    "figures": {
        "linear": {"cells": False, "columns": [{"id": "limit", "title": "h w", "decades": True, "ends": [0.1, 60]}]},
        "events": {"cells": True, "columns": [{"id": "found", "title": "found", "decades": False, "ends": None}]},
    },
    "tiers": {"lost_digits": {"tiers": [["gnomon:RK4"], ["scipy:RK45"]]}},
    "rows": [
        {"integrator": name, "panel": panel, "data": {}, "sentences": [f"Use {name}."], "marks": [
            {"column": column, "at": 0.9, "low": 0.1, "high": 1.5, "text": "9/10"}]}
        for panel, column in (("linear", "limit"), ("events", "found")) for name in ("gnomon:RK4", "scipy:RK45")
    ],
}  # fmt: skip
LOST, SLOW = ("pendulum_simple", "long"), ("kepler_orbit", "e09")
"""A hard variant on which every trial failed, and one that takes a hundred times as long as the default."""


def _written(trial: dict[str, Any], launch: int, found: dict[str, Any]) -> dict[str, Any] | None:
    if launch > 2:
        return None
    if (trial["case"], trial["variant"]) == LOST:
        return {"status": "timeout", "reason": "planted"}
    if (trial["case"], trial["variant"]) == SLOW and "seconds_median" in found:
        return found | {"seconds_median": 100 * found["seconds_median"], "rhs_calls": 7 * (found["rhs_calls"] or 0)}
    return found


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a run with all parts: profiles, needs, a picture that moves, hard variants, stability."""
    folder = tmp_path_factory.mktemp("reports")
    cases = invented_runs.cases(10) | synthetic.CASES
    results = synthetic.write(folder / "results.sqlite", cases, METHODS, _written)
    pendulum = case_class("pendulum_simple")().rounded()
    numbers = json.dumps({name: str(value) for name, value in pendulum.numbers.items()})
    with sqlite3.connect(results) as db:
        schema.with_checksums(db)
        db.execute(
            "UPDATE trials SET numbers = ? WHERE \"case\" = 'pendulum_simple' AND variant = 'default'", (numbers,)
        )
        schema.seal_all(db, "trials")
    (folder / "stability.json").write_text(json.dumps(STABILITY))
    return write_report(results, folder)


METHODS = (
    *(method for method in synthetic.INTEGRATORS if method[0] != "rebound"),
    *(method for method in invented_runs.METHODS if method[1] not in ("DOP853", "RK45", "RK4") or method[0] == "scipy"),
)
METHODS = tuple({method[:3]: method for method in METHODS}.values())

BUILT = """[...document.querySelectorAll(".chart")].every((one) => !one.checkVisibility() || one.dataset.state === "built")"""
OPENED = "document.querySelectorAll('details').forEach((part) => (part.open = true))"
SCROLLING = """[...document.querySelectorAll("main *")].filter((one) => {
  const { overflowX, overflowY } = getComputedStyle(one);
  return (/auto|scroll/.test(overflowX) && one.scrollWidth > one.clientWidth)
    || (/auto|scroll/.test(overflowY) && one.scrollHeight > one.clientHeight);
}).map((one) => one.outerHTML.slice(0, 80))"""
WIDE = """[...document.querySelectorAll("main *:not(svg *)")].filter((one) => one.checkVisibility()
  && one.getBoundingClientRect().right > document.documentElement.clientWidth + 1).map((one) => one.outerHTML.slice(0, 80))"""
CUT = """[...document.querySelectorAll("main svg text")].filter((one) => {
  const [outer, inner] = [one.ownerSVGElement.getBoundingClientRect(), one.getBoundingClientRect()];
  return inner.width && one.checkVisibility() && one.textContent.trim() && (inner.left < outer.left - 2
    || inner.right > outer.right + 2 || inner.top < outer.top - 3 || inner.bottom > outer.bottom + 3);
}).map((one) => one.textContent)"""
UNDRAWN = """[...document.querySelectorAll("main figure")].filter((one) => one.checkVisibility()
  && ![...one.querySelectorAll("svg")].some((svg) => svg.checkVisibility() && svg.getBoundingClientRect().height > 30
    && svg.querySelectorAll("path, line, circle, use").length > 2)).map((one) => one.outerHTML.slice(0, 80))"""


def _all_built(page: Page) -> None:
    page.wait_for_function("gnomonCharts.all || gnomonCharts.failed")


@pytest.mark.parametrize(("width", "height"), [(1400, 900), (768, 1024), (390, 844)])
def test_page_in_a_browser(visit: Callable[..., Visit], report: Path, width: int, height: int) -> None:
    """No complaint, no request, nothing beyond the edge, nothing that scrolls inside the page, and every figure is drawn
    without scrolling to it, as for a capture of the whole page."""
    here = visit(width, height)
    page = here.open(report)
    _all_built(page)
    for _ in ("as it opens", "all details open"):
        assert page.evaluate(UNDRAWN) == []
        assert page.evaluate("document.documentElement.scrollWidth") == width
        assert page.evaluate(WIDE) == []
        assert page.evaluate(CUT) == []
        assert page.evaluate(SCROLLING) == []
        page.evaluate(OPENED)
        page.wait_for_function(BUILT)
    assert page.evaluate("gnomonCharts.failed") == 0
    assert page.evaluate("scrollY") == 0
    assert page.locator(".chart[data-state=built]").count() == page.locator(".chart").count() >= 4
    assert here.complaints == []
    assert here.requests == [report.resolve().as_uri()]


@pytest.mark.parametrize("width", [1400, 390])
def test_the_first_figure_and_the_numbers_are_there_without_a_script(
    visit: Callable[..., Visit], report: Path, width: int
) -> None:
    here = visit(width, 844, java_script_enabled=False)
    here.page.goto(report.resolve().as_uri())
    drawn = here.page.locator(".lead figure svg:visible")
    assert drawn.count() == 1, "of the two widths and axes one is shown"
    box = drawn.bounding_box()
    assert box is not None
    assert box["y"] < 844, "on the first screen"
    assert here.page.locator("#overview figure svg:visible").count() == 2, "its diagram, and the profiles"
    assert here.page.locator("#overview svg.moving:visible").count() == 1
    assert here.page.locator("noscript:visible").count() == 1
    assert here.page.locator("button:visible").count() == 0, "a switch that does nothing is not shown"


AXES = """["time", "calls"].map((axis) => [...document.querySelectorAll(`main [data-axis="${axis}"]`)].filter(
  (one) => one.checkVisibility() && one.textContent.trim()).length)"""
PLACES = (
    """[...document.querySelectorAll('[data-chart="work"] svg path')].map((path) => path.getAttribute("d")).join()"""
)


def _built_again(page: Page, before: str) -> None:
    page.wait_for_function(
        f"before => document.querySelector('[data-chart=work]').dataset.state === 'built' && {PLACES} !== before",
        arg=before,
    )


def test_the_axis_of_evaluations_is_followed_by_every_figure_and_table(
    visit: Callable[..., Visit], report: Path
) -> None:
    """Its switch says what a press will do, and is remembered."""
    here = visit()
    page = here.open(report)
    _all_built(page)
    switch = page.locator("#axis")
    first, places = switch.inner_text(), page.evaluate(PLACES)
    time, calls = page.evaluate(AXES)
    assert time > 20
    assert calls == 0
    switch.click()
    _built_again(page, places)
    assert page.evaluate(AXES)[0] == 0
    assert page.evaluate(AXES)[1] > 20
    second = switch.inner_text()
    assert second != first
    page.reload()
    wait_until_ready(page)
    assert (switch.inner_text(), switch.get_attribute("aria-pressed")) == (second, "true")
    assert page.evaluate(AXES)[0] == 0
    switch.click()
    assert (switch.inner_text(), switch.get_attribute("aria-pressed")) == (first, "false")
    assert page.evaluate(AXES)[1] == 0
    assert here.complaints == []


OWN_INK = """["stroke", "color"].map((name) => [...new Set([
  ...document.querySelectorAll("#overview .still path, tbody.own td, .multiples.own path.reached")
].filter((one) => one.checkVisibility()).map((one) => getComputedStyle(one)[name]))])"""


def test_gnomons_own_methods_are_grey_until_they_are_coloured(visit: Callable[..., Visit], report: Path) -> None:
    """In the drawings and in the table; the switch says what a press will do, and is remembered."""
    here = visit()
    page = here.open(report)
    switch, first = page.locator("#own"), page.locator("#own").inner_text()
    strokes, colours = page.evaluate(OWN_INK)
    switch.click()
    second = switch.inner_text()
    assert second != first
    after = page.evaluate(OWN_INK)
    assert set(strokes) != set(after[0])
    assert set(colours) != set(after[1])
    page.reload()
    wait_until_ready(page)
    assert (switch.inner_text(), switch.get_attribute("aria-pressed")) == (second, "true")
    assert page.evaluate(OWN_INK) == after
    switch.click()
    assert page.evaluate(OWN_INK) == [strokes, colours]
    assert switch.inner_text() == first
    assert here.complaints == []


def test_the_switches_work_where_the_browser_stores_nothing(visit: Callable[..., Visit], report: Path) -> None:
    here = visit()
    forbidden = "Object.defineProperty(window, 'localStorage', { get() { throw new DOMException('no storage') } })"
    here.page.add_init_script(forbidden)
    page = here.open(report)
    page.locator("#axis").click()
    assert page.evaluate(AXES)[0] == 0
    assert here.complaints == []


FOCUSED = "document.activeElement.id || document.activeElement.dataset.role || document.activeElement.tagName"


def test_every_control_is_reached_and_used_by_the_keyboard(visit: Callable[..., Visit], report: Path) -> None:
    page = visit().open(report)
    wanted, seen = {"axis", "own", "pause", "find", "case", "problem", "download", "find-card"}, set()
    for _ in range(400):
        page.keyboard.press("Tab")
        now = page.evaluate(FOCUSED)
        seen.add(now)
        if now == "axis":
            page.keyboard.press("Enter")
            assert page.locator("#axis").get_attribute("aria-pressed") == "true"
        if wanted <= seen:
            break
    assert wanted <= seen
    assert "SUMMARY" in seen, "closed parts can be opened"


TIMES = """Object.fromEntries([...document.querySelectorAll("#work table.times tbody tr:not(.group)")].map((row) => [
  row.querySelector("th").firstChild.textContent,
  [...row.querySelectorAll('td b[data-axis="time"]')].map((cell) => cell.firstChild.textContent)]))"""


def _panel(page: Page) -> tuple[dict[str, list[str]], str, str]:
    """The times of each integrator, the diagram and the words of stability of the chosen problem."""
    return page.evaluate(TIMES), page.evaluate(PLACES), page.locator('[data-role="stability"]').inner_text()


def test_a_hard_variant_changes_the_diagram_and_all_below_it(visit: Callable[..., Visit], report: Path) -> None:
    """The table under the diagram once stayed that of the default variant, and named the wrong method for stiff problems."""
    here = visit()
    page = here.open(report)
    page.locator('[data-role="case"]').select_option(SLOW[0])
    page.wait_for_function("document.querySelector('[data-chart=work]').dataset.state === 'built'")
    before = _panel(page)
    page.locator('[data-role="problem"]').select_option(SLOW[1])
    _built_again(page, before[1])
    after = _panel(page)
    assert set(before[0]) == set(after[0])
    assert len([name for name, times in before[0].items() if times]) > 5
    assert all(set(times).isdisjoint(after[0][name]) for name, times in before[0].items() if times)
    assert before[2]
    assert not after[2], "stability is of the default variant"
    assert not page.locator('[data-role="limit"]').is_visible(), "so is the limit of a trial"
    assert here.complaints == []


@pytest.mark.parametrize("name", synthetic.CASES)
def test_variants_that_were_not_run_are_listed_as_such(visit: Callable[..., Visit], report: Path, name: str) -> None:
    page = visit().open(report)
    page.locator('[data-role="case"]').select_option(name)
    options = page.locator('[data-role="problem"] option')
    disabled = {one.get_attribute("value") for one in options.all() if one.is_disabled()}
    ran = set(synthetic.CASES[name][3])
    assert disabled == {variant.name for variant in case_class(name).variants} - ran
    texts = {one.inner_text() for one in options.all() if one.is_disabled()}
    assert texts.isdisjoint(disabled), "they say that they were not run"


@pytest.mark.parametrize(("problem", "shown"), [("long", [False, True]), ("separatrix", [True, False])])
def test_an_empty_diagram_is_not_shown_but_said(
    visit: Callable[..., Visit], report: Path, problem: str, shown: list[bool]
) -> None:
    here = visit()
    panel = here.open(report).locator("#work")
    panel.locator('[data-role="case"]').select_option("pendulum_simple")
    panel.locator('[data-role="problem"]').select_option(problem)
    assert [panel.locator(part).is_visible() for part in ("figure", '[data-role="nothing"]')] == shown
    assert here.complaints == []


PARSED = """(pieces) => Object.fromEntries(Object.entries(pieces).map(([name, html]) => {
  const part = document.createElement(html.startsWith("<thead") ? "table" : "div");
  part.innerHTML = html;
  return [name, [part.innerHTML, part.querySelector("p")?.textContent]];
}))"""
"""Pieces of HTML as a browser writes them again, and the text of their first paragraph."""
CHOICES = """() => {
  const role = (name) => document.querySelector(`[data-role="${name}"]`);
  const values = (name) => [...role(name).options].map((one) => one.value);
  const found = [];
  for (const error of values("error")) for (const group of values("group")) for (const kind of values("kind")) {
    Object.entries({ error, group, kind }).forEach(([name, value]) => (role(name).value = value));
    role("choices").dispatchEvent(new Event("change"));
    const answer = role("answer");
    const lines = answer.querySelector("pre")?.textContent ?? "";
    found.push([`seconds/${group}/${error}`, kind, role("kinds").innerHTML, answer.querySelector("p").textContent, lines]);
  }
  return found;
}"""


def test_the_table_of_kinds_shows_for_every_choice_what_was_computed(visit: Callable[..., Visit], report: Path) -> None:
    """The script only chooses: tables and sentences are those of Python, for each error, group and kind."""
    here = visit()
    page = here.open(report)
    kinds = carried(report)["kinds"]
    tables, said = unfold(kinds["tables"]), unfold(kinds["said"])
    found = page.evaluate(CHOICES)
    assert {key for key, *_ in found} == set(tables)
    assert len(found) == len(kinds["orders"])
    parsed = page.evaluate(PARSED, {**tables, **said})
    for key, kind, table, answer, lines in found:
        assert table == parsed[key][0]
        order = kinds["orders"][f"{key}/{kind}"]
        expected = parsed[f"{key}/{kind}/{order[0]}"][1] if order else "None of these libraries"
        assert answer.startswith(expected)
        if order and order[0] in ("scipy", "heyoka", "gnomon"):
            assert "gnomon.solve(" in lines
            assert "{setting}" not in lines
    assert here.complaints == []


def test_the_sentence_is_of_the_libraries_that_a_reader_has(visit: Callable[..., Visit], report: Path) -> None:
    page = visit().open(report)
    kinds = carried(report)["kinds"]
    said = unfold(kinds["said"])
    place = "seconds/third/1e-6/" + (page.locator('[data-role="kind"]').input_value())
    first, second = kinds["orders"][place][:2]
    page.locator(".mine summary").click()
    page.locator(f'input[name="mine"][value="{first}"]').uncheck()
    answer = page.locator('[data-role="answer"] p')
    expect(answer).to_have_text(page.evaluate(PARSED, {"": said[f"{place}/{second}"]})[""][1])
    for box in page.locator('input[name="mine"]').all():
        box.uncheck()
    assert "None of these libraries" in answer.inner_text()


def test_searches_find_and_say_where_they_find_nothing(visit: Callable[..., Visit], report: Path) -> None:
    """Of cases by title, name and section; of cards by the name of an integrator, none of which are shown before."""
    page = visit().open(report)
    chapters, find = page.locator("details.chapter:visible"), page.locator('[data-role="find"]')
    find.fill("orbit 7.12")
    expect(chapters).to_have_count(1)
    assert [link.get_attribute("href") for link in chapters.locator("a:visible").all()] == ["#case-kepler_orbit"]
    for words, nothing in (("orbit", False), ("no such case", True), ("", False)):
        find.fill(words)
        assert page.locator('[data-role="found-none"]').is_visible() == nothing
    cards, none = page.locator("article.method:visible"), page.locator('[data-role="card-none"]')
    expect(cards).to_have_count(0)
    texts = {none.inner_text()}
    for words, shown in (("rk45", 1), ("k4", 2), ("no such", 0), ("", 0)):
        page.locator('[data-role="find-card"]').fill(words)
        expect(cards).to_have_count(shown)
        assert none.is_visible() == (shown == 0)
        texts |= {none.inner_text()} if not shown else set()
    assert len(texts) == 2, "nothing typed, and nothing found"


def test_links_show_what_they_lead_to(visit: Callable[..., Visit], report: Path) -> None:
    """A case with its variant in the diagram, a card of stability, a closed part."""
    here = visit()
    page = here.open(report)
    for name in synthetic.CASES:
        page.evaluate(f"location.hash = 'case-{name}'")
        expect(page.locator('[data-role="case"]')).to_have_value(name)
        expect(page.locator('[data-role="permanent"]')).to_have_attribute("href", f"#case-{name}")
    page.evaluate(f"location.hash = 'case-{'/'.join(SLOW)}'")
    expect(page.locator('[data-role="problem"]')).to_have_value(SLOW[1])
    page.evaluate("location.hash = 'card-scipy:RK45'")
    expect(page.locator("article.method:visible h4")).to_have_text(["scipy:RK45"])
    page.evaluate("document.querySelectorAll('details').forEach((part) => (part.open = false))")
    part = page.locator("details[id]").first
    page.evaluate(f"location.hash = '{part.get_attribute('id')}'")
    expect(part).to_have_attribute("open", "")
    assert here.complaints == []


def test_a_chosen_case_changes_no_other_table(visit: Callable[..., Visit], report: Path, tmp_path: Path) -> None:
    """The first table of times on the page was taken for that of the case, so that the costs of stiff systems were lost."""
    other = tmp_path / "index.html"
    table = '<table class="times"><tbody><tr><td>kept</td></tr></tbody></table><section id="cases">'
    other.write_text(report.read_text().replace('<section id="cases">', table))
    page = visit().open(other)
    page.locator('[data-role="case"]').select_option(SLOW[0])
    assert page.locator("#work table.times tbody tr").count() > 5
    expect(page.locator("table.times:not(#work *)").first).to_have_text("kept")


def test_a_phone_shows_what_is_needed_first_and_folds_the_rest(visit: Callable[..., Visit], report: Path) -> None:
    """Every fold says what it holds, and a key opens it; on a wide page the same parts are open."""
    page = visit(390, 844).open(report)
    _all_built(page)
    folds = page.locator("details.panel:visible")
    closed = page.evaluate("document.documentElement.scrollHeight")
    assert folds.count() > 8
    assert page.locator("details.panel[open]:visible").count() == 0
    for fold in folds.all():
        assert len(fold.locator("> summary").inner_text().split()) > 1, "what it holds"
    own = page.locator("#work details.panel:has(tbody.own) > summary")
    expect(page.locator("#work tbody.own tr:visible")).to_have_count(0)
    own.press("Enter")
    assert page.locator("#work tbody.own tr:visible").count() > 2
    page.evaluate(OPENED)
    page.wait_for_function(BUILT)
    assert page.evaluate("document.documentElement.scrollHeight") > 1.7 * closed
    assert visit().open(report).locator("details.panel:not([open]):visible").count() == 0


CLOSED = """[...document.querySelectorAll("details:not(.controls *)")].filter((part) =>
  ![...part.children].slice(1).every((one) => one.hidden || one.checkVisibility({ contentVisibilityAuto: true }))).length"""


def test_print_has_the_figures_and_all_that_is_closed_on_the_screen(visit: Callable[..., Visit], report: Path) -> None:
    page = visit().open(report)
    _all_built(page)
    assert page.evaluate(CLOSED) > 3
    page.emulate_media(media="print")
    page.wait_for_function(f"{CLOSED} === 0")  # it takes a frame or two
    assert page.evaluate(UNDRAWN) == []
    assert page.locator(".lead figure svg:visible, #libraries ~ figure svg:visible").count() >= 2
    assert page.locator("nav:visible, button:visible").count() == 0
    assert len(page.pdf()) > 50_000


MOVES = "[...document.querySelectorAll('.moves')].map((one) => getComputedStyle(one).animationPlayState)"


def test_the_picture_moves_until_a_reader_stops_it_or_prefers_no_motion(
    visit: Callable[..., Visit], report: Path
) -> None:
    page = visit().open(report)
    for state in ("running", "paused", "running"):
        assert set(page.evaluate(MOVES)) == {state}
        page.locator('[data-role="pause"]').click()
    assert set(visit(reduced_motion="reduce").open(report).evaluate(MOVES)) == {"paused"}


def test_the_page_can_be_read_by_all(visit: Callable[..., Visit], report: Path) -> None:
    """By axe-core's rules of WCAG 2, A and AA: contrast, alternative texts, names, scrolling by the keyboard."""
    for scheme, width in (("light", 1400), ("light", 390), ("dark", 1400)):
        page = visit(width, color_scheme=scheme).open(report)
        page.evaluate(OPENED)
        page.evaluate("document.querySelectorAll('.method').forEach((card) => (card.hidden = false))")
        _all_built(page)
        found = Axe().run(page, options={"runOnly": ["wcag2a", "wcag2aa"], "resultTypes": ["violations"]})
        violations = [(one["id"], len(one["nodes"]), one["nodes"][0]["target"]) for one in found["violations"]]
        assert violations == [], (scheme, width)


PAINTED = """["body", "nav", ".note", "thead th", ".lead figure svg text"].map((one) => {
  const style = getComputedStyle(document.querySelector(one));
  return [one.endsWith("text") ? style.fill : style.color, style.backgroundColor];
})"""


def test_who_prefers_the_dark_gets_it(visit: Callable[..., Visit], report: Path) -> None:
    """Letters, paper, and the drawings in the page."""
    found = [visit(color_scheme=scheme).open(report).evaluate(PAINTED) for scheme in ("light", "dark")]
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
