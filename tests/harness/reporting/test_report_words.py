"""The sentences of a report, each counted from rows."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pandas as pd
import pytest
from gnomon.harness.registry.lookup import own
from gnomon.harness.reporting import report_benchmarks
from gnomon.harness.reporting.findings import findings
from gnomon.harness.reporting.report_words import hierarchy_rows, launches_text, machines_text, scatter_text, together
from gnomon.harness.reporting.tables import Cell
from gnomon.harness.results.rankings import comparison


def _launched(**launches: int) -> pd.DataFrame:
    rows = [
        {"case": case, "variant": "", "launch": launch, "status": "ok", "setting": 0.1, "seconds_median": seconds}
        for case, count in launches.items()
        for launch, seconds in zip(range(1, count + 1), (1.0, 2.0, 4.0, 1.0, 1.0), strict=False)
    ]
    return pd.DataFrame(rows).assign(formulation="", library="l", integrator_id="l:one")


def test_how_often_cases_were_launched() -> None:
    assert launches_text(_launched(a=1, b=1)) == "from one launch"
    assert launches_text(_launched(a=3, b=3)) == "medians of 3 launches"
    assert launches_text(_launched(a=3, b=1)) == "medians of 3 launches on 1 of the 2 cases, one launch on the others"
    assert launches_text(_launched(a=3, b=2)) == "medians of 3 launches on 1 of the 2 cases, fewer on the others"


def test_the_scatter_of_launches_is_that_of_all_their_pairs() -> None:
    """1, 2 and 4 s are 2, 4 and 2 times apart; the 90 % quantile of (2, 2, 4) is 3.6."""
    assert "within 2.00 times of each other in half of all pairs, within 3.6 times in 90 %" in scatter_text(
        _launched(a=3, b=1)
    )
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


def _equal() -> pd.DataFrame:
    columns = ["case", "integrator_id", "target", "ratio"]
    rows = [("a", "x:one", 1e-6, 1.0), ("a", "x:two", 1e-6, 1.1), ("a", "y:three", 1e-6, 3.0)]
    rows += [("b", "x:two", 1e-6, 1.0), ("b", "y:three", 1e-6, 6.0), ("b", "y:four", 1e-6, 5.0)]
    table = pd.DataFrame(rows, columns=columns).assign(variant="", formulation="")
    return table.assign(library=table["integrator_id"].str[:1], tied=table["ratio"] < 1.2)


def test_who_wins_and_how_far_behind_the_others_are() -> None:
    wins, behind = findings(_equal(), pd.DataFrame(), (), _matrix(), _trusted())
    assert wins == (
        "At an error of 1e-6, x:two is the fastest or on a par with it on 2 of the 2 cases where any integrator reaches"
        " it, x:one on 1."
    )
    assert behind.endswith("over the cases that it reaches: y 4.0 times on 2.")  # of 3 and 5


def _matrix(*problems: tuple[str, str, str, float]) -> pd.DataFrame:
    table = pd.DataFrame(problems, columns=["case", "variant", "integrator_id", "best"])
    return table.assign(formulation="", verdict="ok").astype({"best": float})


def _trusted(*ratios: tuple[str, str, float]) -> pd.DataFrame:
    table = pd.DataFrame(ratios, columns=["case", "integrator_id", "over_tolerance"])
    return table.assign(variant="", formulation="").astype({"over_tolerance": float})


def test_who_holds_on_hard_variants_and_whose_tolerance_means_what_it_says() -> None:
    """x:one holds on one of its two hard variants, y:three on both; who runs fewer than half is left out."""
    names = [("a", "stiff"), ("a", "long"), ("b", "long"), ("b", "stiff")]
    matrix = _matrix(
        *[(case, variant, "x:one", math.nan if variant == "stiff" else 1e-9) for case, variant in names],
        *[(case, variant, "y:three", 1e-3) for case, variant in names],
        ("a", "long", "z:seldom", 1e-9),
        ("a", "", "x:one", math.nan),
    )
    trusted = _trusted(("a", "x:one", 0.5), ("b", "x:one", 0.9), ("a", "y:three", 30.0), ("b", "y:three", 50.0))
    *_, sturdy, tolerance = findings(_equal(), pd.DataFrame(), (), matrix, trusted)
    assert "the 4 hard variants" in sturdy
    assert sturdy.endswith(": y:three on 4 of 4, x:one on 2 of 4.")
    assert "1 of the 2 adaptive integrators" in tolerance
    assert tolerance.endswith("y:three exceeds it by a median factor of 40.")


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
    said = findings(_equal(), pd.DataFrame(), (), _matrix(), trusted)[-1]
    assert "1 of the 3 adaptive integrators" in said
    assert said.endswith("x:two exceeds it by a median factor of 7.")


def test_the_three_most_reliable_of_those_that_ran_on_half() -> None:
    problems = [("a", str(n)) for n in range(4)]
    right = {"x:all": 4, "x:most": 3, "x:some": 2, "x:none": 0}
    rows = [
        (*problem, name, 1e-9 if k < count else math.nan)
        for name, count in right.items()
        for k, problem in enumerate(problems)
    ]
    rows += [(*problem, "x:half", 1e-9) for problem in problems[:2]]
    said = findings(_equal(), pd.DataFrame(), (), _matrix(*rows), _trusted())[-1]
    assert said.endswith(": x:all on 4 of 4, x:half on 2 of 2, x:most on 3 of 4.")


def test_libraries_are_listed_from_the_fastest_to_the_slowest_for_one_target() -> None:
    equal = _equal()
    slow = equal[equal["library"] == "y"].assign(library="a", integrator_id="a:slow", ratio=9.0)
    tight = equal[equal["integrator_id"] == "x:one"].assign(target=1e-12)
    near = equal[equal["integrator_id"] == "y:three"].assign(target=1e-9, tied=True)
    said = findings(pd.concat([equal, slow, tight, near]), pd.DataFrame(), (), _matrix(), _trusted())
    assert said[1].startswith("At an error of 1e-12, x:one is the fastest or on a par with it on 1 of the 1 cases")
    assert said[2].endswith("over the cases that it reaches: y 4.0 times on 2, a 9.0 times on 2.")


def test_engines_are_compared_at_the_step_of_most_problems_and_policies_by_their_best() -> None:
    policies = _policies(("a", 0.2, 0.1), ("b", 0.4, 0.1), ("b", 0.3, 0.2))
    other = _policies(("a", 0.9, 0.01)).assign(step=0.001)
    said = findings(_equal(), pd.concat([other, policies]), (), _matrix(), _trusted())[-1]
    assert said.startswith("At a step of 0.01 s")
    assert said.endswith(
        "on 2 of 2 problems; configured for the scene, its error is smaller by a median factor of 2.5."
    )


def test_the_effect_of_configuration() -> None:
    policies = _policies(("a", 0.2, 0.1), ("b", 0.05, 0.01), ("c", math.nan, 0.01))
    said = findings(_equal(), policies, (), _matrix(), _trusted())[-1]
    assert said == (
        "At a step of 0.01 s the error of an engine as shipped is above a tenth of the motion on 2 of 3 problems;"
        " configured for the scene, its error is smaller by a median factor of 5.0."
    )
    one = _policies(("a", math.nan, 0.1))
    assert findings(_equal(), one, (), _matrix(), _trusted())[-1].endswith("on 1 of 1 problems.")


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
    said = _said(tmp_path, row)
    assert (said["law"], said["verdict"]) == (law, verdict)
    assert (said["power"], said["periods"]) == (f"{power:.2f} ({low:.2f} to {high:.2f})", "1e5")


def test_a_file_without_intervals_is_read_by_its_standard_errors(tmp_path: Path) -> None:
    row = {"integrator": "one", "case": "a", "setting": "s", "periods": 1e5, "starts": 8, "size": 1e-13}
    row |= {"power": 0.69, "uncertainty": 0.05, "law": "sqrt t", "expected": "sqrt t"}
    said = _said(tmp_path, row)
    assert (said["power"], said["law"]) == ("0.69 (0.59 to 0.79)", "between √t and t")
    assert _said(tmp_path, row | {"uncertainty": 0.15})["law"] == "undecided between √t and t"


def _said(folder: Path, row: dict[str, object]) -> dict[str, str]:
    (folder / "growth.json").write_text(json.dumps({"environment": {}, "rows": [row]}))
    found = report_benchmarks.growth(folder)
    assert found is not None
    (said,) = found["rows"]
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
    found = report_benchmarks.orders(tmp_path)
    assert found is not None
    (words,) = found["rows"]
    assert tuple(words[name] for name in ("order", "arithmetic", "formula", "verdict")) == said
    assert (words["name"], words["declared"], words["points"], words["keeps"]) == ("one", "4", "4", "")


def test_all_that_an_integrator_may_claim_has_its_word() -> None:
    assert {word for method in own().values() for word in method.conserves} == set(report_benchmarks.KEPT)


@pytest.mark.parametrize(
    ("first", "ratio", "null", "note"),
    [
        (1e-3, 3.0, 1e-5, ""),
        (1e-3, 1.19, 1e-5, "no difference is claimed"),
        (1e-3, 0.84, 1e-5, "no difference is claimed"),
        (1e-3, 3.0, 2e-4, "20 % of the time of one is overhead of its call; no difference is claimed"),
        (None, None, 1e-5, "not so accurate: one"),
    ],
)
def test_notes_of_pairs(tmp_path: Path, first: float | None, ratio: float | None, null: float, note: str) -> None:
    row = {"group": "against two", "problem": "a", "level": "1e-06", "first_name": "one", "second_name": "two"}
    row |= {"first": first, "second": 2e-3, "first_null": null, "second_null": 1e-5}  # type: ignore[dict-item]
    row |= {"median": ratio, "low": ratio, "high": ratio}  # type: ignore[dict-item]
    (tmp_path / "benchmarks.json").write_text(json.dumps({"launches": 5, "environment": {}, "rows": [row]}))
    found = report_benchmarks.benchmarks(tmp_path)
    assert found is not None
    (pair,) = found["pairs"]
    assert (pair["level"], pair["note"]) == ("1e-6", note)
    assert pair["ratio"] == ("–" if ratio is None else f"{ratio:.2f}")


@pytest.mark.parametrize(("ratio", "text"), [(0.8349, "0.83"), (9.94, "9.94"), (9.96, "10"), (25.4, "25")])
def test_from_ten_on_a_ratio_has_no_decimals(ratio: float, text: str) -> None:
    """Five launches do not determine more than its integer part."""
    assert report_benchmarks._times(ratio) == text


def test_the_report_says_on_how_many_machines_it_stands() -> None:
    """A pair that could not run was measured nowhere."""
    frame = pd.DataFrame({"status": ["ok", "ok", "unsupported"], "machine": ["a", "a", "b"]})
    assert machines_text(frame) == "one machine"
    assert machines_text(frame.assign(status="ok")).startswith("2 machines: a time is compared only")


def test_a_sentence_that_a_change_of_the_comparison_refutes_is_left_out() -> None:
    """x:two wins most cases; without case b it shares the win with x:one, which has the smaller mean ratio."""
    claim = "At an error of 1e-6, x:two is the fastest"
    same = {("one launch left out", "launch 1"): comparison(_equal())}
    assert findings(_equal(), pd.DataFrame(), (), _matrix(), _trusted(), same)[0].startswith(claim)
    other = same | {("one kind of system left out", "b"): comparison(_equal()[_equal()["case"] == "a"])}
    said = findings(_equal(), pd.DataFrame(), (), _matrix(), _trusted(), other)
    assert not any(claim in sentence for sentence in said)
    assert any("At 1e-6, the time of the best integrator of each other library" in sentence for sentence in said)
    near = comparison(_equal().assign(ratio=1.0))
    said = findings(_equal(), pd.DataFrame(), (), _matrix(), _trusted(), {("another error measure", "end"): near})
    assert not any("each other library" in sentence for sentence in said), "y is as fast as x there"


def test_the_best_third_party_is_named_beside_an_in_house_winner() -> None:
    ours = {"x:one": "gnomon:one", "x:two": "gnomon:two"}
    equal = _equal().assign(integrator_id=lambda rows: rows["integrator_id"].replace(ours))
    equal = equal.assign(library=equal["integrator_id"].str.split(":").str[0])
    first = findings(equal, pd.DataFrame(), (), _matrix(), _trusted())[0]
    assert "gnomon:two is the fastest or on a par with it on 2 of the 2 cases" in first
    assert first.endswith(", the best third-party one y:three on 0.")


def test_the_reliability_that_one_kind_of_system_makes_is_left_out() -> None:
    """x:one solves two of three hard variants, x:two one; without the kind of case a, x:one solves none."""
    rows = [("a", "p", "x:one", 1e-9), ("a", "q", "x:one", 1e-9), ("b", "r", "x:one", math.nan)]
    rows += [("a", "p", "x:two", math.nan), ("a", "q", "x:two", math.nan), ("b", "r", "x:two", 1e-9)]
    matrix = pd.DataFrame(rows, columns=["case", "variant", "integrator_id", "best"])
    matrix = matrix.assign(formulation="", verdict="ok")
    cells = [Cell("–", kind="none")] * 5
    kinds = [{"head": head, "cases": [head], "cells": cells} for head in "ab"]
    alone = findings(_equal(), pd.DataFrame(), kinds[:1], matrix, _trusted())
    assert any("most reliable" in sentence and "x:one on 2 of 3" in sentence for sentence in alone)
    assert not any("most reliable" in s for s in findings(_equal(), pd.DataFrame(), kinds, matrix, _trusted()))
