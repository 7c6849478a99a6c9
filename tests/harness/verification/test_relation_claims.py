"""Other units, mirrored and permuted numbers: faults that these show, and right methods that they must not fail."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator, Steps, Tolerance
from gnomon.harness.measuring.reference_solution import CaseSpec, ReferenceSolution, reference_solution
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.registry.declaration import validate
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.verification.claims import DEPTHS, Outcome
from gnomon.harness.verification.function_adapter import from_solve, from_step
from gnomon.harness.verification.verify import CLAIMS
from planted_methods import good_pair, good_rk4, good_verlet
from planted_right import right_ros2, undeclared_ros2, with_differences
from planted_steps import drops_small_increments, first_component_by_euler, increment
from scipy.integrate import solve_ivp

RELATIONS = ("units", "rounded_times", "mirror", "permuted")


@cache
def _reference(name: str) -> ReferenceSolution:
    return reference_solution(CaseSpec.of(get(name).rounded()))


@cache
def outcome(claim: str, integrator: Integrator, name: str = "kepler_orbit") -> Outcome:
    trials = Trials(integrator, get(name).rounded(), _reference(name), DEPTHS["low"])
    return CLAIMS[claim].check(trials).outcome


def longest_step_in_seconds(f: Any, t: float, y: Any, h: float) -> Any:
    return y + increment(f, t, y, min(h, 1e-3))


def first_component_in_single_precision(f: Any, t: float, y: Any, h: float) -> Any:
    found = y + increment(f, t, y, h)
    found[0] = np.float32(found[0])
    return found


def rounds_down(f: Any, t: float, y: Any, h: float) -> Any:
    return np.floor((y + increment(f, t, y, h)) * 2.0**40) * 2.0**-40


def never_below_zero(f: Any, t: float, y: Any, h: float) -> Any:
    found = y + increment(f, t, y, h)
    found[0] = max(found[0], 0.0)
    return found


def absolute_slope(f: Any, t: float, y: Any, h: float) -> Any:
    return y + increment(lambda t, y: f(t, np.append(np.abs(y[:1]), y[1:])), t, y, h)


def clipped_solve(f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
    """A solver whose equations see positive numbers only."""
    found = solve_ivp(lambda t, y: f(t, np.abs(y)), (t0, times[-1]), y0, t_eval=times, rtol=tolerance, atol=tolerance)
    return found.y.T


@pytest.mark.parametrize(
    ("claim", "step", "case"),
    [
        ("units", drops_small_increments, "kepler_orbit"),
        ("units", longest_step_in_seconds, "pendulum_simple"),
        ("permuted", first_component_in_single_precision, "kepler_orbit"),
        ("permuted", first_component_by_euler, "kepler_orbit"),
        ("mirror", rounds_down, "pendulum_simple"),
        ("mirror", never_below_zero, "kepler_orbit"),
        ("mirror", absolute_slope, "forced_oscillator"),
    ],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_a_fault_fails_the_relation_that_it_breaks(claim: str, step: Any, case: str) -> None:
    method = from_step(step, name=step.__name__, order=4, sweep=Steps(0.25, 6))
    assert outcome(claim, good_rk4, case) == Outcome.PASSED
    assert outcome(claim, method, case) == Outcome.FAILED


def test_an_adaptive_method_that_sees_no_signs_fails_the_mirror() -> None:
    method = from_solve(clipped_solve, name="clipped", sweep=Tolerance(1e-4, 1e-12))
    assert outcome("mirror", method, "pendulum_simple") == Outcome.FAILED


def omits_steps(f: Any, t0: float, y0: Any, times: Any, step: float) -> Any:
    """A solver that ends where the sum of its steps says so, which rounding may put after the sample."""
    t, y, found = t0, y0, []
    for end in times:
        while t + step <= end:
            t, y = t + step, y + increment(f, t, y, step)
        found.append(y)
    return np.array(found)


def test_a_step_omitted_by_rounding_fails_where_times_round_only() -> None:
    """Steps of a power of two over the sampling interval never round: the other claims do not see it."""
    method = from_solve(omits_steps, name="omits steps", order=4, sweep=Steps(0.25, 6))
    assert [outcome(name, method, "pendulum_simple") for name in ("units", "rounded_times")] == ["passed", "failed"]


def implicit(stage: Callable[[Any], float], name: str) -> Integrator:
    """The implicit midpoint rule, whose iteration ends where it changes the state by less than `stage(state)`."""

    def step(f: Any, t: float, y: Any, h: float) -> Any:
        middle = y + h / 2 * f(t, y)
        for _ in range(100):
            better = y + h / 2 * f(t + h / 2, middle)
            change, middle = np.max(np.abs(better - middle)), better
            if change < stage(y):
                break
        return y + h * f(t + h / 2, middle)

    return from_step(step, name=name, order=2, sweep=Steps(0.125, 6))


def absolute_solve(f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
    """An absolute tolerance only: SciPy's least relative tolerance is 100 roundings."""
    found = solve_ivp(f, (t0, times[-1]), y0, "DOP853", t_eval=times, rtol=3e-14, atol=tolerance)
    return found.y.T


RIGHT = (
    good_rk4,
    good_verlet,
    good_pair,
    implicit(lambda y: 1e-15 * float(np.max(np.abs(y))), "ends at round-off"),
    implicit(lambda y: 1e-11, "ends at an absolute bound"),
    from_solve(absolute_solve, name="absolute tolerance", order=8, sweep=Tolerance(1e-4, 1e-12)),
    find_one("scipy:LSODA"),
)


@pytest.mark.parametrize("method", RIGHT, ids=lambda method: method.name)
def test_right_methods_keep_all_relations(method: Integrator) -> None:
    """An absolute bound, of an iteration or of an error, is only tighter in units in which numbers are larger."""
    assert {outcome(claim, method) for claim in RELATIONS} == {Outcome.PASSED}


def test_bodies_may_be_exchanged() -> None:
    assert {outcome(claim, good_verlet, "two_body") for claim in RELATIONS} == {Outcome.PASSED}


def test_a_relation_that_does_not_follow_is_not_claimed() -> None:
    """A splitting by axes is right, and has another error where axes are exchanged; engines have lengths of their own."""
    assert outcome("permuted", find_one("gnomon:Axis splitting 2"), "euler_top") == Outcome.NOT_APPLICABLE
    assert outcome("permuted", good_rk4, "euler_top") == Outcome.PASSED
    assert outcome("permuted", good_rk4, "pendulum_simple") == Outcome.NOT_APPLICABLE
    engine = find_one("pybullet:stepSimulation [configured]")
    assert {outcome(claim, engine, "pendulum_simple") for claim in RELATIONS} == {Outcome.NOT_APPLICABLE}


class OneLength(type(get("harmonic_oscillator"))):  # type: ignore[misc]
    """An oscillator with a hidden length of 1 m."""

    forms = (FirstOrder(lambda t, y, p: (y[1], -p[1] / p[0] * (y[0] + y[0] * y[0]))),)


def test_equations_with_a_hidden_length_are_not_held_to_other_units() -> None:
    case = OneLength().rounded()
    trials = Trials(good_rk4, case, _reference("harmonic_oscillator"), DEPTHS["low"])
    found = CLAIMS["units"].check(trials)
    assert found.outcome == Outcome.NOT_APPLICABLE
    assert found.why == "its equations hold in one system of units only"


def test_a_jacobian_of_differences_is_declared() -> None:
    """Its error changes with the signs: the bound of the relations follows from the declaration, and still shows a
    component that is solved in another way."""
    assert outcome("mirror", undeclared_ros2) == Outcome.FAILED
    for claim in (*RELATIONS, "clock", "step_order", "order_short", "quadrature"):
        for name in ("kepler_orbit", "forced_oscillator"):
            assert outcome(claim, right_ros2, name) != Outcome.FAILED, (claim, name)
    assert outcome("permuted", right_ros2) == Outcome.PASSED
    wrong = with_differences(from_step(first_component_by_euler, name="Euler in one component", order=2))
    assert outcome("permuted", wrong) == Outcome.FAILED


def test_a_jacobian_is_exact_or_of_differences() -> None:
    with pytest.raises(ValueError, match="jacobian = 'numerical'; it is exact or differences"):
        validate(type("Odd", (type(good_rk4),), {"jacobian": "numerical"})())
