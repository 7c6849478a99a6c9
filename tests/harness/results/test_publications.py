"""The numbers of all publications: entries are added, times count on one machine, and a wrong file is named."""

import json
from pathlib import Path

import pytest
from gnomon.harness.results import publications
from gnomon.harness.results.publications import Entry


def entry(sources: str, machine: str = "here", **numbers: float) -> Entry:
    environment = {"sources": sources, "machine": machine, "revision": f"revision {sources}", "date": "2026-01-02"}
    return Entry(environment, {name.replace("_of_", "/"): value for name, value in numbers.items()})


def test_a_publication_is_added_and_one_of_the_same_revision_and_machine_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "history.json"
    for one in (entry("a", reached_of_x=3), entry("b", reached_of_x=4), entry("b", "there", reached_of_x=5)):
        publications.append(path, one)
    publications.append(path, entry("b", reached_of_x=6))
    assert [(one.key, one.numbers["reached/x"]) for one in publications.read(path)] == [
        (("a", "here"), 3.0), (("b", "there"), 5.0), (("b", "here"), 6.0),
    ]  # fmt: skip


def test_times_count_on_the_machine_of_the_last_publication_alone_and_errors_on_all() -> None:
    entries = [entry("a", "old", seconds_of_x=1, digits_of_x=7), entry("b", seconds_of_x=2), entry("c", digits_of_x=9)]
    entries.append(entry("d", seconds_of_x=3, digits_of_x=9))
    assert publications.values(entries, "seconds/x") == [None, 2.0, None, 3.0]
    assert publications.values(entries, "digits/x") == [7.0, None, 9.0, 9.0]


def test_names_may_be_patterns_and_an_unknown_one_is_told_with_the_nearest() -> None:
    entries = [entry("a", **{"digits_of_gnomon:RK4 [events]": 1, "digits_of_scipy:RK45": 2})]
    assert publications.choose(entries, ["digits/*[events]"]) == ["digits/gnomon:RK4 [events]"]
    with pytest.raises(ValueError, match=r"'digits/scipy:RK4'.*digits/scipy:RK45"):
        publications.choose(entries, ["digits/scipy:RK4"])


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{}", '{"schema": 2, "entries": []}', '{"schema": 1, "entries": [{}]}', "[" * 100_000,
     json.dumps({"schema": 1, "entries": [{"environment": {}, "numbers": {}}]}),
     json.dumps({"schema": 1, "entries": [{"environment": {"sources": "a", "machine": "b"}, "numbers": {"x": "\x1b"}}]})],
)  # fmt: skip
def test_a_file_that_holds_something_else_is_named_in_one_line(tmp_path: Path, content: str) -> None:
    path = tmp_path / "history.json"
    path.write_text(content)
    with pytest.raises(ValueError, match="no history of gnomon's") as error:
        publications.read(path)
    assert str(path) in str(error.value)
    assert str(error.value).isprintable()


def test_without_a_file_the_way_to_one_is_told(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"history\.json: .*`make publication`.*--from"):
        publications.read(tmp_path / "history.json")
