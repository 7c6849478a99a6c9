"""Integrators made of plain functions: counts, samples, settings, and where worker processes find them."""

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import planted_methods
import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Refused, Steps
from gnomon.harness.contract.problem import counting, initial_state, problem_of
from gnomon.harness.contract.validation import Unusable
from gnomon.harness.integrators.runge_kutta.explicit import RK4
from gnomon.harness.registry import lookup, references
from gnomon.harness.verification.function_adapter import from_name, from_solve, from_step, right_hand_side
from gnomon.harness.verification.functions.right_hand_side import RightHandSide

CASE = get("pendulum_simple").rounded()


def solved(integrator: Any, problem: Any, setting: float) -> Any:
    return integrator.prepare(problem, setting)(initial_state(CASE)[None])


def test_a_step_made_of_a_plain_function_is_the_method() -> None:
    """The in-house method has the same coefficients: 1024 steps differ by rounding, carried by the motion."""
    problem = problem_of(CASE, RK4.accepts)
    mine, theirs = (solved(one, problem, problem.interval / 16) for one in (planted_methods.good_rk4, RK4()))
    allowed = 2 * 1024 * float(np.max(CASE.conditioning(CASE.times)))
    assert np.max(CASE.metric.distance(mine.states[0], theirs.states[0])) < allowed
    assert mine.steps == theirs.steps == 16 * 64


def test_right_hand_sides_of_a_plain_f_are_counted() -> None:
    problem = counting(problem_of(CASE, RK4.accepts))
    solved(planted_methods.good_rk4, problem, problem.interval / 2)
    assert problem.buffer[-1] == 4 * 2 * 64


def test_samples_between_steps_are_reached_by_shorter_steps() -> None:
    """At samples off the grid the error is the method's error, 1e-6 here, not the error of a sample at a wrong time."""
    problem = problem_of(CASE, RK4.accepts)
    shifted = problem.times - 0.37 * problem.interval
    found = solved(planted_methods.good_rk4, replace(problem, times=shifted), problem.interval / 64)
    assert np.max(CASE.metric.distance(found.states[0], CASE.sample(shifted))) < 1e-5


def test_a_solver_gets_the_times_and_the_tolerance() -> None:
    given: list[Any] = []

    def solve(f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
        given.extend([t0, y0.tolist(), times.tolist(), tolerance])
        return [y0] * len(times)

    problem = problem_of(CASE, RK4.accepts)
    found = solved(from_solve(solve, name="constant"), problem, 1e-5)
    assert given == [0.0, initial_state(CASE).tolist(), problem.times.tolist(), 1e-5]
    assert np.all(found.states[0] == initial_state(CASE))
    assert found.steps is None


def test_an_answer_of_another_shape_names_both_shapes() -> None:
    problem = problem_of(CASE, RK4.accepts)
    transposed = from_solve(lambda f, t0, y0, times, tolerance: np.zeros((2, 64)), name="transposed")
    with pytest.raises(Unusable, match=r"shape \(2, 64\): .* shape \(64, 2\)"):
        solved(transposed, problem, 1e-5)
    answers = {"an array of shape (1,)": lambda y: y[:1], "None": lambda y: None, "(1, [2, 3])": lambda y: (1, [2, 3])}
    for given, answer in answers.items():  # of a step that returns a part, nothing, or rows without a shape
        mine = from_step(lambda f, t, y, h, answer=answer: answer(y), name="wrong")
        with pytest.raises(Unusable, match=f"returned {re.escape(given)}: .* shape \\(2,\\)"):
            solved(mine, problem, problem.interval)
    listed = from_step(lambda f, t, y, h: [x + h * slope for x, slope in zip(y, f(t, y), strict=True)], name="listed")
    assert np.all(np.isfinite(solved(listed, problem, problem.interval).states)), (
        "a list of the right length is a state"
    )


def test_arguments_in_another_order_name_the_right_order() -> None:
    """Of the step, of a call of f with positions and velocities, and of the function given to `from_step`."""
    problem = problem_of(CASE, RK4.accepts)
    swapped = from_step(lambda f, y, t, h: y + h * f(t, y), name="swapped")
    with pytest.raises(TypeError, match=r"f\(t, y\) takes .* \(\) and \(2,\), .* \(2,\) and \(\)"):
        solved(swapped, problem, problem.interval)
    with_velocities = RightHandSide(problem, velocities=True)
    assert with_velocities(0.0, np.array([0.5]), np.array([1.0])).shape == (1,)
    for arguments in ([np.array([0.5]), 0.0, np.array([1.0])], [0.0, np.array([0.5])], [0.0, 0.5, 1.0], [0.0]):
        with pytest.raises(TypeError, match=r"f\(t, q, v\) takes"):
            with_velocities(*arguments)
    with pytest.raises(TypeError, match=r"f\(t, y\) takes"):
        right_hand_side(problem)(0.0, np.zeros(2), 1.0)
    with pytest.raises(ValueError, match=r"three takes \(f, t, y\); a step takes \(f, t, y, h\)"):
        from_step(lambda f, t, y: y, name="three")  # type: ignore[misc]
    assert from_step(lambda f, t, y, h, jac, scale=1.0: y, name="more").name == "more"


def test_f_gives_accelerations_or_nan_where_the_equations_have_no_value() -> None:
    problem = problem_of(CASE, planted_methods.good_verlet.accepts)
    f = right_hand_side(problem)
    g, length = problem.parameters
    assert f(0.0, [0.5]) == f(0.0, np.array([0.5, 7.0])), "the positions are the first half of a whole state"
    assert f(0.0, [0.5]) == pytest.approx([-g / length * math.sin(0.5)], rel=1e-15)
    assert np.isnan(f(0.0, [math.inf])).all(), "math.sin(inf) raises"


@pytest.mark.parametrize("setting", [0.0, -1.0, math.nan, math.inf, 1e-300])
@pytest.mark.parametrize("integrator", planted_methods.GOOD, ids=lambda one: one.name)
def test_impossible_settings_are_refused(integrator: Any, setting: float) -> None:
    with pytest.raises(Refused, match=r"^(step size|tolerance) "):
        integrator.prepare(problem_of(CASE, integrator.accepts), setting)


def test_other_processes_find_it_by_its_name_in_its_module() -> None:
    found = references.dereference(references.reference(planted_methods.good_pair))
    assert found is planted_methods.good_pair
    assert lookup.from_path("planted_methods:good_verlet") is planted_methods.good_verlet


def test_a_named_function_with_other_arguments_is_told_the_right_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The way out is another function, and no other name for it."""
    monkeypatch.syspath_prepend(tmp_path)
    step = "def three(f, t, y):\n    return y\n"
    (tmp_path / "three_arguments.py").write_text(step)
    (tmp_path / "made_of_three.py").write_text(
        f"{step}\n\nfrom gnomon.verify import from_step\nmine = from_step(three, name='mine')\n"
    )
    for name, find in (("three_arguments:three", from_name), ("made_of_three:mine", lookup.from_path)):
        with pytest.raises(ValueError, match=r"takes \(f, t, y\); a step takes \(f, t, y, h\), a solver .*\)$"):
            find(name)


def test_a_wrong_declaration_is_refused_when_it_is_made() -> None:
    with pytest.raises(ValueError, match="order = 0"):
        from_step(lambda f, t, y, h: y, name="still", order=0)
    with pytest.raises(ValueError, match="sweep"):
        from_step(lambda f, t, y, h: y, name="still", sweep=Steps(coarsest=-1.0))
