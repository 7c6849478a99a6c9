"""Boost's odeint: errors, samples, counts, derivatives in time, messages where it fails, the kept library."""

from math import cos, log, sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.registry import get
from gnomon.harness.adapters import odeint
from gnomon.harness.contract.integrator import Problem, Refused, solver_of
from gnomon.harness.contract.problem import counting
from gnomon.harness.registry import lookup
from on_cases import exact_states, solved

LACKING = lookup.missing(odeint.Dopri5())
pytestmark = pytest.mark.skipif(LACKING is not None, reason=str(LACKING))
each = pytest.mark.parametrize("kind", odeint.INTEGRATORS, ids=lambda kind: kind.name)


def turning(t: Any, y: Any, p: Any) -> Any:
    return y[1], -p[0] * y[0]


def stiff(t: Any, y: Any, p: Any) -> Any:
    """x relaxes to sin t, a million times faster than sin t changes."""
    return -1e6 * p[0] * (y[0] - sin(y[1])) + cos(y[1]), 1.0


def opaque(t: Any, y: Any, p: Any) -> Any:
    """A function that has no expression."""
    return (-p[0] * abs(y[0]),)


def ending(t: Any, y: Any, p: Any) -> Any:
    """Not finite from time 1/2 on."""
    return (-y[0] + 0 * log(1 / 2 - t),)


def problem(equations: Any, dimension: int, times: Any) -> Problem:
    return Problem(FirstOrder(equations), dimension, np.array([1.0]), np.array(times), 1.0)


def run(kind: Any, given: Problem, setting: float, start: Any) -> Any:
    return solver_of(kind(), given, setting)(np.array([start], dtype=float))


@each
def test_the_error_follows_the_tolerance(kind: Any) -> None:
    """Each step is allowed the tolerance twice, as the absolute and as the relative error, and a turn keeps errors."""
    times = np.linspace(3.2, 6.4, 3)
    exact = np.column_stack([np.cos(times), -np.sin(times)])
    errors = []
    for tolerance in (1e-4, 1e-9):
        found = run(kind, problem(turning, 2, times), tolerance, [1, 0])
        errors.append(float(np.max(np.abs(found.states[0] - exact))))
        assert errors[-1] < 2 * found.steps * tolerance
    assert errors[1] < errors[0] / 100


@each
def test_two_starts_are_two_motions(kind: Any) -> None:
    starts = np.array([[1.0, 0.0], [0.0, 1.0]])
    both = solver_of(kind(), problem(turning, 2, [0.7, 1.3]), 1e-9)(starts).states
    alone = [run(kind, problem(turning, 2, [0.7, 1.3]), 1e-9, start).states[0] for start in starts]
    assert np.array_equal(both, np.array(alone))


@each
@pytest.mark.parametrize("name", ["pendulum_simple", "kepler_orbit"])
def test_follows_the_exact_motion(kind: Any, name: str) -> None:
    """Each step is allowed the tolerance, and over ten revolutions phase errors grow by up to a thousand."""
    case = get(name).rounded()
    found = solved(kind(), case, 1e-9)
    assert np.max(np.abs(found.states - exact_states(case))) < 1e3 * found.steps * 1e-9


@each
def test_samples_that_were_not_reached_are_nan_with_the_reason(kind: Any) -> None:
    found = run(kind, problem(ending, 1, [0.2, 0.4, 0.8]), 1e-6, [1.0])
    assert found.states[0, :1, 0] == pytest.approx(np.exp([-0.2]), rel=1e-3)
    assert np.isnan(found.states[0, 2, 0])
    assert "not finite" in found.stopped


@each
def test_counts_are_those_of_right_hand_sides(kind: Any) -> None:
    plain = problem(turning, 2, np.linspace(0.1, 6.4, 64))
    counted = counting(plain)
    plain_run, counted_run = (run(kind, one, 1e-6, [1, 0]) for one in (plain, counted))
    assert plain.buffer[-1] == 0
    assert plain_run.steps == counted_run.steps
    assert counted.buffer[-1] >= counted_run.steps > 0


def test_stiff_equations_take_few_steps() -> None:
    """An explicit method needs a million."""
    times = np.linspace(0.05, 3.2, 64)
    found = run(odeint.Rosenbrock4, problem(stiff, 2, times), 1e-7, [0.0, 0.0])
    assert found.steps < 5000
    assert found.states[0, :, 0] == pytest.approx(np.sin(times), abs=1e-5)


def test_equations_without_derivatives_are_refused() -> None:
    with pytest.raises(Refused, match="dopri5"):
        solver_of(odeint.Rosenbrock4(), problem(opaque, 1, [1.0]), 1e-6)
