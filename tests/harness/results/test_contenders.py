"""Further launches: the pairs that plain rows give are those of the page's tables, in each division."""

import math
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import synthetic
from gnomon.harness.results import analysis, contenders, rankings, reading, store
from gnomon.harness.results.contenders import MOST_LAUNCHES, Pair, Time


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return synthetic.write(tmp_path_factory.mktemp("contenders") / "results.sqlite")


def of_tables(equal: pd.DataFrame) -> set[Pair]:
    """The pairs of all divisions by `rankings`, which computes with pandas."""
    ranked = rankings.divisions(equal)
    found = [pair for _, part in ranked.groupby("division") for pair in rankings.undecided(part)]
    return {Pair(case, variant, target, first, other) for case, variant, _, target, first, other in found}


def test_times_and_pairs_are_those_of_the_page(results: Path) -> None:
    """A run must not launch what the page ranks, nor leave what it does not."""
    equal = analysis.equal_error(analysis.own(analysis.tidy(store.load(results))))
    found = contenders.times(reading.rows(results))
    key = ["case", "integrator_id", "target"]
    expected = equal.set_index(key)
    assert {(one.case, one.integrator_id, one.target) for one in found} == set(expected.index)
    for one in found:
        row = expected.loc[(one.case, one.integrator_id, one.target)]
        assert one.seconds == pytest.approx(row["seconds"])
        assert one.null_share == pytest.approx(row["null_share"], nan_ok=True)
        assert one.times == row["times"]
    assert set(contenders.undecided(found)) == of_tables(equal)


def cell(times: dict[str, list[float]], null: float = 0.01) -> list[Time]:
    return [
        Time(
            "c", "", name.split(":")[0], name, 1e-6, sum(s) / len(s), len(s), {(1, n): x for n, x in enumerate(s)}, null
        )
        for name, s in times.items()
    ]


def frame(found: list[Time]) -> Any:
    return pd.DataFrame([one._asdict() | {"formulation": ""} for one in found])


@pytest.mark.parametrize(
    ("times", "null", "pairs"),
    [
        ({"x:a": [1.0], "x:b": [1.9], "x:c": [2.1]}, 0.01, [("x:a", "x:b")]),
        ({"gnomon:a": [1.0], "x:b": [5.0], "y:c": [6.0]}, 0.01, [("x:b", "y:c")]),  # third parties among themselves
        ({"x:a": [1.0, 1.0, 1.01, 1.0], "x:b": [1.9, 1.9, 1.9, 1.9]}, 0.01, []),  # separated
        ({"x:a": [1.0] * MOST_LAUNCHES, "x:b": [1.0] * MOST_LAUNCHES}, 0.01, []),  # a tie
        ({"x:a": [1.0], "x:b": [1.1]}, 0.5, []),  # no launch makes a span longer
        ({"x:a": [1.0], "x:b": [1.1]}, math.nan, []),  # as a cell whose null call is not known
        ({"x:a": [1.0]}, 0.01, []),
    ],
)
def test_pairs_of_a_cell(times: dict[str, list[float]], null: float, pairs: list[tuple[str, str]]) -> None:
    found = cell(times, null)
    assert [(one.first, one.contender) for one in contenders.undecided(found)] == pairs
    assert set(contenders.undecided(found)) == of_tables(frame(found))
