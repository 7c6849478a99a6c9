"""A method on a case: its states at a setting, their distance from the exact motion, a fitted order, its calls of Python."""

import gc
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any
from unittest.mock import ANY

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.cases.core.case import Case
from gnomon.cases.core.formulation import Formulation
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator, SceneRun
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solution, solver_of
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.measuring.reference_solution import CaseSpec, find_kept


@cache
def exact_states(case: Case) -> Floats:
    """At the sample times, shape (64, dimension); once for a case. The states that come with gnomon are read, as long as
    the sources of the case and of its motion are those that made them: bodies that attract each other take seconds."""
    kept = find_kept(CaseSpec.of(case))
    return case.sample(case.times) if kept is None else kept.exact


def exact_state(case: Case, sample: int) -> Floats:
    """At one sample time, shape (dimension,)."""
    kept = find_kept(CaseSpec.of(case))
    return np.array(case.exact(case.times[sample].item()), dtype=float) if kept is None else kept.exact[sample]


@dataclass(frozen=True)
class Solved:
    """A solution that reached the end. Of several trajectories `states` and `error` are of the first."""

    case: Case
    problem: Problem
    solution: Solution

    @property
    def states(self) -> Floats:
        return self.solution.states[0]

    @property
    def steps(self) -> int:
        assert self.solution.steps is not None
        return self.solution.steps

    @property
    def calls(self) -> int:
        """The right-hand sides, where they are counted."""
        return int(self.problem.buffer[-1])

    @property
    def events(self) -> tuple[tuple[float, str], ...]:
        assert self.solution.events is not None
        return self.solution.events

    @property
    def error(self) -> float:
        """The largest distance at a sample, without the components that a formulation adds to the state."""
        states = self.states[:, : len(self.case.state)]
        return float(np.max(self.case.metric.distance(states, exact_states(self.case), self.case.times)))


def setting_of(method: Integrator, problem: Problem, tolerance: float, steps: float) -> float:
    """The setting of the method's kind: the tolerance, or the step size with so many steps from sample to sample."""
    return tolerance if method.sweep.kind == "tolerance" else problem.interval / steps


def solved(
    method: Integrator,
    case: Case,
    tolerance: float = 1e-9,
    steps: float = 64,
    formulation: Formulation | None = None,
    counted: bool = False,
) -> Solved:
    """At the tolerance or with the steps of `setting_of`."""
    problem = problem_of(case, method.accepts, formulation, counted)
    solver = solver_of(method, problem, setting_of(method, problem, tolerance, steps))
    solution = solver(initial_state(case, formulation)[None])
    assert solution.stopped is None
    return Solved(case, problem, solution)


def of_order(order: float | None) -> tuple[Any, Any]:
    """Equal to a fit of this order, to a tenth, to any number of points."""
    return pytest.approx(order, abs=0.1), ANY


@cache
def recorded(policy: type[SceneIntegrator]) -> dict[str, Any]:
    """Each option that an engine records on the scenes of the suite `engines`, as the last scene that has it does."""
    options: dict[str, Any] = {}
    for name in read_declared("running", "suites.toml")["engines"]["cases"]:
        case = get(*name.split("/")).rounded()
        if case.scene is None or policy().unsupported(case.scene) is not None:
            continue
        try:
            run = policy().prepare(problem_of(case, policy.accepts), float(case.times[0]))
        except Refused:
            continue
        assert isinstance(run, SceneRun)
        run.world.place(run.form.build(tuple(initial_state(case).tolist()), run.parameters))
        options |= run.options
        run.close()
    return options


def count_python_calls(function: Callable[..., Any], *arguments: Any) -> int:
    """The number of functions, of Python and of C, that Python calls in the second call of a function."""
    function(*arguments)
    calls = 0

    def count(frame: Any, event: str, called: Any) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    gc.disable()  # a collection would call finalizers of other objects here
    sys.setprofile(count)
    try:
        function(*arguments)
    finally:
        sys.setprofile(None)
        gc.enable()
    return calls
