"""Step resonances are seen where theory predicts them; the nonlinear limit is that of the linear one on a linear chain."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import planted_methods
import pytest
from gnomon.harness.contract.integrator import Integrator, Steps
from gnomon.harness.registry import lookup
from gnomon.harness.scoring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.stability.resonance import fastest, resonance, runs, window_around
from gnomon.harness.verification.doors import from_step

from gnomon import cases

WITHIN = 0.03
"""Of the prediction, for order 3: the force of the nonlinear terms moves the frequency of a finite motion."""


def measured(integrator: Integrator, seconds: float = 1.0) -> dict[str, Any]:
    found = resonance.measured(integrator, seconds)
    assert "refused" not in found, found
    return found


def row_at(found: dict[str, Any], order: int, predicted: float) -> dict[str, Any]:
    """The row of this order and prediction of theory, to 1e-3."""
    (row,) = [
        row for row in found["resonances"]
        if row["order"] == order and row["predicted"] == pytest.approx(predicted, rel=1e-3)
    ]  # fmt: skip
    return row


def seen_near(row: dict[str, Any]) -> bool:
    low, high = (1 - WITHIN) * row["predicted"], (1 + WITHIN) * row["predicted"]
    return any(ends is not None and ends[0] <= high and ends[1] >= low for ends in row["seen"])


@pytest.mark.parametrize(
    ("identity", "predicted"),
    [
        ("gnomon:Störmer-Verlet", math.sqrt(3)),  # 2 - x^2 = 2 cos(2 pi/3)
        ("gnomon:Position Verlet", math.sqrt(3)),
        ("gnomon:Implicit midpoint", 2 * math.sqrt(3)),  # 2 atan(x/2) = 2 pi/3
        ("gnomon:Gauss 2-stage", 2.140937),  # (x/2)/(1 - x^2/12) = tan(pi/3)
        ("gnomon:Gauss 2-stage", 5.605038),  # the same, = tan(2 pi/3)
    ],
)
def test_a_resonance_of_order_3_is_seen_where_it_is_predicted(identity: str, predicted: float) -> None:
    row = row_at(measured(lookup.own()[identity], 2.0), 3, predicted)
    assert seen_near(row), row


def test_the_predictions_of_order_4_are_those_of_theory() -> None:
    assert row_at(measured(lookup.own()["gnomon:Störmer-Verlet"]), 4, math.sqrt(2))
    assert row_at(measured(lookup.own()["gnomon:Implicit midpoint"]), 4, 2.0)


def test_a_method_that_damps_has_no_resonance() -> None:
    assert measured(lookup.own()["gnomon:RK4"])["resonances"] == []


@pytest.mark.parametrize("name", ["Störmer-Verlet", "RK4"])
def test_the_linear_chain_fails_at_the_predicted_step(name: str) -> None:
    """From 1.00 to 1.05: just above the limit the growth in 2048 steps is too small to show."""
    found = measured(lookup.own()[f"gnomon:{name}"], 2.0)
    (row,) = [row for row in found["limits"] if row["nearly_linear"]]
    assert 1 / row["ratio_step"] <= row["ratio"] <= 1.05
    assert any("small_vibrations_3dof_chain" in text for text in resonance.sentences(found))


def test_the_fastest_frequency_of_the_pendulum_is_that_of_its_lowest_point() -> None:
    """J has the eigenvalues +-sqrt(-g/L cos theta), largest at theta = 0, which the samples of the motion come near."""
    case = cases.get("pendulum_simple").rounded()
    exact = reference_solution(CaseSpec.of(case)).exact
    lowest = np.cos(exact[:, 0])
    g, length = (float(value) for value in case.parameter_values())
    assert fastest(case, exact) == pytest.approx(math.sqrt(g / length * np.max(np.abs(lowest))), rel=1e-6)


def test_runs_of_points_are_found() -> None:
    window = window_around(2.0, 5)
    assert window[2] == 2.0
    assert runs(window, np.array([True, True, False, True, True])) == [window[:2].tolist(), window[3:].tolist()]
    assert runs(window, np.zeros(5, dtype=bool)) == []


def verlet(f: Any, t: float, q: Any, v: Any, h: float) -> tuple[Any, Any]:
    middle = v + h / 2 * f(t, q)
    q = q + h * middle
    return q, middle + h / 2 * f(t + h, q)


def longer(factor: float) -> Integrator:
    """Verlet whose every step is longer than it says: resonances come at smaller h w."""

    def step(f: Any, t: float, y: Any, h: float) -> Any:
        q, v = np.split(y, 2)
        return np.concatenate(verlet(f, t, q, v, factor * h))

    return from_step(step, name=f"longer {factor}", order=2, sweep=Steps(0.25, 10), accelerations=True)


def linearised(f: Any, t: float, y: Any, h: float) -> Any:
    """Verlet that drops the nonlinear part of small motions: no resonance is seen."""
    q, v = np.split(y, 2)
    small = 1e-6

    def force(t: float, q: Any) -> Any:
        scale = np.array([small, *([1.0] * (len(q) - 1))])
        return f(t, q * scale) / scale

    return np.concatenate(verlet(force, t, q, v, h))


def overflowing(f: Any, t: float, y: Any, h: float) -> Any:
    """Verlet that loses motions of amplitude 0.1: they escape far from any resonance."""
    q, v = np.split(y, 2)
    return np.concatenate(verlet(f, t, q, v, h)) * (np.nan if abs(q[0]) > 0.1 else 1.0)


def from_accelerations(step: Any, name: str) -> Integrator:
    return from_step(step, name=name, order=2, sweep=Steps(0.25, 10), accelerations=True)


def test_planted_faults_move_or_hide_a_resonance() -> None:
    """A right method first; then a step that is too long, a force without its nonlinear part, motions that are lost, a
    kick with the wrong sign, half a kick left out."""
    right = row_at(measured(planted_methods.verlet(), 0.2), 3, math.sqrt(3))
    assert seen_near(right)
    assert right["seen"][0] is None or right["seen"][0][1] < 1.05 * math.sqrt(3)
    long = measured(longer(1.05), 0.2)["resonances"]
    assert all(row["predicted"] != pytest.approx(math.sqrt(3), rel=1e-3) for row in long)
    hidden = row_at(measured(from_accelerations(linearised, "linearised"), 0.2), 3, math.sqrt(3))
    assert not any(hidden["seen"])
    lost = row_at(measured(from_accelerations(overflowing, "overflowing"), 0.2), 4, math.sqrt(2))
    assert lost["seen"][1][0] == pytest.approx(0.94 * math.sqrt(2), rel=1e-3)
    for fault in ("sign", "missing_half"):
        assert not any(
            row["predicted"] == pytest.approx(math.sqrt(3), rel=1e-3)
            for row in measured(planted_methods.verlet(fault), 0.2)["resonances"]
        )
