"""DOP853: the error follows the tolerance, samples do not change the steps, SciPy's takes as many right-hand sides."""

from dataclasses import replace

import numpy as np
import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.contract.problem import counting, initial_state, problem_of
from gnomon.harness.integrators.runge_kutta.dop853 import Dop853
from scipy.integrate import solve_ivp


@pytest.mark.parametrize("name", ["pendulum_simple", "kepler_orbit", "euler_top"])
def test_the_error_follows_the_tolerance(name: str) -> None:
    """Over six decades of tolerance the error, of order 8 where the estimate is of 7, falls by six to seven."""
    case = get(name).rounded()
    problem, exact = problem_of(case, Dop853.accepts), case.sample(case.times)
    errors = []
    for tolerance in (1e-6, 1e-12):
        solution = Dop853().prepare(problem, tolerance)(initial_state(case)[None])
        assert solution.stopped is None
        errors.append(np.max(case.metric.distance(solution.states[0], exact)))
    assert 1e-9 < errors[1] / errors[0] < 1e-5
    assert errors[1] < 1e-12 * 1e4, "ten periods, errors growing with the square of time"


def test_samples_do_not_change_the_steps() -> None:
    case = get("pendulum_simple").rounded()
    problem = problem_of(case, Dop853.accepts)
    few = replace(problem, times=problem.times[-1:].copy())
    both = [Dop853().prepare(p, 1e-10)(initial_state(case)[None]) for p in (problem, few)]
    assert both[0].steps == both[1].steps
    assert np.array_equal(both[0].states[0, -1], both[1].states[0, -1])


def test_dense_output_is_as_good_as_the_steps() -> None:
    """At some ten times in each step the error is at most twice that at 64 samples over the same growth."""
    case = get("pendulum_simple").rounded()
    problem = problem_of(case, Dop853.accepts)
    times = np.linspace(0.0, float(case.times[-1]), 4097)[1:]
    solution = Dop853().prepare(replace(problem, times=times), 1e-10)(initial_state(case)[None])
    errors = case.metric.distance(solution.states[0], case.sample(times))
    coarse = case.metric.distance(solution.states[0, 63::64], case.sample(times[63::64]))
    assert np.max(errors) < 2 * np.max(coarse)


def test_work_is_that_of_scipy_at_the_same_tolerance() -> None:
    """The controllers differ (PI here, I in SciPy), the formulas and the norm do not: within a fifth."""
    case = get("kepler_orbit").rounded()
    problem = counting(problem_of(case, Dop853.accepts))
    Dop853().prepare(problem, 1e-9)(initial_state(case)[None])
    equations = problem.form.equations  # type: ignore[union-attr]
    parameters = tuple(problem.parameters.tolist())
    scipy = solve_ivp(
        lambda t, y: equations(t, tuple(y.tolist()), parameters),
        (0.0, problem.times[-1]),
        initial_state(case),
        method="DOP853",
        rtol=1e-9,
        atol=1e-9,
    )
    extra = 3 * len(problem.times)  # stages of the dense output, in steps that hold samples
    assert 0.8 * scipy.nfev < problem.buffer[-1] < 1.2 * scipy.nfev + extra
