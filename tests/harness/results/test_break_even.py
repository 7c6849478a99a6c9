"""The cost of one solve and of many: libraries on the same systems, first use and preparation included."""

import math
from typing import Any

import pandas as pd
import pytest
from gnomon.harness.results import analysis
from gnomon.harness.results.best import Cost
from gnomon.harness.results.break_even import SOLVES, AtError, break_even
from gnomon.harness.results.rankings import FEWEST

COMPILED, PLAIN = "heyoka:Taylor", "scipy:RK45"
SYSTEMS = 6


def row(name: str, case: str, seconds: float, preparation: float = 0.0) -> dict[str, Any]:
    fixed = {"variant": "", "formulation": "", "target": 1e-6, "library": name.partition(":")[0]}
    return fixed | {"case": case, "integrator_id": name, "seconds": seconds, "prepare_seconds": preparation}


def at(rows: list[dict[str, Any]], **loads: float) -> AtError | None:
    """The comparison at 1e-6; first uses are of a third of a second but for these, by library."""
    known = {one["integrator_id"]: loads.get(one["library"], 1 / 3) for one in rows}
    return next(break_even(pd.DataFrame(rows), known), None)


def both(systems: int = SYSTEMS) -> list[dict[str, Any]]:
    """A library that compiles for a second and solves in 50 us, and one that solves in 1 ms; times differ by system."""
    scale = [1 + 0.1 * k for k in range(systems)]
    compiled = [row(COMPILED, f"c{k}", 5e-5 * x, preparation=1.0) for k, x in enumerate(scale)]
    return compiled + [row(PLAIN, f"c{k}", 1e-3 * x) for k, x in enumerate(scale)]


@pytest.mark.parametrize(
    ("one", "other"),
    [(Cost(1.0, 1e-3), Cost(0.0, 3e-3)), (Cost(0.0, 3e-3), Cost(0.0, 2e-3)), (Cost(0.1, 1.0), Cost(0.2, 1.0))],
)
def test_one_overtakes_another_at_the_first_number_of_solves_at_which_it_takes_less(one: Cost, other: Cost) -> None:
    for a, b in ((one, other), (other, one)):
        number = a.overtakes(b)
        expected = next((n for n in range(1, 2000) if a.total(n) < b.total(n)), math.inf)
        assert number == expected


def test_a_library_that_compiles_is_the_fastest_for_many_solves_only() -> None:
    found = at(both(), heyoka=0.5)
    assert found is not None
    assert (found.systems, found.first, found.later) == (SYSTEMS, "scipy", "heyoka")
    costs = {one.name: one for one in found.libraries}
    middle = 1.25  # of the factors by system
    assert costs["heyoka"].costs == pytest.approx([1.5 + n * 5e-5 * middle for n in SOLVES])
    assert costs["scipy"].costs == pytest.approx([1 / 3 + n * 1e-3 * middle for n in SOLVES])
    assert [one.fastest for one in (costs["scipy"], costs["heyoka"])] == [
        (True, True, False),
        (False, True, True),  # 1.56 and 1.58 s for a thousand are equal
    ]
    assert found.even == pytest.approx(7 / 6 / (0.95e-3 * middle), rel=0.02)


def test_the_first_use_of_a_library_counts() -> None:
    quick, slow = at(both(), scipy=0.0), at(both(), scipy=5.0)
    assert quick is not None
    assert slow is not None
    assert (quick.first, slow.first) == ("scipy", "heyoka")
    assert (slow.later, slow.even) == ("heyoka", 1)


def test_of_the_methods_of_a_library_the_cheapest_for_that_number_counts() -> None:
    rows = both() + [row("heyoka:quick", f"c{k}", 2e-3) for k in range(SYSTEMS)]
    found = at(rows, heyoka=0.0)
    assert found is not None
    (heyoka,) = (one for one in found.libraries if one.name == "heyoka")
    assert heyoka.costs[0] == pytest.approx(2e-3)
    assert heyoka.costs[2] == pytest.approx(1 + 1e6 * 5e-5 * 1.25)


def test_libraries_are_compared_on_the_systems_that_all_of_them_reach() -> None:
    """Neither a library that reaches few systems, nor systems that one library alone reaches, change a number."""
    plain = at(both(14))
    assert plain is not None
    hard = [row(PLAIN, f"hard{k}", 50.0) for k in range(4)]
    few = [row("rebound:WHFast", f"c{k}", 1e-6) for k in range(FEWEST)]
    found = at(both(14) + hard + few)
    assert found is not None
    assert found.aside == (("rebound", FEWEST),)
    assert {one.name: one.costs for one in found.libraries} == {one.name: one.costs for one in plain.libraries}
    assert {one.name: one.reached for one in found.libraries} == {"scipy": 18, "heyoka": 14}


@pytest.mark.parametrize("rows", [both(4), both()[:SYSTEMS], [*both(), row(PLAIN, "hard", 1.0) | {"variant": "hard"}]])
def test_nothing_is_said_of_fewer_than_five_systems_or_one_library(rows: list[dict[str, Any]]) -> None:
    found = at(rows)
    assert found is None or found.systems == SYSTEMS, "hard variants are not counted"
    assert (found is None) == (len(rows) < 2 * SYSTEMS)


def test_a_method_whose_first_use_or_preparation_is_unknown_is_left_out() -> None:
    """A cost without them would make a library that compiles the fastest for one solve."""
    rows = pd.DataFrame(both())
    assert not [*break_even(rows, {PLAIN: 0.1})]
    assert not [*break_even(rows, {PLAIN: 0.1, COMPILED: math.nan})]
    missing = rows.assign(prepare_seconds=rows["prepare_seconds"].where(rows["library"] == "scipy"))
    assert not [*break_even(missing, {PLAIN: 0.1, COMPILED: 0.1})]


def test_gnomon_is_not_named_the_fastest_where_there_are_third_parties() -> None:
    own = [row("gnomon:RK4", f"c{k}", 1e-7) for k in range(SYSTEMS)]
    found = at(both() + own)
    assert found is not None
    assert found.libraries[-1].name == "gnomon"
    assert not any(found.libraries[-1].fastest)
    assert "gnomon" not in (found.first, found.later)


def test_a_first_use_is_without_its_preparation_and_its_call() -> None:
    """Each later use has these, so that the sum counts them once."""
    rows = pd.DataFrame(
        {
            "integrator_id": ["a", "a", "b", "c"],
            "first_seconds": [math.nan, 2.0, 0.1, math.nan],
            "prepare_seconds": [9.0, 0.5, 0.2, 0.1],
            "seconds_median": [9.0, 0.25, 0.1, 0.1],
        }
    )
    assert analysis.load_seconds(rows).to_dict() == {"a": 1.25, "b": 0.0}
