"""Time at equal error, ratios, orders and verdicts of sweeps with given errors and times."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from gnomon.harness.results import analysis, equal_error, rankings, reading, summary
from gnomon.harness.results.contenders import OWN
from gnomon.harness.results.rankings import rank_methods
from gnomon.harness.results.store import load
from gnomon.harness.studies import model_hierarchy

MIDDLE = math.sqrt(1.1)
"""The geometric mean of two launches 10 % apart."""


def _rows(name: str, errors: list[float], seconds: list[float], **columns: Any) -> pd.DataFrame:
    """The rows of one series, a setting halved from one to the next, in two launches 10 % apart."""
    launches = []
    for launch, factor in enumerate((1.0, 1.1)):
        rows = pd.DataFrame({"error_max": errors, "seconds_median": np.array(seconds) * factor})
        rows["setting"] = 0.5 ** np.arange(len(errors))
        keys = [f"{name} {columns} {setting}" for setting in rows["setting"]]
        launches.append(rows.assign(launch=launch, trial_key=keys))
    fixed = {"case": "c", "variant": "default", "formulation": "standard", "library": "l", "integrator": name}
    fixed |= {"integrator_id": f"l:{name}", "policy": "", "status": "ok", "reason": "", "sampling": "grid"}
    fixed |= {"setting_kind": "step", "settings_changed": "{}", "order_declared": 2, "floor": 1e-17}
    fixed |= {"conditioning": 1e-15, "rhs_calls": 1, "steps": 1, "turns": 0, "error_end": 0.0, "error_rms": 0.0}
    fixed |= dict.fromkeys(("error_phase", "error_shape", "events_missing", "events_extra", "events_time_error"))
    fixed |= {"seconds_low": 1.0, "seconds_high": 1.0, "prepare_seconds": 0.0, "machine": "m", "run": 1}
    fixed |= dict.fromkeys(
        ("null_seconds", "turned_starts", "error_low", "error_high", "error_unturned", "error_start")
    )
    fixed |= dict.fromkeys(("null_work", "first_seconds", "delay_seconds", "more_seconds"))
    return analysis.tidy(pd.concat(launches).assign(**(fixed | columns)))


def test_interpolation_is_linear_in_the_logarithms() -> None:
    errors, seconds = [1e-2, 1e-4, 1e-6], [1.0, 4.0, 16.0]
    found, bound = equal_error.time_at(errors, seconds, 1e-3)
    assert found == pytest.approx(2.0)
    assert not bound
    assert equal_error.time_at(errors, seconds, 1e-1) == (1.0, True)
    assert math.isnan(equal_error.time_at(errors, seconds, 1e-9)[0])


def test_a_tighter_setting_that_takes_less_time_counts() -> None:
    """For example with Taylor series: a looser tolerance gives a lower order and more steps."""
    errors = [1e-2, 1e-4, 1e-6, 1e-8]
    assert equal_error.time_at(errors, [9.0, 8.0, 2.0, 3.0], 1e-3) == (2.0, False)
    assert equal_error.time_at(errors, [9.0, 8.0, 2.0, 3.0], 1e-1) == (2.0, True)
    assert equal_error.time_at(errors, [9.0, 8.0, 2.0, 3.0], 1e-8)[0] == pytest.approx(3.0)
    assert equal_error.time_at(errors, [1.0, 8.0, 2.0, 3.0], 1e-2) == (1.0, True)


def test_a_setting_without_a_time_counts_by_its_error_only() -> None:
    errors, missing = [1e-2, 1e-4, 1e-6, 1e-8], math.nan
    assert equal_error.time_at(errors, [9.0, 8.0, missing, 3.0], 1e-4) == (3.0, False)
    assert math.isnan(equal_error.time_at(errors, [9.0, 8.0, missing, 3.0], 1e-5)[0])


def test_the_time_of_a_setting_beyond_round_off_is_ignored() -> None:
    assert equal_error.time_at([1e-2, 1e-8, 1e-12, 2e-12, 1e-10], [1.0, 2.0, 4.0, 5.0, 0.1], 1e-8)[0] == pytest.approx(
        2.0
    )


def test_a_small_error_by_chance_is_credited_with_the_errors_of_tighter_settings() -> None:
    errors = [1e-2, 1e-9, 1e-4, 1e-5, 1e-6]
    assert equal_error.credit_errors(errors).tolist() == [1e-2, 1e-4, 1e-4, 1e-5, 1e-6]
    found, _ = equal_error.time_at(errors, [1.0, 2.0, 4.0, 8.0, 16.0], 1e-6)
    assert found == pytest.approx(16.0)


def test_one_small_error_by_chance_does_not_cut_the_sweep() -> None:
    assert equal_error.credit_errors([1e-2, 1e-4, 1e-12, 1e-7, 1e-8]).tolist() == [1e-2, 1e-4, 1e-7, 1e-7, 1e-8]


def test_settings_beyond_round_off_are_left_out() -> None:
    held = equal_error.credit_errors([1e-4, 1e-8, 1e-12, 2e-12, 1e-10, 1e-9])
    assert held.tolist() == [1e-4, 1e-8, 2e-12, 2e-12, math.inf, math.inf]


def test_the_sweep_ends_where_errors_are_three_times_the_second_smallest() -> None:
    assert equal_error.credit_errors([1e-4, 1e-12, 2e-12, 7e-12]).tolist() == [1e-4, 2e-12, 2e-12, math.inf]
    assert equal_error.credit_errors([1e-4, 1e-12, 2e-12, 5e-12]).tolist() == [1e-4, 5e-12, 5e-12, 5e-12]


def test_equal_error_ignores_a_setting_that_diverged() -> None:
    rows = _rows("one", [1e-2, 1e-4], [1.0, 2.0])
    rows.loc[rows["error_max"] < 1e-3, "status"] = "diverged"
    assert analysis.equal_error(rows, targets=[1e-2, 1e-4])["target"].tolist() == [1e-2]


def test_a_setting_takes_the_median_of_its_launches_and_the_largest_error() -> None:
    rows = pd.concat([_rows("one", [1e-2], [1.0]), _rows("one", [3e-2], [7.0]).assign(launch=2)])
    (reduced,) = analysis.settings(rows).to_dict("records")
    assert reduced["seconds"] == pytest.approx(np.median([1.0, 1.1, 7.0, 7.7]))
    assert reduced["error_max"] == 3e-2


def test_trust_takes_the_best_setting_and_the_tolerances_above_the_attainable() -> None:
    rows = _rows("one", [1e-2, 2e-6, 3e-9, 9e-9], [1.0, 2.0, 3.0, 4.0], setting_kind="tolerance", floor=1e-17)
    rows["setting"] = [1e-3, 1e-6, 1e-9, 1e-12] * 2
    (found,) = analysis.trust(analysis.settings(rows.assign(conditioning=1e-10))).to_dict("records")
    assert (found["best"], found["at"], found["attainable"]) == (3e-9, 1e-9, 1e-10)
    # 1e-12 is below the attainable error; the errors of the others are 10, 2 and 3 times the tolerance
    assert found["over_tolerance"] == pytest.approx(3.0)
    assert found["worst_over_tolerance"] == pytest.approx(10.0)
    (above,) = analysis.trust(analysis.settings(rows.assign(conditioning=1e-18))).to_dict("records")
    assert above["attainable"] == 1e-17


def test_the_worst_error_over_tolerance_is_that_of_every_solution_with_an_error() -> None:
    """An inaccurate and a diverged solution have the largest ratios: without them 10 would be shown for 9e5."""
    rows = _rows("one", [0.9, 1.5, 1e-5, math.nan], [1.0, 2.0, 3.0, 4.0], setting_kind="tolerance")
    rows["status"] = ["inaccurate", "diverged", "ok", "diverged"] * 2
    rows = rows[rows["launch"] == 0].assign(setting=[1e-6, 1e-4, 1e-5, 1e-7])
    (found,) = analysis.trust(analysis.settings(rows)).to_dict("records")
    assert found["worst_over_tolerance"] == pytest.approx(9e5)
    assert found["over_tolerance"] == pytest.approx(1.5e4), "the median of 1, 1.5e4 and 9e5"


def test_the_anatomy_is_that_of_the_setting_nearest_1e_5() -> None:
    rows = _rows("one", [1e-2, 3e-5, 1e-9], [1.0, 2.0, 3.0], turns=[0, 4, 1] * 2, error_phase=[1e-2, 2e-5, 1e-9] * 2)
    (found,) = analysis.anatomy(rows).to_dict("records")
    assert (found["error_max"], found["error_phase"], found["turns"]) == (3e-5, 2e-5, 4)


def test_equal_error_keeps_the_times_of_each_launch() -> None:
    table = analysis.equal_error(_rows("one", [1e-2, 1e-4], [1.0, 2.0]), targets=[1e-2, 1e-3])
    assert table["seconds"].tolist() == [pytest.approx(MIDDLE), pytest.approx(MIDDLE * math.sqrt(2))]
    assert table["times"].tolist() == [
        {(1, 0): pytest.approx(x), (1, 1): pytest.approx(1.1 * x)} for x in (1.0, math.sqrt(2))
    ]
    assert (table["low"][0], table["high"][0], table["launches"][0]) == (1.0, pytest.approx(1.1), 2)


def test_order_is_measured_above_the_plateau_of_round_off() -> None:
    errors = [max(1e-3 * 0.25**k, 3e-13 * 0.9**k) for k in range(20)]
    rows = analysis.settings(_rows("verlet", errors, [1.0] * 20, conditioning=1e-16))
    assert analysis.orders(rows)["order"].tolist() == [pytest.approx(2.0, abs=0.01)]


@pytest.mark.parametrize("limit", ["conditioning", "floor"])
def test_an_order_is_fitted_to_errors_above_twenty_times_the_attainable_one(limit: str) -> None:
    """The last four of nine errors are below 2e-7, on a line of another slope."""
    errors = [1e-3 * 0.25**k for k in range(5)] + [1.9e-7 * 2 ** (-1.2 * k) for k in range(4)]
    known = {"conditioning": 1e-16, "floor": 1e-16} | {limit: 1e-8}
    rows = analysis.settings(_rows("verlet", errors, [1.0] * 9, **known))
    assert analysis.orders(rows)["order"].tolist() == [pytest.approx(2.0, abs=1e-9)]


def test_errors_of_coarse_steps_that_level_off_are_not_a_plateau() -> None:
    errors = [2e-3, 1.9e-3, *(1e-3 * 0.25**k for k in range(8))]
    rows = analysis.settings(_rows("verlet", errors, [1.0] * 10, conditioning=1e-16))
    assert analysis.orders(rows)["order"].tolist() == [pytest.approx(2.0, abs=0.05)]


@pytest.mark.parametrize(
    ("bend", "straight"),
    [([1, 1, 1, 1], True), ([1, 1, 1, 1.06], True), ([1, 1, 1, 0.9], False), ([1, 1, 0.03, 1], False)],
)
def test_an_order_is_printed_only_where_the_points_lie_on_a_line(bend: list[float], straight: bool) -> None:
    """A factor f on the finest of four errors changes the last slope by log2 f, and the fitted slope by 0.3 log2 f."""
    errors = [1e-3 * 0.25**k * f for k, f in enumerate(bend)]
    rows = analysis.settings(_rows("verlet", errors, [1.0] * 4, conditioning=1e-16))
    (found,) = analysis.orders(rows).to_dict("records")
    pieces = -np.diff(np.log2(errors))
    assert (found["lowest"], found["highest"]) == (pytest.approx(min(pieces)), pytest.approx(max(pieces)))
    assert math.isfinite(found["order"]) is straight
    assert found["declared"] == 2


def test_three_settings_show_no_order() -> None:
    rows = analysis.settings(_rows("verlet", [1e-3, 2.5e-4, 6.25e-5], [1.0] * 3))
    (found,) = analysis.orders(rows).to_dict("records")
    assert all(math.isnan(found[name]) for name in ("order", "lowest", "highest"))


def test_an_order_is_that_of_the_finest_settings_that_agree() -> None:
    """Order 1 at coarse steps, order 2 at finer ones, and a bend just above round-off."""
    errors = [4e-2, 2e-2, 1e-2, 5e-3, *(5e-3 * 0.25**k for k in range(1, 5)), 1.5e-5, 1e-5]
    rows = analysis.settings(_rows("verlet", errors, [1.0] * len(errors), conditioning=1e-16))
    assert analysis.orders(rows)["order"].tolist() == [pytest.approx(2.0)]


@pytest.mark.parametrize("name", ["error_rms", "error_end", "error_start"])
def test_where_an_error_passes_through_zero_another_gives_the_order(name: str) -> None:
    """One error is |1 - 3 h| h^2, on both sides of h = 1/3; another is h^2."""
    steps = 0.5 ** np.arange(6)
    crossing = (1e-2 * steps**2 * np.abs(1 - 3 * steps)).tolist()
    assert math.isnan(analysis.orders(analysis.settings(_rows("verlet", crossing, [1.0] * 6)))["order"][0])
    plain = np.tile(1e-2 * steps**2, 2)
    rows = _rows("verlet", crossing, [1.0] * 6, **{name: plain})
    assert analysis.orders(analysis.settings(rows))["order"].tolist() == [pytest.approx(2.0)]


@pytest.mark.parametrize(
    ("errors", "why"),
    [
        ([1.5e-14, 3e-16, 1e-15, 0.0], "round-off at every step size"),
        ([4e-1, 2e-1, 1e-1, 4e-2], "1 setting with an error below 0.05, 4 are needed"),
        ([1e-2, 1e-6, 1e-10, 1e-14, 1e-15], "3 settings between an error of 0.05 and round-off, 4 are needed"),
        ([1e-2, 1e-3, 1e-6, 2e-7, 1e-9], ""),
        ([1e-2, 2.5e-3, 6.25e-4, 1.5625e-4], ""),
        ([4e-2, 2e-2, 5e-4, 3e-5], "no four settings agree"),
    ],
)
def test_an_order_that_is_not_measured_has_its_reason(errors: list[float], why: str) -> None:
    (found,) = analysis.orders(analysis.settings(_rows("verlet", errors, [1.0] * len(errors)))).to_dict("records")
    assert found["why"] == why


@pytest.mark.parametrize("error", [0.5, math.nan])
def test_looser_settings_than_one_that_diverged_are_credited_with_its_error(error: float) -> None:
    """At 1/4 it diverged, with a large error or with states that are not finite; at 1/8 it is accurate again."""
    rows = _rows("patchy", [1e-9, 1e-9, error, 1e-9, 1e-9], [1.0, 2.0, 4.0, 8.0, 16.0])
    rows.loc[rows["setting"] == 0.25, "status"] = "diverged"
    (found,) = analysis.equal_error(rows, targets=[1e-6]).to_dict("records")
    assert (found["seconds"], found["at_loosest"]) == (pytest.approx(8.0 * MIDDLE), True)


@pytest.mark.parametrize("status", ["crashed", "refused", "timeout", "skipped"])
def test_a_setting_without_a_solution_is_ignored(status: str) -> None:
    rows = _rows("patchy", [1e-9, 1e-9, math.nan, 1e-9], [1.0, 2.0, math.nan, 8.0])
    rows.loc[rows["setting"] == 0.25, "status"] = status
    (found,) = analysis.equal_error(rows, targets=[1e-6]).to_dict("records")
    assert found["seconds"] == pytest.approx(MIDDLE)


def test_divergence_beyond_the_best_settings_does_not_count() -> None:
    rows = _rows("verlet", [1e-3, 1e-6, 1e-9, 1.0], [1.0, 2.0, 4.0, 8.0])
    rows.loc[rows["error_max"] == 1.0, "status"] = "diverged"
    (found,) = analysis.equal_error(rows, targets=[1e-6]).to_dict("records")
    assert found["seconds"] == pytest.approx(2.0 * MIDDLE)


def test_verdicts() -> None:
    good = _rows("good", [1e-2, 1e-4], [1.0, 2.0])
    cut = _rows("cut", [1e-2, 1e-4], [1.0, 2.0])
    cut.loc[cut["setting"] < 1, "status"] = "skipped"
    broken = _rows("broken", [1e-2, 1e-4], [1.0, 2.0])
    broken.loc[broken["setting"] == 1, ["status", "reason"]] = ["diverged", "why"]
    never = _rows("never", [2.0, 1.0], [1.0, 2.0], status="inaccurate")
    hung = _rows("hung", [math.nan] * 3, [math.nan] * 3, status="skipped")
    hung.loc[hung["setting"] == 1, "status"] = "timeout"
    matrix = analysis.status_matrix(analysis.settings(pd.concat([good, cut, broken, never, hung])))
    verdicts = matrix.set_index("integrator_id")["verdict"].to_dict()
    answered = {"l:good": "ok", "l:cut": "ok", "l:broken": "partly", "l:never": "inaccurate"}
    assert verdicts == answered | {"l:hung": "timeout"}, "a setting that was not started is not a failure"
    assert matrix.set_index("integrator_id").loc["l:broken", "reason"] == "why"


def nothing_ran(rows: pd.DataFrame) -> str | None:
    return summary.nothing_ran(zip(rows["status"], rows["reason"], strict=True))


def test_why_nothing_ran_is_the_most_frequent_reason() -> None:
    missing = _rows("a", [math.nan] * 2, [math.nan] * 2, status="not_installed", reason="no module\nnamed x")
    other = _rows("b", [math.nan], [math.nan], status="unsupported", reason="no contact")
    assert nothing_ran(pd.concat([missing, other])) == "not installed: no module named x"
    assert nothing_ran(missing[:0]) == "no measurement"
    assert nothing_ran(pd.concat([missing, _rows("c", [1.0], [1.0], status="timeout")])) is None


def test_a_stored_run_is_read(synthetic_results: Path) -> None:
    frame = analysis.tidy(load(synthetic_results))
    table = rank_methods(analysis.equal_error(frame), rankings.scatter(frame)[OWN])
    assert (table["ratio"] >= 1).all()
    assert (table.groupby(["case", "variant", "target"])["ratio"].min() == 1).all()
    assert set(analysis.trust(analysis.settings(frame))["integrator_id"]) == set(frame["integrator_id"])


def test_slow_settings_of_one_launch_leave_the_medians_of_the_others() -> None:
    rows = _rows("one", [1e-2, 1e-4, 1e-6], [1.0, 2.0, 4.0])
    short = rows[(rows["launch"] == 0) | (rows["setting"] > 0.25)]
    table = analysis.equal_error(short, targets=[1e-2, 1e-6]).set_index("target")
    assert (table.loc[1e-2, "launches"], table.loc[1e-2, "seconds"]) == (2, pytest.approx(MIDDLE))
    assert (table.loc[1e-6, "launches"], table.loc[1e-6, "seconds"]) == (1, 4.0)


def test_times_are_those_of_whole_calls_with_the_share_of_the_null_call() -> None:
    """A user waits for the whole call: the time before its first step is not subtracted."""
    errors = [1e-2, 1e-4, 1e-6, 1e-8, 1e-10]
    rows = _rows("costly call", errors, [12e-5, 13e-5, 15e-5, 19e-5, 27e-5], null_seconds=1e-4)
    (found,) = analysis.equal_error(rows[rows["launch"] == 0], (1e-6,)).to_dict("records")
    assert found["seconds"] == pytest.approx(15e-5, rel=1e-12)
    assert found["null_share"] == pytest.approx(10 / 15)
    (unknown,) = analysis.equal_error(rows.assign(null_seconds=math.nan), (1e-6,)).to_dict("records")
    assert math.isnan(unknown["null_share"])
    reduced = analysis.settings(rows[rows["launch"] == 0])
    np.testing.assert_allclose(reduced["seconds"], [12e-5, 13e-5, 15e-5, 19e-5, 27e-5], rtol=1e-12)


CALL, STEP, STAGES = 1e-4, 2e-6, 12
"""Seconds of a call and of a right-hand side; right-hand sides of a step."""


@pytest.mark.parametrize("forced", [0, 1, 64], ids=["fixed steps", "interpolates", "stops at samples"])
def test_the_steps_in_a_null_call_are_free_for_no_method(forced: int) -> None:
    """A method that stops at samples takes 64 steps in a null call, up to half the steps of a whole call; a method that
    interpolates takes one step, a method of fixed steps no step. All three pay an equal time for the call."""
    steps = np.maximum([70, 90, 150, 300, 700], forced)
    columns = {"rhs_calls": STAGES * steps, "steps": None, "null_work": STAGES * forced}
    seconds = CALL + STEP * STAGES * steps
    whole = _rows("one", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10], [0.0] * 5).iloc[:5]
    whole = whole.assign(seconds_median=seconds, null_seconds=CALL + STEP * STAGES * forced, **columns)
    later = whole.assign(launch=1, rhs_calls=None)  # later launches do not count right-hand sides
    frame = analysis.tidy(pd.concat([whole, later]))
    np.testing.assert_allclose(frame["null_seconds"], CALL, rtol=1e-9)
    waits = np.array([0.0, 0.0, 0.0, 0.0, 1.0])  # the cost of a right-hand side comes from times without waits
    busy = analysis.tidy(whole.assign(seconds_median=seconds + waits, delay_seconds=waits))
    np.testing.assert_allclose(busy["null_seconds"], CALL, rtol=1e-9)
    pd.testing.assert_frame_equal(analysis.tidy(frame), frame)


def test_a_null_call_with_about_the_work_of_a_whole_call_keeps_its_time() -> None:
    """A cost a right-hand side from less than twice the work would be noise; and one from a file without counts unknown."""
    rows = _rows("one", [1e-2, 1e-4], [2e-4, 2.1e-4], rhs_calls=100, null_seconds=1e-4, null_work=60)
    assert set(rows["null_seconds"]) == {1e-4}
    assert set(_rows("one", [1e-2, 1e-4], [2e-4, 9e-4], rhs_calls=900, null_seconds=1e-4)["null_seconds"]) == {1e-4}


def test_a_measurement_that_waited_for_a_processor_is_counted() -> None:
    """On a file without delays, or a system that does not tell, nothing is known."""
    rows = _rows("one", [1e-2, 1e-4], [1.0, 1.0], delay_seconds=[0.0, 0.02, 0.03, math.nan])
    rows["seconds_median"] = 1.0
    assert summary.count_waits(zip(rows["seconds_median"], rows["delay_seconds"], strict=True)) == (4, 1, 1)


LONGER = "default timing span x5"


@pytest.mark.parametrize(
    ("change", "own", "longer", "more"),
    [
        ({}, 1.0, 4.2, 0.8),
        ({}, 1.0, 2.25, 0.3125),
        ({}, 1.0, 2.24, None),  # the scatter of both times would be most of the difference
        ({}, 1.0, 0.9, None),
        ({"delay_seconds": 95.8}, 1.0, 100.0, 0.8),  # it waited for a processor
        ({"launch": 2}, 1.0, 4.2, None),
        ({"run": 2}, 1.0, 4.2, None),
        ({"machine": "another"}, 1.0, 4.2, None),
        ({"setting": 0.25}, 1.0, 4.2, None),
        ({"case": "d"}, 1.0, 4.2, None),
        ({"variant": "default length=2 timing span x5"}, 1.0, 4.2, None),
        ({"error_max": None}, 1.0, 4.2, None),  # not finite
        ({"error_max": 3.0}, 1.0, 4.2, 0.8),
        ({}, None, 4.2, None),
        ({}, 1.0, None, None),
    ],
)
def test_one_more_period_is_a_difference_of_times_of_one_launch(
    change: dict[str, Any], own: float | None, longer: float | None, more: float | None
) -> None:
    """On a span five times as long; the times over that span have none."""
    row = {"case": "c", "variant": "default", "formulation": "standard", "library": "l", "integrator_id": "l:a"}
    row |= {"setting": 0.5, "machine": "m", "run": 1, "launch": 1, "error_max": 1e-9}
    row |= {"seconds_median": own, "delay_seconds": None}
    rows = [row, {**row, "variant": LONGER, "seconds_median": longer, **change}]
    found = reading._more_seconds({name: [one[name] for one in rows] for name in row})
    assert found == [None if more is None else pytest.approx(more), None]


def test_one_more_period_is_interpolated_by_the_errors_of_the_whole_call() -> None:
    """The errors over several spans are larger; and where one of two settings beside the target has no time, nothing is said."""
    own = _rows("one", [1e-2, 1e-4, 1e-6], [1.0, 4.0, 16.0])
    own["more_seconds"] = own["seconds_median"].map(lambda seconds: seconds / 4 if seconds < 10 else math.nan)
    longer = _rows("one", [1e-1, 1e-3, 1e-5], [16.0, 64.0, 256.0], variant=LONGER)
    frame = analysis.own_spans(pd.concat([own, longer]))
    assert len(frame) == len(own)
    equal = analysis.equal_error(frame, targets=[1e-3, 1e-5])
    assert equal["seconds"].tolist() == pytest.approx([2.0 * 1.05, 8.0 * 1.05], rel=2e-3)
    assert equal["more_seconds"].tolist() == pytest.approx([0.5 * 1.05, math.nan], rel=2e-3, nan_ok=True)
    (more,) = analysis.one_more_period(equal).to_dict("records")
    assert (more["low"], more["high"], more["launches"]) == (pytest.approx(0.5), pytest.approx(0.55), 2)
    assert more["null_share"] == 0.0


def test_the_difference_of_two_times_scatters_by_no_more_than_its_bound() -> None:
    """Simulated at the least ratio that is used, where the bound is within 3 %; at larger ones it is wider."""
    scatter, numbers = 0.02, np.random.default_rng(1)
    one, other = (np.exp(scatter * numbers.standard_normal(40_000)) for _ in range(2))
    for ratio, least in ((reading.APART, 0.95), (4.0, 0.0)):
        found = np.std(np.log(ratio * one - other)) / scatter
        assert least * reading.MORE_SCATTER < found < 1.02 * reading.MORE_SCATTER


@pytest.mark.parametrize("factor", [1.0, 2.0])
def test_one_more_period_has_wider_intervals_than_a_time(factor: float) -> None:
    """Of one more period in each launch a tenth apart: the interval is that of a scatter twice as large."""
    rows = [_rows(name, [1e-2, 1e-4], [seconds, seconds]) for name, seconds in (("a", 1.0), ("b", 1.4))]
    frame = pd.concat(rows)
    frame["more_seconds"] = frame["seconds_median"] * 3
    equal = analysis.equal_error(frame, targets=[1e-3])
    given = rankings.scatter(frame)
    ranked_ = rankings.divisions(equal, {name: one.scaled(factor) for name, one in given.items()})
    later = rankings.one_more_period(equal, given)
    assert later["ratio"].tolist() == pytest.approx(ranked_["ratio"].tolist())
    width, wide = (float(np.log(each["high"] / each["low"]).max()) for each in (ranked_, later))
    assert (width == pytest.approx(wide)) == (factor == reading.MORE_SCATTER)
    assert width <= wide * (1 + 1e-12)


def test_if_a_launch_has_the_median_over_turned_starts_errors_of_launches_from_one_start_are_ignored() -> None:
    rows = _rows("x", [1e-3, 1e-5], [1.0, 2.0], launch=1, turned_starts=9, error_low=1e-6, error_high=1e-2)
    first = rows.iloc[:2].assign(launch=1)
    later = rows.iloc[:2].assign(launch=2, turned_starts=None, error_low=None, error_high=None, error_max=[1e-1, 1e-7])
    frame = analysis.tidy(pd.concat([first, later]))
    reduced = analysis.settings(frame)
    assert list(reduced["error_max"]) == [1e-3, 1e-5]
    best = analysis.trust(reduced).iloc[0]
    assert (best["best"], best["error_low"], best["error_high"], best["turned_starts"]) == (1e-5, 1e-6, 1e-2, 9)
    assert list(analysis.settings(analysis.tidy(later))["error_max"]) == [1e-1, 1e-7], "no launch has turned starts"


def test_times_of_several_machines_are_not_compared() -> None:
    """The machine that timed most of a problem's series counts; errors of the others stay."""
    errors, seconds = [1e-2, 1e-4, 1e-6], [1.0, 4.0, 16.0]
    mine = [_rows(name, errors, seconds) for name in ("A", "B")]
    fast = _rows("C", errors, [1e-3 * each for each in seconds], machine="faster")
    frame = analysis.one_machine(pd.concat([*mine, fast]))
    equal = analysis.equal_error(analysis.tidy(pd.concat([*mine, fast])), [1e-3])
    assert equal[["integrator_id", "machine"]].to_numpy().tolist() == [["l:A", "m"], ["l:B", "m"]]
    assert frame["error_max"].notna().all()
    elsewhere = fast.assign(case="d")  # another problem: its times are all of that machine
    assert len(analysis.equal_error(analysis.tidy(pd.concat([*mine, elsewhere])), [1e-3])) == 3


def test_a_model_hierarchy_compares_times_of_one_machine() -> None:
    """The time of a model over the time of the full case, for an integrator that ran both on the same machine."""
    reduced = pd.DataFrame({"case": ["c", "d"], "variant": "", "span": 1.0, "time_scale": 1.0})
    equal = pd.DataFrame({"case": ["c", "d"], "variant": "", "formulation": "", "target": 1e-6, "integrator_id": "l:A"})
    equal = equal.assign(seconds=[1.0, 2.0], machine="m")
    assert model_hierarchy.cost("c", "d", model_hierarchy.times_of(equal, reduced))["ratio"] == 2.0
    elsewhere = equal.assign(machine=["m", "another"])
    apart = model_hierarchy.cost("c", "d", model_hierarchy.times_of(elsewhere, reduced))
    assert math.isnan(apart["ratio"])
