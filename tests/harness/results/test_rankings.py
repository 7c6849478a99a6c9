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
from gnomon.harness.results.contenders import ALONE, ANSWERED, UNDECIDED
from gnomon.harness.results.equal_error import find_reached
from gnomon.harness.results.rankings import find_solved, rank_methods
from gnomon.harness.results.time_ratios import EQUAL, FASTEST, OPEN, SLOWER, UNMEASURED
from launches import KNOWN, SCATTER

TARGETS = (1e-3, 1e-6, 1e-9)
SCATTERS = dict.fromkeys((contenders.THIRD, contenders.YOURS, contenders.OWN), KNOWN)


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
            found[key] = statistics.geometric_mean(known)
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
    frame = analysis.tidy(store.load(results))
    equal = rank_methods(analysis.equal_error(frame), rankings.scatter(frame)[contenders.OWN])
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
    at = {one.target: one.calls for one in find_reached(rows, (1e-2, 1e-4, 1e-5, 1e-6))}
    assert at == pytest.approx({1e-2: 10, 1e-4: 30, 1e-5: 90})
    without = [row | {"rhs_calls": None} for row in rows]
    assert all(math.isnan(one.calls) for one in find_reached(without, (1e-4,)))


@pytest.mark.parametrize("seed", range(8))
def test_a_launch_of_the_settings_on_which_a_time_rests_counts(seed: int) -> None:
    """Rounds launch these alone: also where a tighter setting takes less time than the one that reaches the error."""
    rng = np.random.default_rng(seed)
    times = np.exp(rng.standard_normal(8))  # in no order
    first = [
        {"run": 1, "launch": 1, "setting": 10.0**-k, "error_max": 10.0 ** (-1.3 * k), "null_seconds": 1e-9}
        | {"seconds_median": seconds, "rhs_calls": k}
        for k, seconds in enumerate(times, 2)
    ]
    for one in find_reached(first, (1e-3, 1e-6, 1e-9)):
        again = [row | {"launch": 2, "seconds_median": 1.21 * row["seconds_median"]} for row in first]
        beside = [row for row in again if row["setting"] in one.settings]
        rows = sorted([*first, *beside], key=lambda row: -row["setting"])
        (both,) = find_reached(rows, (one.target,))
        assert both.settings == one.settings
        assert [*both.times] == [(1, 1), (1, 2)]
        assert both.seconds == pytest.approx(1.1 * one.seconds)


def test_a_launch_that_waited_for_a_processor_counts_only_if_all_did() -> None:
    """Of a time of 2 s, 0.9 s were the machine's other work; without a quiet launch it is all that is known."""
    rows = [
        {
            "run": 1,
            "launch": launch,
            "setting": 1e-3,
            "error_max": 1e-4,
            "seconds_median": seconds,
            "null_seconds": 0.01,
        }
        | {"rhs_calls": 9, "delay_seconds": delay}
        for launch, seconds, delay in ((1, 2.0, 0.9), (2, 1.0, 0.0), (3, 1.1, 0.01))
    ]
    (quiet,) = find_reached(rows, (1e-3,))
    assert quiet.times == {(1, 2): 1.0, (1, 3): 1.1}
    (busy,) = find_reached(rows[:1], (1e-3,))
    assert busy.times == {(1, 1): 2.0}


def cells(times: dict[str, dict[str, list[float]]]) -> pd.DataFrame:
    """The rows of `equal_error` at 1e-6, from the seconds by launch of each integrator on each case."""
    rows: list[dict[str, Any]] = [
        {"case": case, "integrator_id": name, "library": name.partition(":")[0]}
        | {"times": {(1, n): x for n, x in enumerate(seconds)}}
        | {"seconds": statistics.geometric_mean(seconds), "launches": len(seconds)}
        for case, own in times.items()
        for name, seconds in own.items()
    ]
    return pd.DataFrame(rows).assign(variant="", formulation="", target=1e-6, null_share=0.01)


def drawn(rng: np.random.Generator, factors: dict[str, float], launches: int = 3) -> dict[str, list[float]]:
    """Seconds of integrators whose times are `factors` apart, with the scatter of `KNOWN`."""
    noise = np.exp(SCATTER * rng.standard_normal((len(factors), launches)))
    return {name: (factor * row).tolist() for (name, factor), row in zip(factors.items(), noise, strict=True)}


def test_every_row_has_a_factor_an_interval_and_one_state() -> None:
    """A hundred cells; in each, two are identical, one takes 1.5 times as long, and one 50 times."""
    rng = np.random.default_rng(3)
    factors = {"a:one": 1.0, "a:same": 1.0, "b:near": 1.5, "b:far": 50.0}
    rows = rank_methods(cells({f"case {k}": drawn(rng, factors) for k in range(100)}), KNOWN)
    assert set(rows["state"]) <= {FASTEST, SLOWER, EQUAL, OPEN}
    assert (rows[rows["state"] == FASTEST].groupby("case").size() == 1).all()
    assert (rows["low"] <= rows["ratio"]).all()
    assert (rows["ratio"] <= rows["high"]).all()
    shares = rows.groupby("integrator_id")["state"].value_counts(normalize=True)
    assert shares["b:near", SLOWER] > 0.95
    assert shares["b:far", SLOWER] == 1.0
    assert rows[rows["integrator_id"].str.startswith("a:")]["state"].isin([FASTEST, EQUAL]).mean() > 0.9


def test_a_cell_is_answered_by_one_launch_where_the_scatter_allows_it() -> None:
    """Nine times as slow is slower in one launch; 1.12 times is, if launches scatter by 3 %, and open if by an assumed 10 %."""
    times = {"far": {"x:a": [1.0], "x:b": [9.0]}, "near": {"x:a": [1.0], "x:b": [1.12]}, "alone": {"x:a": [1.0, 1.0]}}
    known, assumed = rank_methods(cells(times), KNOWN), rank_methods(cells(times), UNMEASURED)
    kinds = [rows.groupby("case")["cell"].first().to_dict() for rows in (known, assumed)]
    assert kinds[0] == {"far": ANSWERED, "near": ANSWERED, "alone": ALONE}
    assert kinds[1] == {"far": ANSWERED, "near": UNDECIDED, "alone": ALONE}
    assert known.loc[known["integrator_id"] == "x:b", "state"].tolist() == [SLOWER, SLOWER]
    assert (assumed["high"] >= known["high"]).all()


def test_a_pair_that_is_open_far_behind_leaves_the_cell_answered() -> None:
    """Whether the second takes 1.6 or 1.9 times as long is no question of who is fastest."""
    rough = {"x:a": [1.0, 1.0, 1.0], "x:b": [0.9, 1.8, 3.6]}
    rows = rank_methods(cells({"c": rough}), UNMEASURED).set_index("integrator_id")
    assert rows.loc["x:b", "ratio"] > 1.5
    assert rows.loc["x:b", "state"] == OPEN
    assert set(rows["cell"]) == {ANSWERED}


RANKS = ["case", "integrator_id", "ratio", "low", "high", "state", "cell"]


def mixed(cases: int = 40) -> pd.DataFrame:
    """Third parties that are identical or 1.5 times apart; gnomon's own as fast as the fastest, or far ahead; a user's own."""
    rng = np.random.default_rng(7)
    factors = {"scipy:a": 1.0, "heyoka:b": 1.0, "rebound:c": 1.5, "gnomon:same": 1.0, "gnomon:far": 0.01, "mine:d": 3.0}
    table = cells({f"case {k}": drawn(rng, factors) for k in range(cases)})
    return table.assign(calls=100.0 * table["integrator_id"].map(factors))


@pytest.mark.parametrize("rank", [rank_methods, rankings.rank_by_counts])
@pytest.mark.parametrize("others", [["gnomon"], ["mine"], ["gnomon", "mine"]])
def test_third_parties_are_ranked_as_if_nothing_else_had_run(rank: Any, others: list[str]) -> None:
    """gnomon publishes the page: what it adds to a run must not change how others stand, not even by one rate for all."""
    table = mixed()
    alone = rankings.divisions(table[~table["library"].isin(others)], SCATTERS, rank)
    found = rankings.divisions(table, SCATTERS, rank)
    third = [rows.loc[rows["division"] == contenders.THIRD, RANKS].reset_index(drop=True) for rows in (found, alone)]
    pd.testing.assert_frame_equal(*third)
    assert {FASTEST, SLOWER} <= set(third[0]["state"])
    assert (third[0].groupby("case")["ratio"].min() == 1).all(), "a third party sets the scale"


def test_other_divisions_are_set_against_the_least_of_third_parties() -> None:
    """A hundred times is apart and identical methods are not; the ratio is the quotient of the times."""
    table = mixed()
    least = table[table["library"].isin(["scipy", "heyoka", "rebound"])].groupby("case")["seconds"].min()
    found = rankings.divisions(table, SCATTERS).set_index(["integrator_id", "case"])
    for name in ("gnomon:same", "gnomon:far", "mine:d"):
        seconds = table[table["integrator_id"] == name].set_index("case")["seconds"]
        pd.testing.assert_series_equal(
            found.loc[name, "against"], seconds.div(least)[found.loc[name].index], check_names=False
        )
    of = found["against_state"]
    assert of["gnomon:same"].isin([EQUAL, OPEN]).mean() >= 0.95
    assert (of["gnomon:far"] == FASTEST).all()
    assert (of["mine:d"] == SLOWER).all()
    assert (of[["scipy:a", "heyoka:b", "rebound:c"]] == "").all()
    assert found["against"].isna().groupby("integrator_id").all()[["scipy:a", "heyoka:b", "rebound:c"]].all()


def test_one_that_is_like_all_third_parties_is_not_slower_than_the_least_of_them() -> None:
    """Of twenty identical ones some has the least time by chance; with many true differences a rate of 5 % claims more."""
    rng = np.random.default_rng(5)
    names = {f"scipy:{k}": 1.0 for k in range(20)} | {"mine:same": 1.0} | {f"gnomon:{k}": 30.0 for k in range(20)}
    found = rankings.divisions(cells({f"case {k}": drawn(rng, names) for k in range(60)}), SCATTERS)
    assert (found[found["library"] == "mine"]["against_state"] == SLOWER).mean() <= 0.05
    assert (found[found["library"] == "gnomon"]["against_state"] == SLOWER).all()


def test_where_no_third_party_gets_there_nothing_is_set_against_it() -> None:
    found = rankings.divisions(cells({"c": {"gnomon:a": [1.0, 1.1], "mine:b": [9.0, 9.1]}}), SCATTERS)
    assert found["against"].isna().all()
    assert (found["against_state"] == "").all()


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
    found = rankings.divisions(cells({"c": {f"{library}:a": [1.0, 1.1]}}), SCATTERS)
    assert found["division"].tolist() == [contenders.division(library)] == [division]


def test_without_rows_there_are_no_divisions() -> None:
    empty = rankings.divisions(cells({"c": {"scipy:a": [1.0]}}).iloc[:0], SCATTERS)
    assert len(empty) == 0
    assert {*RANKS, "division", "against", "against_state"} <= set(empty.columns)


def test_counts_are_compared_without_a_test_and_equal_within_a_tenth() -> None:
    """A count is the same in every launch; between settings it is interpolated, so that a few per cent decide nothing."""
    one = cells({"c": {f"scipy:{k}": [1.0] for k in "abcd"} | {"gnomon:e": [1.0], "gnomon:f": [1.0]}})
    table = one.assign(calls=[100.0, 109.0, 112.0, math.nan, 50.0, 95.0])
    found = rankings.divisions(table, SCATTERS, rankings.rank_by_counts).set_index("integrator_id")
    assert "scipy:d" not in found.index, "it was not counted"
    assert found["state"].to_dict() == {
        "scipy:a": FASTEST, "scipy:b": EQUAL, "scipy:c": SLOWER, "gnomon:e": FASTEST, "gnomon:f": SLOWER,
    }  # fmt: skip
    assert found.loc["scipy:a", ["ratio", "cell"]].tolist() == [1.0, ANSWERED]
    assert found.loc[["gnomon:e", "gnomon:f"], "against"].tolist() == [0.5, 0.95]
    assert found.loc[["gnomon:e", "gnomon:f"], "against_state"].tolist() == [FASTEST, EQUAL]
    alone = rankings.rank_by_counts(table.iloc[:1])
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
    assert find_solved(pd.concat([rough, fine])).iloc[0].to_dict() == {"rough": 0.0, "fine": 1.0}
    hard = pd.concat([rough, fine]).assign(conditioning=2e-9)
    assert find_solved(hard).iloc[0].to_dict() == {"rough": 1.0, "fine": 1.0}


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
    found = find_solved(pd.concat([variant("x", *settings), variant("other", ("ok", 1e-9))]))
    assert found["x"].iloc[0] == pytest.approx(right, nan_ok=True)


@pytest.mark.parametrize("status", ["unsupported", "not_installed"])
def test_what_cannot_run_is_not_known(status: str) -> None:
    found = find_solved(pd.concat([variant("x", (status, math.nan)), variant("other", ("ok", 1e-9))]))
    assert "x" not in found
    assert found["other"].tolist() == [1.0]
