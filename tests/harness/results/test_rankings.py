"""Ranks: separated integrators in a cell, over a page and over hard variants; times again from the exported rows."""

import csv
import math
import statistics
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import synthetic
from gnomon.harness.results import analysis, contenders, rankings, store
from gnomon.harness.results.contenders import ALONE, ONE_LAUNCH, RANKED, TOO_SHORT
from gnomon.harness.results.equal_error import reached
from gnomon.harness.results.rankings import ranked, solved
from launches import measured

TARGETS = (1e-3, 1e-6, 1e-9)


Row = dict[str, str]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return synthetic.write(tmp_path_factory.mktemp("rankings") / "results.sqlite")


def exported(results: Path, folder: Path) -> list[Row]:
    """The default rows of `gnomon export`, as another program reads them."""
    store.export(results, folder / "rows.csv", "csv")
    with (folder / "rows.csv").open() as file:
        return [row for row in csv.DictReader(file) if row["variant"] == "default" and row["formulation"] == "standard"]


def independent_times(rows: list[Row], target: float, column: str = "seconds_median") -> dict[tuple[str, str], float]:
    """Seconds, or another column, to an error by case and integrator, as the documentation defines them."""
    sweeps: dict[tuple[str, str], dict[int, list[tuple[float, float, float]]]] = {}
    for row in rows:
        if row["status"] in ("ok", "inaccurate", "diverged") and row["seconds_median"]:
            time = float(row[column] or "nan")
            size = math.inf if row["status"] == "diverged" else float(row["error_max"] or "nan")
            launches = sweeps.setdefault((row["case"], row["integrator_id"]), {})
            launches.setdefault(int(row["launch"]), []).append((float(row["setting"]), size, time))
    found = {}
    for key, launches in sweeps.items():
        most = max(sorted(launches), key=lambda number: len(launches[number]))
        sizes = {setting: size for setting, size, _ in sorted(launches[most], reverse=True)}
        times = []
        for launch in launches.values():
            of = {setting: time for setting, _, time in launch}
            times.append(_time(list(sizes.values()), [of.get(setting, math.nan) for setting in sizes], target))
        known = [time for time in times if not math.isnan(time)]
        if known:
            found[key] = statistics.median(known)
    return found


def _time(sizes: list[float], times: list[float], target: float) -> float:
    """The time of one sweep, loosest first: cut where round-off begins, each setting with the largest tighter error."""
    finite = sorted(size for size in sizes if math.isfinite(size))
    if not finite:
        return math.nan
    end = max(k for k, size in enumerate(sizes) if size <= 3 * finite[min(1, len(finite) - 1)]) + 1
    held = [max(sizes[k:end]) for k in range(end)]
    reached = [k for k in range(end) if held[k] <= target]
    if not reached:
        return math.nan
    k = reached[0]
    there = times[k]
    if k > 0 and math.isfinite(held[k - 1]):
        share = math.log(held[k - 1] / target) / math.log(held[k - 1] / held[k])
        there = times[k - 1] ** (1 - share) * times[k] ** share
    return min([there, *(times[n] for n in reached)])


def test_times_and_ratios_are_those_that_other_code_finds_in_the_exported_rows(results: Path, tmp_path: Path) -> None:
    equal = ranked(analysis.equal_error(analysis.tidy(store.load(results))))
    rows = exported(results, tmp_path)
    for target in TARGETS:
        base = independent_times(rows, target)
        least = {case: min(time for (other, _), time in base.items() if other == case) for case, _ in base}
        found = analysis.own(equal[equal["target"] == target])
        keys = list(zip(found["case"], found["integrator_id"], strict=True))
        assert dict(zip(keys, found["seconds"], strict=True)) == pytest.approx(base, rel=1e-12)
        ratios = {key: time / least[key[0]] for key, time in base.items()}
        assert dict(zip(keys, found["ratio"], strict=True)) == pytest.approx(ratios, rel=1e-12)


def test_evaluations_at_an_error_are_those_that_other_code_finds_in_the_exported_rows(
    results: Path, tmp_path: Path
) -> None:
    """Interpolated like times, so that both axes of a page compare the same settings; nan of who does not count."""
    equal = analysis.equal_error(analysis.tidy(store.load(results)))
    rows = exported(results, tmp_path)
    for target in TARGETS:
        base = independent_times(rows, target, "rhs_calls")
        found = analysis.own(equal[equal["target"] == target])
        keys = zip(found["case"], found["integrator_id"], strict=True)
        counted = {key: calls for key, calls in zip(keys, found["calls"], strict=True) if not math.isnan(calls)}
        assert counted == pytest.approx(base, rel=1e-12)
        assert not any("pybullet" in name for _, name in counted), "it counts nothing"


def test_evaluations_are_counted_in_the_first_launch_alone() -> None:
    """At 1e-4, halfway in the logarithms from 1e-3 to 1e-5, are 30 calls, between 10 and 90."""
    rows = [
        {"run": 1, "launch": launch, "setting": error, "error_max": error, "null_seconds": 1e-9}
        | {"seconds_median": seconds, "rhs_calls": calls if launch == 1 else None}
        for launch in (1, 2, 3)
        for error, seconds, calls in ((1e-3, 1.0, 10), (1e-5, 9.0, 90))
    ]
    at = {one.target: one.calls for one in reached(rows, (1e-2, 1e-4, 1e-5, 1e-6))}
    assert at == pytest.approx({1e-2: 10, 1e-4: 30, 1e-5: 90})
    without = [row | {"rhs_calls": None} for row in rows]
    assert all(math.isnan(one.calls) for one in reached(without, (1e-4,)))


def cells(times: dict[str, dict[str, list[float]]], null_share: float = 0.01) -> pd.DataFrame:
    """The rows of `equal_error` at 1e-6, from the seconds by launch of each integrator on each case."""
    rows: list[dict[str, Any]] = [
        {"case": case, "integrator_id": name, "library": name.partition(":")[0], "times": dict(enumerate(seconds))}
        | {"seconds": statistics.median(seconds), "launches": len(seconds)}
        for case, own in times.items()
        for name, seconds in own.items()
    ]
    return pd.DataFrame(rows).assign(variant="", formulation="", target=1e-6, null_share=null_share)


def drawn(rng: np.random.Generator, factors: dict[str, float], launches: int = 10) -> dict[str, list[float]]:
    """Seconds of integrators whose times are `factors` apart, with the scatter that was measured."""
    noise = measured(rng, (len(factors), launches)) / math.sqrt(2)  # of one launch, from a difference of two
    return {name: (factor * np.exp(row)).tolist() for (name, factor), row in zip(factors.items(), noise, strict=True)}


def test_on_a_page_of_many_cells_identical_methods_tie_and_a_factor_of_1_5_is_separated() -> None:
    """A hundred cells with ten launches; in each, two are identical, one takes 1.5 times as long, and one 50 times."""
    rng = np.random.default_rng(3)
    factors = {"a:one": 1.0, "a:same": 1.0, "b:near": 1.5, "b:far": 50.0}
    rows = ranked(cells({f"case {k}": drawn(rng, factors) for k in range(100)}))
    assert set(rows["cell"]) == {RANKED}
    slower = rows.groupby("integrator_id")["slower"].mean()
    assert slower["a:one"] < 0.05
    assert slower["a:same"] < 0.05
    assert slower["b:near"] > 0.7, "three are contenders, so that a p value counts twice"
    assert slower["b:far"] == 1.0
    two = {"a:one": 1.0, "b:near": 1.5}
    rows = ranked(cells({f"case {k}": drawn(rng, two) for k in range(200)}))
    assert rows[rows["integrator_id"] == "b:near"]["slower"].mean() > 0.8


@pytest.mark.parametrize("far", [0, 40])
def test_of_identical_methods_the_one_with_the_least_time_is_not_the_fastest(far: int) -> None:
    """Of thirty it is the least by chance: a test of it as if it had been named before separates it from many, above all on
    a page with many true differences, which the false discovery rate takes as a reason to claim more."""
    rng = np.random.default_rng(5)
    names = {f"x:{k}": 1.0 for k in range(30)} | {f"y:{k}": 40.0 for k in range(far)}
    rows = ranked(cells({f"case {k}": drawn(rng, names, 5) for k in range(40)}))
    same = rows[rows["integrator_id"].str.startswith("x:")]
    assert same["slower"].mean() < 0.01
    assert same.groupby("case")["slower"].any().mean() <= 0.2
    assert not (rows["leaders"] == 1).any()


def test_a_cell_is_ranked_only_where_launches_and_span_allow_it() -> None:
    one, several = {"x:a": [1.0], "x:b": [9.0]}, {"x:a": [1.0, 1.1, 1.0], "x:b": [9.0, 9.1, 9.3]}
    rows = ranked(cells({"one": one, "several": several, "alone": {"x:a": [1.0, 1.0]}})).set_index(
        ["case", "integrator_id"]
    )
    assert rows["cell"].groupby("case").first().to_dict() == {"one": ONE_LAUNCH, "several": RANKED, "alone": ALONE}
    assert rows.loc[("several", "x:b"), "slower"]
    assert not rows.loc["one", "slower"].any(), "one launch separates nothing, at any ratio"
    assert ranked(cells({"several": several}, 0.1))["cell"].unique() == [RANKED]
    assert ranked(cells({"several": several}, 0.11))["cell"].unique() == [TOO_SHORT]
    assert not ranked(cells({"several": several}, 0.11))["slower"].any()
    assert ranked(cells({"several": several}, math.nan))["cell"].unique() == [TOO_SHORT], "it was not measured"


def test_the_null_call_counts_of_contenders_alone() -> None:
    several = cells({"c": {"x:a": [1.0, 1.1], "x:b": [9.0, 9.1], "x:c": [1.9, 2.0]}})
    long_call = several.assign(null_share=[0.05, 0.9, 0.05])
    assert set(ranked(long_call)["cell"]) == {RANKED}
    assert set(ranked(several.assign(null_share=[0.05, 0.05, 0.2]))["cell"]) == {TOO_SHORT}


def test_launches_of_different_runs_are_no_pairs() -> None:
    """A run interleaves its launches; a launch of another day is not comparable in time."""
    table = cells({"c": {"x:a": [1.0, 1.1, 1.0], "x:b": [9.0, 9.1, 9.3]}})
    table["times"] = [
        {(1, n): s for n, s in enumerate([1.0, 1.1, 1.0])},
        {(2, n): s for n, s in enumerate([9.0, 9.1, 9.3])},
    ]
    assert set(ranked(table)["cell"]) == {ONE_LAUNCH}


def test_undecided_are_contenders_that_more_launches_may_separate() -> None:
    several = {"x:a": [1.0, 1.2, 1.0], "x:b": [1.1, 1.1, 1.3], "x:c": [9.0, 9.1, 9.3]}
    often = {"x:a": [1.0, 1.2] * 5, "x:b": [1.1, 1.1] * 5}
    one = {"x:a": [1.0], "x:b": [1.3], "x:c": [5.0]}
    rows = ranked(cells({"several": several, "often": often, "one": one}))
    found = [(case, first, second) for case, _, _, _, first, second in rankings.undecided(rows)]
    assert found == [("one", "x:a", "x:b"), ("several", "x:a", "x:b")]
    assert rankings.undecided(ranked(cells({"several": several}, 0.5))) == [], "no launch makes a span longer"


RANKS = ["case", "integrator_id", "ratio", "cell", "slower", "tied", "leaders"]


def mixed(cases: int = 40) -> pd.DataFrame:
    """Third parties that are identical or 1.5 times apart; gnomon's own as fast as the fastest, or far ahead; a user's own."""
    rng = np.random.default_rng(7)
    factors = {"scipy:a": 1.0, "heyoka:b": 1.0, "rebound:c": 1.5, "gnomon:same": 1.0, "gnomon:far": 0.01, "mine:d": 3.0}
    table = cells({f"case {k}": drawn(rng, factors) for k in range(cases)})
    return table.assign(calls=100.0 * table["integrator_id"].map(factors))


@pytest.mark.parametrize("rank", [ranked, rankings.counted])
@pytest.mark.parametrize("others", [["gnomon"], ["mine"], ["gnomon", "mine"]])
def test_third_parties_are_ranked_as_if_nothing_else_had_run(rank: Any, others: list[str]) -> None:
    """gnomon publishes the page: what it adds to a run must not change how others stand, not even by one rate for all."""
    table = mixed()
    alone = rankings.divisions(table[~table["library"].isin(others)], rank)
    found = rankings.divisions(table, rank)
    third = [rows.loc[rows["division"] == contenders.THIRD, RANKS].reset_index(drop=True) for rows in (found, alone)]
    pd.testing.assert_frame_equal(*third)
    assert 0 < third[0]["tied"].mean() < 1
    assert (third[0].groupby("case")["ratio"].min() == 1).all(), "a third party sets the scale"


def test_other_divisions_are_set_against_the_least_of_third_parties() -> None:
    """Identical methods are not apart in more than 5 % of all cells; a hundred times is; the ratio is that of the medians."""
    table = mixed()
    least = table[table["library"].isin(["scipy", "heyoka", "rebound"])].groupby("case")["seconds"].min()
    found = rankings.divisions(table).set_index(["integrator_id", "case"])
    for name in ("gnomon:same", "gnomon:far", "mine:d"):
        seconds = table[table["integrator_id"] == name].set_index("case")["seconds"]
        pd.testing.assert_series_equal(
            found.loc[name, "against"], seconds.div(least)[found.loc[name].index], check_names=False
        )
    apart = found["apart"].groupby("integrator_id").mean()
    assert apart["gnomon:same"] <= 0.05
    assert apart["gnomon:far"] == 1.0
    assert apart["mine:d"] > 0.9
    assert found["against"].isna().groupby("integrator_id").all()[["scipy:a", "heyoka:b", "rebound:c"]].all()


def test_one_that_is_like_all_third_parties_is_not_slower_than_the_least_of_them() -> None:
    """Of twenty identical ones some has the least time by chance; with many true differences a rate of 5 % claims more."""
    rng = np.random.default_rng(5)
    names = {f"scipy:{k}": 1.0 for k in range(20)} | {"mine:same": 1.0} | {f"gnomon:{k}": 30.0 for k in range(20)}
    found = rankings.divisions(cells({f"case {k}": drawn(rng, names) for k in range(60)}))
    assert found[found["library"] == "mine"]["apart"].mean() <= 0.03
    assert found[found["library"] == "gnomon"]["apart"].all()


def test_where_no_third_party_gets_there_nothing_is_set_against_it() -> None:
    found = rankings.divisions(cells({"c": {"gnomon:a": [1.0, 1.1], "mine:b": [9.0, 9.1]}}))
    assert found["against"].isna().all()
    assert not found["apart"].any()


@pytest.mark.parametrize(
    ("own", "third", "share", "apart"),
    [
        ({0: 1.0, 1: 1.1, 2: 1.0}, {0: 9.0, 1: 9.1, 2: 9.3}, 0.05, True),
        ({0: 1.0, 1: 1.1, 2: 1.0}, {0: 9.0, 1: 9.1, 2: 9.3}, 0.2, False),
        ({0: 1.0}, {0: 9.0}, 0.05, False),
        ({0: 1.0, 1: 1.1, 2: 1.0}, {7: 9.0, 8: 9.1, 9: 9.3}, 0.05, False),
    ],
)
def test_divisions_are_apart_only_where_launches_and_span_allow_it(
    own: dict[int, float], third: dict[int, float], share: float, apart: bool
) -> None:
    """Not by one launch, by launches of different runs, or where a null call is more than a tenth of the time."""
    table = cells({"c": {"gnomon:a": [*own.values()], "scipy:b": [*third.values()]}}, share)
    found = rankings.divisions(table.assign(times=[own, third])).set_index("library")
    assert bool(found.loc["gnomon", "apart"]) == apart


@pytest.mark.parametrize(
    ("library", "division"),
    [
        ("gnomon", contenders.OWN),
        ("scipy", contenders.THIRD),
        ("pybullet", contenders.THIRD),
        ("mine", contenders.YOURS),
    ],
)
def test_a_users_own_integrator_is_no_third_party(library: str, division: str) -> None:
    """It may run in Python, and nobody else has it: neither a rank among libraries nor a best third party is made of it."""
    found = rankings.divisions(cells({"c": {f"{library}:a": [1.0, 1.1]}}))
    assert found["division"].tolist() == [contenders.division(library)] == [division]


def test_without_rows_there_are_no_divisions() -> None:
    empty = rankings.divisions(cells({"c": {"scipy:a": [1.0]}}).iloc[:0])
    assert len(empty) == 0
    assert {*RANKS, "division", "against", "apart"} <= set(empty.columns)


def test_counts_are_compared_without_a_test_and_tie_within_a_tenth() -> None:
    """A count is the same in every launch; between settings it is interpolated, so that a few per cent decide nothing."""
    one = cells({"c": {f"scipy:{k}": [1.0] for k in "abcd"} | {"gnomon:e": [1.0], "gnomon:f": [1.0]}})
    table = one.assign(calls=[100.0, 109.0, 112.0, math.nan, 50.0, 95.0])
    found = rankings.divisions(table, rankings.counted).set_index("integrator_id")
    assert "scipy:d" not in found.index, "it was not counted"
    assert found["tied"].to_dict() == {
        "scipy:a": True, "scipy:b": True, "scipy:c": False, "gnomon:e": True, "gnomon:f": False,
    }  # fmt: skip
    assert found.loc["scipy:a", ["ratio", "leaders", "cell"]].tolist() == [1.0, 2, RANKED]
    assert found.loc[["gnomon:e", "gnomon:f"], "against"].tolist() == [0.5, 0.95]
    assert found.loc[["gnomon:e", "gnomon:f"], "apart"].tolist() == [True, False]
    alone = rankings.counted(table.iloc[:1])
    assert alone["cell"].tolist() == [ALONE]


def table(**held: list[float]) -> pd.DataFrame:
    return pd.DataFrame(held, index=pd.MultiIndex.from_product([["c"], range(len(next(iter(held.values()))))]))


def variant(name: str, *settings: tuple[str, float], conditioning: float = 1e-15) -> pd.DataFrame:
    rows = [{"status": status, "error_max": error, "integrator_id": name} for status, error in settings]
    return pd.DataFrame(rows).assign(case="c", variant="hard", formulation="", conditioning=conditioning)


def test_a_hard_variant_is_solved_by_an_error_and_not_by_a_word() -> None:
    """`ok` is an error below a tenth of the motion. Where the motion is so ill-conditioned that 1e-6 loses no digit more
    than another, 1000 times the conditioning counts."""
    rough = variant("rough", ("ok", 0.09), ("ok", 2e-6))
    fine = variant("fine", ("inaccurate", 0.2), ("ok", 9e-7))
    assert solved(pd.concat([rough, fine])).iloc[0].to_dict() == {"rough": 0.0, "fine": 1.0}
    hard = pd.concat([rough, fine]).assign(conditioning=2e-9)
    assert solved(hard).iloc[0].to_dict() == {"rough": 1.0, "fine": 1.0}


@pytest.mark.parametrize(
    ("settings", "right"),
    [
        ([("timeout", math.nan), ("timeout", math.nan)], 0.0),
        ([("diverged", math.nan), ("skipped", math.nan)], math.nan),
        ([("ok", 1e-3), ("interrupted", math.nan)], math.nan),
        ([("ok", 1e-7), ("skipped", math.nan)], 1.0),
        ([("crashed", math.nan), ("ok", 1e-3)], 0.0),
    ],
)
def test_what_was_left_out_is_no_failure(settings: list[tuple[str, float]], right: float) -> None:
    found = solved(pd.concat([variant("x", *settings), variant("other", ("ok", 1e-9))]))
    assert found["x"].iloc[0] == pytest.approx(right, nan_ok=True)


@pytest.mark.parametrize("status", ["unsupported", "not_installed"])
def test_what_cannot_run_is_not_known(status: str) -> None:
    found = solved(pd.concat([variant("x", (status, math.nan)), variant("other", ("ok", 1e-9))]))
    assert "x" not in found
    assert found["other"].tolist() == [1.0]
