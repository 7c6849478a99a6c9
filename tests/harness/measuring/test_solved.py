"""The outcome of a call: solved, counted, or failed with one status and reason, whoever asks."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from changed_methods import changed
from gnomon.cases.core.registry import get
from gnomon.harness.contract import validation
from gnomon.harness.contract.integrator import Refused, Unsupported
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.solved import Solved, outcome, solve_within

CASE = get("pendulum_simple").rounded()
START = initial_state(CASE)[None]


def at(moves: bool = False, seconds: float = 60.0, **change: Callable[..., Any]) -> Solved:
    integrator = changed("gnomon:DOP853", **change)
    problem = problem_of(CASE, integrator.accepts, counted=True)
    return solve_within(integrator, problem, 1e-8, START, moves, seconds)


def raising(error: Exception) -> Callable[[Any], Any]:
    def change(states: Any) -> Any:
        raise error

    return change


def test_a_solution_has_its_states_and_the_number_of_its_right_hand_sides() -> None:
    found = at()
    assert (found.status, found.reason) == (Status.OK, "")
    assert found.whole.states.shape == (1, 64, 2)
    assert np.array_equal(found.states, found.whole.states)
    assert found.calls > 100


@pytest.mark.parametrize(
    ("error", "status", "reason"),
    [
        (Refused("too stiff"), Status.REFUSED, "too stiff"),
        (Refused(), Status.REFUSED, "declined without a reason"),
        (Unsupported("a joint"), Status.UNSUPPORTED, "a joint"),
        (ZeroDivisionError("by zero"), Status.CRASHED, "ZeroDivisionError: by zero"),
        (MemoryError(), Status.OUT_OF_MEMORY, "needed more than there is ()"),
    ],
)
def test_a_failure_is_a_status_and_a_reason_and_has_no_states(error: Exception, status: Status, reason: str) -> None:
    found = at(states=raising(error))
    assert (found.status, found.reason, found.solution) == (status, reason, None)
    for part in ("states", "whole"):
        with pytest.raises(Refused, match=reason.partition("(")[0]):
            getattr(found, part)


def test_states_that_rest_are_refused_only_where_the_motion_moves() -> None:
    def rests(states: Any) -> Any:
        return np.broadcast_to(START[:, None], states.shape).copy()

    found = at(moves=True, states=rests)
    assert (found.status, found.reason) == (Status.REFUSED, validation.DID_NOT_MOVE)
    assert at(states=rests).status == Status.OK


def test_a_call_without_end_is_given_up() -> None:
    def hangs(states: Any) -> Any:
        while True:
            pass

    found = at(seconds=0.05, states=hangs)
    assert (found.status, found.reason) == (Status.REFUSED, "no answer within 0.05 s of processor time")


def test_an_integration_that_ended_early_has_states_and_is_not_whole() -> None:
    found = at().whole
    early = outcome(lambda: (replace(found, stopped="its step vanished"), 0))
    assert np.array_equal(early.states, found.states)
    with pytest.raises(Refused, match="its step vanished"):
        _ = early.whole
