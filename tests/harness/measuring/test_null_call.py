"""The null call measures the cost of a call apart from the integration, without the time of steps."""

import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import planted
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Integrator, Problem, Solution, Steps, Tolerance
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.measuring import null_call, prepared
from gnomon.harness.measuring.null_call import SHRUNK

ENTRY, STEP = 1e-3, 2e-6
"""Simulated seconds of a call, and of each step in it."""
CALLS = 12
"""Right-hand sides of a step."""
CASE = planted.Short().rounded()


class Costs(Integrator):
    """Takes ENTRY for a call and STEP for each step, on a simulated clock; records the problems that it prepares."""

    name, library = "costs", "planted"
    accepts = (FirstOrder,)
    sweep = Steps()

    def __init__(self, clock: list[float]) -> None:
        self.clock = clock
        self.asked: list[tuple[float, float]] = []

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        self.asked.append((float(problem.times[-1]), setting))

        def solve(initial_states: Any) -> Solution:
            steps = self.steps(problem, setting)
            problem.buffer[-1] += CALLS * steps if problem.counted else 0
            self.clock[0] += ENTRY + STEP * steps
            return Solution(np.zeros((1, 64, 2)), steps)

        return solve

    def steps(self, problem: Problem, setting: float) -> int:
        return 64 * round(problem.interval / setting)


class Adapts(Costs):
    name = "adapts"
    sweep = Tolerance()

    def steps(self, problem: Problem, setting: float) -> int:
        return 64


class Uncounted(Adapts):
    name, counts_rhs = "uncounted", False


class Silent(Uncounted):
    """Says nothing about its steps."""

    name = "silent"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        solve = super().prepare(problem, setting)
        return lambda initial_states: Solution(solve(initial_states).states)


class Fails(Costs):
    name = "fails"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        raise ArithmeticError("planted")


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> Callable[[type[Costs]], tuple[float | None, int | None, Costs]]:
    clock = [0.0]
    monkeypatch.setattr(prepared, "perf_counter_ns", lambda: round(clock[0] * 1e9))

    def measure(kind: type[Costs]) -> tuple[float | None, int | None, Costs]:
        made = kind(clock)
        starts: Iterator[Any] = (np.full(2, float(k)) for k in itertools.count(1))

        def problem(*, counted: bool) -> Problem:
            return problem_of(CASE, (FirstOrder,), counted=counted)

        return *null_call.null_call(made, problem, 1e-3, starts), made

    return measure


def test_for_fixed_steps_the_time_of_the_steps_is_subtracted(measured: Any) -> None:
    found, work, made = measured(Costs)
    assert found == pytest.approx(ENTRY, rel=1e-6), "64 steps would add 13 %"
    assert work == 0
    interval = CASE.times[0] * SHRUNK
    assert made.asked == [(CASE.times[-1] * SHRUNK, interval), (CASE.times[-1] * SHRUNK, interval / 2)]


@pytest.mark.parametrize(("kind", "counted"), [(Adapts, 64 * CALLS), (Uncounted, 64), (Silent, None)])
def test_for_an_adaptive_method_the_work_of_its_steps_is_counted(
    measured: Any, kind: type[Costs], counted: int | None
) -> None:
    """In right-hand sides, or in steps where those are not counted; one that stops at samples takes 64 steps."""
    found, work, made = measured(kind)
    assert (found, work) == (pytest.approx(ENTRY + 64 * STEP, rel=1e-6), counted)
    assert set(made.asked) == {(CASE.times[-1] * SHRUNK, 1e-3)}


def test_a_method_that_fails_on_the_null_call_has_no_time_for_it(measured: Any) -> None:
    assert measured(Fails)[:2] == (None, None)
