"""Right adaptive methods keep the error that a tolerance allows; with estimates 100 times too small they do not."""

from typing import Any

import numpy as np
import planted_right
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.measuring.growth import growth
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.verification.claims import DEPTHS, Outcome
from gnomon.harness.verification.verify import CLAIMS
from scipy.integrate import solve_ivp

CASES = ("pendulum_simple", "forced_oscillator")
OF_TOLERANCE = ("tolerance", "tolerance_short")


def outcomes(integrator: Integrator) -> list[Outcome]:
    """Outcomes of the claims about the tolerance on two cases of depth low."""
    found = []
    for name in CASES:
        trials = Trials.of(integrator, CaseSpec.of(get(name).rounded()), DEPTHS["low"])
        found += [CLAIMS[claim].check(trials).outcome for claim in OF_TOLERANCE]
    return found


@pytest.mark.parametrize("method", [*planted_right.adaptive(), planted_right.right_radau], ids=lambda m: m.name)
def test_a_right_adaptive_method_keeps_to_its_tolerance(method: Integrator) -> None:
    """With and without local extrapolation, samples at or between steps, the tolerance of a step or of a unit of time."""
    assert Outcome.FAILED not in outcomes(method)


@pytest.mark.parametrize("method", planted_right.adaptive(100.0), ids=lambda m: m.name)
def test_an_estimate_of_the_error_that_is_100_times_too_small_fails(method: Integrator) -> None:
    assert Outcome.FAILED in outcomes(method)


def test_the_right_hand_sides_of_a_step_are_found_from_their_counts() -> None:
    """Six of a pair of Dormand and Prince, whose last is the first of the next step, three of Bogacki and Shampine's; where
    iterations make the counts of steps differ, each right-hand side counts as a step."""
    found = [
        Trials.of(method, CaseSpec.of(get("pendulum_simple").rounded()), DEPTHS["low"]).calls_of_a_step
        for method in (planted_right.adaptive()[0], planted_right.adaptive()[4], planted_right.right_radau)
    ]
    assert found == [6, 3, 1]


@pytest.mark.parametrize("name", CASES)
def test_growth_is_that_of_the_variational_equations(name: str) -> None:
    """The largest of F(t) F(s)^-1, with F integrated beside the motion."""
    case = get(name).rounded()
    times, sizes = case.times, np.array([case.metric.groups[i].scale for i in range(2)])
    form = next(form for form in case.all_forms() if isinstance(form, FirstOrder))
    parameters = [float(value) for value in case.parameter_values()]

    def slope(t: float, state: Any) -> Any:
        """The equations of y, and the equations of F with differences for the Jacobian."""
        rows, y = state[2:].reshape(2, 2), state[:2]
        matrix = np.empty((2, 2))
        for i in range(2):
            moved = y + 1e-6 * np.eye(2)[i], y - 1e-6 * np.eye(2)[i]
            ahead, behind = (np.array(form.equations(t, tuple(at), parameters)) for at in moved)
            matrix[:, i] = (ahead - behind) / 2e-6
        return np.concatenate([np.array(form.equations(t, tuple(y), parameters)), (matrix @ rows).ravel()])

    start = np.concatenate([np.array([float(x) for x in case.initial_state]), np.eye(2).ravel()])
    solved = solve_ivp(slope, (0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-10, atol=1e-10)
    carried = [np.eye(2), *(f.reshape(2, 2) * sizes / sizes[:, None] for f in solved.y[2:].T)]
    ways = [[carried[k] @ np.linalg.inv(carried[j]) for j in range(k)] for k in range(1, len(carried))]
    expected = [max(1.0, *(float(np.max(np.linalg.norm(way, axis=1))) for way in row)) for row in ways]
    assert growth(case, times, sizes) == pytest.approx(expected, rel=1e-4)
    assert np.max(expected) > 1.1


def test_growth_is_not_claimed_across_events_or_off_a_constraint() -> None:
    for name in ("bouncing_ball", "holonomic_constraint_dae"):
        case = get(name).rounded()
        assert growth(case, case.times, np.ones(len(case.state))) is None
