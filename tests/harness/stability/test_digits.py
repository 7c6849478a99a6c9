"""The panel of digits: digits that a method loses beyond the problem, planted losses, and the horizon of a motion."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from changed_methods import changed
from gnomon.harness.contract import validation
from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.stability.digits import calls_at, count_lost, digits, hard_variants, horizon, levels_off
from gnomon.harness.stability.subjects import trials_of

HARD = ("pendulum_simple", "rotation")


def row(integrator: Integrator, seconds: float = 60.0) -> dict[str, Any]:
    return count_lost(trials_of(integrator, *HARD), seconds)


def planted(**change: Callable[..., Any]) -> Integrator:
    return changed("gnomon:DOP853", **change)


def declines(states: Any) -> Any:
    raise Refused("planted: it declines")


def test_the_right_method_loses_few_digits() -> None:
    found = row(planted())
    assert found["complete"]
    assert found["failed"] is None
    assert found["lost"] < 4


@pytest.mark.parametrize(
    ("change", "seen"),
    [
        ({"tolerance": lambda given, start: max(given, 1e-6)}, lambda row: row["lost"] > 5),
        ({"states": lambda found: found.astype(np.float32).astype(np.float64)}, lambda row: row["lost"] > 5),
        ({"states": lambda found: found * (1 + 1e-9)}, lambda row: row["lost"] > 4.5),
        ({"states": lambda found: found * np.nan}, lambda row: row["failed"] == "no setting has finite states"),
        ({"states": declines}, lambda row: row["failed"] == "planted: it declines"),
        ({"states": lambda found: found[:, :1].repeat(64, axis=1)}, lambda row: "smallest error" in row["failed"]),
    ],
    ids=["bounded tolerance", "single precision", "other units", "not finite", "declines", "does not move"],
)
def test_each_planted_loss_is_seen(change: dict[str, Any], seen: Callable[[dict[str, Any]], bool]) -> None:
    assert seen(row(planted(**change)))


def test_a_sweep_that_is_cut_for_time_is_no_failure() -> None:
    found = row(planted(), seconds=0.0)
    assert not found["complete"]
    assert found["settings"] == 1
    assert digits.sentences({"variants": {"pendulum_simple/rotation": found}, "of": 1}) == []


def test_the_panel_counts_what_it_measured_and_says_what_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gnomon.harness.stability.digits.CASES", HARD[:1])
    found = digits.measured(find_one("gnomon:DOP853"), 0.5)
    assert 2 <= len(found["variants"]) <= found["of"] == 6  # with a chaotic one
    first = found["variants"]["pendulum_simple/rotation"]
    assert first["complete"]
    assert first["lost"] == pytest.approx(max(0.0, math.log10(first["error"] / first["conditioning"])))


def hangs(states: Any) -> Any:
    while True:
        pass


def test_a_solve_without_end_is_stopped_and_the_other_settings_are_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    """SciPy's Radau takes steps of 1e-10 periods on an orbit of eccentricity 0.999999, for hours."""
    monkeypatch.setattr("gnomon.harness.stability.digits.SOLVE_SECONDS", 0.05)
    found = row(planted(states=hangs))
    assert found["failed"] == "no answer within 0.05 s of processor time"
    assert found["settings"] == found["of"]


def test_failures_are_told_together_each_reason_once() -> None:
    bad = {"complete": True, "lost": None, "horizon": 0.5, "horizon_of_problem": 1.0}
    rows: dict[str, Any] = {f"k/{n}": bad | {"error": 10.0**n, "failed": f"error {n}"} for n in range(3)}
    rows |= {f"p/{n}": {"complete": True, "lost": None, "failed": "it stopped"} for n in range(2)}
    rows["q/1"] = bad | {"lost": 0.0, "failed": None}
    said = digits.sentences({"variants": rows})
    assert said[-3:-1] == [
        "Not for k/0, k/1, k/2: its smallest errors are 1 to 1e+02.",
        "Not for p/0, p/1: it stopped.",
    ]
    assert "q/1 after 0.50 of its span" in said[-1]


def test_hard_variants_take_each_case_once_before_the_next_round() -> None:
    known = hard_variants(find_one("gnomon:DOP853"))
    cases = [name for name, _ in known]
    assert len(set(cases[: len(set(cases))])) == len(set(cases)) >= 7
    assert len(known) >= 29
    assert ("double_pendulum", "upright") in known[:10]
    assert not any("long" in variant or "engines" in variant for _, variant in known)


@pytest.mark.parametrize(
    "name", ["gnomon:Boris", "gnomon:RATTLE", "gnomon:Exponential Runge-Kutta 4", "gnomon:Moreau [time stepping]"]
)
def test_a_method_for_one_form_is_measured_on_hard_variants_of_that_form(name: str) -> None:
    found = digits.measured(find_one(name), 2.0)
    assert any(row["complete"] for row in found["variants"].values())


def test_a_method_that_does_not_move_is_refused() -> None:
    """The distance of the start from the exact motion is not the error of a solution."""
    start = trials_of(planted(), *HARD).start
    found = row(planted(states=lambda found: np.broadcast_to(start, found.shape).copy()))
    assert found["failed"] == validation.DID_NOT_MOVE


@pytest.mark.parametrize(
    ("errors", "seen"),
    [
        ([1e-4, 1e-8, 1e-12], False),  # its sweep ends there
        ([1e-4, 1e-8, 1e-12, 8e-13, 2e-12], True),
        ([1e-4, 1e-8, 1e-12, 9e-13, 4e-13], False),
        ([1e-12, 1e-12], False),  # too short to say
    ],
)
def test_a_sweep_levels_off_where_its_last_settings_do_not_halve_the_error(errors: list[float], seen: bool) -> None:
    assert levels_off(errors) is seen


def lost_at(value: float, levelled: bool) -> dict[str, Any]:
    return {"complete": True, "levelled": levelled, "failed": None, "lost": value, "horizon": 1.0,
            "horizon_of_problem": 1.0}  # fmt: skip


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (
            [lost_at(1.0, True)] * 5,
            "Use it on hard motions: it loses 1.0 digits in the median of 5 variants of 5 cases",
        ),
        ([lost_at(1.0, False)] * 5, "Use it on hard motions: it loses at most 1.0 digits"),
        ([lost_at(3.0, True)] * 5, "Not where each digit counts on hard motions: it loses 3.0 digits"),
        ([lost_at(3.0, False)] * 5, None),  # a sweep that goes on may lose none
        ([lost_at(1.0, True)] * 4, None),  # four cases
    ],
)
def test_digits_are_claimed_from_five_cases_on_and_where_sweeps_level_off(rows: Any, said: str | None) -> None:
    found = digits.sentences({"variants": {f"case{k}/hard": row for k, row in enumerate(rows)}})
    assert len(found) == (said is not None)
    assert said is None or found[0].startswith(said)
    same = digits.sentences({"variants": {f"case/hard{k}": row for k, row in enumerate(rows)}})
    assert same == [], "variants of one case are one system"


def test_a_solution_without_any_error_loses_no_digit() -> None:
    """A block that holds: its error is zero, which has no logarithm."""
    assert (
        count_lost(trials_of(find_one("gnomon:Moreau [time stepping]"), "block_incline_friction", "holds"), 5.0)["lost"]
        >= 0
    )


@pytest.mark.parametrize(
    ("points", "calls"),
    [
        ([(100, 1e-4), (400, 1e-8)], 200.0), ([(100, 1e-7)], 100.0), ([(100, 1e-4)], None), ([(None, 1e-9)], None),
    ],
)  # fmt: skip
def test_calls_at_an_error_are_between_settings_by_a_power_law(points: Any, calls: float | None) -> None:
    assert calls_at(points, 1e-6) == (None if calls is None else pytest.approx(calls))


def test_the_horizon_ends_at_the_first_error_above_a_tenth() -> None:
    errors = np.full(64, 1e-9)
    assert horizon(errors) == 1.0
    errors[48:50] = 0.2
    assert horizon(errors) == 0.75
    errors[:] = np.nan
    assert horizon(errors) == 0.0
