"""Messages about steps that do not divide and equations that fail. All methods: test_promises, test_bad_equations."""

from typing import Any

import numpy as np
import pytest
from bad_equations import scalar, squared, stiff, undefined
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.multistep_extrapolation.extrapolation import GraggBulirschStoer
from gnomon.harness.integrators.runge_kutta.dop853 import Dop853
from gnomon.harness.integrators.runge_kutta.explicit import RK4
from gnomon.harness.integrators.taylor.taylor import Taylor


def test_a_step_that_does_not_divide_the_interval() -> None:
    problem = problem_of(get("pendulum_simple").rounded(), RK4.accepts)
    for step, divisor in ((problem.interval / 2.6, problem.interval / 3), (problem.interval * 2, problem.interval)):
        with pytest.raises(Refused, match=rf"does not divide the sampling interval .*; {divisor!r} does$"):
            RK4().prepare(problem, step)
    RK4().prepare(problem, problem.interval / 3)


@pytest.mark.parametrize("method", [Dop853, GraggBulirschStoer])
def test_a_step_that_shrinks_on_the_way_to_infinity_ends_at_the_spacing_of_times(method: type[Integrator]) -> None:
    solution = method().prepare(scalar(squared), 1e-8)(np.array([[1.0]]))
    assert solution.stopped == "the step size fell below the spacing of times, before sample 33"


@pytest.mark.parametrize(
    ("method", "equations", "why"),
    [
        *((method, squared, "step size fell below the spacing of times") for method in (Radau5, Taylor)),
        *((method, undefined, "not finite") for method in (Radau5, Taylor)),
        *(
            (method, stiff, f"more than {most} steps")
            for method, most in ((Dop853, Dop853.most_steps), (Taylor, 5000000))
        ),
    ],
)
def test_adaptive_methods_end_with_their_reason(method: type[Integrator], equations: Any, why: str) -> None:
    """On stiff equations stability bounds the step of an explicit method: 3e7 would be needed."""
    solution = method().prepare(scalar(equations), 1e-8)(np.array([[1.0]]))
    assert why in str(solution.stopped)
    assert "before sample" in str(solution.stopped)
    assert np.isnan(solution.states[0, -1, 0])


def test_one_trajectory_that_fails_leaves_the_others() -> None:
    """x' = x^2 from -1 decays: x = -1 / (1 + t)."""
    problem = scalar(squared)
    solution = RK4().prepare(problem, 2.0**-9)(np.array([[1.0], [-1.0]]))
    assert np.isnan(solution.states[0, -1, 0])
    assert np.allclose(solution.states[1, :, 0], -1 / (1 + problem.times), rtol=1e-9)
