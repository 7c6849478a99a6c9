"""Performance profiles: shares that are counted, failures, bands."""

import math

import numpy as np
import pandas as pd
import pytest
from gnomon.harness.results import profiles

NAMES = ["gnomon:A", "scipy:B", "rebound:C"]
TIMES = pd.DataFrame(
    [[1.0, 2.0, np.inf], [4.0, 1.0, np.inf], [3.0, 3.0, 1.5], [np.inf, np.inf, np.inf]],
    index=pd.Index(["p", "q", "r", "s"], name="case"),
    columns=NAMES,
)


def ratios(times: pd.DataFrame) -> pd.DataFrame:
    """Of the problems that somebody solves."""
    solved = times[np.isfinite(times.min(axis=1))]
    return solved.div(solved.min(axis=1), axis=0)


def test_shares_are_those_that_are_counted() -> None:
    """Ratios: A 1, 4, 2; B 2, 1, 2; C never, never, 1."""
    relative = ratios(TIMES)
    shares = {one.name: one.share for one in profiles.profiles(relative, [1, 2, 4, 1e9])}
    np.testing.assert_allclose(shares["gnomon:A"], [1 / 3, 2 / 3, 1, 1])
    np.testing.assert_allclose(shares["scipy:B"], [1 / 3, 1, 1, 1])
    np.testing.assert_allclose(shares["rebound:C"], [1 / 3, 1 / 3, 1 / 3, 1 / 3])


def test_a_failure_counts_at_every_factor() -> None:
    """A method that leaves out the problems on which it is slow has no better profile than one that fails there."""
    worse = TIMES.assign(**{"gnomon:A": [1.0, np.inf, 3.0, np.inf]})
    before, after = (profiles.profiles(ratios(table), [1, 10])[0].share for table in (TIMES, worse))
    assert np.all(after <= before)
    assert after[-1] == pytest.approx(2 / 3)


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


@pytest.mark.parametrize("count", [6, 9, 20])
def test_the_interval_of_a_median_covers_it_whatever_the_distribution(count: int) -> None:
    """Factors of systems are skew: their logarithms have heavy tails here, with a median of 0."""
    draw = np.random.default_rng(count)
    samples = np.exp(draw.standard_t(3, size=(4000, count)))
    found = [profiles.median(sample.tolist()) for sample in samples]
    covered = np.mean([one.low <= 1 <= one.high for one in found])
    assert covered >= 0.95 - 3 * math.sqrt(0.05 * 0.95 / len(found))
    assert all(one.confident and one.count == count for one in found)


def test_few_systems_have_a_range_that_is_no_interval() -> None:
    """The range of five values holds the median in 94 % alone."""
    found = profiles.median([3.0, 1.0, 2.0, 5.0, 4.0])
    assert (found.value, found.low, found.high, found.confident) == (3.0, 1.0, 5.0, False)
    assert profiles.median([3.0]).confident is False
    assert profiles.median([*range(1, 7)]).confident
