"""Parts of a plan have every series once, about the same cost, and do not depend on the order of options."""

from collections import Counter
from typing import Any

import numpy as np
import pytest
from gnomon.harness.registry import lookup, selection
from gnomon.harness.running import cost, plan
from hypothesis import given
from hypothesis import strategies as st

SUITE = plan.suite("quick")


@pytest.fixture(scope="module")
def series() -> list[plan.Series]:
    return plan.list_series(selection.choose(SUITE.scope.cases, False), lookup.find_all(()))


@given(st.lists(st.floats(1e-3, 30.0), min_size=1, max_size=60), st.integers(1, 12))
def test_parts_are_consecutive_and_differ_from_the_mean_by_at_most_the_largest_item(
    seconds: list[float], parts: int
) -> None:
    """No division into whole items is better by more than the largest item, and series of one case stay together."""
    found = cost.divide(range(len(seconds)), seconds, parts)
    assert [item for part in found for item in part] == list(range(len(seconds)))
    assert len(found) == parts
    mean = sum(seconds) / parts
    for part in found:
        assert abs(sum(seconds[item] for item in part) - mean) <= max(seconds) * (1 + 1e-9)


@pytest.mark.parametrize("count", [2, 7, 40])
def test_every_series_is_in_exactly_one_shard(series: list[plan.Series], count: int) -> None:
    shards = [cost.shard(series, SUITE.change(shard=(k, count))) for k in range(1, count + 1)]
    assert Counter(one.id for part in shards for one in part) == Counter(one.id for one in series)
    seconds = [sum(cost.predict_seconds(one, SUITE) for one in part) for part in shards]
    largest = max(cost.predict_seconds(one, SUITE) for one in series)
    assert max(seconds) - min(seconds) <= 2 * largest * cost.PIECES  # each part is within the largest of the mean
    assert min(seconds) > 0


def test_shards_do_not_depend_on_the_order_of_options(series: list[plan.Series]) -> None:
    """Two jobs may name the same integrators in another order; each series must still run once."""
    shuffled: list[Any] = np.random.default_rng(1).permutation(np.array(series, dtype=object)).tolist()
    for k in (1, 2, 3):
        suite = SUITE.change(shard=(k, 3))
        assert [one.id for one in cost.shard(series, suite)] == [one.id for one in cost.shard(shuffled, suite)]


def test_more_launches_cost_more(series: list[plan.Series]) -> None:
    (one,) = (each for each in series if each.id == "pendulum_simple/default | standard | gnomon:RK4")
    once, often = (cost.predict_seconds(one, SUITE.change(launches=n)) for n in (1, 5))
    assert often - once == pytest.approx(4 * cost.COSTS["short"]["gnomon"])


def test_the_launches_of_one_series_follow_one_another() -> None:
    """A run of one series has nothing for a second worker to do: it takes the time of all its launches."""
    one, three = [("a", 4.0)] * 3, [("a", 4.0), ("b", 4.0), ("c", 4.0)]
    for workers in (1, 2, 3):
        assert cost.run_seconds(one, workers) == pytest.approx(cost.START + 12)
        assert cost.run_seconds(three, workers) == pytest.approx(cost.START + 12 / workers)
    assert cost.run_seconds([], 2) == 0


@given(st.floats(1e-3, 10.0), st.floats(1.0, 8.0))
def test_a_method_of_no_known_library_takes_the_longer_the_longer_a_trial_may(limit: float, factor: float) -> None:
    """A user's own method in Python runs at ever smaller steps until one trial takes the limit."""
    short, long = (cost.seconds_of("mine", False, seconds, turned=False) for seconds in (limit, factor * limit))
    assert long - short == pytest.approx(cost.OWN_SWEEP * (factor - 1) * limit)
    assert short >= cost.OWN_START + 2 * limit, "the counted and the timed call of the last trial"
