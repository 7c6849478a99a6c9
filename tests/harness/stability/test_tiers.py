"""Tiers: an order that chance, or one case, can turn round is not published."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
from gnomon.harness.stability.run import Row, as_json
from gnomon.harness.stability.tiers import by_calls, by_lost_digits, rank_intervals, separated, summary, tiers


def scores(*values: float) -> dict[str, float]:
    return {f"case {k}": value for k, value in enumerate(values)}


def test_methods_that_differ_on_every_case_are_in_tiers_of_their_own() -> None:
    found = tiers(
        {"slow": scores(2.0, 2.2, 1.9, 2.1), "fast": scores(0.0, 0.1, 0.2, 0.0), "middle": scores(1, 1.1, 0.9, 1)}
    )
    assert found == [["fast"], ["middle"], ["slow"]]


def test_one_case_cannot_make_an_order() -> None:
    """The mean of b is three times worse because of one case: without it b is the better one."""
    assert tiers({"a": scores(0.1, 0.1, 0.1, 0.1, 0.1), "b": scores(0.0, 0.0, 0.0, 0.0, 1.5)}) == [["a", "b"]]


def test_chance_does_not_make_an_order() -> None:
    """Two methods with the same distribution over 12 cases are separated in about one of twenty draws, at most."""
    rng = np.random.default_rng(1)
    pairs = [rng.normal(size=(2, 12)) for _ in range(200)]
    wrong = sum(separated(a, b) or separated(b, a) for a, b in pairs)
    assert wrong <= 0.12 * len(pairs)


def test_every_method_of_a_later_tier_is_separated_from_one_of_the_tier_before_and_no_two_of_a_tier_are() -> None:
    rng = np.random.default_rng(2)
    table = {f"m{k}": {f"c{j}": k / 3 + rng.normal() / 3 for j in range(9)} for k in range(8)}
    values = {method: np.array(list(row.values())) for method, row in table.items()}
    found = tiers(table)
    assert len(found) > 1
    assert sorted(method for tier in found for method in tier) == sorted(table)
    for before, tier in itertools.pairwise([[], *found]):
        assert not any(separated(values[one], values[other]) for one in tier for other in tier)
        assert not before or all(any(separated(values[one], values[other]) for one in before) for other in tier)


def test_easy_cases_alone_put_no_method_before_others() -> None:
    """The method with the least mean was measured on two cases only: nothing can be said of it, and it hides no other."""
    table = {"few": {"case 0": 0.0, "case 1": 0.0}, "good": scores(0.1, 0.2, 0.1, 0.2), "bad": scores(9, 8, 9, 8)}
    assert tiers(table) == [["good"], ["bad"]]
    assert tiers({}) == []


def test_two_shared_cases_are_too_few() -> None:
    """Each has four cases; the second is far worse on the two that they share."""
    table = {"a": {"1": 0.0, "2": 0.0, "3": 0.0, "4": 0.0}, "b": {"3": 9.0, "4": 9.0, "5": 0.0, "6": 0.0}}
    assert tiers(table) == [["a", "b"]]


def test_methods_that_are_better_than_each_other_in_a_circle_are_in_one_tier() -> None:
    """Each pair shares other cases, so that no order is possible."""
    table = {
        "a": {"1": 0.0, "2": 0.0, "3": 0.0, "7": 1.0, "8": 1.0, "9": 1.0},
        "b": {"1": 1.0, "2": 1.0, "3": 1.0, "4": 0.0, "5": 0.0, "6": 0.0},
        "c": {"4": 1.0, "5": 1.0, "6": 1.0, "7": 0.0, "8": 0.0, "9": 0.0},
    }
    assert tiers(table) == [["a", "b", "c"]]


def row(lost: float | None, calls: float | None, complete: bool = True) -> dict[str, object]:
    return {"lost": lost, "calls": calls, "complete": complete}


def test_a_failure_is_a_thousand_times_the_calls_and_a_lack_of_time_is_no_failure() -> None:
    panels = {
        "a": {"variants": {"k/1": row(1.0, 100.0), "p/1": row(2.0, 50.0), "q/1": row(None, None)}},
        "b": {"variants": {"k/1": row(3.0, 1000.0), "p/1": row(None, None), "q/1": row(None, None)}},
        "c": {"variants": {"k/1": row(3.0, None, complete=False), "p/1": row(0.0, 500.0, complete=False)}},
        "engine": {"variants": {"k/1": row(0.0, None)}},
        "other": {"not_applicable": "no form"},
    }
    found = by_calls(panels)
    assert found == {"a": {"k": 0.0, "p": 0.0}, "b": {"k": 1.0, "p": 3.0}, "c": {"p": 1.0}}
    lost = by_lost_digits(panels)
    assert lost["b"] == {"k": 3.0, "p": 16.0, "q": 16.0}
    assert lost["engine"] == {"k": 0.0}


def test_a_case_with_many_variants_counts_once() -> None:
    rows = {f"k/{n}": row(float(n), None) for n in range(3)} | {"p/1": row(5.0, None)}
    assert by_lost_digits({"a": {"variants": rows}}) == {"a": {"k": 1.0, "p": 5.0}}
    assert math.isclose(by_lost_digits({"a": {"variants": rows}}, censored=0.5)["a"]["p"], 0.5)


def test_rank_intervals_are_wide_where_cases_disagree_and_a_point_where_they_agree() -> None:
    table = {"a": scores(0, 0, 0, 0), "b": scores(1, 9, 1, 9), "c": scores(9, 1, 9, 1), "d": scores(20, 20, 20, 20)}
    assert rank_intervals(table) == {"a": (1, 1), "b": (2, 3), "c": (2, 3), "d": (4, 4)}


def test_the_summary_has_both_scores_and_leaves_out_what_was_not_measured() -> None:
    panels = {
        name: {"variants": {f"c{k}/1": row(lost, 10.0**lost) for k in range(4)}}
        for name, lost in (("a", 0.5), ("b", 2.0))
    }
    found = summary(panels | {"engine": {"refused": "no form"}})
    assert found["calls"]["tiers"] == found["lost_digits"]["tiers"] == [["a"], ["b"]]
    assert found["calls"]["rank_intervals"] == {"a": (1, 1), "b": (2, 2)}
    assert summary({}) == {}
    rows = [Row(name, "digits", 1.0, data, []) for name, data in panels.items()]
    assert json.loads(as_json(rows, "normal"))["tiers"]["calls"]["tiers"] == [["a"], ["b"]]
