"""Time of a step of PyBullet on a hinge and on a free body: times in the report are compared with these."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.adapters.engines.bullet.pybullet import PyBullet, PyBulletMaximal
from gnomon.harness.contract.problem import initial_state, problem_of

pytest.importorskip("pybullet", reason="pybullet has wheels up to CPython 3.11 only")

STEPS = 10_000


@pytest.mark.parametrize("policy", [PyBullet, PyBulletMaximal], ids=lambda kind: kind.policy)
@pytest.mark.parametrize("name", ["pendulum_simple", "euler_top"])
def test_step(benchmark: Any, name: str, policy: type[PyBullet]) -> None:
    case = get(name).rounded()
    problem = problem_of(case, PyBullet.accepts)
    dt = float(case.times[0]) * 64 / STEPS
    run = policy().prepare(replace(problem, times=np.array([STEPS * dt])), dt)
    try:
        solution = benchmark.pedantic(
            run.solve, (initial_state(case)[None],), setup=run.reset, rounds=5, warmup_rounds=1
        )
    finally:
        run.close()
    benchmark.extra_info["us_per_step"] = benchmark.stats.stats.median / STEPS * 1e6 if benchmark.stats else None
    assert solution.steps == STEPS
    assert np.all(np.isfinite(solution.states))
