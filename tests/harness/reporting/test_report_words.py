"""The sentences of a report, each counted from rows."""

import json
import math
import statistics
from pathlib import Path

import pandas as pd
import pytest
from gnomon.harness.registry.lookup import own
from gnomon.harness.reporting import report_benchmarks
from gnomon.harness.reporting.findings import findings
from gnomon.harness.reporting.report_words import (
    hierarchy_rows,
    launches_text,
    machines_text,
    scatter_text,
    spans_text,
    together,
)  # fmt: skip
from gnomon.harness.results.rankings import ranked
from launches import timed
from said import integrators_in, numbers_in


def _launched(**launches: int) -> pd.DataFrame:
    rows = [
        {"case": case, "variant": "", "launch": launch, "status": "ok", "setting": 0.1, "seconds_median": seconds}
        for case, count in launches.items()
        for launch, seconds in zip(range(1, count + 1), (1.0, 2.0, 4.0, 1.0, 1.0), strict=False)
    ]
    return pd.DataFrame(rows).assign(formulation="", library="l", integrator_id="l:one")


def test_how_often_cases_were_launched() -> None:
    """Once; three times; three times on one of two cases, and once or twice on the other."""
    texts = [launches_text(_launched(a=a, b=b)) for a, b in ((1, 1), (3, 3), (3, 1), (3, 2))]
    assert [numbers_in(text) for text in texts] == [[], ["3"], ["3", "1", "2"], ["3", "1", "2"]]
    assert len(set(texts)) == 4


def test_the_span_of_timing_and_its_limit_are_said() -> None:
    rows = [
        {"case": case, "variant": "", "span": span, "limit_seconds": 1.0} for case, span in (("a", 2.0), ("b", 3.0))
    ]
    default = pd.DataFrame(rows)
    found = spans_text(default.assign(span=[32.0, 3.0]), default)
    assert {case: numbers_in(text) for case, text in found.items()} == {"a": ["16", "64", "1"], "b": ["1"]}


def test_the_scatter_of_launches_is_that_of_all_their_pairs() -> None:
    """1, 2 and 4 s are 2, 4 and 2 times apart; the 90 % quantile of (2, 2, 4) is 3.6."""
    assert numbers_in(scatter_text(_launched(a=3, b=1))) == ["2.00", "3.6", "90"]
    assert scatter_text(_launched(a=1)) == ""


def test_environments_of_several_runs_are_joined() -> None:
    first = {"cpu": "one", "revision": "a", "numpy": None}
    second = {"cpu": "one", "revision": "b", "numpy": None, "heyoka": "7"}
    assert together([first, second]) == {"cpu": "one", "revision": "a, b", "numpy": "", "heyoka": "7"}


def test_levels_of_a_hierarchy_in_words() -> None:
    level = {"error": 0.2, "early": 9e-4, "ratio": math.nan, "seconds": 2e-5, "third_seconds": math.nan}
    (row,) = hierarchy_rows(pd.DataFrame([level]))
    assert (row["error"], row["early"], row["cost"], row["seconds"]) == ("0.2", "9.0e-4", "–", "20.0 µs")
    (full,) = hierarchy_rows(pd.DataFrame([level | {"error": 0.0, "early": 0.0, "ratio": 1.254}]))
    assert (full["error"], full["early"], full["cost"]) == ("0", "0", "1.25")


def _equal(**launches: int) -> pd.DataFrame:
    """x:one and x:two tie on a, x:two is separated from all others on b; y:three is there on both, y:four on b."""
    rows = [("a", "x:one", 1.0), ("a", "x:two", 1.1), ("a", "y:three", 3.0)]
    rows += [("b", "x:two", 1.0), ("b", "y:three", 6.0), ("b", "y:four", 5.0)]
    named = [{"case": case, "integrator_id": name, "seconds": x, "library": name[:1]} for case, name, x in rows]
    return timed([row | {"target": 1e-6} for row in named], **launches)


def test_who_is_separated_from_all_others_and_how_far_behind_the_others_are() -> None:
    """Of two cases x:two is separated on one, and one is a tie; y is slower on both, by factors of 3 and 5."""
    wins, behind = findings(_equal(), pd.DataFrame(), (), _reduced(), _trusted())
    assert (numbers_in(wins), integrators_in(wins)) == (["1e-6", "2", "1", "1", "1"], ["x:two"])
    assert numbers_in(behind) == ["1e-6", "2", "2", "4.0"]


def test_no_sentence_ranks_what_one_launch_timed_or_a_span_that_is_too_short() -> None:
    """No sentence ranks an integrator that has a case for itself. Each has the number of cases and the reason."""
    frames = [_equal(launches=1), ranked(_equal().assign(null_share=0.2)), ranked(_equal().drop_duplicates("case"))]
    texts = [text for frame in frames for text in findings(frame, pd.DataFrame(), (), _reduced(), _trusted())]
    assert [numbers_in(text) for text in texts] == [["1e-6", "2", "2"]] * 3
    assert len(set(texts)) == 3
    assert not any(map(integrators_in, texts))


def _reduced(*problems: tuple[str, str, str, float]) -> pd.DataFrame:
    table = pd.DataFrame(problems, columns=["case", "variant", "integrator_id", "error_max"])
    table = table.assign(formulation="", status="ok", setting=0.1, conditioning=1e-15).astype({"error_max": float})
    return table.assign(status=table["status"].where(table["error_max"].notna(), "timeout"))


def _trusted(*ratios: tuple[str, str, float]) -> pd.DataFrame:
    table = pd.DataFrame(ratios, columns=["case", "integrator_id", "over_tolerance"])
    return table.assign(variant="", formulation="").astype({"over_tolerance": float})


def test_who_solves_more_hard_variants_and_whose_tolerance_means_what_it_says() -> None:
    """x:one solves half of sixteen hard variants, y:three all; an integrator that ran fewer than half is left out."""
    names = [(case, kind) for kind in ("stiff", "long") for case in "abcdefgh"]
    rows = [(*problem, "x:one", math.nan if problem[1].startswith("stiff") else 1e-9) for problem in names]
    rows += [(*problem, "y:three", 1e-8) for problem in names]
    reduced = _reduced(*rows, ("a", "long", "z:seldom", 1e-9), ("a", "", "x:one", math.nan))
    trusted = _trusted(("a", "x:one", 0.5), ("b", "x:one", 0.9), ("a", "y:three", 30.0), ("b", "y:three", 50.0))
    *_, sturdy, tolerance = findings(_equal(), pd.DataFrame(), (), reduced, trusted)
    limits, integrators, variants = ["1e-6", "1000"], ["2"], ["16", "8"]
    assert numbers_in(sturdy) == [*limits, *integrators, *variants, "16", "16", "8", "16"]
    assert integrators_in(sturdy) == ["y:three", "y:three", "x:one"]
    assert (numbers_in(tolerance), integrators_in(tolerance)) == (["1", "2", "40"], ["y:three"])


def test_who_is_not_separated_on_hard_variants_is_not_more_reliable() -> None:
    """Three of four differ from all of four by one variant; a variant that a rule left out is not a failure."""
    problems = [(case, "hard") for case in "abcde"]
    right = {"x:all": 5, "x:most": 4, "x:some": 3, "x:none": 0}
    rows = [
        (*problem, name, 1e-9 if k < count else math.nan)
        for name, count in right.items()
        for k, problem in enumerate(problems)
    ]
    rows += [(*problem, "x:half", 1e-9) for problem in problems[:3]]
    said = findings(_equal(), pd.DataFrame(), (), _reduced(*rows), _trusted())[-1]
    assert integrators_in(said) == ["x:all", "x:half", "x:most"] * 2
    assert numbers_in(said)[-7:] == ["2", *("5", "5"), *("3", "3"), *("4", "5")], "two more are not separated"
    one_case = [("a", case, *rest) for case, _, *rest in rows]
    assert not any("x:half" in one for one in findings(_equal(), pd.DataFrame(), (), _reduced(*one_case), _trusted()))


def _policies(*errors: tuple[str, float, float]) -> pd.DataFrame:
    rows = [
        {"engine": "e", "problem": problem, "policy": policy, "step": 0.01, "error": error}
        for problem, shipped, configured in errors
        for policy, error in (("as shipped", shipped), ("configured", configured))
    ]
    return pd.DataFrame(rows)


def test_an_integrator_that_accepts_few_of_the_cases_is_not_among_those_that_exceed_their_tolerance() -> None:
    """Fewer than half: the error of x:few exceeds its tolerance by more than the others, but on one case of three."""
    trusted = _trusted(*[(case, name, off) for case in "abc" for name, off in (("x:one", 2.0), ("x:two", 7.0))])
    trusted = pd.concat([trusted, _trusted(("a", "x:few", 99.0), ("a", "x:even", 0.1), ("b", "x:even", 0.1))])
    said = findings(_equal(), pd.DataFrame(), (), _reduced(), trusted)[-1]
    assert (numbers_in(said), integrators_in(said)) == (["1", "3", "7"], ["x:two"])


def test_libraries_are_listed_by_the_factor_by_which_they_are_slower() -> None:
    rows = [("a", "x:one", 1.0), ("a", "y:two", 7.0), ("a", "a:slow", 9.0), ("b", "x:one", 1.0), ("b", "y:two", 1.05)]
    named = [{"case": case, "integrator_id": name, "seconds": x, "library": name[:1]} for case, name, x in rows]
    said = findings(timed([row | {"target": 1e-6} for row in named]), pd.DataFrame(), (), _reduced(), _trusted())[1]
    assert numbers_in(said) == ["1e-6", *("1", "2", "7.0"), *("1", "1", "9.0")], "y, then a"


def test_engines_are_compared_at_the_step_of_most_problems_and_policies_by_their_best() -> None:
    policies = _policies(("a", 0.2, 0.1), ("b", 0.4, 0.1), ("b", 0.3, 0.2))
    other = _policies(("a", 0.9, 0.01)).assign(step=0.001)
    said = findings(_equal(), pd.concat([other, policies]), (), _reduced(), _trusted())[-1]
    assert numbers_in(said) == ["0.01", "2", "2", "2.5"]


def test_the_effect_of_configuration() -> None:
    policies = _policies(("a", 0.2, 0.1), ("b", 0.05, 0.01), ("c", math.nan, 0.01))
    said = findings(_equal(), policies, (), _reduced(), _trusted())[-1]
    assert numbers_in(said) == ["0.01", "2", "3", "5.0"]
    one = findings(_equal(), _policies(("a", math.nan, 0.1)), (), _reduced(), _trusted())[-1]
    assert numbers_in(one) == ["0.01", "1", "1"], "nothing is divided by an error that is not a number"


@pytest.mark.parametrize(
    ("low", "high", "expected", "law", "verdict"),
    [
        (0.41, 0.59, "sqrt t", "√t", ""),
        (1.01, 1.03, "sqrt t", "t", "differs"),
        (0.48, 0.98, "sqrt t", "undecided between √t and t", ""),
        (0.695, 0.810, "sqrt t", "between √t and t", "differs"),
        (1.38, 1.52, "t", "t√t", "differs"),
    ],
)
def test_a_law_is_named_only_where_the_interval_excludes_the_others(
    tmp_path: Path, low: float, high: float, expected: str, law: str, verdict: str
) -> None:
    """The fourth: .757 (.695 to .810) was called √t, as every power from .25 to .75 was."""
    power = (low + high) / 2
    row = {"integrator": "one", "case": "a", "setting": "s", "periods": 1e5, "starts": 24, "size": 1e-13}
    row |= {"power": power, "uncertainty": 0.04, "low": low, "high": high, "law": "sqrt t", "expected": expected}
    said = _read_growth(tmp_path, row)
    assert (said["law"], said["verdict"]) == (law, verdict)
    assert (said["power"], said["periods"]) == (f"{power:.2f} ({low:.2f} to {high:.2f})", "1e5")


def test_a_file_without_intervals_is_read_by_its_standard_errors(tmp_path: Path) -> None:
    row = {"integrator": "one", "case": "a", "setting": "s", "periods": 1e5, "starts": 8, "size": 1e-13}
    row |= {"power": 0.69, "uncertainty": 0.05, "law": "sqrt t", "expected": "sqrt t"}
    said = _read_growth(tmp_path, row)
    assert (said["power"], said["law"]) == ("0.69 (0.59 to 0.79)", "between √t and t")
    assert _read_growth(tmp_path, row | {"uncertainty": 0.15})["law"] == "undecided between √t and t"


def _read_growth(folder: Path, row: dict[str, object]) -> dict[str, str]:
    (folder / "growth.json").write_text(json.dumps({"environment": {}, "rows": [row]}))
    (said,) = (report_benchmarks.growth(folder) or {})["rows"]
    return dict(said)


@pytest.mark.parametrize(
    ("order", "digits", "fixed", "said"),
    [
        (3.96, 16, False, ("3.96", "binary64", "as it runs", "")),
        (4.099, 60, True, ("4.10", "60 digits", "its formula at fixed steps", "")),
        (4.101, 60, True, ("4.10", "60 digits", "its formula at fixed steps", "off by 0.10")),
        (3.5, 16, False, ("3.50", "binary64", "as it runs", "off by 0.50")),
    ],
)
def test_measured_orders_beside_the_declared_ones(
    tmp_path: Path, order: float, digits: int, fixed: bool, said: tuple[str, ...]
) -> None:
    row = {"integrator": "one", "case": "a", "span": 1.0, "points": 4, "declared": 4, "keeps": []}
    row |= {"order": order, "digits": digits, "at_fixed_steps": fixed}
    assert report_benchmarks.orders(tmp_path) is None
    (tmp_path / "orders.json").write_text(json.dumps({"environment": {}, "rows": [row]}))
    (words,) = (report_benchmarks.orders(tmp_path) or {})["rows"]
    assert tuple(words[name] for name in ("order", "arithmetic", "formula", "verdict")) == said
    assert (words["name"], words["declared"], words["points"], words["keeps"]) == ("one", "4", "4", "")


def test_all_that_an_integrator_may_claim_has_its_word() -> None:
    assert {word for method in own().values() for word in method.conserves} == set(report_benchmarks.KEPT)


SAME, APART = [1.3, 0.9, 1.1, 0.8, 1.2], [3.1, 2.9, 3.0, 3.0, 3.2]


@pytest.mark.parametrize(
    ("first", "ratios", "null", "note"),
    [
        (1e-3, APART, 1e-5, ""),
        (1e-3, [1 / ratio for ratio in APART], 1e-5, ""),
        (1e-3, SAME, 1e-5, "not separated"),
        (1e-3, [], 1e-5, "not separated"),
        (1e-3, APART, 2e-4, "20 % of the time of one is overhead of its call; not separated"),
        (None, None, 1e-5, "not so accurate: one"),
    ],
)
def test_notes_of_pairs(
    tmp_path: Path, first: float | None, ratios: list[float] | None, null: float, note: str
) -> None:
    """A file of an earlier revision has no ratios by launch."""
    ratio = None if ratios is None else statistics.median(ratios or [3.0])
    row = {"group": "against two", "problem": "a", "level": "1e-06", "first_name": "one", "second_name": "two"}
    row |= {"first": first, "second": 2e-3, "first_null": null, "second_null": 1e-5}  # type: ignore[dict-item]
    row |= {"median": ratio, "low": ratio, "high": ratio} | ({"ratios": ratios} if ratios else {})  # type: ignore[dict-item]
    (tmp_path / "benchmarks.json").write_text(json.dumps({"launches": 5, "environment": {}, "rows": [row]}))
    (pair,) = (report_benchmarks.benchmarks(tmp_path) or {})["pairs"]
    assert (pair["level"], pair["note"]) == ("1e-6", note)
    assert pair["ratio"] == ("–" if ratio is None else f"{ratio:.2f}")


@pytest.mark.parametrize(("ratio", "text"), [(0.8349, "0.83"), (9.94, "9.94"), (9.96, "10"), (25.4, "25")])
def test_from_ten_on_a_ratio_has_no_decimals(ratio: float, text: str) -> None:
    """Five launches do not determine more than its integer part."""
    assert report_benchmarks._times(ratio) == text


def test_the_report_says_on_how_many_machines_it_stands() -> None:
    """A pair that could not run was measured nowhere."""
    frame = pd.DataFrame({"status": ["ok", "ok", "unsupported"], "machine": ["a", "a", "b"]})
    assert numbers_in(machines_text(frame)) == []
    assert numbers_in(machines_text(frame.assign(status="ok"))) == ["2"]
