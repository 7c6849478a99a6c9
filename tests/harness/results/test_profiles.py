"""Performance profiles: shares that are counted, failures, bands."""

import numpy as np
import pandas as pd
import pytest
from gnomon.harness.results import profiles
from launches import timed

NAMES = ["gnomon:A", "scipy:B", "rebound:C"]
TIMES = pd.DataFrame(
    [[1.0, 2.0, np.inf], [4.0, 1.0, np.inf], [3.0, 3.0, 1.5], [np.inf, np.inf, np.inf]],
    index=pd.Index(["p", "q", "r", "s"], name="case"),
    columns=NAMES,
)


def test_shares_are_those_that_are_counted() -> None:
    """Ratios: A 1, 4, 2; B 2, 1, 2; C never, never, 1. A problem that nobody solves is not in the profile."""
    relative = profiles.ratios(TIMES)
    assert list(relative.index) == ["p", "q", "r"]
    shares = {one.name: one.share for one in profiles.profiles(relative, [1, 2, 4, 1e9])}
    np.testing.assert_allclose(shares["gnomon:A"], [1 / 3, 2 / 3, 1, 1])
    np.testing.assert_allclose(shares["scipy:B"], [1 / 3, 1, 1, 1])
    np.testing.assert_allclose(shares["rebound:C"], [1 / 3, 1 / 3, 1 / 3, 1 / 3])


def test_a_failure_counts_at_every_factor() -> None:
    """A method that leaves out the problems on which it is slow has no better profile than one that fails there."""
    worse = TIMES.assign(**{"gnomon:A": [1.0, np.inf, 3.0, np.inf]})
    before, after = (profiles.profiles(profiles.ratios(table), [1, 10])[0].share for table in (TIMES, worse))
    assert np.all(after <= before)
    assert after[-1] == pytest.approx(2 / 3)


def test_the_best_of_a_library_and_of_all_third_parties() -> None:
    best = profiles.by_library(TIMES, lambda name: name.partition(":")[0])
    assert best[profiles.THIRD_PARTY].tolist() == [2.0, 1.0, 1.5, np.inf]
    assert best["gnomon"].tolist() == TIMES["gnomon:A"].tolist()


def test_bands_hold_the_share_and_shrink_with_the_number_of_cases() -> None:
    def width(cases: int) -> float:
        drawn = np.random.default_rng(3).choice([1.0, 5.0], (cases, 1))
        (one,) = profiles.profiles(pd.DataFrame(drawn, index=range(cases), columns=["x"]), [2.0])
        assert one.low[0] <= one.share[0] <= one.high[0]
        return float(one.high[0] - one.low[0])

    assert width(400) == pytest.approx(width(25) / 4, rel=0.3), "as one over the root of the number"


def test_variants_of_a_case_are_drawn_together() -> None:
    """Twenty variants of one case are not twenty independent problems."""
    index = pd.MultiIndex.from_tuples([(case, variant) for case in "ab" for variant in range(20)])
    values = pd.DataFrame({"x": [1.0] * 20 + [0.0] * 20}, index=index)
    (one,) = profiles.profiles(values, [1.0], above=True)
    assert (one.low[0], one.share[0], one.high[0]) == (0.0, 0.5, 1.0)


def test_digits_are_those_of_the_best_setting_that_is_ok() -> None:
    reduced = pd.DataFrame(
        [
            ("p", "hard", "", "gnomon:A", "ok", 1e-9),
            ("p", "hard", "", "gnomon:A", "ok", 1e-4),
            ("p", "hard", "", "scipy:B", "inaccurate", 1e-1),
            ("p", "worse", "", "gnomon:A", "timeout", np.nan),
            ("p", "", "", "gnomon:A", "ok", 1e-12),
        ],
        columns=["case", "variant", "formulation", "integrator_id", "status", "error_max"],
    )
    table = profiles.digits(reduced)
    assert table.loc[("p", "hard")].to_dict() == {"gnomon:A": 9.0, "scipy:B": 0.0}
    assert table.loc[("p", "worse")].to_dict() == {"gnomon:A": 0.0, "scipy:B": 0.0}


def test_those_that_are_tied_share_the_least_time() -> None:
    """A profile draws no order where the launches separate nothing: one launch separates nothing below a factor of two."""
    rows = [
        {"case": "c", "integrator_id": name, "seconds": x, "target": 1e-6}
        for name, x in (("a", 1.0), ("b", 1.1), ("c", 5.0))
    ]
    assert profiles.times(timed(rows), 1e-6).loc["c"].to_dict() == {"a": 1.0, "b": 1.0, "c": 5.0}
    apart = [row | {"seconds": 1.5} if row["integrator_id"] == "b" else row for row in rows]
    assert profiles.times(timed(apart), 1e-6).loc["c", "b"] == 1.5
    assert profiles.times(timed(apart, launches=1), 1e-6).loc["c"].to_dict() == {"a": 1.0, "b": 1.0, "c": 5.0}
