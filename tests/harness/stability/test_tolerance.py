"""The panel of tolerances: known methods, planted faults of the step-size control, and its intervals."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from changed_methods import changed
from gnomon.cases.core.registry import get
from gnomon.harness.contract import validation
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.stability.subjects import Budget, trials_of
from gnomon.harness.stability.tolerance import (
    JUMPY,
    SENSITIVE,
    line,
    over_tolerance,
    proportionality,
    sensitivity,
    tolerance,
)
from gnomon.harness.verification.function_adapter import from_solve

SECONDS = 60.0
"""More than all tolerances and starts take: their number then does not depend on the machine."""


def row(integrator: Integrator, name: str = "pendulum_simple") -> dict[str, Any]:
    return proportionality(trials_of(integrator, name), SECONDS)


@pytest.fixture(autouse=True)
def fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gnomon.harness.stability.tolerance.MOST", 41)
    monkeypatch.setattr("gnomon.harness.stability.tolerance.STARTS_MOST", 20)


@cache
def right() -> dict[str, Any]:
    return row(changed())


def low_bits(y: Any) -> int:
    return int(np.abs(y[:1]).view(np.uint64)[0] % 8)


def test_the_right_pair_has_a_steady_line_and_no_sensitivity() -> None:
    found = right()
    assert 0.8 < found["slope_low"] <= found["slope_high"] < 1.2
    assert found["scatter_decades"] < 0.1
    assert found["ulps"] < 1.01


@pytest.mark.parametrize(
    ("change", "seen"),
    [
        (lambda tolerance, y: 1e-5, lambda row: abs(row["slope"]) < 0.1),
        (lambda tolerance, y: (1e-7 * tolerance) ** 0.5, lambda row: row["slope_high"] < 0.75),
        (lambda tolerance, y: 0.01 * tolerance * (tolerance / 1e-5) ** 0.7, lambda row: row["slope_low"] > 1.2),
        (lambda tolerance, y: 10.0 ** round(np.log10(tolerance)), lambda row: row["largest_jump"] > JUMPY),
        (lambda tolerance, y: max(tolerance, 1e-6), lambda row: row["scatter_decades"] > 0.08),
        (lambda tolerance, y: tolerance * 2.0 ** low_bits(y), lambda row: row["ulps"] > SENSITIVE),
    ],
    ids=["ignored", "square root", "too steep", "by decades", "bounded below", "from the last bits of the start"],
)
def test_each_planted_fault_of_the_control_is_seen(
    change: Callable[[float, Any], float], seen: Callable[[dict[str, Any]], bool]
) -> None:
    assert seen(row(changed(tolerance=change)))
    assert not seen(right())


def test_methods_that_choose_their_order_jump_and_a_pair_does_not() -> None:
    """Taylor's order follows from the tolerance, so its error jumps where that changes; the pair's order is 5 always."""
    steady, jumping = (
        row(find_one("gnomon:Dormand-Prince 5(4)")),
        row(find_one("gnomon:Taylor")),
    )
    assert steady["scatter_decades"] < 0.1 < jumping["scatter_decades"]
    assert steady["largest_jump"] < 2 < 5 < jumping["largest_jump"]


def test_the_sentences_name_the_numbers() -> None:
    jumping, pair = row(find_one("gnomon:Taylor")), find_one("gnomon:Dormand-Prince 5(4)")
    over = over_tolerance(pair, Budget(0.0))
    said = tolerance.sentences({"problems": {"pendulum_simple": jumping}, "over_tolerance": over})
    assert any(
        f"{jumping['largest_jump']:.3g} times" in text for text in said if text.startswith("Not for comparing runs")
    )
    assert any("times the tolerance 1e-06 in the median of 2 cases" in text for text in said)
    assert (over["tried"], over["of"] > 80) == (2, True)


def test_a_method_of_fixed_steps_is_not_measured() -> None:
    assert "not_applicable" in tolerance.measured(find_one("gnomon:RK4"), 1.0)


def test_a_method_that_raises_is_refused_with_its_reason() -> None:
    def solve(f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
        raise ZeroDivisionError("planted")

    found = tolerance.measured(from_solve(solve, name="raises", order=3), 0.01)
    rows = found["problems"].values()
    assert all(one["slope"] is None and "ZeroDivisionError: planted" in one["why"] for one in rows)
    assert any("ZeroDivisionError" in text for text in tolerance.sentences(found))


def test_the_derivative_by_the_start_is_that_of_the_exact_motion() -> None:
    """A start moved by 1e-4 of a size: the second derivative leaves 1e-8 times the growth over the span, squared."""
    case = get("pendulum_simple").rounded()
    moved = case.with_numbers([case.initial_state[0] + 2**-14, case.initial_state[1]], case.parameters)
    change = moved.sample(case.times) - case.sample(case.times)
    linear = sensitivity("pendulum_simple")[:, :, 0] * 2.0**-14
    assert np.max(np.abs(change - linear)) < 0.02 * np.max(np.abs(change))


def test_the_interval_of_a_slope_holds_it_though_neighbours_are_correlated() -> None:
    """Residuals that are sums over ten neighbours, as errors at near tolerances are: about 95 of 100 intervals hold."""
    rng, x = np.random.default_rng(3), np.linspace(-7, -5, 121)
    held = 0
    for _ in range(100):
        noise = np.convolve(rng.normal(size=130), np.ones(10) / 10, mode="valid")
        found = line(x, 0.8 * x + noise)
        held += found["slope_low"] <= 0.8 <= found["slope_high"]
    assert held >= 88


def test_a_method_that_does_not_move_is_refused() -> None:
    """The distance of the start from the exact motion follows no tolerance; it is not the error of a solution."""
    start = trials_of(changed(), "pendulum_simple").start
    still = changed(states=lambda found: np.broadcast_to(start, found.shape).copy())
    found = row(still)
    assert (found["slope"], found["why"]) == (None, validation.DID_NOT_MOVE)
