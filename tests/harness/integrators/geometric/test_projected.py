"""Explicit pairs with projection: constraints kept to round-off, errors that follow the tolerance."""

from typing import Any

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.integrators.geometric import projected
from gnomon.harness.integrators.runge_kutta.dop853 import Dop853
from on_cases import exact_states

METHODS = pytest.mark.parametrize("method", projected.INTEGRATORS, ids=lambda method: method.name)


def on_two_rods(method: Any, tolerance: float) -> tuple[Any, Any, Any]:
    """The double pendulum in Cartesian coordinates: states, their error, and the departure from rods and tangents."""
    case = get("double_pendulum").rounded()
    (formulation,) = case.formulations
    problem = problem_of(case, method.accepts, formulation)
    states = method().prepare(problem, tolerance)(initial_state(case, formulation)[None]).states[0]
    error = np.max(case.metric.distance(formulation.decode(states, problem.parameters), exact_states(case)))
    x1, y1, x2, y2, u1, v1, u2, v2 = states.T
    rods = (x1, y1, u1, v1), (x2 - x1, y2 - y1, u2 - u1, v2 - v1)
    off = max(np.max(np.abs(np.hypot(x, y) - 1)) for x, y, _, _ in rods)
    across = max(np.max(np.abs(x * u + y * v)) for x, y, u, v in rods)
    return float(error), float(off), float(across)


@METHODS
def test_rods_and_tangents_are_kept_at_every_sample_at_any_tolerance(method: Any) -> None:
    """The samples too, which an interpolant gives: it alone would leave the rods."""
    for tolerance in (1e-3, 1e-6, 1e-9):
        _, off, across = on_two_rods(method, tolerance)
        assert off < 8 * np.finfo(float).eps
        assert across < 128 * np.finfo(float).eps


@METHODS
def test_the_error_follows_the_tolerance_on_two_rods(method: Any) -> None:
    errors = [on_two_rods(method, tolerance)[0] for tolerance in (1e-6, 1e-9, 1e-12)]
    for error, tolerance in zip(errors, (1e-6, 1e-9, 1e-12), strict=True):
        assert error < 1e3 * tolerance


def test_without_projection_the_rods_drift() -> None:
    """The same pair on the equations of index 1: that the test above has something to find."""
    _, off, across = on_two_rods(Dop853, 1e-6)  # takes the equations of index 1 of the same formulation
    assert off > 1e-9
    assert across > 1e-9


@METHODS
def test_time_in_a_constraint_and_forces_of_velocities_are_taken(method: Any) -> None:
    """The car axis, whose road moves: its velocities are tangent in the sense of the moving constraint."""
    case = get("car_axis").rounded()
    problem = problem_of(case, method.accepts)
    states = method().prepare(problem, 1e-9)(initial_state(case)[None]).states[0]
    form, p = problem.form, problem.parameters
    first = form.constraint(0.0, tuple(case.initial_state[:4]), p)
    for t, state in zip(case.times, states, strict=True):
        held = form.constraint(t, tuple(state[:4]), p)
        rates = np.array(form.gradient(t, tuple(state[:4]), p)).reshape(2, 4) @ state[4:]
        rates = rates + np.array(form.constraint_rate(t, tuple(state[:4]), p))
        assert np.allclose(held, np.array(first, float), rtol=0, atol=1e-14)
        assert np.allclose(rates, 0, atol=1e-13)
    assert float(np.max(case.metric.distance(states, exact_states(case)))) < 1e-6
