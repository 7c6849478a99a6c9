"""Rankings under changes of the comparison: Kendall's tau, and the same numbers from the exported rows by other code."""

from __future__ import annotations

import csv
import math
import statistics
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import synthetic
from gnomon.harness.results import analysis, rankings, store
from gnomon.harness.results.rankings import ERROR, KIND, LAUNCH, LIMIT, LONGER
from scipy.stats import kendalltau

SHARE = 0.003
"""In place of the tenth of the time limit: the invented times are short."""
TARGETS = (1e-3, 1e-6, 1e-9)
KINDS = {"contact": ["bouncing_ball"], "smooth": ["pendulum_simple", "kepler_orbit"]}


@pytest.mark.parametrize("seed", range(5))
def test_tau_is_that_of_scipy_with_ties(seed: int) -> None:
    drawn = np.random.default_rng(seed).integers(0, 4, (2, 15))
    first, second = ({f"method {k}": value / 3 for k, value in enumerate(values)} for values in drawn.tolist())
    assert rankings.kendall(first, second) == pytest.approx(kendalltau(*drawn).statistic, abs=1e-14)


def test_tau_of_the_same_and_of_the_reversed_ranking() -> None:
    scores = {"a": 0.0, "b": 1.0, "c": 2.0}
    assert rankings.kendall(scores, scores) == 1.0
    assert rankings.kendall(scores, {name: -value for name, value in scores.items()}) == -1.0
    assert math.isnan(rankings.kendall({"a": 0.0}, {"a": 0.0}))


def test_who_is_missing_has_the_worst_score() -> None:
    """A method that a change leaves without a solution falls to the end of the ranking."""
    assert rankings.kendall({"a": 0.0, "b": 1.0}, {"b": 1.0}) == -1.0


Row = dict[str, str]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return synthetic.write(tmp_path_factory.mktemp("rankings") / "results.sqlite")


def exported(results: Path, folder: Path) -> list[Row]:
    """The default rows of `gnomon export`, as another program reads them."""
    store.export(results, folder / "rows.csv", "csv")
    with (folder / "rows.csv").open() as file:
        return [row for row in csv.DictReader(file) if row["variant"] == "default" and row["formulation"] == "standard"]


def independent_times(rows: list[Row], error: str, target: float) -> dict[tuple[str, str], float]:
    """Seconds to an error by case and integrator, as the documentation defines them."""
    sweeps: dict[tuple[str, str], dict[int, list[tuple[float, float, float]]]] = {}
    for row in rows:
        if row["status"] in ("ok", "inaccurate", "diverged") and row["seconds_median"]:
            time = float(row["seconds_median"])
            time = max(time - float(row["null_seconds"] or 0), time / 10)
            size = math.inf if row["status"] == "diverged" else float(row[error] or "nan")
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


def independent_tau(first: dict[tuple[str, str], float], second: dict[tuple[str, str], float]) -> float:
    """Tau of the rankings by the mean logarithm of the ratio, at most a factor of 1000."""

    def scores(times: dict[tuple[str, str], float]) -> Callable[[str], float]:
        fastest: dict[str, float] = {}
        for (case, _), time in times.items():
            fastest[case] = min(time, fastest.get(case, math.inf))

        def score(name: str) -> float:
            ratios = [times.get((case, name), math.inf) / least for case, least in fastest.items()]
            return statistics.fmean(math.log10(min(ratio, 1000)) for ratio in ratios)

        return score

    names = sorted({name for _, name in (*first, *second)})
    values = [[round(score(name), 9) for name in names] for score in (scores(first), scores(second))]
    return float(kendalltau(*values).statistic)


def changed_rows(rows: list[Row], change: tuple[str, str]) -> tuple[list[Row], str]:
    """The rows and the error column of a changed comparison."""
    kind, name = change
    if kind == KIND:
        return [row for row in rows if row["case"] not in KINDS[name]], "error_max"
    if kind == ERROR:
        return rows, {"error at the end": "error_end", "root mean square error": "error_rms"}[name]
    if kind == LAUNCH:
        repeated = {row["case"] for row in rows if row["launch"] != "1"}
        dropped = name.removeprefix("launch ")
        return [row for row in rows if row["case"] not in repeated or row["launch"] != dropped], "error_max"
    assert kind == LIMIT
    slow = [r for r in rows if r["seconds_median"] and r["limit_seconds"]]
    late = {id(row) for row in slow if float(row["seconds_median"]) > SHARE * float(row["limit_seconds"])}
    return [row for row in rows if id(row) not in late], "error_max"


def test_rankings_are_those_that_other_code_finds_in_the_exported_rows(
    results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rankings, "LIMIT_SHARE", SHARE)
    frame = analysis.tidy(store.load(results))
    equal = analysis.equal_error(frame)
    changed = rankings.alternatives(frame, equal, KINDS)
    assert {kind for kind, _ in changed} >= {KIND, ERROR, LIMIT, LONGER}
    rows = exported(results, tmp_path)
    found: dict[str, list[float]] = {kind: [] for kind, _ in changed}
    for target in TARGETS:
        base = independent_times(rows, "error_max", target)
        pairs = rankings.comparison(equal)[target]
        fastest = {case: min(time for (other, _), time in base.items() if other == case) for case, _ in base}
        assert {(pair.case, pair.name): pair.ratio * fastest[pair.case] for pair in pairs} == pytest.approx(
            base, rel=1e-12
        )
        for change, one in changed.items():
            if change[0] == LONGER:
                stopped = {
                    (row["case"], row["integrator_id"]): float(row["limit_seconds"])
                    for row in rows
                    if row["status"] in ("timeout", "skipped")
                }
                assert stopped
                after = stopped | base
            else:
                after = independent_times(*changed_rows(rows, change), target)
            tau = rankings.kendall(rankings.scores(pairs), rankings.scores(one.get(target, ())))
            expected = independent_tau(base, after)
            assert tau == pytest.approx(expected, abs=1e-12, nan_ok=True), (change, target)
            found[change[0]].append(tau)
    assert min(found[KIND]) < 1
    sizes = [sum(map(len, one.values())) for one in (changed[LIMIT, LIMIT], rankings.comparison(equal))]
    assert sizes[0] < sizes[1], "a limit that changes nothing shows nothing"


def _rows(**seconds: list[float]) -> pd.DataFrame:
    """The rows of `equal_error` at 1e-6 of integrators on three cases."""
    rows: list[dict[str, Any]] = [
        {"case": f"case {k}", "integrator_id": name, "library": name, "seconds": time, "target": 1e-6}
        for name, times in seconds.items()
        for k, time in enumerate(times)
    ]
    return analysis.compared(pd.DataFrame(rows).assign(variant="", formulation=""))


def test_without_in_house_integrators_ratios_are_to_the_fastest_third_party() -> None:
    equal = _rows(gnomon=[1.0, 1.0, 9.0], scipy=[2.0, 4.0, 1.0], heyoka=[4.0, 2.0, 3.0])
    third = rankings.third_party(equal)
    assert set(third["library"]) == {"scipy", "heyoka"}
    assert third.set_index(["library", "case"])["ratio"].to_dict() == {
        ("scipy", "case 0"): 1.0, ("scipy", "case 1"): 2.0, ("scipy", "case 2"): 1.0,
        ("heyoka", "case 0"): 2.0, ("heyoka", "case 1"): 1.0, ("heyoka", "case 2"): 3.0,
    }  # fmt: skip
    assert rankings.without_ours(rankings.comparison(equal)) == rankings.comparison(third)


def test_the_winner_is_the_first_of_the_standings() -> None:
    equal = _rows(a=[1.0, 5.0, 5.0], b=[5.0, 1.0, 5.0], c=[2.0, 2.0, 1.1], d=[9.0, 9.0, 1.0])
    for cases in ({"case 0"}, {"case 1", "case 2"}, {"case 0", "case 1"}, {"case 0", "case 1", "case 2"}):
        first = rankings.standings(equal[equal["case"].isin(cases)]).index[0]
        assert rankings.winner(rankings.comparison(equal)[1e-6], cases) == first


def test_the_smallest_tau_of_a_kind_of_change_is_shown() -> None:
    base = rankings.comparison(_rows(a=[1.0, 1.0, 1.0], b=[2.0, 2.0, 2.0], c=[4.0, 4.0, 4.0]))
    reversed_ = rankings.comparison(_rows(a=[4.0, 4.0, 4.0], b=[2.0, 2.0, 2.0], c=[1.0, 1.0, 1.0]))
    (row,) = rankings.taus(base, {(KIND, "same"): base, (KIND, "reversed"): reversed_}, (1e-6,)).to_dict("records")
    assert (row["tau"], row["worst"], row["count"]) == (-1.0, "reversed", 2)


def test_what_the_limit_stopped_is_solved_at_the_limit_and_never_before() -> None:
    """A method that was stopped after 2 s is in the best case the second on a case whose fastest takes 1 s, and the
    first on a case that nobody else solves; where it has solved the case, nothing changes."""
    equal = _rows(a=[1.0, 1.0], b=[4.0])
    frame = pd.DataFrame(
        [
            {"case": case, "integrator_id": name, "library": name, "status": status, "limit_seconds": limit}
            for case, name, status, limit in (
                ("case 1", "b", "timeout", 2.0),
                ("case 1", "b", "skipped", 3.0),
                ("case 0", "b", "skipped", 2.0),
                ("case 2", "b", "timeout", 2.0),
                ("case 1", "c", "refused", 2.0),
            )
        ]
    )
    found = rankings._at_the_limit(rankings.comparison(equal), equal, frame)[1e-6]
    assert {(pair.case, pair.name): pair.ratio for pair in found} == {
        ("case 0", "a"): 1.0, ("case 0", "b"): 4.0, ("case 1", "a"): 1.0, ("case 1", "b"): 2.0, ("case 2", "b"): 1.0,
    }  # fmt: skip
