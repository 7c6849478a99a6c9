"""The words of a report about a run that is not complete."""

import json
import re
import shutil
import sqlite3
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import invented_runs
import planted_sidecars
import pytest
from command_line import numbers_in
from gnomon.harness.reporting.page import first_screen
from gnomon.harness.reporting.report import write_report
from gnomon.harness.reporting.report_charts import work_problems
from gnomon.harness.reporting.report_missing import missing
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.reporting.report_words import page_words
from gnomon.harness.results import schema
from gnomon.harness.results.outstanding import outstanding
from invented_runs import NOBODY


def _without(results: Path, condition: str, planned: bool = False) -> int:
    """Remove the measurements of the trials that meet a condition, or also their plan; returns the number of these trials."""
    with sqlite3.connect(results) as db:
        trials = f"SELECT trial_key FROM trials WHERE {condition}"
        ((count,),) = db.execute(f"SELECT count(*) FROM ({trials})")
        for table in ("sampled_states", "settings_changed"):
            db.execute(
                f"DELETE FROM {table} WHERE measurement IN"
                f" (SELECT measurement FROM measurements WHERE trial_key IN ({trials}))"
            )
        db.execute(f"DELETE FROM measurements WHERE trial_key IN ({trials})")
        if planned:
            db.execute(f"DELETE FROM planned WHERE series IN (SELECT series FROM trials WHERE {condition})")
            db.execute(f"DELETE FROM trials WHERE {condition}")
    return int(count)


def test_a_complete_run_has_nothing_missing(synthetic_results: Path) -> None:
    assert missing(outstanding(synthetic_results)) is None


def test_cases_and_libraries_are_named(synthetic_results: Path) -> None:
    lost = _without(synthetic_results, "\"case\" = 'bouncing_ball'")
    scipy = _without(synthetic_results, "\"case\" = 'kepler_orbit' AND library = 'scipy'")
    found = missing(outstanding(synthetic_results)) or {}
    assert found["trials"] == lost + scipy
    assert found["cases"]["names"] == ["bouncing_ball"]
    assert found["partly"]["names"] == ["kepler_orbit"]
    of_ball = 11  # settings of each integrator on a variant
    assert f"scipy ({scipy + of_ball})" in found["libraries"]["names"]
    with sqlite3.connect(synthetic_results) as db:
        assert found["planned"] == db.execute("SELECT count(*) FROM planned").fetchone()[0]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return invented_runs.write(tmp_path_factory.mktemp("missing") / "results.sqlite", CASES, launches=2)


@pytest.fixture(scope="module")
def before(whole: Path) -> Iterator["Page"]:
    with pytest.MonkeyPatch.context() as patch:
        yield Page(whole, patch)


class Page:
    """The first parts of a page as words, the needs, and the points that its diagrams were given."""

    def __init__(self, results: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.diagrams: list[Any] = []
        monkeypatch.setattr(first_screen, "stills", self._keep)
        self.run = Run.read(results)
        self.words = page_words(self.run, [results.parent], work_problems(self.run))
        self.first = self.words["first"]

    def _keep(self, specifications: Sequence[Any]) -> list[str]:
        self.diagrams += specifications
        return ["<svg></svg>"] * len(specifications)

    @property
    def of_all_cases(self) -> Any:
        """All that is said over all cases."""
        profiles = [one for one in self.diagrams if "layer" not in one]
        cards = [{**card, "lines": None} for card in self.words["needs"]]
        said = [self.words["tolerances"], (self.first["profiles"] or {}).get("said")]
        return profiles, self.first["kinds"], self.first["fails"], said, cards, self.words["multiples"]


LOST = ("case_06", "case_11")
CASES = first_screen.FEWEST + len(LOST)


def test_cases_with_outstanding_trials_count_nowhere_and_the_page_says_so(
    whole: Path, before: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A trial that has not run yet is no failure. The page is the same as one of a run that planned the complete cases only."""
    for name in ("partly", "without"):
        shutil.copy(whole, tmp_path / f"{name}.sqlite")
    lost = _without(tmp_path / "partly.sqlite", f"\"case\" = '{LOST[0]}' AND library = 'scipy'")
    lost += _without(tmp_path / "partly.sqlite", f"\"case\" = '{LOST[1]}'")
    _without(tmp_path / "without.sqlite", f'"case" IN {LOST}', planned=True)
    partly, without = (Page(tmp_path / f"{name}.sqlite", monkeypatch) for name in ("partly", "without"))
    assert repr(partly.of_all_cases) == repr(without.of_all_cases) != repr(before.of_all_cases)
    assert partly.first["profiles"] is not None
    assert (before.first["complete"], partly.first["complete"]) == (CASES, CASES - 2)
    assert {name for row in partly.first["fails"]["rows"] for name in row["cases"]}.isdisjoint(LOST)
    assert partly.words["missing"]["trials"] == lost
    page = write_report(tmp_path / "partly.sqlite", tmp_path / "page").read_text(encoding="utf-8")
    warning = page[page.index('<details class="warning"') : page.index('<section id="overview">')]
    assert {str(lost), str(CASES - 2)} <= set(numbers_in(warning.replace("\N{NO-BREAK SPACE}", "")))
    assert LOST[1] in warning.replace("<wbr>", "")


def test_of_a_case_that_is_under_way_no_fastest_is_named_and_it_says_what_did_not_run(
    whole: Path, before: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The fastest of the others may lose its place, and what has not run has not failed to reach an error."""
    path = shutil.copy(whole, tmp_path / "results.sqlite")
    lost = _without(path, "\"case\" = 'case_06' AND library = 'scipy'")
    found = Page(path, monkeypatch)

    def cells(page: Page, case: str) -> list[str]:
        (row,) = (row for row in page.words["fastest"] if row.head == case)
        return [cell.text for cell in row.cells]

    assert len({*cells(before, "case_06")}) > 1
    (said,) = {*cells(found, "case_06")}
    assert said not in {text for row in before.words["fastest"] for text in cells(before, row.head)}
    (about,) = (case["lacking"]["default"] for case in found.words["cases"] if case["name"] == "case_06")
    assert numbers_in(about) == [str(lost)]
    assert not any(case["lacking"] for case in before.words["cases"])


def test_complete_cases_keep_their_tables_and_ranks(
    whole: Path, before: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is said of a case depends on no other case, but for the scatter of launches and the false discovery rate."""
    path = shutil.copy(whole, tmp_path / "results.sqlite")
    _without(path, "\"case\" = 'case_06' AND library = 'scipy'")
    found = Page(path, monkeypatch)
    assert set(found.words["times"]) == set(before.words["times"])

    def without_intervals(name: str, page: Page) -> dict[str, str]:
        return {
            variant: re.sub(r" \([^)]*\)( equal| open)?", "", text)
            for variant, text in page.words["times"][name].items()
        }

    names = before.words["times"]
    same = [name for name in names if without_intervals(name, found) == without_intervals(name, before)]
    assert len(same) >= CASES - 4
    assert "case_06" not in same


def test_a_run_without_a_complete_case_has_no_profile_and_shows_a_case_that_is_under_way(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = shutil.copy(whole, tmp_path / "results.sqlite")
    monkeypatch.setattr(first_screen, "LEAD", NOBODY)
    before_said = Page(path, monkeypatch).first["lead"]["said"]["time"]
    _without(path, "library = 'scipy'")
    found = Page(path, monkeypatch)
    assert (found.first["complete"], found.first["profiles"], found.first["kinds"], found.first["fails"]) == (
        0,
        None,
        None,
        None,
    )
    assert found.words["needs"] == []
    assert "not reach" in before_said, "the run has one that does not reach it"
    assert "not reach" not in found.first["lead"]["said"]["time"]


def test_a_run_that_did_not_end_lacks_later_launches(synthetic_results: Path) -> None:
    with sqlite3.connect(synthetic_results) as db:
        db.execute("UPDATE runs SET ended = NULL")
        schema.seal_all(schema.with_checksums(db), "runs")
    assert (missing(outstanding(synthetic_results)) or {})["trials"] == 0


def test_a_tolerance_to_rely_on_has_the_margin_of_the_trial_outside_of_the_catalogue(
    whole: Path, before: Page, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The share on the first screen is of settings with this margin: the cards must show the same ones."""
    shutil.copy(whole, tmp_path / "run.sqlite")
    (tmp_path / "outside.json").write_text(json.dumps(planted_sidecars.files()["outside.json"]))
    after = Page(tmp_path / "run.sqlite", monkeypatch)
    loose, tight = (_reliable_tolerances(page.words["needs"]) for page in (before, after))
    assert loose
    assert loose.keys() == tight.keys()
    assert all(tight[place] <= loose[place] for place in loose)
    assert any(tight[place] == pytest.approx(0.1 * loose[place]) for place in loose)


def _reliable_tolerances(cards: Sequence[Any]) -> dict[tuple[str, str], float]:
    """The recommended tolerance of each card and library."""
    found = {}
    for card in cards:
        for one in card["answers"]:
            if match := re.search(r"recommended: tolerance (\S+?)[ ,;)]", f"{one['on']};"):
                found[card["key"], one["library"]] = float(match[1])
    return found
