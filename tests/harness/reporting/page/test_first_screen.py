"""The first screen: what other divisions must not change, and what is said of small and unusual runs."""

import itertools
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import invented_runs
import pytest
import synthetic
from command_line import numbers_in
from gnomon.harness.reporting.page import first_screen
from gnomon.harness.reporting.page.case_tables import WAYS
from gnomon.harness.reporting.page.multiples import _energies
from gnomon.harness.reporting.page.representing import NAMED, Representatives
from gnomon.harness.reporting.report import write_report
from gnomon.harness.reporting.report_charts import work_problems
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.reporting.report_words import page_words
from gnomon.harness.results.contenders import OWN, THIRD, YOURS
from page_parts import read_page

METHODS = invented_runs.METHODS
OTHERS = ("gnomon", "mine")


def _words(folder: Path, methods: Any = METHODS, count: int = 13) -> tuple[Run, dict[str, Any]]:
    run = Run.read(invented_runs.write(folder / "results.sqlite", count, methods, launches=2))
    return run, page_words(run, [folder], work_problems(run))


@pytest.fixture(scope="module")
def without_drawing() -> Any:
    """Drawing a figure takes a tenth of a second, and changes no word."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(first_screen, "stills", lambda specifications: ["<svg></svg>"] * len(specifications))
        yield


@pytest.fixture(scope="module")
def whole(without_drawing: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[Run, dict[str, Any]]:
    return _words(tmp_path_factory.mktemp("whole"))


def _third(words: dict[str, Any]) -> Any:
    """What the page says of third-party libraries."""
    fails = [
        (
            row["kind"],
            [(cell["stand"].name, cell["counts"]) for cell in row["cells"] if cell["stand"].division == THIRD],
        )
        for row in words["first"]["fails"]["rows"]
    ]
    bodies = {
        case: re.findall(r'<tbody class="third">.*?</tbody>', text["default"]) for case, text in words["times"].items()
    }
    kinds = words["first"]["kinds"]["carried"]
    tables = {key: table for key, table in kinds["tables"].items() if "/third/" in key}
    # "mine" has a column of its own, and with it no other can be the only one
    third = {key: re.findall(r'data-label="(?!stepper)[^>]*>.*?</td>', str(table)) for key, table in tables.items()}
    said = {key: text for key, text in kinds["said"].items() if "/third/" in key and not key.endswith("mine:stepper")}
    return third, said, fails, words["fastest"], bodies


def test_the_fastest_of_a_library_stands_beside_the_method_of_its_manual(
    whole: tuple[Run, dict[str, Any]], without_drawing: Any, tmp_path: Path
) -> None:
    """A tenth of the time a right-hand side is a tenth of the time, up to the scatter of invented launches and errors."""
    before = [one["than"] for one in whole[1]["first"]["faster"]]
    assert "scipy:DOP853" not in before, "scipy:RK45 is slower"
    quick = ("scipy", "odeint", "", 8, "tolerance", 3e-9, "")
    run, words = _words(tmp_path, (*METHODS, quick))
    (one,) = (one for one in words["first"]["faster"] if one["than"] not in before)
    assert (one["library"], one["method"], one["than"]) == ("SciPy", "scipy:odeint", "scipy:DOP853")
    assert one["low"] <= one["ratio"] <= one["high"]
    assert one["ratio"] == pytest.approx(0.1, rel=0.5)
    assert 5 <= one["cases"] <= len(run.names)
    page = read_page(write_report(tmp_path / "results.sqlite", tmp_path / "page"))
    assert re.search(r"scipy:odeint</code> takes 0\.\d+ of the time of <code>scipy:DOP853", page)


@pytest.mark.parametrize("left_out", [OTHERS[:1], OTHERS[1:]])
def test_third_parties_stand_as_if_nothing_else_had_run(
    whole: tuple[Run, dict[str, Any]], without_drawing: Any, tmp_path: Path, left_out: Sequence[str]
) -> None:
    """gnomon publishes the page. Its methods, and one that a user adds, change no profile, rank, tie or ratio of others."""
    run, words = _words(tmp_path, [method for method in METHODS if method[0] not in left_out])
    assert _third(words) == _third(whole[1])
    for target, axis in itertools.product(first_screen.TARGETS, first_screen.AXES):
        found, before = (_shares(each, target, axis) for each in (run, whole[0]))
        third = {name for name in before if name not in OTHERS and not name.startswith("mine")}
        assert {name: found[name] for name in third} == {name: before[name] for name in third}, (target, axis)


def _shares(run: Run, target: float, axis: str) -> dict[str, list[float]]:
    found = Representatives(run)
    rows = found.rows(run.equal if axis == "time" else run.counted)
    parts = first_screen._shares(found, rows, target, first_screen.AXES[axis])
    return {one["stand"].name: [*one["share"], *one["low"], *one["high"]] for one in parts}


def test_the_first_sentence_names_its_case_and_the_limit_of_a_trial(whole: tuple[Run, dict[str, Any]]) -> None:
    """ "At an error of 1e-6: ..." was read as if it were of all cases."""
    run, words = whole
    lead = words["first"]["lead"]
    for said in lead["said"].values():
        assert run.titles[lead["case"]].lower() in said.lower()
    limits = {f"{limit:g}" for limit in run.frame["limit_seconds"]}
    assert any(limit in numbers_in(words["limits"]) for limit in limits)


def test_a_library_reaches_an_error_however_long_others_take(
    whole: tuple[Run, dict[str, Any]], without_drawing: Any, tmp_path: Path
) -> None:
    """The sentence below the profiles and the counts of failures have one definition: MuJoCo was on 44 of 109, beside 72."""
    fast = [(*method[:5], method[5] * (1e-5 if method[0] == "heyoka" else 1), method[6]) for method in METHODS]
    _, words = _words(tmp_path, fast)
    for each in (words, whole[1]):
        (row,) = each["first"]["fails"]["rows"]
        for cell in row["cells"]:
            count = dict(cell["counts"]).get("reaches", 0)
            assert f"{cell['stand'].title} on {count} of" in each["first"]["profiles"]["said"]
    assert words["first"]["profiles"]["said"] == whole[1]["first"]["profiles"]["said"]


def test_every_integrator_has_a_line_with_all_that_the_readme_promises(whole: tuple[Run, dict[str, Any]]) -> None:
    """Speed, digits, order, error over tolerance, hard variants, energy: where they were measured."""
    rows = {row["name"]: row for of in whole[1]["multiples"].values() for row in of}
    assert set(rows) == {f"{library}:{name}" for library, name, *_ in METHODS}
    for name, row in rows.items():
        first, *_ = numbers_in(row["speed"])
        assert float(first) > 0, name
        assert row["digits"]
        assert row["over"] or row["order"]
    growth = {"rows": [{"name": "RK4", "law": "t", "periods": "1e4", "case": "pendulum_simple"}]}
    stability = {"rows": [{"integrator": "scipy:RK45", "panel": "long_time", "sentences": ["A.", "Its energy grows."]}]}
    found = _energies({"growth": growth, "stability": stability})
    assert found == {"gnomon:RK4": "t over 1e4 periods of pendulum_simple", "scipy:RK45": "Its energy grows"}


def test_the_page_explains_each_way_that_it_names(tmp_path: Path) -> None:
    """It said of all engines that Python calls them once a step, also of those that take a whole stretch of steps in a call."""
    page, _ = _page(tmp_path, cases=ONE_CASE)
    (explained,) = re.findall(r'<p id="ways">(.*?)</p>', page, re.DOTALL)
    assert set(re.findall(r"<em>(.*?)</em>", explained)) == set(WAYS.values())
    assert "once a step" not in explained


def test_gnomon_sets_no_scale_where_it_is_faster_than_all(tmp_path: Path, without_drawing: Any) -> None:
    """A thousand times faster, its own curve is at the left end wherever it arrives; where no other arrives, it alone is."""
    fast = [(*method[:5], method[5] / (1000 if method[0] == "gnomon" else 1), method[6]) for method in METHODS]
    run = Run.read(invented_runs.write(tmp_path / "results.sqlite", 13, fast, launches=2))
    found = Representatives(run)
    parts = first_screen._shares(found, found.rows(run.equal), 1e-6, "seconds")
    own = next(one for one in parts if one["stand"].division == OWN)
    assert own["share"][0] == own["share"][-1] > 0
    assert max(one["share"][0] for one in parts if one["stand"].division == THIRD) > 0.2


def test_a_users_own_integrator_comes_first_and_is_yours(whole: tuple[Run, dict[str, Any]]) -> None:
    words = whole[1]
    divisions = {one["name"]: one["division"] for one in words["first"]["stands"]}
    assert next(iter(divisions)) == "mine:stepper"
    assert divisions.pop("mine:stepper") == YOURS
    assert divisions.pop("gnomon") == OWN
    assert set(divisions.values()) == {THIRD}
    assert "mine:stepper" in [row["name"] for row in words["multiples"][YOURS]]
    assert not any("mine" in cell.text + cell.note for row in words["fastest"] for cell in row.cells)
    assert all('class="yours"' in text["default"] for text in words["times"].values())


def test_a_library_has_one_line_and_a_picture_no_more_lines_than_there_are_colours() -> None:
    """A best of 54 methods is never set against a best of 2."""
    names = [f"gnomon:{k}" for k in range(54)] + ["scipy:DOP853"]
    found = Representatives.__new__(Representatives)
    assert first_screen.choose_for(found, "c", names[-NAMED:]) == names[-NAMED:]
    colours = first_screen._distinct(["scipy"] * NAMED)
    assert len(set(colours)) == NAMED


def test_a_library_whose_method_is_not_in_the_run_has_not_failed(tmp_path: Path, without_drawing: Any) -> None:
    """A run of chosen integrators lacks the method that stands for a library: no 0 %, and no system that it cannot state."""
    _, words = _words(
        tmp_path, [method for method in METHODS if method[1] not in ("DOP853", "Taylor") or method[0] == "gnomon"]
    )
    (row,) = words["first"]["fails"]["rows"]
    counts = {cell["stand"].name: dict(cell["counts"]) for cell in row["cells"]}
    assert counts["scipy"] == {"unrun": 13}
    assert "unrun" not in counts["rebound"]
    assert "SciPy" not in words["first"]["profiles"]["said"]
    assert "REBOUND" in words["first"]["profiles"]["said"]


ONE_CASE = {"pendulum_simple": (*synthetic.CASES["pendulum_simple"][:3], ("default",))}
HARD = {"pendulum_simple": (*synthetic.CASES["pendulum_simple"][:3], ("separatrix",))}
MINE = [("mine", "stepper", "", 6, "tolerance", 4e-8, "")]
GNOMON = [method for method in synthetic.INTEGRATORS if method[0] == "gnomon"]


def _failed(trial: dict[str, Any], launch: int, found: dict[str, Any]) -> dict[str, Any]:
    return found if found["status"] == "unsupported" else {"status": "crashed", "reason": "planted"}


def _page(folder: Path, **run: Any) -> tuple[str, str]:
    """The page without its data and drawings, as a reader sees it, and the summary."""
    page = write_report(synthetic.write(folder / "results.sqlite", **run), folder)
    text = read_page(page)
    assert text.rstrip().endswith("</html>")
    main = re.sub(
        r"<(svg|style|script).*?</\1>", "", text[text.index("<main") : text.index("</main>")], flags=re.DOTALL
    )
    for forbidden in ("nan<", ">nan", "None<", "inf<"):
        assert forbidden not in text
    return main, (folder / "summary.md").read_text(encoding="utf-8")


def _part(page: str, name: str) -> str:
    return page.partition(f'<section id="{name}">')[2].partition("</section>")[0]


def test_a_run_of_one_case_has_its_diagram_and_plain_numbers(tmp_path: Path) -> None:
    """No profile, and no count of cases: "on 1 of the 1 cases" says nothing. Below it a need has its interval too."""
    page, summary = _page(tmp_path, cases=ONE_CASE)
    overview = _part(page, "overview")
    assert overview.count("<figure>") == 1
    said = re.sub(r"<[^>]+>", "", overview.partition('<p class="said">')[2].partition("</p>")[0])
    assert {"1e-6", "100"} <= set(numbers_in(said)), "the error and its exponent, and the times of IAS15 and of RK4"
    assert len(numbers_in(said)) >= 4
    for absent in ('id="libraries"', 'id="kinds"', 'id="fails"'):
        assert absent not in overview
    assert not re.search(r"\b1 of (the )?1\b|of the 1 |of 1 case", overview + summary)


@pytest.mark.parametrize("methods", [MINE, GNOMON])
def test_a_run_without_third_parties_says_nothing_of_them(tmp_path: Path, methods: Any) -> None:
    """ "None gets there" would be false of libraries that did not run."""
    cases = invented_runs.cases(12) | ONE_CASE
    page, _ = _page(tmp_path, cases=cases, integrators=methods)
    overview = _part(page, "overview")
    assert "<figure>" in overview
    assert 'value="third"' not in overview
    assert 'id="libraries"' not in overview
    assert 'id="fails"' in overview
    name = f"{methods[0][0]}: {methods[0][1]}".replace(": ", ":<wbr>")
    assert name in _part(page, "cases"), "its own times are there"


def test_a_run_without_a_default_variant_says_so_and_lists_its_cases(tmp_path: Path) -> None:
    page, summary = _page(tmp_path, cases=HARD)
    overview, cases = _part(page, "overview"), _part(page, "cases")
    assert "<figure>" not in overview
    assert "default variant" in overview
    assert 'id="case-pendulum_simple"' in cases
    assert "not reached" not in cases + summary, "it was not tried"


def test_a_run_in_which_all_failed_says_of_each_that_it_does_not_get_there(tmp_path: Path) -> None:
    page, _ = _page(tmp_path, change=_failed)
    overview = _part(page, "overview")
    said = overview.partition('<p class="said">')[2].partition("</p>")[0]
    assert said.count("does not reach") == 7
    assert numbers_in(re.sub(r"<[^>]+>", " ", said)) == ["1e-6", "1", "1e-6"], "the error, and the limit"
    assert "planted" in _part(page, "failures")
    assert "f-reaches" not in overview.partition('class="key"')[0]


def test_ties_have_one_place_in_a_profile_whatever_their_times(whole: tuple[Run, dict[str, Any]]) -> None:
    """As a quotient of quotients, the least time of a tie was not always the least time."""
    found = Representatives(whole[0])
    rows = found.rows(whole[0].equal)
    at = rows[(rows["division"] == THIRD) & rows["state"].isin(["fastest", "equal"])]
    assert (at.groupby(["case", "target"]).size() > 1).any()
    for (case, target), part in at.groupby(["case", "target"]):
        assert found.times(rows, target, "seconds").loc[case, list(part["stand"])].nunique() == 1


def test_a_library_that_is_not_installed_is_not_on_the_first_screen(tmp_path: Path) -> None:
    """It has failed nowhere: a line at 0 % would say that it has."""

    def change(trial: dict[str, Any], launch: int, found: dict[str, Any]) -> dict[str, Any] | None:
        if trial["library"] != "heyoka":
            return found
        return {"status": "not_installed", "reason": "planted"} if launch == 1 else None

    run = Run.read(synthetic.write(tmp_path / "results.sqlite", invented_runs.cases(3), METHODS, change))
    assert "heyoka" not in {one.name for one in Representatives(run).stands}
    assert "scipy" in {one.name for one in Representatives(run).stands}
