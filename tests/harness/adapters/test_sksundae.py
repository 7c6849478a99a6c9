"""CVODE through scikit-sundae: its order and errors, one sample, and what it says where it fails."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.sksundae import INTEGRATORS
from gnomon.harness.contract.integrator import Problem, solver_of

pytest.importorskip("sksundae", reason="scikit-sundae is optional")
each = pytest.mark.parametrize("kind", INTEGRATORS, ids=lambda kind: kind.name)


def turning(t: Any, y: Any, p: Any) -> Any:
    return y[1], -p[0] * y[0]


def escaping(t: Any, y: Any, p: Any) -> Any:
    return (y[0] * y[0],)


def problem(equations: Any, dimension: int, times: Any, parameters: Any = (1.0,)) -> Problem:
    return Problem(FirstOrder(equations), dimension, np.array(parameters), np.array(times), 1.0)


@each
def test_the_error_follows_the_tolerance(kind: Any) -> None:
    times = np.linspace(0.1, 6.4, 64)
    exact = np.column_stack([np.cos(times), -np.sin(times)])
    errors = []
    for tolerance in (1e-4, 1e-8):
        states = solver_of(kind(), problem(turning, 2, times), tolerance)(np.array([[1.0, 0.0]])).states[0]
        errors.append(float(np.max(np.abs(states - exact))))
        assert errors[-1] < 300 * tolerance
    assert errors[1] < errors[0] / 100


@each
def test_one_sample_is_the_state_there_and_not_a_step(kind: Any) -> None:
    states = solver_of(kind(), problem(turning, 2, [1.3]), 1e-9)(np.array([[1.0, 0.0], [0.0, 1.0]])).states
    turn = [[math.cos(1.3), -math.sin(1.3)], [math.sin(1.3), math.cos(1.3)]]
    assert states[:, 0] == pytest.approx(np.array(turn), abs=1e-6)


@each
def test_samples_that_were_not_reached_are_nan_with_the_reason(
    kind: Any, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """y' = y^2 from 1 is infinite at t = 1. Few steps are allowed, as else it takes ever smaller ones."""
    monkeypatch.setattr("gnomon.harness.adapters.sksundae.STEPS", 500)
    found = solver_of(kind(), problem(escaping, 1, [0.5, 0.9, 2.0, 3.0]), 1e-6)(np.array([[1.0]]))
    assert found.states[0, :2, 0] == pytest.approx([2.0, 10.0], rel=1e-3)
    assert np.all(np.isnan(found.states[0, 2:]))
    assert found.stopped is not None
    assert "max_num_steps" in found.stopped
    assert capfd.readouterr().err == ""


@each
def test_one_sample_that_was_not_reached_is_nan(kind: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two times CVODE returns its own steps, the last one where it stopped: not the state at the sample."""
    monkeypatch.setattr("gnomon.harness.adapters.sksundae.STEPS", 500)
    found = solver_of(kind(), problem(escaping, 1, [2.0]), 1e-6)(np.array([[1.0]]))
    assert np.all(np.isnan(found.states))
    assert found.stopped is not None
