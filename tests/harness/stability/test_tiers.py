"""Tiers: an order that chance, or one case, can turn round is not published."""

import itertools
import json

import numpy as np
import pytest
from gnomon.harness.stability.panel_run import Row, as_json
from gnomon.harness.stability.tiers import FEWEST, by_calls, by_lost_digits, is_separated, summary, tiers


def scores(*values: float) -> dict[str, float]:
    return {f"case {k}": value for k, value in enumerate(values)}


def test_methods_that_differ_on_every_case_are_in_tiers_of_their_own() -> None:
    small = (0.0, 0.1, 0.2, 0.0, 0.1, 0.0, 0.2, 0.1)
    table = {name: scores(*(away + x for x in small)) for name, away in (("slow", 2.0), ("fast", 0.0), ("middle", 1.0))}
    table = {name: row | {"case 0": row["case 0"] + 0.1 * k} for k, (name, row) in enumerate(table.items())}
    assert tiers(table) == [["fast"], ["middle"], ["slow"]]


def test_one_case_cannot_make_an_order() -> None:
    """The mean of b is worse because of one case: without it b is the better one."""
    assert tiers({"a": scores(*[0.1] * 8), "b": scores(*[0.0] * 7, 9.0)}) == [["a", "b"]]


SCATTER = 0.25
"""Decades, of a method on a case. Between two methods it is 0.35, the median over pairs of the published calls."""


def simulated(rng: np.random.Generator, sizes: tuple[int, ...], cases: int) -> tuple[list[list[str]], list[list[str]]]:
    """The tiers that are found, and those that are right, for groups of methods each ten times as good as the next one."""
    common = 0.5 * rng.normal(size=cases)
    right, table = [], {}
    for k, size in enumerate(sizes):
        right.append([f"m{k}{number:02}" for number in range(size)])
        for name in right[-1]:
            table[name] = scores(*(k + common + SCATTER * rng.normal(size=cases)))
    return tiers(table), right


@pytest.mark.parametrize("cases", [3, 5, FEWEST, 9])
def test_sixty_identical_methods_are_one_tier_in_95_of_100_tables(cases: int) -> None:
    rng, tables = np.random.default_rng(cases), 200
    wrong = sum(len(simulated(rng, (60,), cases)[0]) > 1 for _ in range(tables))
    assert wrong <= 0.05 * tables


@pytest.mark.parametrize("sizes", [(1, 1), (2, 1), (30, 30), (50, 10), (10, 50)])
def test_a_factor_of_ten_makes_two_tiers_in_90_of_100_tables(sizes: tuple[int, ...]) -> None:
    rng, tables = np.random.default_rng(sizes), 60
    right = sum(found == expected for found, expected in (simulated(rng, sizes, 9) for _ in range(tables)))
    assert right >= 0.9 * tables


def test_two_equal_methods_are_separated_in_no_more_than_one_of_twenty_tables() -> None:
    rng = np.random.default_rng(1)
    pairs = [rng.normal(size=(2, 12)) for _ in range(400)]
    wrong = sum(is_separated(a, b) or is_separated(b, a) for a, b in pairs)
    assert wrong <= 0.05 * len(pairs)


def test_every_method_of_a_later_tier_is_worse_than_the_mean_of_the_tier_before() -> None:
    rng = np.random.default_rng(2)
    table = {f"m{k}": {f"c{j}": k / 3 + rng.normal() / 6 for j in range(9)} for k in range(12)}
    values = {method: np.array(list(row.values())) for method, row in table.items()}
    found = tiers(table)
    assert len(found) > 1
    assert sorted(method for tier in found for method in tier) == sorted(table)
    for before, tier in itertools.pairwise(found):
        assert all(np.mean(values[one] - np.mean([values[m] for m in before], axis=0)) > 0 for one in tier)


def test_easy_cases_alone_put_no_method_before_others() -> None:
    """The method with the least mean was measured on two cases only: nothing can be said of it, and it hides no other."""
    table = {"few": {"case 0": 0.0, "case 1": 0.0}, "good": scores(*[0.1, 0.2] * 4), "bad": scores(*[9, 8] * 4)}
    assert tiers(table) == [["good"], ["bad"]]
    assert tiers({}) == []


def test_seven_shared_cases_are_too_few() -> None:
    """Each has fourteen cases; the second is far worse on the seven that they share."""
    a, b = {str(k): 0.0 for k in range(14)}, {str(k): 9.0 * (k < 14) for k in range(7, 21)}
    assert tiers({"a": a, "b": b}) == [["a", "b"]]


def test_a_method_is_not_worse_than_its_lower_bound() -> None:
    """Its sweep ends before it levels off: perhaps it loses not one of these digits."""
    table = {"a": scores(*[0.1, 0.2] * 4), "b": scores(*[5.0, 5.2] * 4)}
    assert tiers(table, table) == [["a"], ["b"]]
    assert tiers(table, table | {"b": scores(*[0.0] * 8)}) == [["a", "b"]]


def row(lost: float | None, calls: float | None, complete: bool = True) -> dict[str, object]:
    failed = None if lost is not None else "it failed"
    return {"lost": lost, "failed": failed, "calls": calls, "complete": complete, "levelled": complete}


def test_a_failure_is_a_thousand_times_the_calls_and_a_lack_of_time_is_no_failure() -> None:
    panels = {
        "a": {"variants": {"k/1": row(1.0, 100.0), "p/1": row(2.0, 50.0), "q/1": row(None, None)}},
        "b": {"variants": {"k/1": row(3.0, 1000.0), "p/1": row(None, None), "q/1": row(None, None)}},
        "c": {"variants": {"k/1": row(3.0, None, complete=False), "p/1": row(0.0, 500.0, complete=False)}},
        "engine": {"variants": {"k/1": row(0.0, None)}},
        "other": {"not_applicable": "no form"},
    }
    assert by_calls(panels) == {"a": {"k": 0.0, "p": 0.0}, "b": {"k": 1.0, "p": 3.0}, "c": {"p": 1.0}}


def settled(*lost: float | None) -> dict[str, object]:
    """Variants of cases of their own that lose digits, each of a sweep that has levelled off."""
    return {f"c{k}/1": row(value, 10.0 if value is None else 10.0**value) for k, value in enumerate(lost)}


def test_a_failure_loses_sixteen_digits_and_a_sweep_that_goes_down_to_its_end_may_lose_none() -> None:
    variants = settled(*[1.0] * FEWEST, None) | {"c0/2": row(3.0, None) | {"levelled": False}}
    most, least = by_lost_digits({"a": {"variants": variants}})
    assert most["a"]["c0"] == 2.0
    assert least["a"]["c0"] == 0.5
    assert most["a"][f"c{FEWEST}"] == least["a"][f"c{FEWEST}"] == 16.0
    few = settled(*[1.0] * (FEWEST - 1)) | {"c9/1": row(3.0, None) | {"levelled": False}}
    assert by_lost_digits({"a": {"variants": few}}) == ({}, {})


def test_a_case_with_many_variants_counts_once() -> None:
    rows = settled(*[5.0] * FEWEST) | {f"k/{n}": row(float(n), None) for n in range(3)}
    assert by_lost_digits({"a": {"variants": rows}})[0]["a"]["k"] == 1.0
    assert by_lost_digits({"a": {"variants": rows}}, censored=0.5)[0]["a"]["c1"] == 0.5


def test_the_summary_has_both_scores_and_leaves_out_what_was_not_measured() -> None:
    panels = {name: {"variants": settled(*[lost] * FEWEST)} for name, lost in (("a", 0.5), ("b", 2.0))}
    found = summary(panels | {"engine": {"refused": "no form"}})
    assert found["calls"]["tiers"] == found["lost_digits"]["tiers"] == [["a"], ["b"]]
    assert summary({}) == {}
    rows = [Row(name, "digits", 1.0, data, []) for name, data in panels.items()]
    assert json.loads(as_json(rows, "normal"))["tiers"]["calls"]["tiers"] == [["a"], ["b"]]
