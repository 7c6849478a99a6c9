"""GSL by its C interface: errors, samples, counts, derivatives in time, messages where it fails."""

from math import cos, log, sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.registry import get
from gnomon.harness.adapters import gsl
from gnomon.harness.contract.integrator import Problem, Refused, solver_of
from gnomon.harness.contract.problem import counting
from gnomon.harness.registry import lookup
from on_cases import exact_states, solved

LACKING = lookup.missing(gsl.Rkf45())
pytestmark = pytest.mark.skipif(LACKING is not None, reason=str(LACKING))
each = pytest.mark.parametrize("kind", gsl.INTEGRATORS, ids=lambda kind: kind.name)
newton = pytest.mark.parametrize("kind", [gsl.Bsimp, gsl.Msbdf], ids=lambda kind: kind.name)


def turning(t: Any, y: Any, p: Any) -> Any:
    return y[1], -p[0] * y[0]


def escaping(t: Any, y: Any, p: Any) -> Any:
    return (y[0] * y[0],)


def following(t: Any, y: Any, p: Any) -> Any:
    """x relaxes to sin t, a million times faster than sin t changes."""
    return (-1e6 * p[0] * (y[0] - sin(t)) + cos(t),)


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
    """Each step is allowed the absolute and the relative tolerance, 2 in all for a state of size 1, and a turn keeps errors."""
    times = np.linspace(3.2, 6.4, 2)
    exact = np.column_stack([np.cos(times), -np.sin(times)])
    errors = []
    for tolerance in (1e-4, 1e-9):
        found = run(kind, problem(turning, 2, times), tolerance, [1, 0])
        errors.append(float(np.max(np.abs(found.states[0] - exact))))
        assert errors[-1] < 2 * found.steps * tolerance
    assert kind is gsl.Bsimp or errors[1] < errors[0] / 100, (
        "extrapolation is more accurate than a loose tolerance asks"
    )


@each
def test_two_starts_are_two_motions(kind: Any) -> None:
    """The driver keeps steps and derivatives of the motion before: each motion begins as the first one of a driver."""
    solve = solver_of(kind(), problem(turning, 2, [0.7, 1.3]), 1e-9)
    starts = np.array([[1.0, 0.0], [0.0, 1.0]])
    alone = [solver_of(kind(), problem(turning, 2, [0.7, 1.3]), 1e-9)(start[None]).states[0] for start in starts]
    assert np.array_equal(solve(starts).states, np.array(alone))


@each
@pytest.mark.parametrize("name", ["pendulum_simple", "kepler_orbit", "forced_oscillator"])
def test_follows_the_exact_motion(kind: Any, name: str) -> None:
    """Each step is allowed the tolerance, and over ten revolutions phase errors grow by up to a thousand."""
    case = get(name).rounded()
    found = solved(kind(), case, 1e-11)
    assert np.max(np.abs(found.states - exact_states(case))) < 1e3 * found.solution.steps * 1e-11


@each
def test_samples_that_were_not_reached_are_nan_with_the_reason(kind: Any) -> None:
    found = run(kind, problem(ending, 1, [0.2, 0.4, 0.8]), 1e-6, [1.0])
    assert found.states[0, :2, 0] == pytest.approx(np.exp([-0.2, -0.4]), rel=1e-3)
    assert np.isnan(found.states[0, 2, 0])
    assert "not finite at t = 0." in found.stopped


@each
def test_a_motion_that_escapes_ends_with_a_reason(kind: Any) -> None:
    """y' = y^2 from 1 is infinite at t = 1; GSL gives up where a step no longer changes the time."""
    found = run(kind, problem(escaping, 1, [0.5, 0.9, 2.0]), 1e-6, [1.0])
    assert found.states[0, :2, 0] == pytest.approx([2.0, 10.0], rel=1e-2)
    assert np.isnan(found.states[0, 2, 0])
    assert "at t = 1" in found.stopped or "at t = 0.99" in found.stopped


@each
def test_counts_are_those_of_right_hand_sides(kind: Any) -> None:
    plain = problem(turning, 2, np.linspace(0.1, 6.4, 64))
    counted = counting(plain)
    plain_run, counted_run = (run(kind, one, 1e-6, [1, 0]) for one in (plain, counted))
    assert plain.buffer[-1] == 0
    assert plain_run.steps == counted_run.steps >= 64
    assert counted.buffer[-1] >= counted_run.steps


@each
def test_no_step_is_longer_than_the_longest(kind: Any) -> None:
    one = kind()
    one.max_step = 0.01
    found = solver_of(one, problem(turning, 2, [1.0, 2.0]), 1e-3)(np.array([[1.0, 0.0]]))
    assert found.steps >= 200


@newton
def test_stiff_equations_take_few_steps(kind: Any) -> None:
    """An explicit method needs a million."""
    times = np.linspace(0.05, 3.2, 64)
    found = run(kind, problem(following, 1, times), 1e-8, [0.0])
    assert found.steps < 5000
    assert found.states[0, :, 0] == pytest.approx(np.sin(times), abs=1e-6)


def test_time_may_be_a_component_of_the_state() -> None:
    """With the right df/dt a linearly implicit method takes the same steps either way; without, the error at 1e-2 changes."""

    def driven(t: Any, y: Any, p: Any) -> Any:
        return (-p[0] * y[0] + sin(9 * t),)

    def with_time(t: Any, y: Any, p: Any) -> Any:
        return -p[0] * y[0] + sin(9 * y[1]), 1.0

    times = [5.0]
    alone, both = (
        run(gsl.Bsimp, problem(f, len(at), times), 1e-2, at) for f, at in ((driven, [1]), (with_time, [1, 0]))
    )
    assert alone.steps == both.steps
    assert alone.states[0, :, 0] == pytest.approx(both.states[0, :, 0], rel=0, abs=1e-14)


@newton
def test_equations_without_derivatives_are_refused(kind: Any) -> None:
    with pytest.raises(Refused, match="msadams"):
        solver_of(kind(), problem(opaque, 1, [1.0]), 1e-6)


def test_a_closed_solver_is_not_called() -> None:
    """Its driver was freed: a call would read memory of others."""
    prepared = gsl.Rkf45().prepare(problem(turning, 2, [1.0]), 1e-6)
    prepared.close()
    with pytest.raises(RuntimeError, match="after close"):
        prepared.solve(np.array([[1.0, 0.0]]))
