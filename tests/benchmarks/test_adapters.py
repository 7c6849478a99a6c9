"""Time of each SciPy, REBOUND and heyoka adapter on one problem: the cost of a library with its callbacks."""

from typing import Any

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.adapters import heyoka, rebound_nbody, rebound_ode, scipy_ivp, scipy_ode
from gnomon.harness.adapters.rebound_nbody import FixedSteps
from gnomon.harness.contract.integrator import Integrator, Tolerance
from gnomon.harness.contract.problem import counting, initial_state, problem_of

SMOOTH = (*scipy_ivp.INTEGRATORS, *scipy_ode.INTEGRATORS, *rebound_ode.INTEGRATORS, *heyoka.INTEGRATORS)


@pytest.mark.parametrize("integrator", SMOOTH, ids=lambda kind: kind().id)
def test_pendulum(benchmark: Any, integrator: type[Integrator]) -> None:
    """10.37 periods of the simple pendulum at tolerance 1e-6."""
    pytest.importorskip(integrator.library, reason=f"{integrator.library} is not installed")
    case = get("pendulum_simple").rounded()
    problem = problem_of(case, integrator.accepts)
    start = initial_state(case)[None]
    solution = benchmark(integrator().prepare(problem, 1e-6).solve, start)
    assert np.all(np.isfinite(solution.states))
    if integrator.counts_rhs:
        counted = counting(problem)
        integrator().prepare(counted, 1e-6)(start)
        benchmark.extra_info["rhs_calls"] = int(counted.buffer[-1])


@pytest.mark.parametrize("integrator", rebound_nbody.INTEGRATORS, ids=lambda kind: kind().id)
def test_kepler(benchmark: Any, integrator: type[Integrator]) -> None:
    """10.37 orbits at e = 0.6: tolerance 1e-9, or 64 steps between samples."""
    case = get("kepler_orbit").rounded()
    problem = problem_of(case, integrator.accepts)
    setting = problem.interval / 64 if issubclass(integrator, FixedSteps) else 1e-9
    assert issubclass(integrator, FixedSteps) != isinstance(integrator.sweep, Tolerance)
    solution = benchmark(integrator().prepare(problem, setting).solve, initial_state(case)[None])
    assert np.all(np.isfinite(solution.states))
    benchmark.extra_info["steps"] = solution.steps
