"""The report's page in a real browser: headless Chromium, driven over its DevTools protocol through a pipe."""

import base64
import fcntl
import itertools
import json
import os
import shutil
import sqlite3
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import axe_core_python
import pytest
import synthetic
from gnomon.cases import case_class
from gnomon.harness.reporting.report import write_report
from gnomon.harness.results import schema

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync", "--remote-debugging-pipe"),
)
DEADLINE = 120
"""Seconds until Chromium is killed, so that a test cannot hang: the broken pipe ends it."""

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium found: install the system's package `chromium`"),
]


class Browser:
    """One headless Chromium with one page. Commands and events are JSON, each ended by a zero byte."""

    def __init__(self, profile: Path) -> None:
        assert CHROMIUM is not None
        to_browser, self._write = os.pipe()
        self._read, from_browser = os.pipe()

        def place() -> None:
            """Chromium reads from descriptor 3 and writes to 4; copies prevent that one overwrites the other."""
            copies = [fcntl.fcntl(descriptor, fcntl.F_DUPFD, 10) for descriptor in (to_browser, from_browser)]
            for copy, wanted in zip(copies, (3, 4), strict=True):
                os.dup2(copy, wanted)

        self._process = subprocess.Popen(
            ["timeout", "-s", "KILL", str(DEADLINE), CHROMIUM, *FLAGS, f"--user-data-dir={profile}", "about:blank"],
            preexec_fn=place,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_browser)
        os.close(from_browser)
        self._numbers = itertools.count(1)
        self._rest = b""
        self.events: list[dict[str, Any]] = []
        targets = self.call("Target.getTargets", session=None)["targetInfos"]
        page = next(target["targetId"] for target in targets if target["type"] == "page")
        self._session = self.call("Target.attachToTarget", session=None, targetId=page, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, session: str | None = "", **parameters: Any) -> dict[str, Any]:
        """Send a command and return its result; events that arrive meanwhile are kept."""
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": parameters}
        if session is not None:
            message["sessionId"] = session or self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == number:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return dict(answer["result"])
            self.events.append(answer)

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            chunk = os.read(self._read, 1 << 20)
            if not chunk:
                raise RuntimeError(f"Chromium ended, or was killed after {DEADLINE} s")
            self._rest += chunk
        message, _, self._rest = self._rest.partition(b"\0")
        return dict(json.loads(message))

    def open(self, page: Path, width: int, height: int) -> None:
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.call("Emulation.setDeviceMetricsOverride", **size)
        self.call("Page.navigate", url=page.resolve().as_uri())
        while not any(event.get("method") == "Page.loadEventFired" for event in self.events):
            self.events.append(self._next())

    def value(self, expression: str) -> Any:
        """The value of a JavaScript expression, awaited where it is a promise."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def picture(self, path: Path, whole: bool = False) -> None:
        found = self.call("Page.captureScreenshot", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(found["data"]))

    def complaints(self) -> list[str]:
        """Errors and warnings of the console, and exceptions."""
        found = []
        for event in self.events:
            method, parameters = event.get("method"), event.get("params", {})
            if method == "Runtime.exceptionThrown":
                found.append(str(parameters["exceptionDetails"].get("exception", parameters["exceptionDetails"])))
            if method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
                found.append(json.dumps(parameters["args"])[:500])
            if method == "Log.entryAdded" and parameters["entry"]["level"] == "error":
                found.append(parameters["entry"]["text"])
        return found

    def requests(self) -> list[str]:
        """Addresses of everything that the page asked for."""
        sent = [e["params"]["request"]["url"] for e in self.events if e.get("method") == "Network.requestWillBeSent"]
        return [url for url in sent if not url.startswith(("data:", "blob:"))]

    def close(self) -> None:
        self._process.terminate()
        self._process.wait()
        os.close(self._write)
        os.close(self._read)


READY = """(async () => {
  while (!gnomonCharts.ready && !gnomonCharts.failed) await new Promise(requestAnimationFrame);
})()"""

SCROLLED = """(async () => {
  document.documentElement.style.scrollBehavior = "auto";
  document.querySelectorAll("details:not([open]) > summary, .map button[aria-expanded=false]").forEach((part) => part.click());
  const frame = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  const waiting = () => [...document.querySelectorAll(".chart")].filter(
    (figure) => !["built", "failed"].includes(figure.dataset.state));
  while (waiting().length) {
    waiting()[0].scrollIntoView();
    await frame();
  }
  return document.querySelectorAll(".chart").length;
})()"""

CHOSEN = """(async () => {
  const choose = (role, index) => {
    const select = document.querySelector(`#panel [data-role="${role}"]`);
    select.selectedIndex = (index + select.options.length) % select.options.length;
    select.dispatchEvent(new Event("change", { bubbles: true }));
  };
  choose("case", 1);
  choose("problem", -1);
  document.querySelector('[data-role="axis"] [value="calls"]').click();
  document.querySelector('[data-role="which"] [value="all"]').click();
  while (gnomonCharts.built + gnomonCharts.failed < WANTED) await new Promise(requestAnimationFrame);
  return document.querySelector('[data-table="times"] th').textContent;
})()"""


FOUND = """(() => {
  const field = document.querySelector('[data-role="find"]');
  field.value = "WORDS";
  field.dispatchEvent(new Event("input", { bubbles: true }));
  return [...document.querySelectorAll("details.chapter:not([hidden])")].map((chapter) => [
    chapter.querySelector("strong").textContent,
    [...chapter.querySelectorAll("tr[data-words] a")].filter((link) => link.getClientRects().length)
      .map((link) => link.hash.slice("#case-".length)),
  ]);
})()"""


SHOWN = """(() => {
  const [of, problem] = ["case", "problem"].map((role) => document.querySelector(`#panel [data-role="${role}"]`));
  [[of, "pendulum_simple"], [problem, "NAME"]].forEach(([select, value]) => {
    select.value = value;
    select.dispatchEvent(new Event("change", { bubbles: true }));
  });
  return ["figure", '[data-role="nothing"]'].map((part) => !document.querySelector(`#panel ${part}`).hidden);
})()"""

SORTED = """(() => {
  const table = document.querySelector(".sortable");
  const column = [...table.querySelectorAll("thead button")].findIndex((one) => one.textContent.startsWith("digits"));
  const numbers = () => [...table.tBodies[0].rows].map((row) => row.cells[column].dataset.value);
  const button = table.querySelectorAll("thead button")[column];
  button.click();
  const up = numbers();
  button.click();
  return [up, numbers()];
})()"""

PAINTED = """["body", ".panel", ".summary b", "thead th"].map((one) => {
  const style = getComputedStyle(document.querySelector(one));
  return [style.color, style.backgroundColor];
})"""


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
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


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[Browser]:
    opened = Browser(tmp_path / "profile")
    yield opened
    opened.close()


@pytest.mark.parametrize(("width", "height"), [(1400, 900), (390, 844)])
def test_page_in_a_browser(browser: Browser, page: Path, tmp_path: Path, width: int, height: int) -> None:
    browser.open(page, width, height)
    browser.value(READY)
    assert browser.complaints() == []
    assert browser.value("document.documentElement.scrollWidth") == width

    shown = browser.value(SCROLLED)
    assert shown == 3, "kinds of system, work-precision and tolerances"
    assert browser.value("gnomonCharts") == {"built": shown, "failed": 0, "ready": True}
    drawn = """[...document.querySelectorAll('.chart[data-state="built"]')].every(
        (figure) => figure.querySelectorAll("svg path, svg line").length > 30)"""
    assert browser.value(drawn)
    cells = """[...document.querySelectorAll("[data-map]")].map((map) => map.querySelectorAll("td").length)"""
    variants = {(name, variant.name) for name in synthetic.CASES for variant in case_class(name).variants}
    problems = variants | {(name, label) for name, (*_, labels) in synthetic.CASES.items() for label in labels}
    assert browser.value(cells) == [3 * 7 + 2, (2 + 3 + len(problems)) * 7], (
        "rows of defaults; of chapters, cases, problems"
    )
    assert browser.value("document.documentElement.scrollWidth") == width

    # Typing finds a case and opens its chapter; nothing typed shows all.
    assert browser.value(FOUND.replace("WORDS", "orbit 7.12")) == [["7 Momentum, work and energy", ["kepler_orbit"]]]
    assert len(browser.value(FOUND.replace("WORDS", ""))) == 2

    # Another case, its last variant, the other axis and all integrators replace the diagram.
    assert browser.value(CHOSEN.replace("WANTED", str(shown + 4))) == "integrator"
    assert browser.value("gnomonCharts.failed") == 0
    browser.picture(tmp_path / f"page_{width}.png")
    assert (tmp_path / f"page_{width}.png").stat().st_size > 20_000

    assert browser.complaints() == []
    assert browser.requests() == [page.resolve().as_uri()]


@pytest.mark.parametrize(("problem", "shown"), [("long", [False, True]), ("separatrix", [True, False])])
def test_an_empty_diagram_is_not_shown_but_said(browser: Browser, page: Path, problem: str, shown: list[bool]) -> None:
    browser.open(page, 1400, 900)
    browser.value(READY)
    assert browser.value(SHOWN.replace("NAME", problem)) == shown
    assert browser.complaints() == []


def test_a_heading_sorts_its_column_both_ways(browser: Browser, page: Path) -> None:
    browser.open(page, 1400, 900)
    browser.value(READY)
    up, down = browser.value(SORTED)
    assert len(set(up)) > 3
    assert up == sorted(up, key=float)
    assert down == up[::-1]


OWN_NAMES = """(() => {
  const shown = (element) => element.checkVisibility();
  const cells = [...document.querySelectorAll("main tbody :is(th, td), main li, main svg text, main .map th")].filter(shown);
  return cells.map((cell) => cell.textContent).filter((text) => text.includes("gnomon:"));
})()"""
RATIOS = """(() => [...document.querySelectorAll("#panel .times td small")].map((note) => note.textContent))()"""


def test_in_house_methods_can_be_hidden_on_the_whole_page_and_stay_hidden(browser: Browser, page: Path) -> None:
    """The times of third parties are then compared with each other: some third party is the fastest of each column."""
    browser.open(page, 1400, 900)
    browser.value(READY)
    browser.value(SCROLLED)
    assert browser.value(OWN_NAMES)
    browser.value("document.getElementById('own').click()")
    browser.value(SCROLLED)
    assert browser.value(OWN_NAMES) == []
    assert any(note.startswith("fastest") for note in browser.value(RATIOS))
    browser.events.clear()
    browser.open(page, 1400, 900)
    browser.value(READY)
    assert browser.value("document.getElementById('own').getAttribute('aria-pressed')") == "true"
    assert browser.value(OWN_NAMES) == []
    browser.value("document.getElementById('own').click()")
    browser.value(SCROLLED)
    assert browser.value(OWN_NAMES)
    assert browser.complaints() == []


FOUND_NONE = """(() => {
  const field = document.querySelector('[data-role="find"]'), text = document.querySelector('[data-role="found-none"]');
  return ["orbit", "no such case"].map((words) => {
    field.value = words;
    field.dispatchEvent(new Event("input"));
    return text.checkVisibility();
  });
})()"""


def test_a_search_that_finds_nothing_says_so(browser: Browser, page: Path) -> None:
    browser.open(page, 1400, 900)
    browser.value(READY)
    assert browser.value(FOUND_NONE) == [False, True]


def test_a_link_to_a_case_shows_its_diagram(browser: Browser, page: Path) -> None:
    browser.open(page, 1400, 900)
    browser.value(READY)
    for name in synthetic.CASES:
        browser.value(f"(location.hash = 'case-{name}', new Promise((done) => setTimeout(done, 50)))")
        assert browser.value("document.querySelector('[data-role=\"case\"]').value") == name
        assert browser.value("document.querySelector('[data-role=\"permanent\"]').hash") == f"#case-{name}"
    assert browser.complaints() == []


AXE = (Path(axe_core_python.__file__).parent / "axe.min.js").read_text(encoding="utf-8")
VIOLATIONS = """axe.run(document, { runOnly: ["wcag2a", "wcag2aa"], resultTypes: ["violations"] }).then(({ violations }) =>
  violations.map((one) => [one.id, one.nodes.length, one.nodes[0].target.join(" ")]))"""


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


def test_a_link_into_a_closed_part_opens_it(browser: Browser, tmp_path: Path) -> None:
    (tmp_path / "stability.json").write_text(json.dumps(STABILITY))
    browser.open(write_report(synthetic.write(tmp_path / "results.sqlite"), tmp_path), 1400, 900)
    browser.value(READY)
    browser.value("(document.querySelectorAll('details').forEach((part) => (part.open = false)), true)")
    part = browser.value("document.querySelector('details[id]').id")
    browser.value(f"(location.hash = '{part}', new Promise((done) => setTimeout(done, 50)))")
    assert browser.value(f"document.getElementById('{part}').open")
    assert browser.complaints() == []


def test_the_page_can_be_read_by_all(browser: Browser, tmp_path: Path) -> None:
    """By axe-core's rules of WCAG 2, A and AA: contrast, alternative texts, names, what scrolls reached by the keyboard."""
    (tmp_path / "stability.json").write_text(json.dumps(STABILITY))
    page = write_report(synthetic.write(tmp_path / "results.sqlite"), tmp_path)
    for scheme, width in (("light", 1400), ("light", 390), ("dark", 1400)):
        browser.events.clear()
        browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        browser.open(page, width, 900)
        browser.value(READY)
        browser.value("(document.querySelectorAll('details').forEach((part) => (part.open = true)), true)")
        browser.value(SCROLLED)
        browser.value(f"{AXE}; true")
        assert browser.value(VIOLATIONS) == [], (scheme, width)


def test_the_switch_works_where_the_browser_stores_nothing(browser: Browser, page: Path) -> None:
    forbidden = "Object.defineProperty(window, 'localStorage', { get() { throw new DOMException('no storage') } })"
    browser.call("Page.addScriptToEvaluateOnNewDocument", source=forbidden)
    browser.open(page, 1400, 900)
    browser.value(READY)
    browser.value("document.getElementById('own').click()")
    assert browser.value(OWN_NAMES) == []
    assert browser.complaints() == []


def test_who_prefers_the_dark_gets_it(browser: Browser, page: Path) -> None:
    found = []
    for scheme in ("light", "dark"):
        browser.events.clear()  # the first load is no sign of the second
        browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        browser.open(page, 1400, 900)
        found.append(browser.value(PAINTED))
    for light, dark in zip(*found, strict=True):
        assert _brightness(light[0]) < 0.5 < _brightness(dark[0]), "letters"
    assert [_brightness(one[1]) > 0.5 for one in found[0][:2]] == [True, True], "paper"
    assert [_brightness(one[1]) > 0.5 for one in found[1][:2]] == [False, False]


def _brightness(colour: str) -> float:
    red, green, blue = (float(part) for part in colour.partition("(")[2].rstrip(")").split(",")[:3])
    return (0.2126 * red + 0.7152 * green + 0.0722 * blue) / 255


def test_the_browser_sees_what_it_must_not(browser: Browser, tmp_path: Path) -> None:
    """A console error, an exception and a request to the network are found; otherwise the test above could not fail."""
    page = tmp_path / "bad.html"
    page.write_text(
        '<link rel="icon" href="data:,"><img src="http://gnomon.invalid/a.png">'
        "<script>console.error('planted'); undefined_function();</script>"
    )
    browser.open(page, 1400, 900)
    complaints = " ".join(browser.complaints())
    assert "planted" in complaints
    assert "undefined_function" in complaints
    assert "http://gnomon.invalid/a.png" in browser.requests()
