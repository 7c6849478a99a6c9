"""SciPy's methods on the simple pendulum: they converge, count truthfully and say so where they give up."""

from __future__ import annotations

from dataclasses import replace
from math import log, sin
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from gnomon.cases.forms import FirstOrder, Values
from gnomon.cases.registry import get
from gnomon.harness.adapters import scipy_ivp, scipy_ode
from gnomon.harness.adapters.scipy_events import PROBE, Guard, set_latch
from gnomon.harness.integrator import Integrator, Problem, Refused
from gnomon.harness.problem import counting, initial_state, problem_of
from scipy.integrate import ode, solve_ivp

ALL = (*scipy_ivp.INTEGRATORS, *scipy_ode.INTEGRATORS)
every = pytest.mark.parametrize("integrator", ALL, ids=lambda kind: kind.name)
explicit = pytest.mark.parametrize("integrator", [scipy_ivp.RK45, scipy_ivp.DOP853], ids=lambda kind: kind.name)

CASE = get("pendulum_simple").rounded()
PROBLEM = problem_of(CASE, (FirstOrder,))
START = initial_state(CASE)[None]


def linear(t: Any, state: Values, parameters: Values) -> Values:
    """x'' = -k x."""
    x, v = state
    (k,) = parameters
    return v, -k * x


def linear_jacobian(t: Any, state: Values, parameters: Values) -> Values:
    (k,) = parameters
    return 0, 1, -k, 0


def hopeless(t: Any, state: Values, parameters: Values) -> Values:
    """Not finite from time 0.5 on, the start included where x starts below zero."""
    x, v = state
    (k,) = parameters
    return v, log(1 - 2 * t) - k * sin(x) + 0 * log(x)


def toy(equations: Any, jacobian: Any = None, counted: bool = False) -> Problem:
    times = np.arange(1, 65) / 16
    return Problem(FirstOrder(equations, jacobian), 2, np.array([1.0]), times, 1.0, counted)


@every
def test_converges_to_the_exact_motion(integrator: type[Integrator]) -> None:
    """1e3 steps (LSODA), each allowed rtol of a state of size 6: at most about 1e4 rtol."""
    exact = CASE.sample(CASE.times)
    errors = []
    for rtol in (1e-4, 1e-7, 1e-10):
        states = integrator().prepare(PROBLEM, rtol)(START).states[0]
        errors.append(float(np.abs(states - exact).max()))
    assert errors[0] > 10 * errors[1] > 100 * errors[2]
    assert errors[2] < 1e4 * 1e-10


@every
def test_many_trajectories_are_solved_one_by_one(integrator: type[Integrator]) -> None:
    starts = np.array([[0.1, 0.0], [2.0, 0.0], [0.5, 7.0]])
    solve = integrator().prepare(PROBLEM, 1e-6)
    together = solve(starts)
    assert together.states.shape == (3, 64, 2)
    for start, states in zip(starts, together.states, strict=True):
        assert np.array_equal(solve(start[None]).states[0], states)
    assert np.array_equal(starts, [[0.1, 0.0], [2.0, 0.0], [0.5, 7.0]])


@pytest.mark.parametrize("integrator", scipy_ivp.INTEGRATORS, ids=lambda kind: kind.name)
def test_counts_equal_scipys_own(integrator: type[scipy_ivp.SolveIvp]) -> None:
    problem = toy(linear, linear_jacobian, counted=True)
    integrator().prepare(problem, 1e-6)(np.array([[1.0, 0.0]]))
    options = {"jac": lambda t, y: np.array([[0.0, 1.0], [-1.0, 0.0]])} if integrator.takes_jacobian else {}
    own = solve_ivp(
        lambda t, y: np.array([y[1], -y[0]]),
        (0, problem.times[-1]),
        [1.0, 0.0],
        integrator.method,
        problem.times,
        rtol=1e-6,
        atol=1e-9,
        **options,
    )
    assert problem.buffer[-1] == own.nfev > 0


def test_right_hand_sides_for_a_numerical_jacobian_are_counted() -> None:
    with_jacobian, without = toy(linear, linear_jacobian, counted=True), toy(linear, counted=True)
    for problem in (with_jacobian, without):
        scipy_ivp.Radau().prepare(problem, 1e-6)(np.array([[1.0, 0.0]]))
    assert without.buffer[-1] > with_jacobian.buffer[-1]


def test_ode_counts_right_hand_sides_and_steps() -> None:
    """12 right-hand sides an accepted step, 11 a rejected one."""
    problem = counting(PROBLEM)
    solution = scipy_ode.Dop853().prepare(problem, 1e-8)(START)
    assert solution.steps is not None
    assert 64 <= solution.steps <= problem.buffer[-1] / 12


def test_ode_counts_the_steps_that_it_accepts() -> None:
    """As many as SciPy shows to a `solout`, which sees the start of each call too; others are tried and rejected."""
    case = get("kepler_orbit").rounded()
    problem = problem_of(case, (FirstOrder,))
    shown, tried = 0, 0

    def solout(t: float, y: Any) -> int:
        nonlocal shown
        shown += 1
        return 0

    solver = ode(scipy_ivp.right_hand_side_of(problem))
    solver.set_integrator("dop853", rtol=1e-6, atol=1e-12)
    solver.set_solout(solout)
    solver.set_initial_value(initial_state(case), 0.0)
    for time in problem.times.tolist():
        solver.integrate(time)
        tried += int(solver._integrator.iwork[17])
    steps = scipy_ode.Dop853().prepare(problem, 1e-6)(initial_state(case)[None]).steps
    assert steps == shown - 64
    assert steps < tried


def test_ode_takes_as_many_steps_as_it_needs() -> None:
    """Its own limit is 500 between two samples: 80 turns at 1e-12 need more."""
    problem = replace(toy(linear), times=np.array([512.0]))
    solution = scipy_ode.Dop853().prepare(problem, 1e-12)(np.array([[1.0, 0.0]]))
    assert solution.stopped is None
    assert solution.steps is not None
    assert solution.steps > 500
    assert solution.states[0, 0, 0] == pytest.approx(np.cos(512.0), abs=1e-9)


@every
def test_plain_run_leaves_the_count_alone(integrator: type[Integrator]) -> None:
    problem = toy(linear)
    integrator().prepare(problem, 1e-4)(np.array([[1.0, 0.0]]))
    assert problem.buffer[-1] == 0


@every
def test_a_right_hand_side_that_is_not_finite_ends_the_run(integrator: type[Integrator]) -> None:
    """Late: samples up to there are kept. At the start: left alone, RK45 and DOP853 would never return."""
    solve = integrator().prepare(toy(hopeless), 1e-6)
    late = solve(np.array([[1.0, 0.0]]))
    assert np.isnan(late.states[0, -1]).any()
    at_once = solve(np.array([[-1.0, 0.0]]))
    assert np.isnan(at_once.states[0]).any(axis=1).all()
    if integrator is not scipy_ivp.LSODA:
        assert late.stopped
        assert np.isfinite(late.states[0, :7]).all()
    assert at_once.stopped


def one_sided(t: Any, state: Values, parameters: Values) -> Values:
    """Not finite below x = -1/2."""
    x, v = state
    (k,) = parameters
    return v, 0 * log(x + 1 / 2) - k * sin(x)


@every
def test_a_trajectory_that_fails_is_told_whatever_becomes_of_the_others(integrator: type[Integrator]) -> None:
    solution = integrator().prepare(toy(one_sided), 1e-6)(np.array([[-1.0, 0.0], [0.25, 0.0]]))
    assert solution.stopped
    assert np.isnan(solution.states[0, -1]).any()
    assert np.isfinite(solution.states[1]).all()


@pytest.mark.parametrize("integrator", scipy_ivp.INTEGRATORS, ids=lambda kind: kind.name)
def test_a_tolerance_that_scipy_would_replace_is_refused(integrator: type[Integrator]) -> None:
    with pytest.raises(Refused, match=r"1e-14: .* 2\.2e-14"):
        integrator().prepare(PROBLEM, 1e-14)


def test_ode_says_where_and_why_it_gave_up() -> None:
    solution = scipy_ode.Dop853().prepare(toy(hopeless), 1e-6)(np.array([[1.0, 0.0]]))
    assert solution.stopped is not None
    assert "step size becomes too small at t = 0.5" in solution.stopped
    assert np.isfinite(solution.states[0, :7]).all()
    assert np.isnan(solution.states[0, 8:]).all()


@every
def test_settings_name_what_differs_from_the_defaults(integrator: type[Integrator]) -> None:
    solve = integrator().prepare(PROBLEM, 1e-5)
    assert solve.settings["rtol"] == 1e-5  # type: ignore[attr-defined]
    assert solve.settings["atol"] < 1e-5  # type: ignore[attr-defined]


@explicit
def test_samples_follow_the_given_times(integrator: type[Integrator]) -> None:
    uneven = replace(toy(linear), times=np.sqrt(np.arange(1, 65)))
    states = integrator().prepare(uneven, 1e-9)(np.array([[1.0, 0.0]])).states[0]
    assert states[:, 0] == pytest.approx(np.cos(uneven.times), abs=1e-7)


def latched(direction: int, place: float, speed: float, fired: bool, after_event: bool) -> float:
    """What a guard that is the place itself is seen as at the start of a segment."""
    guard = Guard(SimpleNamespace(direction=direction), lambda t, y, p: y[:1], np.zeros(0))  # type: ignore[arg-type]
    side = SimpleNamespace(equations=lambda t, y: np.array([speed]))
    y = np.array([place])
    set_latch(guard, side, 1.0, y, fired, after_event, PROBE)  # type: ignore[arg-type]
    assert guard(2.0, y) == place, "only at the start itself"
    return float(np.sign(guard(1.0, y)))


@pytest.mark.parametrize("direction", [-1, 1])
def test_a_guard_at_zero_where_a_segment_starts(direction: int) -> None:
    """Not yet crossed, sign -direction, or crossed already, sign direction."""
    before, crossed = -direction, direction
    at_the_start = {speed: latched(direction, 0.0, speed, False, False) for speed in (-1.0, 1.0)}
    assert at_the_start == {float(before): before, float(crossed): crossed}, "where the motion goes"
    assert latched(direction, 0.0, 1.0, False, True) == before
    assert latched(direction, 0.0, -1.0, True, True) == before
    assert latched(direction, crossed * 1e-17, 1.0, True, True) == before, "round-off of the event just located"
    assert latched(direction, crossed * 1e-17, 1.0, False, True) == crossed
    assert latched(direction, before * 1e-17, 1.0, True, True) == before
