"""The panel of digits: what a method loses beyond the problem, planted losses, and the horizon of a motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gnomon.harness.contract.integrator import Integrator, Refused, Tolerance
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.stability.digits import calls_at, hard_variants, horizon, lost, sentences
from gnomon.harness.stability.panel import PANELS
from gnomon.harness.stability.subjects import trials_of
from gnomon.harness.verification.doors import from_solve
from scipy.integrate import solve_ivp

HARD = ("pendulum_simple", "rotation")


def integrated(f: Any, t: float, y: Any, times: Any, tolerance: float) -> Any:
    found = solve_ivp(f, (t, times[-1]), y, "DOP853", times, rtol=max(tolerance, 3e-14), atol=1e-3 * tolerance)
    return found.y.T


def made(change: Callable[..., Any]) -> Integrator:
    def solve(f: Any, t: float, y: Any, times: Any, tolerance: float) -> Any:
        return change(f, t, y, times, tolerance)

    return from_solve(solve, name="planted", order=8, sweep=Tolerance(1e-6, 1e-12), dense_order=7)


def row(change: Callable[..., Any], seconds: float = 60.0) -> dict[str, Any]:
    return lost(trials_of(made(change), *HARD), seconds)


def declines(f: Any, t: float, y: Any, times: Any, tolerance: float) -> Any:
    raise Refused("planted: it declines")


def test_the_right_method_loses_few_digits() -> None:
    found = row(integrated)
    assert found["complete"]
    assert found["failed"] is None
    assert found["lost"] < 4
    assert 500 < found["calls"] < 20_000


@pytest.mark.parametrize(
    ("change", "seen"),
    [
        (lambda f, t, y, ts, tol: integrated(f, t, y, ts, max(tol, 1e-7)), lambda row: row["lost"] > 5),
        (lambda *given: integrated(*given).astype(np.float32).astype(np.float64), lambda row: row["lost"] > 5),
        (lambda f, t, y, ts, tol: integrated(f, t, y, ts * (1 + 1e-9), tol), lambda row: row["lost"] > 4.5),
        (lambda *given: integrated(*given) * np.nan, lambda row: row["failed"] == "no setting has finite states"),
        (declines, lambda row: row["failed"] == "planted: it declines"),
        (lambda f, t, y, ts, tol: np.tile(y, (64, 1)), lambda row: "smallest error" in row["failed"]),
    ],
    ids=["bounded tolerance", "single precision", "wrong clock", "not finite", "declines", "stands still"],
)
def test_each_planted_loss_is_seen(change: Callable[..., Any], seen: Callable[[dict[str, Any]], bool]) -> None:
    assert seen(row(change))


def test_a_sweep_that_is_cut_for_time_is_no_failure() -> None:
    found = row(integrated, seconds=0.0)
    assert not found["complete"]
    assert found["settings"] == 1
    data = {"variants": {"pendulum_simple/rotation": found}, "of": 1, "median": None, "complete": 0}
    assert sentences(data) == []


def test_the_panel_counts_what_it_measured_and_says_what_is_lost() -> None:
    found = PANELS["digits"].measured(find_one("gnomon:DOP853"), 0.5)
    assert len(found["variants"]) >= 2
    assert found["complete"] <= len(found["variants"]) <= found["of"]
    first = found["variants"]["kepler_orbit/e09"]
    assert first["lost"] == pytest.approx(max(0.0, math.log10(first["error"] / first["conditioning"])))
    assert any("beyond those that the problem loses" in text for text in PANELS["digits"].sentences(found))


def test_hard_variants_take_each_case_once_before_the_next_round() -> None:
    known = hard_variants(find_one("gnomon:DOP853"), False)
    cases = [name for name, _ in known]
    assert len(set(cases[: len(set(cases))])) == len(set(cases)) >= 7
    assert len(known) >= 29
    assert not any("long" in variant or "engines" in variant for _, variant in known)


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
