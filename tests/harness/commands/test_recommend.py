"""`gnomon recommend`: its table, what it refuses and admits; and what it recommends, tried at what it recommends."""

import json
import math
import re
import runpy
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import synthetic
from command_line import gnomon
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.commands.published.recommend import describe, share_text
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.registry import lookup, representatives
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import reading, store
from gnomon.harness.results.advice import needs, recommendations
from gnomon.harness.results.advice.code_lines import argument, choose_system
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.outstanding import outstanding
from gnomon.harness.results.time_ratios import wilson
from gnomon.harness.running import rounds
from gnomon.harness.running.recommending import write_table
from on_cases import solved
from own_motions import error_of

from gnomon import cases

TABLE = recommendations.read()
PUBLISHED = [name for name in LIBRARIES if any(row["library"] == name for row in TABLE.rows)]
"""The libraries of the table: those declared after the last publication are not in it."""
RECOMMENDED = [row for row in TABLE.rows if row["systems"]]
SHARE = {"held": 58, "of": 60, "systems": 31, "share": 0.96, "low": 0.9, "high": 0.99}
PANDAS_ABSENT = "import sys; sys.modules |= dict.fromkeys(('pandas', 'pyarrow', 'jinja2')); sys.argv = {argv}; "
COUNTED = """
import cProfile
with cProfile.Profile(builtins=False) as profile:
    from gnomon.harness.commands.cli import main
    try:
        main()
    except SystemExit as end:
        assert not end.code
print(sum(entry.callcount for entry in profile.getstats()), *sys.modules, file=sys.stderr)
"""
"""The command; then the number of calls of Python functions, and the modules that are loaded."""


def told(capfd: pytest.CaptureFixture[str], *words: str, code: int = 0) -> str:
    assert gnomon("recommend", *words) == code
    out, err = capfd.readouterr()
    return out if code == 0 else err


def test_the_table_answers_every_subject_error_and_library() -> None:
    asked = {(key, error, name) for key in needs.SUBJECTS for error in TARGETS for name in (*PUBLISHED, "gnomon")}
    assert {(row["subject"], row["error"], row["library"]) for row in TABLE.rows} == asked
    assert len(TABLE.rows) == len(asked)


def test_nothing_is_recommended_only_with_a_reason() -> None:
    """Either the manual has no such method, or it was not run, or no system was reached: then with the error that is."""
    for row in TABLE.rows:
        assert bool(row["why"]) == (row["tried"] == 0), row
        assert bool(row["why"]) >= (not row["methods"]), row
        for one in filter(None, (row, row.get("better"))):
            assert (one["systems"] > 0) == ("reliable" in one) == ("setting" in one), one
            assert not (one["systems"] and "best_error" in one), one
            assert one.get("best_error", math.inf) > row["error"], one
    assert RECOMMENDED, "the table recommends nothing at all"


def test_a_share_has_an_interval_that_holds_it() -> None:
    for row in TABLE.rows:
        if row["tried"]:
            assert row["share_low"] <= row["systems"] / row["tried"] <= row["share_high"]
            assert row["share_low"] > 0 or row["systems"] == 0


def test_the_reliable_setting_is_at_most_the_tightest_that_a_problem_needs() -> None:
    """Looser only where that setting does not hold on as many systems: round-off, or a time limit."""
    for row in RECOMMENDED:
        one = row["reliable"]
        assert one["method"] == row["setting"]["method"]
        assert sum(each["of"] for each in (one, *one.get("others", ()))) == row["systems"]
        if one["systems"] == one["of"]:
            assert one.get("value", one.get("relative")) <= row["loosest"] * (1 + 1e-2), row
        assert 0 < one["systems"] <= one["of"]


def test_epsilon_is_called_by_its_name() -> None:
    """A parameter that is not a tolerance must not be read as an error."""
    for row in RECOMMENDED:
        for one in (row["setting"], row["reliable"], *row["reliable"].get("others", ())):
            assert (one.get("name") == "epsilon") == (one["method"] == "rebound:IAS15")


def test_the_advice_for_a_satellite_says_which_spans_and_eccentricities_it_rests_on(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """An orbit with e = .9 over 100 turns is outside of the systems, and a reader can see that."""
    text = told(capfd, "gravitation", "--error", "1e-9", "--library", "scipy")
    (row,) = recommendations.find("gravitation", 1e-9, ["scipy"]).rows
    longest, most = row["rests_on"]["spans"][1], row["rests_on"]["eccentricity"]
    assert f"to {longest:.3g} time scales" in text
    assert f"eccentricities up to {most:.3g}" in text
    assert most < 0.9
    assert longest < 2 * math.pi * 100


@pytest.mark.parametrize(
    ("systems", "tried", "said"),
    [
        (4, 4, "4 of 4 systems; with 95 % confidence on at least 51 % of such systems"),
        (0, 4, "on at most 49 %"),
        (9, 10, "on 60 to 98 %"),
    ],
)
def test_a_share_is_told_with_its_interval(systems: int, tried: int, said: str) -> None:
    low, high = wilson(systems / tried, tried)
    assert said in share_text({"systems": systems, "tried": tried, "share_low": low, "share_high": high})


def test_what_reaches_no_system_is_told_with_the_error_that_it_does_reach() -> None:
    row = {
        **{"why": "", "methods": ["pybullet:step"], "systems": 0, "tried": 4, "share_low": 0.0, "share_high": 0.49},
        "best_error": 0.0021,
    }
    text = "\n".join(describe(row, "PyBullet"))
    assert "nothing is recommended" in text
    assert "pybullet:step" in text
    assert "2.1e-3 on half of them" in text
    assert "no answer" in "\n".join(describe({name: row[name] for name in row if name != "best_error"}, "PyBullet"))


def test_a_table_of_another_form_is_refused_with_the_way_out() -> None:
    """Fields that it lacks have no default: a table of the former form says less than the words of this one."""
    for head in ({}, {"schema": recommendations.SCHEMA - 1}):
        with pytest.raises(ValueError, match=r"recommendations\.jsonl: schema .*: install gnomon again"):
            recommendations.require_schema(head)
    recommendations.require_schema(TABLE.head)


def test_what_is_recommended_for_a_library_is_its_representative() -> None:
    chosen = {(library, one.integrator) for (library, _), one in representatives.representatives().items()}
    assert {(row["library"], name) for row in TABLE.rows for name in row["methods"]} <= chosen


def test_only_engines_have_no_forms_of_equations() -> None:
    for name, forms in TABLE.forms.items():
        assert (not forms) == (lookup.own()[name].accepts == (SceneForm,))
        assert all(choose_system(forms, key) is not None for key in needs.SUBJECTS) == bool(forms)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return Run.read(synthetic.write(tmp_path_factory.mktemp("recommend") / "results.sqlite"))


def test_equal_measurements_give_equal_tables(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = (write_table(run, tmp_path / name).read_bytes() for name in ("one", "two"))
    assert first == second
    head, *rest = map(json.loads, first.splitlines())
    assert head["cpu"] == "Invented CPU"
    assert {row["library"] for row in rest if "subject" in row} == {
        *(name for name, one in LIBRARIES.items() if one.suite is None),
        "gnomon",
    }
    monkeypatch.setattr("gnomon.harness.running.recommending.MOST_BYTES", len(first) - 1)
    with pytest.raises(ValueError, match=r"takes \d+ bytes"):
        write_table(run, tmp_path / "one")
    assert (tmp_path / "one").read_bytes() == first, "a table that is too large replaces nothing"


def test_the_margin_of_the_trial_outside_is_that_of_the_tolerances(run: Run, tmp_path: Path) -> None:
    plain = [json.loads(line) for line in write_table(run, tmp_path / "plain").read_text().splitlines()]
    found = {"margin": 0.01, "systems": 60, "share": SHARE, "order": SHARE}
    (tmp_path / "outside.json").write_text(json.dumps(found))
    text = write_table(run, tmp_path / "wide", tmp_path / "outside.json").read_text()
    wide = [json.loads(line) for line in text.splitlines()]
    assert (plain[0]["margin"], plain[0]["outside"]) == (1.0, None)
    assert (wide[0]["margin"], wide[0]["outside"]) == (0.01, found)
    pairs = [(one, other) for one, other in zip(plain, wide, strict=True) if "reliable" in one]
    tolerances = [(one["reliable"], other["reliable"]) for one, other in pairs if "value" in one["reliable"]]
    assert all(other["value"] <= one["value"] for one, other in tolerances)
    assert any(other["value"] < one["value"] / 10 for one, other in tolerances)
    assert all(one["reliable"] == other["reliable"] for one, other in pairs if "relative" in one["reliable"])
    (tmp_path / "outside.json").write_text(json.dumps({"margin": 0}))
    with pytest.raises(ValueError, match=r"outside\.json: margin=0"):
        write_table(run, tmp_path / "none", tmp_path / "outside.json")


def test_the_share_outside_of_the_catalogue_is_told() -> None:
    assert "not tried" in recommendations.outside_text(None)
    text = recommendations.outside_text({"share": SHARE, "order": SHARE | {"share": 0.8}})
    for words in ("96 % of the trials (90 to 99 %, on 31 systems)", "80 %"):
        assert words in text
    assert "no trial" in recommendations.outside_text({"share": SHARE, "order": None})
    of_stiff = {"by_need": [SHARE | {"need": "stiff", "share": 0.75}]}
    found = {"share": SHARE, "order": SHARE} | of_stiff
    assert "75 %" in recommendations.outside_text(found, "stiff")
    assert "no trial" in recommendations.outside_text(found, "long")


def test_the_head_names_the_last_revision_and_refuses_several_machines_or_sources(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run goes on at another revision of the same sources; other machines or sources give other times."""
    (first,) = store.runs(run.path)

    def then(**made_by: str) -> None:
        later = first | {"suite": "later", "environment": first["environment"] | made_by}
        monkeypatch.setattr("gnomon.harness.running.recommending.store.runs", lambda path: [first, later])

    then(revision="abc123")
    head = json.loads(write_table(run, tmp_path / "table").read_text().splitlines()[0])
    assert (head["revision"], head["suites"]) == ("abc123", ["full", "later"])
    assert head["open"] == rounds.describe_open(reading.rows(run.path))
    assert head["lacks"] == outstanding(run.path).text
    for name in ("machine", "sources"):
        then(**{name: "another"})
        with pytest.raises(ValueError, match=f"several {name} .*another"):
            write_table(run, tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_the_table_that_comes_with_gnomon_is_small() -> None:
    path = Path(recommendations.__file__).with_name(recommendations.NAME)
    assert path.stat().st_size <= recommendations.MOST_BYTES


def test_it_says_whose_measurements_these_are(capfd: pytest.CaptureFixture[str]) -> None:
    text = told(capfd, "accurate")
    for name in ("revision", "date", "cpu", "python", "lacks"):
        assert TABLE.head[name] in text
    assert ", ".join(TABLE.head["suites"]) in text


def test_one_library_has_its_own_share_outside_of_the_catalogue_and_several_have_that_of_all(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """The two differ, and side by side they would contradict each other."""
    outside = TABLE.head["outside"]
    of_all = next(one for one in outside["by_need"] if one["need"] == "long")
    its_own = recommendations.outside_share(outside, "long", "scipy")
    shares = [recommendations.percent_text(share) for share in (its_own, of_all)]
    one, several = told(capfd, "long", "--library", "scipy"), told(capfd, "long")
    assert [share in one for share in shares] == [True, False]
    assert all(share in several for share in shares)


def test_each_library_is_named_once_and_gnomon_last(capfd: pytest.CaptureFixture[str]) -> None:
    text = told(capfd, "accurate", "--error", "1e-6")
    titles = [*(LIBRARIES[name].title for name in PUBLISHED), "gnomon"]
    assert [head for head in re.findall(r"^([^:\n]+): ", text, re.M) if head in titles] == titles


def test_one_library_has_its_lines_with_the_setting(capfd: pytest.CaptureFixture[str]) -> None:
    (row,) = recommendations.find("accurate", 1e-6, ["scipy"]).rows
    text = told(capfd, "accurate", "--error", "1e-6", "--library", "SciPy")
    setting = row["reliable"]
    assert f'"{setting["method"]}", t_eval=times, {argument(setting)})' in text


def test_a_tighter_error_of_the_table_answers_and_never_a_looser_one() -> None:
    assert recommendations.find("smooth", 5e-7).error == 1e-9
    assert recommendations.find("smooth", 1e-6).error == 1e-6
    assert recommendations.find("smooth", 0.1).error == 1e-3


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["stif"], "'stif' (did you mean stiff?)"),
        (["vector calculus"], "no subject is called 'vector calculus'; the subjects are stiff, vibration, long,"),
        (["dry friction", "stiff spring"], "'stiff spring' to vibration and 'dry friction' to events; name one"),
        (["stiff", "--span", "0,1"], "--span belongs to own equations: give --equations mine.py:f too"),
        (["events", "--library", "pybulet"], "'pybulet'; did you mean pybullet"),
        (["events", "--error", "1e-15"], "--error 1e-15: errors were measured down to 1e-12"),
        (["events", "--error", "0"], "--error 0: give a positive number"),
    ],
)
def test_what_it_does_not_know_is_refused_with_the_way_out(
    words: list[str], said: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert said in " ".join(told(capfd, *words, code=2).split())


@pytest.mark.parametrize(
    "phrase",
    [
        "gravitation",
        "Gravitation",
        "bodies under gravitation",
        "satellite",
        "a satellite of Jupiter",
        "planets",
        "N-body",
    ],
)
def test_a_subject_is_found_by_its_names_and_by_words_of_its_systems(phrase: str) -> None:
    assert recommendations.subject(phrase) == "gravitation"


@pytest.mark.parametrize(
    ("phrase", "key"),
    [
        ("stiff chain", "stiff"),
        ("stiff spring", "vibration"),
        ("driven double pendulum", "drag"),
        ("satellite attitude", "rigid"),
    ],
)
def test_of_a_phrase_the_longest_name_counts(phrase: str, key: str) -> None:
    """A word of its own would lead elsewhere: a stiff spring does not decay, an attitude is no orbit."""
    assert recommendations.subject(phrase) == key


def test_words_that_lead_elsewhere_are_named_beside_the_answer(capfd: pytest.CaptureFixture[str]) -> None:
    """A pendulum with dry friction is a question on events too; a satellite's attitude is none on orbits."""
    assert recommendations.further_subjects("satellite attitude") == {}
    assert recommendations.further_subjects("double pendulum with friction") == {"friction": "events"}
    assert "gnomon recommend events" in told(capfd, "double pendulum with friction")


def test_a_word_belongs_to_one_subject_and_names_no_other_one() -> None:
    words = [(word, key) for key, one in needs.SUBJECTS.items() for word in one.words]
    assert len(words) >= 5 * len(needs.SUBJECTS)
    for word, key in words:
        assert recommendations.subject(word) == key, word


def test_several_words_need_no_quotation_marks(capfd: pytest.CaptureFixture[str]) -> None:
    assert told(capfd, "double", "pendulum") == told(capfd, "double pendulum")


def test_it_answers_in_the_base_installation_with_little_work() -> None:
    """It loads no compiler, case or integrator, and calls few functions: a million calls take about a second."""
    code = PANDAS_ABSENT.format(argv=["gnomon", "recommend", "accurate"]) + COUNTED
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "scipy:" in done.stdout
    calls, *loaded = done.stderr.split()
    assert int(calls) < 1_000_000
    assert "gnomon.harness.results.advice.recommendations" in loaded
    others = (
        "numba",
        "flint",
        "scipy.integrate",
        "gnomon.harness.integrators",
        "gnomon.harness.registry.lookup",
        "gnomon.harness.kernels",
    )
    assert not {*others} & {*loaded}


def promises() -> dict[str, tuple[Mapping[str, Any], float]]:
    """What is recommended, each once: a setting on its median problem, with the smallest error that it promises."""
    found: dict[str, tuple[Mapping[str, Any], float]] = {}
    for row in RECOMMENDED:
        for one in filter(None, (row, row.get("better"))):
            setting = one["setting"]
            name = f"{setting['method']} at {setting['value']:g} on {setting['problem']}"
            found[name] = (setting, min(row["error"], found[name][1] if name in found else row["error"]))
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("setting", "error"), promises().values(), ids=promises())
def test_a_recommendation_keeps_its_promise(setting: Mapping[str, Any], error: float) -> None:
    """Its method at its setting, on the median problem, is within the error for which it is recommended."""
    method = lookup.own()[setting["method"]]
    if (why := lookup.missing(method)) is not None:
        pytest.skip(why)
    name, _, variant = setting["problem"].partition("/")
    case = cases.get(name, None if variant == "default" else variant).rounded()
    steps = problem_of(case, method.accepts, None, False).interval / setting["value"]
    assert solved(method, case, tolerance=setting["value"], steps=steps).error <= error


def of_installed(subject: str) -> list[tuple[str, str]]:
    """The libraries that are recommended for a subject and installed here, with the method that the lines run."""
    rows = [row for row in recommendations.find(subject).rows if "reliable" in row]
    named = [(row["library"], row["reliable"]["method"]) for row in rows]
    return [(one, method) for one, method in named if TABLE.forms[method] and not lookup.missing(lookup.own()[method])]


@pytest.mark.parametrize(
    ("subject", "library", "method"),
    [
        pytest.param(key, *one, marks=() if one[0] in ("gnomon", "scipy") else pytest.mark.slow, id=f"{key} {one[1]}")
        for key in needs.SUBJECTS
        for one in of_installed(key)
    ],
)
def test_the_printed_lines_reach_the_error(
    subject: str, library: str, method: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """They run as they stand, on a system of the subject, whose motion is computed apart from them.

    A setting that failed in most trials outside of the catalogue may fail here too: then the answer says how often.
    """
    text = told(capfd, subject, "--library", library)
    (tmp_path / "lines.py").write_text(
        text[re.search(r"^(import|from) ", text, re.M).start() : text.index("\n\nMeasured by")]
    )  # type: ignore[union-attr]
    states = runpy.run_path(str(tmp_path / "lines.py"))["found"].y.T
    system = choose_system(TABLE.forms[method], subject)
    assert system is not None
    outside = recommendations.outside_share(TABLE.head["outside"], subject, library)
    if outside is not None and outside["share"] < 0.5:
        assert f"{100 * outside['share']:.0f} % of the trials" in text
    else:
        assert error_of(system, states) <= needs.SUBJECTS[subject].error


def test_engine_names_all_physics_engines() -> None:
    """One of them would be an answer to another question."""
    found = {row["library"] for row in recommendations.find("events", 1e-3, ["engine"]).rows}
    assert found == {row["library"] for row in TABLE.rows if row["library"] in recommendations.libraries_of("engines")}
    assert {"pybullet", "mujoco", "pydrake"} <= set(recommendations.libraries_of("Engine"))
