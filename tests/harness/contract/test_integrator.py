"""The results that `prepare` may return, and the start time of a problem."""

from dataclasses import replace
from typing import Any

import numpy as np
import planted
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Problem, Solution, Solver, solver_of
from gnomon.harness.contract.problem import counting, initial_state, problem_of
from gnomon.harness.integrators.runge_kutta.explicit import RK4

CASE = planted.Short().rounded()
PROBLEM = problem_of(CASE, (FirstOrder,))
LATE = replace(PROBLEM, times=PROBLEM.times + 3.25, t0=3.25)


class Returns(planted.Sound):
    """Its `prepare` returns a given object."""

    def __init__(self, found: Any) -> None:
        self.found = found

    def prepare(self, problem: Problem, setting: float) -> Any:
        return self.found


def solve(initial_states: Any) -> Solution:
    return Solution(initial_states[:, None])


def test_a_plain_function_becomes_a_solver() -> None:
    """README's integrator returns one."""
    solver = solver_of(Returns(solve), PROBLEM, 0.1)
    assert solver.solve is solve, "the function itself is timed"
    assert (solver.options, solver.reset, solver.close()) == ({}, None, None)
    assert solver(np.ones((2, 3))).states.shape == (2, 1, 3)


def test_attributes_of_a_function_are_read() -> None:
    called = []

    def engine(initial_states: Any) -> Solution:
        return solve(initial_states)

    vars(engine).update(
        options={"dt": 1}, reset=lambda: called.append("reset"), close=lambda: called.append("close"), other=3
    )
    solver = solver_of(Returns(engine), PROBLEM, 0.1)
    assert solver.reset is not None
    solver.reset()
    solver.close()
    assert (solver.options, called) == ({"dt": 1}, ["reset", "close"])


def test_a_solver_stays_what_it_is() -> None:
    solver = Solver(solve, {"dt": 1})
    assert solver_of(Returns(solver), PROBLEM, 0.1) is solver


@pytest.mark.parametrize("found", [None, 3, Solution(np.zeros((1, 1, 1)))])
def test_anything_else_is_named(found: Any) -> None:
    with pytest.raises(
        TypeError, match=r"prepare returned .*; let it return a function of initial states, or a Solver"
    ):
        solver_of(Returns(found), PROBLEM, 0.1)


def test_the_interval_is_that_of_the_times_since_the_start() -> None:
    assert LATE.uniform
    assert LATE.interval == PROBLEM.interval
    assert np.array_equal(LATE.elapsed, PROBLEM.times)
    assert not replace(LATE, t0=3.0).uniform


def test_from_a_late_start_right_hand_sides_are_counted_in_the_same_place() -> None:
    late = counting(LATE)
    RK4().prepare(late, late.interval / 2)(initial_state(CASE)[None])
    assert late.buffer[-1] == 4 * 2 * 64


def test_a_motion_that_starts_at_0_is_itself() -> None:
    """So nothing is compiled anew, and no bit changes."""
    assert PROBLEM.since_start() is PROBLEM
