"""Kinds of systems, and every integrator in a picture with its numbers, in its division."""

import math
import re

import pandas as pd
import pytest
import synthetic
from command_line import numbers_in
from gnomon.harness.registry.kinds import kinds
from gnomon.harness.reporting.page.case_tables import way
from gnomon.harness.reporting.page.multiples import HEIGHT, MOST, WIDTH, _order, _picture, multiples
from gnomon.harness.reporting.report_run import Run


def test_the_most_structured_form_names_the_kind() -> None:
    forms = {
        "swing": {"FirstOrder", "Separable"}, "orbit": {"Separable", "NBody"}, "ball": {"Hybrid"}, "odd": {"Mine"},
    }  # fmt: skip
    found = kinds(forms, ["odd", "swing", "orbit", "ball"])
    assert list(found.items()) == [
        ("Impact, friction and changing contact", ["ball"]),
        ("Bodies under gravitation", ["orbit"]),
        ("Forces of position and time alone", ["swing"]),
    ]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    mine = ("mine", "stepper", "", 6, "tolerance", 4e-8, "")
    methods = (*synthetic.INTEGRATORS, mine)
    return Run.read(synthetic.write(tmp_path_factory.mktemp("multiples") / "results.sqlite", integrators=methods))


def test_every_integrator_has_one_picture_in_its_division(run: Run) -> None:
    """A user's own first, then third parties, then gnomon's: no more, and nobody is left out."""
    found = multiples(run, {}, run.names)
    assert list(found) == ["yours", "third", "own"]
    names = {division: {row["name"] for row in rows} for division, rows in found.items()}
    assert names["yours"] == {"mine:stepper"}
    assert {name.partition(":")[0] for name in names["own"]} == {"gnomon"}
    assert sum(map(len, found.values())) == run.frame["integrator_id"].nunique()


def test_the_numbers_of_a_picture_are_those_of_the_default_variants(run: Run) -> None:
    """Counted again from the rows; of cases that are not asked for, nothing counts."""
    frame = run.frame[(run.frame["variant"] == "") & (run.frame["launch"] == 1)]
    for cases in (run.names, run.names[:2]):
        rows = {row["name"]: row for part in multiples(run, {}, cases).values() for row in part}
        for name, row in rows.items():
            own = frame[
                (frame["integrator_id"] == name) & frame["case"].isin(cases) & (frame["status"] != "unsupported")
            ]
            best = own[own["status"] == "ok"].groupby("case")["error_max"].min()
            assert row["cases"] == own["case"].nunique()
            assert row["within"] == int((best <= 1e-6).sum())
            assert row["failed"] == row["cases"] - len(best)
            digits = (-best.map(lambda error: math.log10(error) if error else -17)).median()
            assert float(row["digits"]) == pytest.approx(digits, abs=0.051)


def test_a_picture_has_a_step_for_each_case_the_best_first() -> None:
    """A case without an answer is a step at the bottom, so that all pictures are of as many cases as were tried."""
    drawn = re.search(r'class="reached" d="([^"]+)"', _picture([16.0, 8.0, 0.0, 0.0], [16.0] * 4))
    assert drawn is not None
    steps = re.findall(r"V([\d.]+)H([\d.]+)", drawn[1])
    assert [float(x) for _, x in steps] == [WIDTH / 4 * k for k in range(1, 5)]
    assert [1 - float(y) / HEIGHT for y, _ in steps] == [1.0, 8 / MOST, 0.0, 0.0]


def test_orders_are_those_of_the_bench_or_the_median_of_the_run() -> None:
    slopes = pd.DataFrame({"order": [3.9, 4.0, math.nan], "declared": 4.0})
    assert numbers_in(_order(slopes, None)) == ["3.95", "2", "4"]
    assert numbers_in(_order(slopes, {"order": "16.03", "declared": "16"})) == ["16.03", "16"]
    assert _order(None, None) == _order(slopes[2:], None) == ""


@pytest.mark.parametrize(
    ("name", "same"),
    [
        ("scipy:DOP853", "scipy:Radau"), ("heyoka:Taylor", "gnomon:RK4"), ("mine:stepper", "other:one"),
        ("sksundae:CVODE BDF [native]", "rebound:BS [ODE mode]"),
    ],
)  # fmt: skip
def test_what_a_time_includes_is_said_by_library_and_method(name: str, same: str) -> None:
    ways = {one: way(one) for one in ("scipy:DOP853", "gnomon:RK4", "sksundae:CVODE BDF [native]", "mine:stepper")}
    assert way(name) == way(same)
    assert len({*ways.values()}) == 4
    assert ways["mine:stepper"] == "", "what a user's own does is not known"
