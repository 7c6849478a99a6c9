"""Errors in a form are reported by every method that accepts it: which function, or before which sample it ended."""

import re
from typing import Any

import numpy as np
import pytest
from bad_forms import (
    BLOWING_UP,
    BRANCHING,
    RAISING,
    STARTS,
    STIFF,
    UNTIL_1,
    WRONG_LENGTH,
    bounce_nowhere,
    fall,
    flight,
    height_until_1,
)  # fmt: skip
from breadth import marks
from gnomon.cases.core.forms import FirstOrder, Hybrid
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Solution
from gnomon.harness.integrators.events.hybrid import EventRungeKutta
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.taylor.taylor import Taylor
from gnomon.harness.registry.lookup import own

ALL = [method for method in own().values() if ".integrators." in type(method).__module__]
EVENTS = [method for method in ALL if isinstance(method, EventRungeKutta)]
TIMES = np.arange(1, 65) * 0.0625


def solved(method: Integrator, form: Any, kind: type, start: tuple[float, ...] = ()) -> Solution:
    start = start or STARTS[kind]
    problem = Problem(form, len(STARTS[kind]), np.zeros(0), TIMES, 1.0)
    setting = 1e-6 if method.sweep.kind == "tolerance" else problem.interval / 8
    return method.prepare(problem, setting)(np.array([start], dtype=np.float64))


def pairs(forms: dict[type, Any], compiled: bool = False) -> list[Any]:
    """Every method with each kind of form that it accepts. Where forms are compiled GaussFast takes seconds for each:
    `make test` has its first-order forms alone."""
    return [
        pytest.param(
            method,
            kind,
            id=f"{method.id}-{kind.__name__}",
            marks=pytest.mark.slow
            if compiled and isinstance(method, GaussFast) and kind is not FirstOrder
            else marks(method),
        )
        for method in ALL
        for kind in method.accepts
        if kind in forms
    ]


@pytest.mark.parametrize(("method", "kind"), pairs(WRONG_LENGTH))
def test_a_function_of_the_wrong_length_is_named(method: Integrator, kind: type) -> None:
    for form, why in WRONG_LENGTH[kind]:
        with pytest.raises((ValueError, Refused), match=why):
            solved(method, form, kind)


@pytest.mark.parametrize(("method", "kind"), pairs(STARTS, compiled=True))
def test_initial_states_of_another_length_are_refused(method: Integrator, kind: type) -> None:
    """Compiled code would write past the end of its arrays."""
    with pytest.raises(ValueError, match=rf"initial states of shape .*; they must be \(n, {len(STARTS[kind])}\)"):
        solved(method, UNTIL_1[kind], kind, (*STARTS[kind], 1.0))


@pytest.mark.parametrize(("method", "kind"), pairs(RAISING))
def test_a_function_that_raises_is_refused(method: Integrator, kind: type) -> None:
    with pytest.raises((ValueError, Refused), match=r"(decay|swing)_or_raise raises an exception|must not branch"):
        solved(method, RAISING[kind], kind)


@pytest.mark.parametrize("equations", BRANCHING)
@pytest.mark.parametrize("method", [Taylor(), Radau5(), GaussFast()], ids=lambda method: method.name)
def test_methods_that_trace_equations_refuse_branches(method: Integrator, equations: Any) -> None:
    """Any comparison: if one were evaluated as false, the other branch would be missing from the equations."""
    with pytest.raises((ValueError, Refused), match="must not branch"):
        solved(method, FirstOrder(equations), FirstOrder)


@pytest.mark.parametrize(("method", "kind"), pairs(UNTIL_1, compiled=True))
def test_equations_that_end_on_the_way_end_the_trajectory_there(method: Integrator, kind: type) -> None:
    """The last sample of a finite state is that at t = 1 or, where a step cannot come so near, the one before."""
    solution = solved(method, UNTIL_1[kind], kind)
    assert "before sample" in str(solution.stopped)
    finite = np.all(np.isfinite(solution.states[0]), axis=1)
    assert 15 <= np.count_nonzero(finite) <= 16
    assert np.all(finite[:15])


@pytest.mark.parametrize(("method", "kind"), pairs(BLOWING_UP, compiled=True))
def test_a_state_that_becomes_infinite_ends_the_trajectory(method: Integrator, kind: type) -> None:
    """Explicit methods of fixed steps step past t = 0.5 and take a few steps more to overflow."""
    form, start = BLOWING_UP[kind]
    solution = solved(method, form, kind, start)
    assert "before sample" in str(solution.stopped)
    assert 6 <= np.count_nonzero(np.all(np.isfinite(solution.states[0]), axis=1)) <= 12


@pytest.mark.slow
@pytest.mark.parametrize(("method", "kind"), [p for p in pairs(STIFF) if p.values[0].sweep.kind == "tolerance"])
def test_stiff_equations_are_solved_or_given_up_after_so_many_steps(method: Integrator, kind: type) -> None:
    solution = solved(method, STIFF[kind], kind)
    if solution.stopped is None:
        assert np.all(np.isfinite(solution.states))
    else:
        assert re.match(r"more than \d+ steps.*before sample \d", solution.stopped)


@pytest.mark.parametrize("method", EVENTS, ids=lambda method: method.name)
def test_a_guard_that_is_not_a_number_ends_the_trajectory(method: Integrator) -> None:
    """No comparison with nan is true, so the ball would fall through the plane undetected."""
    solution = solved(method, Hybrid(**flight(guard=height_until_1)), Hybrid)
    assert solution.stopped == "the state or a guard was not finite before sample 17"


@pytest.mark.parametrize("method", EVENTS, ids=lambda method: method.name)
def test_events_that_accumulate_without_a_limit_mode_end_the_trajectory(method: Integrator) -> None:
    """A reset that leaves the ball below the plane gives events without end."""
    solution = solved(method, Hybrid(**flight(reset=bounce_nowhere)), Hybrid)
    assert str(solution.stopped).startswith("events accumulate at t =")
    assert "limits=" in str(solution.stopped)
    assert 0 < len(solution.events or ()) < 1100


@pytest.mark.parametrize("method", EVENTS, ids=lambda method: method.name)
def test_a_start_in_no_mode_is_named(method: Integrator) -> None:
    def nowhere(t: Any, state: Any, parameters: Any) -> str:
        return "rolls"

    with pytest.raises(ValueError, match="there is no mode 'rolls'; the form has flies"):
        solved(method, Hybrid(**flight(equations=fall, start=nowhere)), Hybrid)
