"""Every row of the catalogue is a case or a check: `catalogue_rows.json` is compared with the registry."""

import json
import re
from pathlib import Path

import pytest
from gnomon.cases import case_class, check_class, check_names, names
from gnomon.harness.reporting.publication import catalogue

ROOT = Path(__file__).parents[2]
ROWS = json.loads((Path(__file__).parent / "catalogue_rows.json").read_text())
LISTED = {name for row in ROWS for name in row["names"]}


def test_every_row_is_there():
    registered = {*names(), *check_names()}
    absent = [
        f"row {row['number']} ({row['section']}): {name}"
        for row in ROWS
        for name in row["names"]
        if name not in registered
    ]
    assert not absent, "missing from the catalogue: " + "; ".join(absent)


def test_the_page_of_cases_lists_every_case_with_its_files() -> None:
    """The charts may change: `make publication` adds them."""
    known, written = (
        re.sub(r"`reports/.*?`", "", text) for text in (catalogue.page(), (ROOT / catalogue.PAGE).read_text())
    )
    assert written == known, "write docs/cases.md again: make catalogue"


def test_rows_are_numbered_without_gaps():
    numbers = {int(re.match(r"\d+", row["number"])[0]) for row in ROWS}
    assert numbers == {*range(1, 44), *range(50, 99)}  # 44 to 49 are unused


@pytest.mark.parametrize("name", sorted(LISTED))
def test_a_case_names_the_section_of_its_row(name):
    """At least one section, such as 6.17, is in both."""
    kind = case_class(name) if name in names() else check_class(name)
    for row in ROWS:
        if name in row["names"]:
            assert sections(row["section"]) & sections(kind.section), (row["section"], kind.section)


def sections(text: str) -> set[tuple[int, int]]:
    """Chapter and section of every number in the text, also of numbers within a range such as 5.14-5.17."""
    found = set()
    for first, last in re.findall(r"(\d+\.\d+)[.\d]*(?:-(\d+\.\d+))?", text):
        chapter, low = map(int, first.split("."))
        high = int(last.split(".")[1]) if last else low
        found |= {(chapter, number) for number in range(low, high + 1)}
    return found
