"""`compare`: its times are those of the report, and odd arguments are named."""

from typing import Any

import pandas as pd
import planted
import pytest
from gnomon.harness.results import analysis
from gnomon.harness.results.equal_error import TARGETS

import gnomon

CASE = "pendulum_simple"
METHODS = ["gnomon:RK4", "gnomon:DOP853"]
FORMULATIONS = {"pendulum_simple": "", "kepler_orbit": "", "kepler_orbit (sundman)": "sundman"}


@pytest.fixture(scope="module")
def found() -> gnomon.Comparison:
    return gnomon.compare(gnomon.case(CASE, L=2), METHODS, limit_seconds=300)


def test_times_at_equal_error_are_those_of_the_report(found: gnomon.Comparison) -> None:
    """Also over several launches of a case whose errors in the first one are medians over turned starts."""
    turned = gnomon.compare("kepler_orbit", METHODS, limit_seconds=300, launches=2)
    assert any(row["turned_starts"] for row in turned.rows)
    for each in (found, turned):
        report = analysis.equal_error(analysis.tidy(pd.DataFrame(each.rows)))
        assert len(report)
        for method in METHODS:
            for problem, times in each.times(method).items():
                rows = report[(report["integrator_id"] == method) & (report["formulation"] == FORMULATIONS[problem])]
                there = dict(zip(rows["target"], rows["seconds"], strict=True))
                assert {target: times[target] for target in TARGETS if target in there} == there
                assert all(times[target] != times[target] for target in TARGETS if target not in there)


def test_print_shows_each_integrator_and_says_what_a_time_is(found: gnomon.Comparison) -> None:
    text = str(found)
    assert all(method in text for method in METHODS)
    assert "without preparation" in text
    assert "Python" not in text, "both are compiled"


def test_an_integrator_of_ones_own_is_said_to_be_interpreted() -> None:
    found = gnomon.compare(CASE, [planted.Sound, "gnomon:RK4"], limit_seconds=300)
    assert {row["status"] for row in found.rows if row["integrator_id"] == "planted:sound"} >= {"ok"}
    assert "Yours (planted:sound) runs in Python" in " ".join(str(found).split())


def test_a_series_that_cannot_run_is_shown_with_its_reason() -> None:
    text = str(gnomon.compare(CASE, ["gnomon:DOP853", "gnomon:DOP853 [events]"]))
    assert "gnomon:DOP853 [events]" in text
    assert "unsupported" in text


def test_an_integrator_that_was_not_compared_is_named(found: gnomon.Comparison) -> None:
    with pytest.raises(ValueError, match="integrator='RK4': gnomon:RK4, gnomon:DOP853 were compared"):
        found.times("RK4")


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (([3], "gnomon:RK4"), "cases: 3 is not a case"),
        (([], "gnomon:RK4"), r"cases=\[\]"),
        ((3, "gnomon:RK4"), "cases=3"),
        ((CASE, []), r"integrators=\[\]"),
        ((CASE, 3), "integrators=3"),
        ((CASE, [dict]), "integrators: <class 'dict'> is not an integrator"),
        ((CASE, "gnomon:RK4", 0), "limit_seconds=0"),
        ((CASE, "gnomon:RK4", "a"), "limit_seconds='a'"),
        ((CASE, "gnomon:RK4", 1, 0), "launches=0"),
        (("pendulum_simpel", "gnomon:RK4"), "did you mean pendulum_simple"),
    ],
)
def test_an_odd_argument_is_named(given: tuple[Any, ...], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        gnomon.compare(*given)
