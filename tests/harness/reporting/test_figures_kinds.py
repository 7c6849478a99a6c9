"""Small multiples by kind of system: each number agrees with the rows that it describes."""

from typing import Any

import pandas as pd
import pytest
import vl_convert
from gnomon.harness.reporting.figures_profiles import kind_marks, kinds_charts
from launches import timed

MEMBERS = {"Orbits": ["one", "two", "three"], "Impacts: and more": ["four"]}
SECONDS = {
    ("gnomon:A", "one"): 1.0, ("gnomon:A", "two"): 1.0, ("gnomon:A", "three"): 9.0,
    ("scipy:B", "one"): 4.0, ("scipy:B", "two"): 16.0, ("scipy:B", "three"): 3.0,
    ("rebound:C", "one"): 1.1,
}  # fmt: skip


def tables() -> tuple[pd.DataFrame, pd.DataFrame]:
    """`equal_error` and `status_matrix` of three integrators; C ran on two orbits, all but A on the impact, without success."""
    rows: list[dict[str, Any]] = [
        {"integrator_id": name, "library": name.partition(":")[0], "case": case, "seconds": seconds, "target": 1e-6}
        for (name, case), seconds in SECONDS.items()
    ]
    ran = [*SECONDS, ("rebound:C", "two"), ("scipy:B", "four"), ("rebound:C", "four")]
    matrix = [
        {"integrator_id": name, "library": name.partition(":")[0], "case": case, "verdict": "ok"} for name, case in ran
    ]
    matrix.append({"integrator_id": "gnomon:A", "library": "gnomon", "case": "four", "verdict": "unsupported"})
    same = {"variant": "", "formulation": ""}
    return timed(rows), pd.DataFrame(matrix).assign(**same)


def test_a_mark_is_the_median_and_range_over_the_cases_that_are_reached() -> None:
    marks = {(mark["integrator"], mark["column"]): mark for mark in kind_marks(*tables(), MEMBERS)}
    assert [marks["scipy:B", "Orbits"][key] for key in ("at", "low", "high")] == [4.0, 1.0, 16.0]
    assert "the 3 of 3 cases" in marks["scipy:B", "Orbits"]["text"]
    assert "the 1 of 2 cases" in marks["rebound:C", "Orbits"]["text"], "a case that it does not reach counts"
    assert marks["rebound:C", "Orbits"]["text"].endswith("of 1 ranked, alone the fastest on 0 and tied on 1"), "by 1.1"
    assert marks["gnomon:A", "Orbits"]["text"].endswith("of 3 ranked, alone the fastest on 1 and tied on 1")
    assert marks["scipy:B", "Impacts: and more"]["text"] == "none of 1"
    assert marks["scipy:B", "Impacts: and more"]["at"] is None
    assert ("gnomon:A", "Impacts: and more") not in marks, "a kind that it cannot run is left empty"


def test_other_variants_and_errors_are_left_out() -> None:
    equal, matrix = tables()
    more = pd.concat([equal, equal.assign(variant="hard", ratio=99.0), equal.assign(target=1e-3, ratio=99.0)])
    assert kind_marks(more, matrix, MEMBERS) == kind_marks(equal, matrix, MEMBERS)


def test_without_in_house_methods_ratios_are_to_the_fastest_of_the_others() -> None:
    charts = kinds_charts(*tables(), MEMBERS)
    rows = charts["kinds_others"].to_dict()["datasets"]["Orbits"]
    assert {row["integrator"] for row in rows} == {"scipy:B", "rebound:C"}
    (row,) = [row for row in rows if row["integrator"] == "scipy:B"]
    assert row["at"] == pytest.approx(0.0), "decades: on two of three cases it is alone"
    drawn = vl_convert.vegalite_to_svg(charts["kinds"].to_dict())
    assert all(text in drawn for text in ("gnomon:A", "Orbits", "none of 1"))
    assert kinds_charts(tables()[0].iloc[:0], tables()[1].iloc[:0], MEMBERS) == {}
