"""IDA on constraints: its answer follows the tolerance, and satisfies both the constraints and their rates."""

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.contract.problem import initial_state, problem_of

pytest.importorskip("sksundae", reason="scikit-sundae is not installed: pip install 'gnomon[peers]'")

from gnomon.harness.adapters.sundials_constraints import IdaOnConstraints
from on_cases import exact_states


@pytest.mark.parametrize("name", ["slider_crank", "car_axis", "andrews_squeezer", "holonomic_constraint_dae"])
def test_the_error_follows_the_tolerance(name: str) -> None:
    """One constraint and several, masses of place, forces of velocities, time in a constraint: each enters the residual."""
    case = get(name).rounded()
    problem = problem_of(case, IdaOnConstraints.accepts)
    exact = exact_states(case)
    errors = []
    for tolerance in (1e-5, 1e-8, 1e-11):
        found = IdaOnConstraints().prepare(problem, tolerance)(initial_state(case)[None])
        assert found.stopped is None
        errors.append(float(np.max(case.metric.distance(found.states[0], exact))))
    assert errors[0] > 10 * errors[1] > 100 * errors[2]
    assert errors[2] < 1e-5


def test_starts_that_follow_each_other_do_not_change_each_other() -> None:
    """The values of the constraints belong to the start: rods of other lengths are kept at these lengths."""
    case = get("holonomic_constraint_dae").rounded()
    problem = problem_of(case, IdaOnConstraints.accepts)
    one = initial_state(case)
    other = np.concatenate([2 * one[:2], one[2:]])
    together = IdaOnConstraints().prepare(problem, 1e-8)(np.stack([one, other, one])).states
    assert np.array_equal(together[0], together[2])
    assert np.hypot(*together[1, -1, :2]) == pytest.approx(2 * np.hypot(*one[:2]), rel=1e-6)
