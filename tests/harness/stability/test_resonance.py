"""Step resonances are seen where theory predicts them; nonlinear and linear limit are equal on a linear chain."""

import math
from typing import Any

import numpy as np
import planted_methods
import pytest
from gnomon.harness.contract.integrator import Integrator, Steps
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.registry import lookup
from gnomon.harness.stability.linear_problems import problem_for
from gnomon.harness.stability.resonance import (
    TRIALS,
    fastest,
    grows,
    predict,
    resonance,
    resonance_at,
    runs,
    try_below,
    window_around,
)
from gnomon.harness.stability.step_matrix import StepMatrix
from gnomon.harness.verification.function_adapter import from_step
from right_methods import verlet

from gnomon import cases

WITHIN = 0.03
"""A part of the prediction, for order 3: the force of the nonlinear terms moves the frequency of a finite motion."""


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
    return any(each is not None and each["from"] <= high and each["to"] >= low for each in row["seen"])


def predictions(method: Integrator, order: int = 3) -> list[float]:
    """h w at which a step turns the phase by a turn over `order`."""
    problem = problem_for(method)
    assert problem is not None
    return [x for found, x in predict(StepMatrix(method, problem)) if found == order]


@pytest.mark.parametrize(
    ("identity", "predicted"),
    [
        ("gnomon:Störmer-Verlet", math.sqrt(3)),  # 2 - x^2 = 2 cos(2 pi/3)
        ("gnomon:Position Verlet", math.sqrt(3)),
        ("gnomon:Implicit midpoint", 2 * math.sqrt(3)),  # 2 atan(x/2) = 2 pi/3
        ("gnomon:Gauss 2-stage", 2.140937),  # (x/2)/(1 - x^2/12) = tan(pi/3)
        ("gnomon:Gauss 2-stage", 5.605038),  # this expression = tan(2 pi/3)
    ],
)
def test_a_resonance_of_order_3_is_seen_where_it_is_predicted(identity: str, predicted: float) -> None:
    (x,) = [x for x in predictions(lookup.own()[identity]) if x == pytest.approx(predicted, rel=1e-3)]
    row = resonance_at(lookup.own()[identity], 3, x, 31)
    assert seen_near(row), row


def test_the_predictions_of_order_4_are_those_of_theory() -> None:
    """2 - x^2 = 0, and 2 atan(x/2) = pi/2."""
    assert predictions(lookup.own()["gnomon:Störmer-Verlet"], 4) == [pytest.approx(math.sqrt(2), rel=1e-3)]
    assert predictions(lookup.own()["gnomon:Implicit midpoint"], 4) == [pytest.approx(2.0, rel=1e-3)]


def test_a_method_that_damps_has_no_resonance() -> None:
    assert predictions(lookup.own()["gnomon:RK4"]) == []


@pytest.mark.parametrize("name", ["Störmer-Verlet", "RK4"])
def test_the_linear_chain_fails_at_the_predicted_step(name: str) -> None:
    """From 1.00 to 1.05: just above the limit the growth in 2048 steps is too small to show."""
    found = measured(lookup.own()[f"gnomon:{name}"])
    (row,) = [row for row in found["limits"] if row["linear"]]
    assert 1 / row["ratio_step"] <= row["ratio"] <= 1.05


CHAIN = "small_vibrations_3dof_chain"


@pytest.mark.parametrize(("name", "frequency"), [("RK4", math.sqrt(8)), ("Störmer-Verlet", 2.0)])
def test_a_recommended_step_is_below_the_first_limit_and_was_tried(name: str, frequency: float) -> None:
    """The fastest frequency of the chain is sqrt(2 + sqrt 2)."""
    found = measured(lookup.own()[f"gnomon:{name}"], 8.0)
    (row,) = [row for row in found["limits"] if row["trial"]]
    limit, up_to = frequency / math.sqrt(2 + math.sqrt(2)), row["trial"]["up_to"]
    assert 0.99 * limit < up_to < limit
    assert row["trial"] == {"up_to": up_to, "tried": TRIALS, "grows_at": None}
    (said,) = [text for text in resonance.sentences(found) if CHAIN in text]
    assert said.startswith(f"Use it on {CHAIN} up to h = {up_to:.3g}, below")
    untried = row | {"trial": row["trial"] | {"tried": TRIALS - 1}}
    assert not any(CHAIN in text for text in resonance.sentences(found | {"limits": [untried]}))


@pytest.mark.parametrize(
    ("name", "step"), [("Störmer-Verlet", 1.085), ("RK4", 1.535), ("Kahan-Li 8", 1.687), ("Blanes-Moan 4", 1.7135)]
)
def test_a_step_beyond_a_limit_or_in_a_tongue_grows(name: str, step: float) -> None:
    assert grows(lookup.own()[f"gnomon:{name}"], cases.get(CHAIN).rounded(), step)


@pytest.mark.parametrize(
    ("name", "wrong"), [("Störmer-Verlet", 1.1), ("RK4", 1.56), ("Kahan-Li 8", 2.21), ("Blanes-Moan 4", 2.75)]
)
def test_a_limit_that_is_too_high_is_caught_by_the_trial(name: str, wrong: float) -> None:
    """These are first steps that fail, on a grid of 2 % that jumps over tongues."""
    trial = try_below(lookup.own()[f"gnomon:{name}"], cases.get(CHAIN).rounded(), wrong, 60.0)
    assert trial["grows_at"] is not None
    row = {"case": CHAIN, "predicted": wrong, "trial": trial, "ratio": None}
    (said,) = resonance.sentences({"resonances": [], "scan": None, "limits": [row]})
    assert said.startswith(f"Not for {CHAIN} at h = ")


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


def longer(f: Any, t: float, y: Any, h: float) -> Any:
    """Verlet whose every step is longer than it says: resonances come at smaller h w."""
    return verlet(f, t, y, 1.05 * h)


def linearised(f: Any, t: float, y: Any, h: float) -> Any:
    """Verlet that drops the nonlinear part of small motions: no resonance is seen."""
    scale = np.array([1e-6, *([1.0] * (len(y) // 2 - 1))])
    return verlet(lambda t, q: f(t, q * scale) / scale, t, y, h)


def overflowing(f: Any, t: float, y: Any, h: float) -> Any:
    """Verlet that loses motions of amplitude 0.1: they escape far from any resonance."""
    return verlet(f, t, y, h) * (np.nan if abs(y[0]) > 0.1 else 1.0)


def from_accelerations(step: Any) -> Integrator:
    return from_step(step, name=step.__name__, order=2, sweep=Steps(0.25, 10), accelerations=True)


def test_planted_faults_move_or_hide_a_resonance() -> None:
    """A right method first; then a kick with the wrong sign, half a kick left out, a step that is too long, a force
    without its nonlinear part, motions that are lost."""
    near = pytest.approx(math.sqrt(3), rel=1e-3)
    assert predictions(planted_methods.verlet()) == [near]
    for method in (planted_methods.verlet("sign"), planted_methods.verlet("missing_half"), from_accelerations(longer)):
        assert near not in predictions(method)
    seen = [
        resonance_at(method, 3, math.sqrt(3), 5)["seen"]
        for method in (planted_methods.verlet(), from_accelerations(linearised), from_accelerations(overflowing))
    ]
    assert any(seen[0])
    assert not any(seen[1])
    assert seen[2][1] == {
        "from": pytest.approx(0.94 * math.sqrt(3)), "to": pytest.approx(1.06 * math.sqrt(3)),
        "factor": math.inf, "escapes": True,
    }  # fmt: skip


@pytest.mark.slow
def test_a_method_in_python_is_measured() -> None:
    found = measured(planted_methods.verlet(), 0.2)
    assert seen_near(row_at(found, 3, math.sqrt(3)))
    assert found["limits"]


def test_sentences_tell_resonances_from_other_escapes() -> None:
    seen = {"from": 1.69, "to": 1.76, "factor": None, "escapes": True}
    row = {"order": 3, "predicted": 1.732, "seen": [seen, None], "spacing": [1e-4, 1e-2]}
    scan = {"to": 2.0, "spacing": 1e-3, "escapes": [[1.69, 1.84], [1.9, 1.91], [1.98, 1.98]]}
    assert resonance.sentences({"resonances": [row], "scan": scan, "limits": []}) == [
        "Not for nonlinear vibrations at h w from 1.69 to 1.76: they escape"
        " (resonance of order 3, predicted at 1.732).",
        "Not for nonlinear vibrations at h w from 1.9 to 1.91, 1.98 to 1.98: they escape there too.",
    ]
    unseen = row | {"seen": [None, None]}
    (said,) = resonance.sentences({"resonances": [unseen], "scan": None, "limits": []})
    assert said.startswith("Use it at the predicted resonances h w = 1.732")
