"""diffrax: orders and errors, ensembles, and its messages where it fails."""

from math import atan2, hypot, sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters import diffrax
from gnomon.harness.adapters.diffrax import ENSEMBLE, INTEGRATORS, Dopri8, Tsit5
from gnomon.harness.contract.integrator import Problem, Refused, solver_of

pytest.importorskip("diffrax", reason="diffrax is optional")
TIMES = np.linspace(0.1, 6.4, 64)


def turning(t: Any, y: Any, p: Any) -> Any:
    return y[1], -p[0] * y[0]


def forced(t: Any, y: Any, p: Any) -> Any:
    """x'' = 2 - w^2 sin(w t) with x = t^2 + sin(w t): functions of numbers and of traced values, and a constant."""
    return y[1], 2 - p[0] ** 2 * sin(p[0] * t) + 0 * hypot(y[0], y[1]) + atan2(0.0, 1.0), 1


def escaping(t: Any, y: Any, p: Any) -> Any:
    return (y[0] * y[0],)


def sliding(t: Any, y: Any, p: Any) -> Any:
    return (1.0 if y[0] > 0 else -1.0,)


def problem(equations: Any, dimension: int, times: Any, parameters: Any = (1.0,)) -> Problem:
    return Problem(FirstOrder(equations), dimension, np.array(parameters), np.array(times), 1.0)


@pytest.mark.parametrize("kind", INTEGRATORS, ids=lambda kind: kind.name)
def test_the_error_follows_the_tolerance(kind: Any) -> None:
    exact = np.column_stack([np.cos(TIMES), -np.sin(TIMES)])
    errors = []
    for tolerance in (1e-4, 1e-9):
        found = solver_of(kind(), problem(turning, 2, TIMES), tolerance)(np.array([[1.0, 0.0]]))
        errors.append(float(np.max(np.abs(found.states[0] - exact))))
        assert errors[-1] < 300 * tolerance
        assert found.steps is not None
        assert found.steps > 5
    assert errors[1] < errors[0] / 100


def test_arithmetic_is_binary64_and_the_users_own_setting_stays() -> None:
    import jax

    before = jax.config.jax_enable_x64
    found = solver_of(Dopri8(), problem(turning, 2, TIMES), 1e-14)(np.array([[1.0, 0.0]]))
    assert np.max(np.abs(found.states[0, :, 0] - np.cos(TIMES))) < 1e-11  # binary32 leaves 1e-7
    assert jax.config.jax_enable_x64 == before


def test_only_the_start_is_converted_at_a_call(monkeypatch: pytest.MonkeyPatch) -> None:
    """Times, parameters and tolerances are arrays of JAX before the first call: it would convert them at each."""
    import jax

    seen: list[Any] = []
    original = diffrax.compile_solver

    def recording(*given: Any) -> Any:
        function = original(*given)
        return lambda *arguments: seen.append(arguments) or function(*arguments)

    monkeypatch.setattr(diffrax, "compile_solver", recording)
    solve = solver_of(Tsit5(), problem(turning, 2, TIMES), 1e-6)
    for start in ([1.0, 0.0], [0.5, 0.0]):
        solve(np.array([start]))
    (first, *rest), (second, *again) = seen
    assert [first[0], second[0]] == [1.0, 0.5]
    assert all(one is other and isinstance(one, jax.Array) for one, other in zip(rest, again, strict=True))
    assert [each.dtype for each in rest] == [np.float64] * 3


def test_functions_of_numbers_and_of_traced_values() -> None:
    found = solver_of(Dopri8(), problem(forced, 3, TIMES, [3.0]), 1e-11)(np.array([[0.0, 3.0, 0.0]]))
    exact = np.column_stack([TIMES**2 + np.sin(3 * TIMES), 2 * TIMES + 3 * np.cos(3 * TIMES), TIMES])
    assert found.states[0] == pytest.approx(exact, abs=1e-8)


def test_an_ensemble_has_the_states_of_each_alone() -> None:
    solve = solver_of(Tsit5(), problem(turning, 2, TIMES), 1e-8)
    starts = np.random.default_rng(3).normal(size=(ENSEMBLE, 2))
    together = solve(starts.copy())
    alone = [solve(start[None].copy()) for start in starts]
    assert together.states == pytest.approx(np.concatenate([each.states for each in alone]), abs=1e-12)
    assert together.steps == sum(each.steps or 0 for each in alone)
    assert together.stopped is None


def test_the_one_of_an_ensemble_that_fails_is_the_reason() -> None:
    """y' = y^2 from y0 > 0 is infinite at t = 1 / y0."""
    starts = np.full((ENSEMBLE, 1), -1.0)
    starts[5] = 1.0
    found = solver_of(Tsit5(), problem(escaping, 1, [0.5, 2.0]), 1e-6)(starts)
    assert np.isnan(found.states[5, 1, 0])
    assert np.delete(found.states, 5, axis=0)[:, 1, 0] == pytest.approx(-1 / 3, rel=1e-4)
    assert str(found.stopped).startswith("The maximum number of solver steps")


def test_samples_that_were_not_reached_are_nan_with_the_reason() -> None:
    """y' = y^2 from 1 is infinite at t = 1: steps get smaller up to their limit."""
    found = solver_of(Tsit5(), problem(escaping, 1, [0.5, 0.9, 2.0, 3.0]), 1e-6)(np.array([[1.0]]))
    assert found.states[0, :2, 0] == pytest.approx([2.0, 10.0], rel=1e-3)
    assert np.all(np.isnan(found.states[0, 2:]))
    assert "maximum number of solver steps" in str(found.stopped)


def test_a_start_that_is_not_finite_has_no_states() -> None:
    found = solver_of(Tsit5(), problem(turning, 2, TIMES), 1e-6)(np.array([[np.nan, 0.0]]))
    assert np.all(np.isnan(found.states))
    assert found.stopped is not None


def test_equations_that_branch_are_refused() -> None:
    with pytest.raises(Refused, match="branch on computed values"):
        Tsit5().prepare(problem(sliding, 1, TIMES), 1e-6)


def looked_up(t: Any, y: Any, p: Any) -> Any:
    return ({0.0: 1.0}[y[0]],)


def test_equations_that_raise_are_refused_with_what_they_raise() -> None:
    with pytest.raises(Refused, match="TypeError: unhashable"):
        Tsit5().prepare(problem(looked_up, 1, TIMES), 1e-6)
