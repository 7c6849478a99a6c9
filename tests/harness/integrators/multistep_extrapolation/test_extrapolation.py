"""Extrapolation: each column has its order, the error follows the tolerance, the order follows it too."""

import numpy as np
import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.contract.problem import counting, initial_state, problem_of
from gnomon.harness.integrators.multistep_extrapolation.extrapolation import GraggBulirschStoer
from gnomon.harness.studies.fixed_step_formulas import with_columns
from gnomon.harness.studies.order_measurement import measure_order_exactly


@pytest.mark.parametrize(("count", "coarsest"), [(1, 96), (2, 48), (4, 24), (7, 24)])
def test_each_column_is_two_orders_better(count: int, coarsest: int) -> None:
    counts = [coarsest * n // 12 for n in (12, 16, 24, 32)]
    measured = measure_order_exactly(with_columns(count), get("kepler_orbit", span="0.5"), counts, digits=80)
    assert measured is not None
    assert measured[0] == pytest.approx(2 * count, abs=0.1), "the next term is smaller by the square of the step"


def test_the_order_follows_the_tolerance() -> None:
    """Right-hand sides a step: a third column at 1e-3, a seventh or more at 1e-13, and at most three times as many steps."""
    case = get("kepler_orbit").rounded()
    found = []
    for tolerance in (1e-3, 1e-13):
        problem = counting(problem_of(case, GraggBulirschStoer.accepts))
        solution = GraggBulirschStoer().prepare(problem, tolerance)(initial_state(case)[None])
        assert solution.steps is not None
        found.append((problem.buffer[-1] / solution.steps, solution.steps))
    assert found[0][0] < 25
    assert found[1][0] > 50
    assert found[1][1] < 3 * found[0][1]


def test_steps_follow_an_orbit_of_high_eccentricity() -> None:
    """At e = 0.99 the steps at pericentre are a thousandth of those at apocentre."""
    case = get("kepler_orbit", "speed_e099").rounded()
    problem = problem_of(case, GraggBulirschStoer.accepts)
    solution = GraggBulirschStoer().prepare(problem, 1e-13)(initial_state(case)[None])
    assert solution.stopped is None
    error = np.max(case.metric.distance(solution.states[0], case.sample(case.times)))
    assert error < 1e-13 * 1e7, "a hundred periods, and a conditioning near 1e-9"
