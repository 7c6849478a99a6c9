"""A page of all cases is light: few elements, few bytes, drawn within a second, and all that it holds is found."""

import random
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import invented_runs
import pytest
from browser_visits import BROWSER, LIMIT, Visit
from gnomon.cases.core.registry import installed_names
from gnomon.harness.reporting import sidecars
from gnomon.harness.reporting.report import write_report
from gnomon.harness.reporting.report_pack import differences, pack, pack_html
from hypothesis import given
from hypothesis import strategies as st
from page_parts import positions, read_page, unfold, unpack
from playwright.sync_api import expect

MOST_ELEMENTS, MOST_BYTES = 10_000, 1_500_000
PUBLISHED = Path(__file__).parents[4] / "reports"
OTHERS = 500_000
"""Bytes left for what a run of eight methods lacks: in a published run are ten times as many, whose tables take these."""
expect.set_options(timeout=LIMIT)


def in_browser(test: Any) -> Any:
    for mark in BROWSER:
        test = mark(test)
    return test


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page of as many cases as are installed, with the published files of stability, engines, certificates and others."""
    folder = tmp_path_factory.mktemp("large")
    for name in sidecars.NAMES:
        if (PUBLISHED / name).is_file():
            shutil.copy(PUBLISHED / name, folder)
    assert (folder / "stability.json").stat().st_size > 1_000_000, "the largest part"
    return write_report(invented_runs.write(folder / "results.sqlite", len(installed_names()), launches=1), folder)


def elements(html: str) -> int:
    return len(re.findall(r"<[a-zA-Z]", html))


def test_a_page_of_all_cases_has_few_elements_and_bytes(large: Path) -> None:
    """It had 45 000 elements and 3.5 MB. What is not in it as elements is in it as data."""
    assert large.stat().st_size < MOST_BYTES - OTHERS
    assert elements(large.read_text(encoding="utf-8")) < MOST_ELEMENTS / 2, "figures that the script builds are more"
    assert elements(read_page(large)) > 2 * MOST_ELEMENTS, "the parts are in the page"


words = st.text(st.sampled_from("ab 1.9e-µ×#\ue000"), max_size=8)
rows = st.lists(st.tuples(words, words), max_size=4).map(
    lambda of: "".join(f'<tr class="x"><th>{a}</th><td>{b}<small>{a}</small></td></tr>' for a, b in of)
)


@given(st.dictionaries(words, rows, max_size=5))
def test_packed_html_is_had_back(fragments: dict[str, str]) -> None:
    """Also where a text has the character that stands for a number."""
    assert unfold(pack_html(fragments)) == fragments


@given(st.lists(st.none() | st.integers(-2000, 2000)))
def test_differences_are_had_back(values: list[int | None]) -> None:
    assert positions(differences(values)) == values


@given(st.text())
def test_packed_texts_are_had_back_and_have_no_markup(text: str) -> None:
    packed = pack(text)
    assert unpack(packed).decode() == text
    assert not set("<>&") & set(packed)


def test_tables_take_less_than_when_they_are_compressed_alone() -> None:
    """Else the tables of all cases do not fit."""
    draw = random.Random(1)
    cells = ("<td><b>{:.3g} µs</b><small>power {:.2f} ({:.2f} to {:.2f})</small></td>",) * 5
    tables = {
        str(k): "".join(
            "<tr><th>method</th>" + "".join(cell.format(*(draw.random() for _ in range(4))) for cell in cells) + "</tr>"
            for _ in range(30)
        )
        for k in range(10)
    }
    alone, packed = (len(pack(repr(value))) for value in (tables, pack_html(tables)))
    assert packed < 0.9 * alone


@pytest.mark.parametrize("width", [1400, 390])
@in_browser
def test_a_browser_makes_few_elements_until_a_reader_asks(visit: Callable[..., Visit], large: Path, width: int) -> None:
    """Also once it has built the figures; parts are drawn by scrolling, by a search, by a link and by opening."""
    here = visit(width)
    page = here.open(large)
    page.wait_for_function("gnomonCharts.all || gnomonCharts.failed")
    assert page.evaluate("document.getElementsByTagName('*').length") < MOST_ELEMENTS
    page.locator('[data-role="find"]').fill("case 7")
    expect(page.locator("details.chapter tr:visible[data-words]")).to_have_count(_named(large, "case 7"))
    page.evaluate("location.hash = 'card-gnomon:RK4'")
    expect(page.locator("article.method:visible h4")).to_have_text(["gnomon:RK4"])
    group = page.locator("#failures details").first
    assert group.locator("td").count() == 0
    group.locator("summary").click()
    expect(group.locator("td").first).to_be_attached()  # a browser tells of an opened part when it has time
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.locator("[data-part]").count() == 0, "print has all"
    assert here.complaints == []


def _named(page: Path, words: str) -> int:
    rows: Any = re.findall(
        r'data-words="([^"]*)"', read_page(page).partition('id="cases"')[2].partition("</section>")[0]
    )
    return sum(all(word in row for word in words.split()) for row in rows)
