"""The judge of recommendations outside the catalogue, on invented rows whose judgement is known."""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
import synthetic
from gnomon.harness.results.advice import outside
from gnomon.harness.results.advice.outside import ERRORS, MARGINS, Pair, System

Row = dict[str, Any]
GRID = [10.0**-k for k in range(3, 14)]
LIBRARIES = ("scipy", "heyoka")


def sweep(case: str, library: str, factor: float, seconds: float = 1e-3, **more: Any) -> list[Row]:
    """The rows of a method whose error is `factor` times its tolerance, and whose time grows by a tenth a decade."""
    return [
        {
            **{"case": case, "variant": "default", "formulation": "standard", "library": library, "machine": "m"},
            **{"integrator_id": f"{library}:any", "status": "ok", "reason": "", "trial_key": f"{case} {library} {k}"},
            **{"run": 1, "launch": 1, "setting": value, "setting_kind": "tolerance", "time_scale": 1.0},
            **{"error_max": factor * value, "conditioning": 1e-15, "floor": 1e-17, "turned_starts": None},
            **{"seconds_median": seconds * 1.1**k, "null_seconds": 1e-8, "delay_seconds": 0.0, "rhs_calls": 10},
            **more,
        }
        for k, value in enumerate(GRID)
    ]


def answers(need: str = "accurate", tightest: float = 1.0, kind: str = "tolerance") -> list[Row]:
    """A table whose tightest setting is the error times `tightest`, and whose median setting is ten times that."""
    return [
        {
            **{"subject": need, "error": error, "library": library, "why": "", "systems": 6},
            "setting": {"kind": kind, "relative": 10 * error * tightest},
            "reliable": {"method": f"{library}:any", "kind": kind, "value": error * tightest},
        }
        for error in ERRORS
        for library in LIBRARIES
    ]


def judged(rows: list[Row], systems: dict[str, System], table: list[Row], pairs: Sequence[Pair] = ()) -> dict[str, Any]:
    """The judgement of a table, whose tolerances a margin tightens."""

    def tightened(margin: float) -> list[Row]:
        return [row | {"reliable": row["reliable"] | {"value": row["reliable"]["value"] * margin}} for row in table]

    return outside.judge(outside.Trials(rows, systems), tightened, pairs)


def halves(count: int, need: str = "accurate") -> dict[str, System]:
    """This number of systems in each half."""
    return {
        f"{half} {k}": System(need, "family", half) for half in (outside.MARGIN, outside.TEST) for k in range(count)
    }


def rows_of(systems: dict[str, System], factors: Sequence[float]) -> list[Row]:
    """Each system in turn with a factor from the error to the tolerance."""
    return [
        row
        for k, name in enumerate(systems)
        for library in LIBRARIES
        for row in sweep(name, library, factors[k % len(factors)])
    ]


@pytest.mark.parametrize(("factor", "margin"), [(0.5, 1.0), (5.0, 0.1), (50.0, 0.01), (5e3, 1e-4)])
def test_the_margin_makes_up_for_errors_that_are_larger_than_in_the_catalogue(factor: float, margin: float) -> None:
    """In the catalogue the tolerance is the error; outside, errors are `factor` tolerances."""
    systems = halves(5)
    found = judged(rows_of(systems, [factor]), systems, answers())
    assert found["margin"] == margin
    assert found["share"]["share"] == 1
    assert found["share"]["of"] == 5 * len(LIBRARIES) * len(ERRORS)
    assert found["half"] == {"margin": 5, "test": 5}


def test_the_margin_is_chosen_on_one_half_and_tested_on_the_other() -> None:
    """Systems of the half `test` are a hundred times worse: the margin does not see it, the share does."""
    systems = halves(4)
    rows = [
        row
        for name, one in systems.items()
        for row in sweep(name, "scipy", 0.5 if one.half == outside.MARGIN else 50.0)
    ]
    found = judged(rows, systems, answers())
    assert found["margin"] == 1
    assert found["share"]["held"] == 0
    assert {one["system"] for one in found["misses"]} == {f"test {k}" for k in range(4)}
    assert all(one["found"] == pytest.approx(50 * one["setting"]) for one in found["misses"])


@pytest.mark.parametrize(("wrong", "margin"), [(1, 1.0), (2, 0.1)])
def test_one_trial_in_forty_may_fail_with_the_margin(wrong: int, margin: float) -> None:
    """Of 40 systems one or two have errors that are ten times larger: 97.5 % or 95 % hold without a margin."""
    systems = {str(k): System("accurate", "family", outside.MARGIN) for k in range(40)}
    found = judged(rows_of(systems, [5.0] * wrong + [0.5] * (40 - wrong)), systems, answers())
    assert found["margin"] == margin


def test_without_an_enough_margin_the_one_with_the_largest_share_is_taken() -> None:
    systems = halves(4)
    found = judged(rows_of(systems, [1e5, 0.5, 0.5, 0.5]), systems, answers())
    shares = [one["share"] for one in found["margins"]]
    assert [one["margin"] for one in found["margins"]] == list(MARGINS)
    assert max(shares) < outside.WANTED
    assert found["margin"] == found["margins"][shares.index(max(shares))]["margin"]


def test_steps_have_no_margin() -> None:
    """A margin was not tried for them: the setting is the tightest of the catalogue."""
    (answer, *_) = answers(kind="step")
    answer["reliable"] = {"method": "scipy:any", "kind": "step", "relative": 0.01}
    assert {outside.reliable(answer, "scipy:any", margin) for margin in MARGINS} == {0.01}


def test_each_method_of_an_answer_has_its_own_setting() -> None:
    """A library that runs two methods on the systems of a need: the settings of one say nothing about the other."""
    (answer, *_) = answers()
    answer["reliable"] = {"method": "scipy:any", "kind": "tolerance", "value": 1e-5}
    answer["reliable"]["others"] = [{"method": "scipy:other", "kind": "tolerance", "value": 1e-8}]
    assert outside.reliable(answer, "scipy:any", 0.1) == pytest.approx(1e-6)
    assert outside.reliable(answer, "scipy:other", 0.1) == pytest.approx(1e-9)


def test_the_shares_are_of_the_settings_that_are_published_with_the_margin() -> None:
    """The table may round a tightened tolerance to one that was measured: what it then names is tried."""
    systems = halves(3)
    trials = outside.Trials(rows_of(systems, [5.0]), systems)
    found = outside.judge(trials, lambda margin: answers(tightest=1.0 if margin == 1 else 1e-3), [])
    assert (found["margin"], found["share"]["share"]) == (0.1, 1.0)
    found = outside.judge(trials, lambda margin: answers(tightest=1.0), [])
    assert (found["margin"], found["share"]["share"]) == (0.1, 0.0)


def test_a_step_is_compared_over_the_time_scale() -> None:
    """A recommended step of 1e-3 time scales is one of 1e-4 s where the scale is 0.1 s."""
    systems = {"a": System("accurate", "family", outside.TEST)}
    rows = sweep("a", "scipy", 0.5, setting_kind="step", time_scale=0.1)
    trials = outside.Trials(rows, systems)
    at = trials.at("a", "scipy", 1e-3)
    assert (at.relative, at.error) == (pytest.approx(1e-3), pytest.approx(0.5e-4))


@pytest.mark.parametrize(
    ("wanted", "taken"), [(1e-5, 1e-5), (3e-5, 1e-5), (0.99e-5, 1e-6), (1e-20, 1e-13), (1.0, 1e-3)]
)
def test_a_setting_is_rounded_down_to_the_measured_ones(wanted: float, taken: float) -> None:
    """Below the tightest one that was measured, this one counts: a method takes no tighter tolerance."""
    systems = {"a": System("accurate", "family", outside.TEST)}
    at = outside.Trials(sweep("a", "scipy", 1.0), systems).at("a", "scipy", wanted)
    assert at.relative == pytest.approx(taken)


@pytest.mark.parametrize("column", ["conditioning", "floor"])
def test_an_error_that_binary64_or_the_reference_cannot_tell_does_not_count(column: str) -> None:
    """The method is wrong at every setting; only the loosest error is above the limit of the system."""
    systems = {"a": System("accurate", "family", outside.TEST)}
    rows = sweep(
        "a", "scipy", 1e9, **{column: 2e-7 / (outside.ROUND_OFF if column == "conditioning" else outside.FLOOR)}
    )
    found = judged(rows, systems, answers())
    assert {one["error"] for one in found["misses"]} == {1e-3, 1e-6}
    assert found["share"]["of"] == 2


@pytest.mark.parametrize("status", ["diverged", "timeout", "crashed", "refused"])
def test_a_setting_without_a_good_solution_is_a_miss(status: str) -> None:
    """Also where an error was stored: the motion left the exact one."""
    systems = {"a": System("accurate", "family", outside.TEST)}
    found = judged(sweep("a", "scipy", 1e-3, status=status), systems, answers())
    assert (found["share"]["held"], found["share"]["of"]) == (0, 3)
    assert {(one["found"], one["status"]) for one in found["misses"]} == {(None, status)}
    json.dumps(found, allow_nan=False)


@pytest.mark.parametrize("status", ["unsupported", "not_installed", "interrupted"])
def test_a_method_that_did_not_run_is_no_trial(status: str) -> None:
    systems = {name: System("accurate", "family", outside.TEST) for name in "ab"}
    rows = [*sweep("a", "scipy", 0.5), *sweep("a", "heyoka", 0.5, status=status)]
    found = judged(rows, systems, answers())
    assert [one["library"] for one in found["by_library"]] == ["scipy"]
    assert found["systems"] == 1


def test_an_answer_without_a_recommendation_is_no_trial() -> None:
    systems = halves(2)
    table = [row | ({"why": "no method"} if row["library"] == "heyoka" else {}) for row in answers()]
    table = [row | ({"systems": 0} if row["error"] == 1e-9 else {}) for row in table]
    found = judged(rows_of(systems, [0.5]), systems, table)
    assert [one["library"] for one in found["by_library"]] == ["scipy"]
    assert found["share"]["of"] == 4


def test_a_system_counts_for_its_own_need_alone() -> None:
    systems = halves(2, "rigid")
    found = judged(rows_of(systems, [0.5]), systems, [*answers("accurate"), *answers("rigid", 1e-3)])
    assert [one["need"] for one in found["by_need"]] == ["rigid"]
    found = judged(rows_of(systems, [0.5]), systems, answers("accurate"))
    assert found["share"] == {"held": 0, "of": 0, "systems": 0, "share": None, "low": None, "high": None}


def test_the_median_setting_is_judged_beside_the_reliable_one() -> None:
    """Errors of half a tolerance: the tightest setting holds, the median one, ten times looser, does not."""
    systems = halves(3)
    found = judged(rows_of(systems, [0.5]), systems, answers())
    assert found["share"]["share"] == 1
    assert found["median_share"]["share"] == pytest.approx(1 / 3)  # the loosest setting is at 1e-3 held anyway


def test_the_interval_rests_on_systems() -> None:
    """Ten outcomes on each of 20 systems are 20 independent trials: the interval of 19 of 20 by Wilson."""
    outcomes = [(str(k), k > 0) for k in range(20) for _ in range(10)]
    found = outside.share(outcomes)
    assert (found["held"], found["of"], found["systems"]) == (190, 200, 20)
    assert (found["low"], found["high"]) == (pytest.approx(0.7639, abs=1e-4), pytest.approx(0.9911, abs=1e-4))


@pytest.mark.parametrize(("part", "count"), [(0.0, 10), (0.3, 10), (0.5, 7), (1.0, 60)])
def test_wilsons_bounds_are_where_the_normal_test_turns(part: float, count: int) -> None:
    """At a bound p the share is 1.96 standard deviations of p away."""
    for bound in outside.wilson(part, count):
        if 1e-9 < bound < 1 - 1e-9:
            assert abs(part - bound) / math.sqrt(bound * (1 - bound) / count) == pytest.approx(1.96, abs=1e-3)


def test_the_order_holds_where_the_faster_library_is_faster() -> None:
    """The published order is right on three of four systems of the half `test`, and on all of the other half."""
    systems = halves(4)
    rows = [
        row
        for name in systems
        for library, seconds in (("scipy", 1e-3), ("heyoka", 2e-3 if name == "test 0" else 1e-4))
        for row in sweep(name, library, 0.5, seconds)
    ]
    pairs = [Pair("accurate", 1e-6, "heyoka", "scipy", 10.0), Pair("rigid", 1e-6, "scipy", "heyoka", 10.0)]
    found = judged(rows, systems, answers(), pairs)["order"]
    assert (found["held"], found["of"], found["pairs"]) == (3, 4, 2)
    assert (found["all"]["held"], found["all"]["of"]) == (7, 8)
    assert [one["need"] for one in found["by_need"]] == ["accurate"]


def test_a_system_on_which_a_library_does_not_reach_the_error_has_no_order() -> None:
    systems = halves(1)
    rows = [*sweep("test 0", "scipy", 0.5), *sweep("test 0", "heyoka", 1e9)]
    found = judged(rows, systems, answers(), [Pair("accurate", 1e-6, "scipy", "heyoka", 2.0)])["order"]
    assert found["of"] == 0


def test_a_pair_names_the_library_that_is_faster_on_common_systems() -> None:
    """heyoka is faster on each of three common systems, by 2, 4 and 3; of its own, a fourth says nothing."""
    first = {"a": 2.0, "b": 4.0, "c": 3.0}
    second = {"a": 1.0, "b": 1.0, "c": 1.0, "d": 100.0}
    ((pair, p),) = outside._pair("accurate", 1e-6, ("scipy", first), ("heyoka", second))
    assert (pair.faster, pair.slower, pair.ratio) == ("heyoka", "scipy", 3.0)
    assert 0 < p < 0.05
    assert outside._pair("accurate", 1e-6, ("scipy", {"a": 1.0}), ("heyoka", second)) == []


def test_the_published_order_is_of_the_catalogue(tmp_path: Path) -> None:
    """Three libraries on three systems: one is forty times slower; two are closer than what counts as equal."""
    names = ("pendulum_simple", "duffing_unforced", "harmonic_oscillator")
    costs = {"scipy:DOP853": 4e-6, "heyoka:Taylor": 1e-7, "sksundae:CVODE Adams [native]": 1.1e-7}
    integrators = []
    for identity, cost in costs.items():
        library, _, name = identity.partition(":")
        name, _, policy = name.partition(" [")
        integrators.append((library, name, policy.rstrip("]"), 8, "tolerance", cost, ""))
    path = synthetic.write(tmp_path / "run.sqlite", {name: (name, "1", 2, ("default",)) for name in names}, integrators)
    found = outside.find_published_order(outside.measurements(path))
    assert {(pair.faster, pair.slower) for pair in found} == {("heyoka", "scipy"), ("sksundae", "scipy")}
    assert {"position", "smooth", "accurate"} <= {pair.need for pair in found}
    assert all(pair.ratio > 20 for pair in found)
