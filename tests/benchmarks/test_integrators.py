"""Each in-house integrator on the simple pendulum (about 10 swings; Euler's top for the rotation-group methods)."""

from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.integrators.gauss import gauss
from gnomon.harness.integrators.geometric import lie, splitting
from gnomon.harness.integrators.multistep_extrapolation import extrapolation, stormer
from gnomon.harness.integrators.runge_kutta import dop853, explicit, explicit_pairs, nystrom

ADAPTIVE = (
    *explicit_pairs.INTEGRATORS, *dop853.INTEGRATORS, *nystrom.INTEGRATORS, *extrapolation.INTEGRATORS,
)  # fmt: skip
SMOOTH = (*explicit.INTEGRATORS, *splitting.INTEGRATORS, *gauss.INTEGRATORS, *stormer.INTEGRATORS, *ADAPTIVE)


def solve_repeatedly(benchmark: Any, method: type[Integrator], name: str) -> None:
    case = get(name).rounded()
    problem = problem_of(case, method.accepts)
    setting = 1e-9 if method.sweep.kind == "tolerance" else problem.interval / 32
    solve = method().prepare(problem, setting).solve
    start = initial_state(case)[None]
    solution = benchmark(solve, start)
    assert solution.stopped is None
    assert np.all(np.isfinite(solution.states))


@pytest.mark.parametrize("method", SMOOTH, ids=lambda method: method.name)
def test_pendulum(benchmark: Any, method: type[Integrator]) -> None:
    solve_repeatedly(benchmark, method, "pendulum_simple")


@pytest.mark.parametrize("method", lie.INTEGRATORS, ids=lambda method: method.name)
def test_rigid_body(benchmark: Any, method: type[Integrator]) -> None:
    solve_repeatedly(benchmark, method, "euler_top")


@pytest.mark.parametrize("method", [explicit.RK4, gauss.Gauss4, dop853.Dop853], ids=lambda method: method.name)
def test_preparation_with_warm_caches(benchmark: Any, method: type[Integrator]) -> None:
    problem = problem_of(get("pendulum_simple").rounded(), method.accepts)
    setting = 1e-9 if method.sweep.kind == "tolerance" else problem.interval / 32
    assert callable(benchmark(method().prepare, problem, setting))
