"""The panel of digits: what a method loses beyond the problem, planted losses, and the horizon of a motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from changed_methods import changed
from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.stability import tiers
from gnomon.harness.stability.digits import calls_at, digits, hard_variants, horizon, lost
from gnomon.harness.stability.subjects import trials_of

HARD = ("pendulum_simple", "rotation")


def row(integrator: Integrator, seconds: float = 60.0) -> dict[str, Any]:
    return lost(trials_of(integrator, *HARD), seconds)


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
    data = {"variants": {"pendulum_simple/rotation": found}, "of": 1, "median": None, "complete": 0}
    assert digits.sentences(data) == []


def test_the_panel_counts_what_it_measured_and_says_what_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gnomon.harness.stability.digits.CASES", HARD[:1])
    found = digits.measured(find_one("gnomon:DOP853"), 0.5)
    assert 2 <= len(found["variants"]) <= found["of"] == 6  # with a chaotic one
    assert found["complete"] <= len(found["variants"])
    first = found["variants"]["pendulum_simple/rotation"]
    assert first["complete"]
    assert first["lost"] == pytest.approx(max(0.0, math.log10(first["error"] / first["conditioning"])))
    assert any("beyond those that the problem loses" in text for text in digits.sentences(found))


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
    said = digits.sentences({"variants": rows, "median": None, "complete": 0})
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
    assert found["complete"] >= 1
    assert digits.sentences(found)


def test_gravitating_and_rigid_bodies_have_cases_enough_for_the_tiers() -> None:
    for name in ("rebound:IAS15", "gnomon:RKMK 4"):
        assert len({case for case, _ in hard_variants(find_one(name))}) >= tiers.FEWEST


def test_a_solution_without_any_error_loses_no_digit() -> None:
    """A block that holds: its error is zero, which has no logarithm."""
    assert (
        lost(trials_of(find_one("gnomon:Moreau [time stepping]"), "block_incline_friction", "holds"), 5.0)["lost"] >= 0
    )


@pytest.mark.parametrize(
    ("points", "calls"),
    [
        ([(100, 1e-4), (400, 1e-8)], 200.0),
        ([(100, 1e-7)], 100.0),
        ([(100, 1e-4)], None),
        ([(None, 1e-9)], None),
    ],
)
def test_calls_at_an_error_are_between_settings_by_a_power_law(points: Any, calls: float | None) -> None:
    assert calls_at(points, 1e-6) == (None if calls is None else pytest.approx(calls))


def test_the_horizon_ends_at_the_first_error_above_a_tenth() -> None:
    errors = np.full(64, 1e-9)
    assert horizon(errors) == 1.0
    errors[48:50] = 0.2
    assert horizon(errors) == 0.75
    errors[:] = np.nan
    assert horizon(errors) == 0.0
