"""Radau IIA on constraints: the orders of index 3 and index 2, and which of the constraints each one keeps."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.integrators.geometric.constrained_radau import RadauIndex2, RadauIndex3
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.verification.claims import DEPTHS, Outcome
from gnomon.harness.verification.verify import CLAIMS
from on_cases import exact_states


def solved(method: Any, name: str, steps: int) -> tuple[Any, Any, Any]:
    """The problem, the case, and states after so many steps in each sampling interval."""
    case = get(name).rounded()
    problem = problem_of(case, method.accepts)
    states = method().prepare(problem, problem.interval / steps)(initial_state(case)[None]).states[0]
    return problem, case, states


def off(problem: Any, case: Any, states: Any) -> tuple[float, float]:
    """The largest departure from the constraints of the start, and from their rates."""
    form, p, half = problem.form, problem.parameters, problem.dimension // 2
    first = np.array(form.constraint(0.0, tuple(map(float, case.initial_state[:half])), p), float)
    place = rate = 0.0
    for t, state in zip(case.times, states, strict=True):
        q = tuple(state[:half])
        place = max(place, np.abs(np.array(form.constraint(t, q, p)) - first).max())
        moving = np.array(form.constraint_rate(t, q, p)) if form.constraint_rate else 0.0
        normals = np.array(form.gradient(t, q, p)).reshape(len(first), half)
        rate = max(rate, np.abs(normals @ state[half:] + moving).max())
    return place, rate


@pytest.mark.parametrize("name", ["slider_crank", "car_axis", "andrews_squeezer"])
@pytest.mark.parametrize(
    ("method", "orders"), [(RadauIndex3, (5, 3)), (RadauIndex2, (5, 5))], ids=["index 3", "index 2"]
)
def test_positions_and_velocities_have_the_orders_of_the_theory(
    method: Any, orders: tuple[int, int], name: str
) -> None:
    """Hairer, Lubich, Roche 1989: 2s - 1 and s at index 3, 2s - 1 for both at index 2, with s = 3 stages.

    One motion of one constraint, two of several, one with time in a constraint, one with masses of place: a wrong term
    would lower an order.
    """
    steps = {"slider_crank": 16, "car_axis": 8, "andrews_squeezer": 8}[name]
    found = []
    for refined in (steps, 2 * steps):
        _, case, states = solved(method, name, refined)
        left = np.abs(states - exact_states(case))
        half = states.shape[1] // 2
        found.append((left[:, :half].max(), left[:, half:].max()))
    measured = np.log2(np.array(found[0]) / np.array(found[1]))
    assert measured == pytest.approx(orders, abs=0.35)


def test_index_3_keeps_the_constraints_and_index_2_their_rates() -> None:
    for name in ("slider_crank", "car_axis"):
        place, rate = off(*solved(RadauIndex3, name, 8))
        assert place < 1e-13
        assert rate > 1e-9
        place, rate = off(*solved(RadauIndex2, name, 8))
        assert place > 1e-12
        assert rate < 1e-12


def test_too_long_steps_are_said_to_be_so() -> None:
    """The fixed-point iteration does not converge there: it must not return what it has."""
    case = get("slider_crank").rounded()
    problem = problem_of(case, RadauIndex3.accepts)
    found = RadauIndex3().prepare(problem, problem.interval)(initial_state(case)[None])
    assert found.stopped is not None
    assert "take shorter steps" in found.stopped


def test_a_sample_that_is_one_rounding_after_a_step_is_no_step_of_its_own() -> None:
    """At index 3 a step of the length of a rounding would find velocities as differences of rounded positions over it."""
    case = get("holonomic_constraint_dae").rounded()
    problem, start = problem_of(case, RadauIndex3.accepts), initial_state(case)[None]
    step, later = problem.interval / 8, problem.times.copy()
    later[9] = np.nextafter(later[9], np.inf)
    on, after = (
        RadauIndex3().prepare(replace(problem, times=times), step)(start).states[0] for times in (problem.times, later)
    )
    assert after == pytest.approx(on, rel=0, abs=1e-12)


def test_round_off_of_positions_over_a_step_is_no_fault_of_its_velocities() -> None:
    """At 1e-7 of the time scale it is 1e-9, far above the rounding of a state, and grows as steps become shorter."""
    trials = Trials.of(RadauIndex3(), CaseSpec.of(get("holonomic_constraint_dae").rounded()), DEPTHS["low"])
    assert CLAIMS["step_order"].check(trials).outcome == Outcome.PASSED
    lower = type("Lower", (RadauIndex3,), {"order": 4})()
    trials = Trials.of(lower, CaseSpec.of(get("holonomic_constraint_dae").rounded()), DEPTHS["low"])
    assert CLAIMS["step_order"].check(trials).outcome == Outcome.FAILED
