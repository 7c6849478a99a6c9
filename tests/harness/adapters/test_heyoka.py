"""heyoka on the pendulum and on Kepler's orbit; runs where the optional extra `peers` is installed."""

import re
from math import atan2, hypot, log, sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.arithmetic import calling
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.cases.core.registry import get
from gnomon.cases.orbits.kepler_orbit import KeplerOrbit
from gnomon.harness.adapters.heyoka import INTEGRATORS, FastTaylor, Taylor, system
from gnomon.harness.contract.integrator import Problem, Refused, Unsupported
from gnomon.harness.contract.problem import initial_state, problem_of
from on_cases import exact_states, solved

from gnomon import solve

heyoka = pytest.importorskip("heyoka", reason="heyoka is optional: pip install 'gnomon[peers]'")


def forced(t: Any, state: Values, parameters: Values) -> Values:
    """x'' = 2 - w^2 sin(w t), with x = t^2 + sin(w t) from (0, w)."""
    _x, v = state
    (w,) = parameters
    return v, 2 - w * w * sin(w * t)


def tilted(t: Any, state: Values, parameters: Values) -> Values:
    """x'' = sin(w) + atan2(x, 1) - atan2(x, 1): functions of numbers, and of both."""
    x, v = state
    (w,) = parameters
    return v, sin(w) + atan2(x, 1.0) - atan2(x, 1.0)


def constant(t: Any, state: Values, parameters: Values) -> Values:
    return 1, 0.5


def lost(t: Any, state: Values, parameters: Values) -> Values:
    """Not finite from time 0.5 on."""
    x, v = state
    return v, 0 * x + log(1 / 2 - t)


def distance(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    return v, -hypot(x, v)


def toy(equations: Any) -> Problem:
    return Problem(FirstOrder(equations), 2, np.array([3.0]), np.arange(1, 65) / 16, 1.0)


def falling(t: Any, state: Values, parameters: Values) -> Values:
    """One variable: y' = -w y."""
    (y,) = state
    (w,) = parameters
    return (-w * y,)


every = pytest.mark.parametrize("policy", INTEGRATORS, ids=lambda kind: kind.policy or "as it comes")


@every
def test_a_state_may_be_one_number(policy: type[Taylor]) -> None:
    """heyoka's `make_vars` of one name gives no list."""
    problem = Problem(FirstOrder(falling), 1, np.array([3.0]), np.arange(1, 65) / 16, 1.0)
    states = policy().prepare(problem, 1e-14)(np.array([[2.0]])).states[0]
    assert states[:, 0] == pytest.approx(2 * np.exp(-3 * problem.times), rel=1e-12)


@every
def test_the_options_recorded_are_the_options_used(policy: type[Taylor], monkeypatch: pytest.MonkeyPatch) -> None:
    """For the integrator of one trajectory and the integrators of an ensemble, as heyoka reports the options."""
    made: list[Any] = []
    for name in ("taylor_adaptive", "taylor_adaptive_batch"):
        original = getattr(heyoka, name)
        monkeypatch.setattr(heyoka, name, lambda *a, _make=original, **k: made.append(_make(*a, **k)) or made[-1])
    solve = policy().prepare(toy(forced), 1e-7)
    solve(np.tile([0.0, 3.0], (16, 1)))
    recorded: Any = solve.options
    assert recorded["tol"] == 1e-7
    assert [one.tol for one in made] == [1e-7] * 2
    assert [one.llvm_state.fast_math for one in made] == [recorded.get("fast_math", False)] * 2
    assert recorded.get("fast_math", False) == (policy is FastTaylor)


@every
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_follows_the_pendulum(policy: type[Taylor], tolerance: float) -> None:
    """Some 300 steps, each allowed the tolerance relative to a state of size 6, phase errors growing linearly."""
    case = get("pendulum_simple").rounded()
    found = solved(policy(), case, tolerance)
    assert np.abs(found.states - exact_states(case)).max() < 1e3 * tolerance
    assert found.steps > 64


def test_takes_a_formulation_with_a_clock() -> None:
    case = KeplerOrbit().rounded()
    (sundman,) = case.formulations
    states = solved(Taylor(), case, 1e-15, formulation=sundman).states
    assert np.abs(states[:, :4] - exact_states(case)).max() < 1e-11
    assert np.abs(states[:, 4] - case.times).max() < 1e-11


@pytest.mark.parametrize("name", ["kepler_orbit", "equilateral_three_body", "tower_drop"])
def test_one_over_u_times_its_root_is_one_power_in_the_fast_policy(name: str) -> None:
    """The derivatives stay, to the rounding of a few operations, and no root is left."""
    problem = problem_of(get(name).rounded(), (FirstOrder,))
    plain, powers = ([derivative for _, derivative in system(problem, way)] for way in (False, True))
    assert "**0.5000" in str(plain)
    assert "**0.5000" not in str(powers)
    state = initial_state(get(name).rounded())
    variables = [variable for variable, _ in system(problem, False)]
    values = [heyoka.cfunc(each, variables)(state, time=0.0) for each in (plain, powers)]
    assert values[0] == pytest.approx(values[1], rel=1e-14)


def test_equations_may_depend_on_time() -> None:
    problem = toy(forced)
    states = Taylor().prepare(problem, 1e-14)(np.array([[0.0, 3.0]])).states[0]
    assert states[:, 0] == pytest.approx(problem.times**2 + np.sin(3 * problem.times), abs=1e-12)


def test_functions_may_be_of_numbers() -> None:
    problem = toy(tilted)
    states = Taylor().prepare(problem, 1e-14)(np.array([[0.0, 0.0]])).states[0]
    assert states[:, 0] == pytest.approx(sin(3) * problem.times**2 / 2, abs=1e-14)


def test_derivatives_may_be_numbers() -> None:
    problem = toy(constant)
    states = Taylor().prepare(problem, 1e-9)(np.array([[0.0, 0.0]])).states[0]
    assert states == pytest.approx(np.outer(problem.times, [1, 0.5]), rel=1e-15)


def test_trajectories_are_independent() -> None:
    case = get("pendulum_simple").rounded()
    solve = Taylor().prepare(problem_of(case, (FirstOrder,)), 1e-9)
    states = solve(np.array([[2.0, 0.0], [0.5, 7.0], [2.0, 0.0]])).states
    assert np.array_equal(states[0], states[2])
    assert np.array_equal(states[0], solve(np.array([[2.0, 0.0]])).states[0])
    assert not np.array_equal(states[0], states[1])


def test_the_reason_names_the_time_where_it_stopped() -> None:
    solution = Taylor().prepare(toy(lost), 1e-9)(np.array([[1.0, 0.0]]))
    assert solution.stopped is not None
    assert np.isfinite(solution.states[0, :7]).all()
    assert np.isnan(solution.states[0, 9:]).all()


def test_a_function_that_heyoka_lacks_is_refused() -> None:
    with pytest.raises(Refused, match="hypot"):
        Taylor().prepare(toy(distance), 1e-9)


def test_an_ensemble_in_batches_equals_single_trajectories() -> None:
    """To the tolerance, with the growth of a phase error over ten periods; 19 leave a batch that is not full."""
    case = get("pendulum_simple").rounded()
    solve = Taylor().prepare(problem_of(case, (FirstOrder,)), 1e-12)
    starts = np.column_stack([np.linspace(0.5, 2.5, 19), np.zeros(19)])
    together = solve(starts)
    assert together.stopped is None
    steps = 0
    for start, states in zip(starts, together.states, strict=True):
        alone = solve(start[None])
        assert np.abs(alone.states[0] - states).max() < 1e3 * 1e-12
        steps += alone.steps or 0
    assert together.steps == pytest.approx(steps, rel=0.05), "steps of a batch's lanes differ from those alone by few"


def test_steps_are_those_of_all_trajectories() -> None:
    case = get("pendulum_simple").rounded()
    solve = Taylor().prepare(problem_of(case, (FirstOrder,)), 1e-6)
    starts = np.array([[2.0, 0.0], [0.5, 0.0]])
    assert solve(starts).steps == sum(solve(start[None]).steps or 0 for start in starts)


def test_only_ensembles_compile_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    made, original = [], heyoka.taylor_adaptive_batch
    monkeypatch.setattr(heyoka, "taylor_adaptive_batch", lambda *a, **k: made.append(1) or original(*a, **k))
    solve = Taylor().prepare(toy(forced), 1e-6)
    solve(np.tile([0.0, 3.0], (15, 1)))
    assert not made
    for _ in range(2):
        solve(np.tile([0.0, 3.0], (16, 1)))
    assert len(made) == 1


def test_an_ensemble_reports_that_it_stopped() -> None:
    solution = Taylor().prepare(toy(lost), 1e-9)(np.tile([1.0, 0.0], (16, 1)))
    assert solution.stopped is not None
    assert np.isnan(solution.states[:, 9:]).all()


def with_abs(t: Any, state: Values) -> Values:
    x, v = state
    return v, -abs(x) * x


def one_sided(t: Any, state: Values) -> Values:
    x, v = state
    return v, -1.0 if x > 0 else 1.0


def equal_to_a_number(t: Any, state: Values) -> Values:
    x, v = state
    return v, 5.0 if x == 0.0 else -x


def true_of_a_number(t: Any, state: Values) -> Values:
    x, v = state
    return v, -x if v else -1.0


def looked_up(t: Any, state: Values) -> Values:
    x, v = state
    return v, {0.0: x}[v]


OPAQUE = {
    with_abs: "abs", one_sided: "x > 0", equal_to_a_number: "x == 0.0", true_of_a_number: "if v", looked_up: "[v]",
}  # fmt: skip


@every
@pytest.mark.parametrize("equations", OPAQUE, ids=lambda equations: equations.__name__)
def test_equations_without_an_expression_are_unsupported_by_name(policy: type[Taylor], equations: Any) -> None:
    """An expression of heyoka is true and unequal to every number: of two branches it would take one in silence."""
    with pytest.raises(Unsupported, match=re.escape(OPAQUE[equations])):
        solve(FirstOrder(calling(equations, "t, state", "alone")), (0, 1), [1.2, 0.0], policy(), rtol=1e-9)


def test_a_branch_on_a_parameter_is_taken() -> None:
    """heyoka is given the parameters as numbers."""
    found = solve(FirstOrder(signed), (0, 1), [2.0], Taylor(), rtol=1e-14, args=[-1.0])
    assert found.y[0, -1] == pytest.approx(2 * np.exp(-1), rel=1e-13)


def signed(t: Any, state: Values, parameters: Values) -> Values:
    (y,) = state
    (w,) = parameters
    return (w * y,) if w < 0 else (-w * y,)
