"""The sentences of a report, each counted from rows."""

import json
import math
import statistics
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from command_line import numbers_in
from gnomon.harness.registry.lookup import own
from gnomon.harness.reporting import report_benchmarks
from gnomon.harness.reporting.report_words import (
    engines_text,
    hierarchy_rows,
    limits_text,
    machines_text,
    open_text,
    tell_origin,
    together,
    tolerances_text,
)
from gnomon.harness.results.contenders import ALONE, ANSWERED, OWN, THIRD, UNDECIDED
from planted_sidecars import PAIR


def test_the_time_limit_of_a_trial_is_said() -> None:
    rows = pd.DataFrame(
        {
            "case": ["a", "b", "b", "c", "a"],
            "variant": ["", "", "hard", "", ""],
            "limit_seconds": [1.0, 0.08, 9.0, None, 2.0],
        }
    )
    found = limits_text(rows)
    assert {case: numbers_in(text) for case, text in found.items()} == {"a": ["1", "2"], "b": ["0.08"]}


def test_the_page_says_which_code_measured_and_which_wrote_it() -> None:
    """It called the revision of the run that of the page, which later code may have written."""
    measured = [{"gnomon": "1.0", "revision": "aaaa"}, {"gnomon": "1.0", "revision": "bbbb"}]
    first, second = tell_origin(measured, {"gnomon": "1.1", "revision": "cccc"}).split(";")
    assert {"aaaa", "bbbb"} <= set(first.replace(",", " ").split())
    assert "cccc" in second
    assert "cccc" not in first
    assert "no known revision" in tell_origin([{}], {"gnomon": "1.1"})


def test_the_share_of_open_cells_is_counted_by_division() -> None:
    """A cell with one integrator has no pair, and counts in neither number."""
    kinds = {"a": (ANSWERED, THIRD), "b": (UNDECIDED, THIRD), "c": (ALONE, THIRD), "d": (ANSWERED, OWN)}
    rows = [
        {
            "case": case,
            "variant": "",
            "formulation": "",
            "target": 1e-6,
            "cell": cell,
            "division": division,
            "state": state,
        }
        for case, (cell, division) in kinds.items()
        for state in ("fastest", "open", "slower")[: 1 + 2 * (cell != ALONE)]
    ]
    assert numbers_in(open_text(pd.DataFrame(rows))) == ["1", "2", "0", "1", "1", "2"]


def test_environments_of_several_runs_are_joined() -> None:
    first = {"cpu": "one", "revision": "a", "numpy": None}
    second = {"cpu": "one", "revision": "b", "numpy": None, "heyoka": "7"}
    assert together([first, second]) == {"cpu": "one", "revision": "a, b", "numpy": "", "heyoka": "7"}


def test_levels_of_a_hierarchy_in_words() -> None:
    """The shortest time is of a third party; gnomon's own stands behind it where it is shorter."""
    level = {"error": 0.2, "early": 9e-4, "ratio": math.nan, "fastest": "gnomon:a", "seconds": 2e-5}
    level |= {"third": "scipy:b", "third_seconds": 3e-5}
    (row,) = hierarchy_rows(pd.DataFrame([level]))
    assert (row["error"], row["early"], row["cost"]) == ("0.20", "9.0e-4", "–")
    assert row["shortest"] == "scipy:b 30.0 µs; gnomon:a 20.0 µs"
    (row,) = hierarchy_rows(pd.DataFrame([level | {"third": "", "third_seconds": math.nan}]))
    assert row["shortest"] == "gnomon:a 20.0 µs"
    (full,) = hierarchy_rows(pd.DataFrame([level | {"error": 0.0, "early": 0.0, "ratio": 1.254}]))
    assert (full["error"], full["early"], full["cost"]) == ("0", "0", "1.25")


def _trusted(*ratios: tuple[str, str, float]) -> pd.DataFrame:
    table = pd.DataFrame(ratios, columns=["case", "integrator_id", "over_tolerance"])
    return table.assign(variant="", formulation="").astype({"over_tolerance": float})


def test_how_many_keep_their_error_below_the_tolerance() -> None:
    """By the median over cases, of those that accept at least half of the cases; of fewer than two nothing is said."""
    trusted = _trusted(*[(case, name, off) for case in "abc" for name, off in (("x:one", 0.5), ("x:two", 7.0))])
    trusted = pd.concat([trusted, _trusted(("a", "x:few", 0.1), ("a", "x:even", 0.1), ("b", "x:even", 0.1))])
    assert numbers_in(tolerances_text(trusted)) == ["2", "3"]
    hard = trusted.assign(variant="stiff", over_tolerance=0.1)
    assert tolerances_text(pd.concat([trusted, hard])) == tolerances_text(trusted), "default variants alone count"
    assert tolerances_text(trusted[trusted["integrator_id"] == "x:one"]) == ""


def _policies(*errors: tuple[str, float, float]) -> pd.DataFrame:
    rows = [
        {"engine": "e", "problem": problem, "policy": policy, "step": 0.01, "error": error}
        for problem, shipped, configured in errors
        for policy, error in (("as shipped", shipped), ("configured", configured))
    ]
    return pd.DataFrame(rows)


def test_engines_are_compared_at_the_step_of_most_problems_and_policies_by_their_best() -> None:
    policies = _policies(("a", 0.2, 0.1), ("b", 0.4, 0.1), ("b", 0.3, 0.2))
    other = _policies(("a", 0.9, 0.01)).assign(step=0.001)
    assert numbers_in(engines_text(pd.concat([other, policies]))) == ["0.01", "2", "2", "2.5"]


def test_the_effect_of_configuration() -> None:
    policies = _policies(("a", 0.2, 0.1), ("b", 0.05, 0.01), ("c", math.nan, 0.01))
    assert numbers_in(engines_text(policies)) == ["0.01", "2", "3", "5.0"]
    one = engines_text(_policies(("a", math.nan, 0.1)))
    assert numbers_in(one) == ["0.01"], (
        "no count of a single problem; nothing is divided by an error that is not a number"
    )
    assert engines_text(policies.iloc[:0]) == engines_text(policies[policies["policy"] == "configured"]) == ""


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


def test_a_file_without_intervals_is_refused(tmp_path: Path) -> None:
    """No interval follows from its standard errors alone: with few starts it is wider."""
    row = {"integrator": "one", "case": "a", "setting": "s", "periods": 1e5, "starts": 8, "size": 1e-13}
    row |= {"power": 0.69, "uncertainty": 0.05, "law": "sqrt t", "expected": "sqrt t"}
    with pytest.raises(ValueError, match=r"growth\.json: rows\[0\]: 'low' is a required property; make it again"):
        _read_growth(tmp_path, row)


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


SAME, WIDE, APART = [1.05, 0.95, 1.0, 0.98, 1.02], [1.6, 0.7, 1.3, 0.8, 1.2], [3.1, 2.9, 3.0, 3.0, 3.2]


@pytest.mark.parametrize(
    ("changes", "note"),
    [
        ({"ratios": APART}, ""),
        ({"ratios": [1 / ratio for ratio in APART]}, ""),
        ({"ratios": SAME}, "equal"),
        ({"ratios": WIDE}, "open"),
        ({"ratios": APART, "first_null": 2e-4}, "20 % of the time of one is overhead of its call"),
        ({"first": None}, "not so accurate: one"),
    ],
)
def test_notes_of_pairs(tmp_path: Path, changes: dict[str, Any], note: str) -> None:
    row = {"group": "against two", "problem": "a", "level": "1e-06", "first_name": "one", "second_name": "two"}
    row |= {"first": 1e-3, "second": 2e-3, "first_null": 1e-5, "second_null": 1e-5} | changes
    (pair,) = _read_benchmarks(tmp_path, row | dict.fromkeys(("median", "low", "high"), 3.0))["pairs"]
    assert (pair["level"], pair["note"]) == ("1e-6", note)
    if "ratios" in changes:
        low, high = (float(end) for end in pair["range"].split(" – "))
        assert low < float(pair["ratio"]) < high
        assert float(pair["ratio"]) == pytest.approx(statistics.geometric_mean(changes["ratios"]), abs=0.006)


def _read_benchmarks(folder: Path, row: dict[str, Any]) -> dict[str, Any]:
    (folder / "benchmarks.json").write_text(json.dumps({"launches": 5, "environment": {}, "rows": [row]}))
    return report_benchmarks.benchmarks(folder) or {}


@pytest.mark.parametrize(
    ("without", "named"), [("ratios", "ratios of single launches"), ("first_name", "names of the sides")]
)
def test_pairs_without_the_numbers_of_a_claim_have_no_table(tmp_path: Path, without: str, named: str) -> None:
    """Without ratios, a factor of 4.34 (4.21 to 4.53) was "not separated": no launches, no difference."""
    assert _read_benchmarks(tmp_path, PAIR)["pairs"]
    found = _read_benchmarks(tmp_path, {name: value for name, value in PAIR.items() if name != without})
    assert (found["pairs"], found["singles"]) == ([], [])
    assert named in found["lacks"]


@pytest.mark.parametrize(("ratio", "text"), [(0.8349, "0.83"), (9.94, "9.94"), (9.96, "10"), (25.4, "25")])
def test_from_ten_on_a_ratio_has_no_decimals(ratio: float, text: str) -> None:
    """Five launches do not determine more than its integer part."""
    assert report_benchmarks._times(ratio) == text


def test_the_report_says_on_how_many_machines_it_stands() -> None:
    """A pair that could not run was measured nowhere."""
    frame = pd.DataFrame({"status": ["ok", "ok", "unsupported"], "machine": ["a", "a", "b"]})
    assert numbers_in(machines_text(frame)) == []
    assert numbers_in(machines_text(frame.assign(status="ok"))) == ["2"]
