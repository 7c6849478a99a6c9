"""Errors are relative to the sizes of the problem: results are the same in any units, also with components at zero."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import FirstOrder, Hybrid, Mode, SecondOrder, Values
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator, Problem
from gnomon.harness.contract.problem import groups_of, initial_state, problem_of
from gnomon.harness.integrators.base.sizes import trial_step, turning_time
from gnomon.harness.integrators.events.hybrid import Dop853Events
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.multistep_extrapolation.extrapolation import GraggBulirschStoer
from gnomon.harness.integrators.runge_kutta.dop853 import Dop853
from gnomon.harness.integrators.runge_kutta.explicit_pairs import BogackiShampine3
from gnomon.harness.integrators.runge_kutta.nystrom import DormandPrinceNystrom6
from gnomon.harness.integrators.taylor.taylor import Taylor
from on_cases import exact_states, solved

METHODS = (Dop853, DormandPrinceNystrom6, GraggBulirschStoer, Taylor, Dop853Events)
"""One of each family of adaptive explicit methods: each has its own loop or its own estimate of the error."""


def attraction(t: float, q: Values, parameters: Values) -> Values:
    """A body attracted to a centre by mu / r^2 and to a wall beside it by a spring."""
    x, y, z = q
    mu, stiffness = parameters
    r = sqrt(x * x + y * y + z * z)
    return -mu * x / (r * r * r) - stiffness * x, -mu * y / (r * r * r), -mu * z / (r * r * r)


def motion(t: float, state: Values, parameters: Values) -> Values:
    x, y, z, u, v, w = state
    return u, v, w, *attraction(t, (x, y, z), parameters)


def moving(t: float, state: Values, parameters: Values) -> str:
    return "motion"


FORMS = {
    FirstOrder: FirstOrder(motion),
    SecondOrder: SecondOrder(attraction),
    Hybrid: Hybrid(modes=(Mode("motion", motion),), start=moving, transitions=(), settle=1e-9),
}


def states(method: type[Integrator], length: int, time: int, tolerance: float = 1e-8) -> np.ndarray:
    """A motion in the plane z = 0 that starts with y = u = 0; units of length and time are 2^-length and 2^-time."""
    unit, second = 2.0**length, 2.0**time
    start = np.array([[1.0, 0.0, 0.0, 0.0, 0.75, 0.0]]) * unit
    start[:, 3:] /= second
    parameters = np.array([unit**3 / second**2, 0.25 / second**2])
    times = np.arange(1, 65) / 4 * second
    problem = Problem(FORMS[method.accepts[0]], 6, parameters, times, second, groups=(0, 0, 0, 1, 1, 1))
    found = method().prepare(problem, tolerance)(start)
    assert found.stopped is None
    return np.asarray(found.states / unit * np.where(np.arange(6) < 3, 1.0, second))


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@pytest.mark.parametrize(("length", "time"), [(-200, 0), (200, 0), (-20, 33)])
def test_the_same_bits_in_units_that_are_powers_of_two(method: type[Integrator], length: int, time: int) -> None:
    """Fourth powers of 2^200 are finite. Components that start at zero have no size there, and z never gets one."""
    assert np.array_equal(states(method, length, time), states(method, 0, 0))


def spring(t: float, state: Values, parameters: Values) -> Values:
    x, v = state
    return v, -x


@pytest.mark.parametrize("amplitude", [2.0**-900, 2.0**1000])
@pytest.mark.parametrize("method", [Dop853, BogackiShampine3, GraggBulirschStoer, Taylor, Radau5])
def test_an_oscillator_of_any_amplitude_has_the_same_bits(method: type[Integrator], amplitude: float) -> None:
    """Below 2^-900 the last digits of its compensated sums are below the smallest number that is normal, 2^-1022."""
    problem = Problem(FirstOrder(spring), 2, np.zeros(0), np.arange(1, 65) / 4, 1.0)
    solve = method().prepare(problem, 1e-6)
    small, one = (solve(np.array([[x, 0.0]])).states for x in (amplitude, 1.0))
    assert np.array_equal(small, one * amplitude)


@pytest.mark.parametrize(
    "method",
    [Dop853, DormandPrinceNystrom6, GraggBulirschStoer, Taylor, pytest.param(Radau5, marks=pytest.mark.slow)],
)
def test_metres_and_megametres_give_the_same_error(method: type[Integrator]) -> None:
    """1e-6 is not a power of two, so round-off differs, but not errors by a factor of 2 (stability.md, D).

    Radau IIA 5 is compiled for each dimension in ten seconds: in `make test` the oscillators above and the stiff motion below,
    of dimension 2, show its sizes.
    """
    errors = [orbit_error(method, length) for length in ("1", "1e-6")]
    assert 0.5 < errors[1] / errors[0] < 2


def orbit_error(method: type[Integrator], length: str) -> float:
    unit = float(length)
    case = get("kepler_orbit", initial_state=(unit, 0, 0, 1.25 * unit), mu=unit**3, span=20).rounded()
    return solved(method(), case, 1e-8).error


def test_the_error_of_a_stiff_motion_does_not_depend_on_units() -> None:
    """The implicit system rounds a fast mode: h times the round-off of its rates would be as large as the motion."""
    case = get("damped_oscillator", "stiff_1e12").rounded()
    problem, start, exact = problem_of(case, Radau5.accepts), initial_state(case)[None], exact_states(case)
    solve = Radau5().prepare(problem, 1e-12)
    one, small = (solve(start * unit).states[0] / unit for unit in (1.0, 2.0**-200))
    assert np.array_equal(one, small)
    # At each step the error of order 3 is below 0.1 tol^(2/3), the error of order 5 far below.
    assert np.max(case.metric.distance(one, exact)) < 1e-8


class Absolute(Dop853):
    """DOP853 with the error norm of most libraries."""

    absolute = True


def test_the_absolute_rule_is_an_option() -> None:
    """In megametres its tolerance of 1e-8 is a hundredth of the orbit: with errors relative to sizes the error is far less."""
    assert orbit_error(Absolute, "1e-6") > 1e3 * orbit_error(Dop853, "1e-6")
    assert orbit_error(Absolute, "1") < 10 * orbit_error(Dop853, "1")


def test_sizes_that_do_not_decrease_save_work_on_an_eccentric_orbit() -> None:
    """With e = 0.99, from apocentre on, speeds range over 200: errors relative to the slow speeds cost right-hand sides and
    gain nothing. Compared at equal error, as the same tolerance gives another error with each norm."""
    case = get("kepler_orbit", initial_state=(1.99, 0, 0, sqrt(0.01 / 1.99))).rounded()
    assert work_at_equal_error(Dop853(), case) < 0.9 * work_at_equal_error(Absolute(), case)


def work_at_equal_error(method: Integrator, case: Case) -> float:
    """Right-hand sides at an error of 1e-4, by a line through the logarithms of both over many tolerances."""
    found = [solved(method, case, float(tolerance), counted=True) for tolerance in np.geomspace(1e-10, 1e-6, 17)]
    slope, constant = np.polyfit(np.log([one.error for one in found]), np.log([one.calls for one in found]), 1)
    return float(np.exp(slope * np.log(1e-4) + constant))


def pulse(t: float, state: Values, parameters: Values) -> Values:
    """Six masses in a row between springs and walls."""
    a, b, c, d, e, f, u, v, w, x, y, z = state
    return u, v, w, x, y, z, b - 2 * a, a - 2 * b + c, b - 2 * c + d, c - 2 * d + e, d - 2 * e + f, e - 2 * f


@pytest.mark.parametrize(("method", "most"), [(BogackiShampine3, 8), (Dop853, 3), (GraggBulirschStoer, 3)])
def test_components_still_at_rest_cost_few_steps(method: type[Integrator], most: float) -> None:
    """One mass of a row is displaced; the last moves as t^10, which no step of order 8 resolves from zero on. Steps that
    resolve it from its first moment on are as many for each factor of time: then order 3 takes ten times the steps, order
    8 six times."""
    problem = Problem(FirstOrder(pulse), 12, np.zeros(0), np.arange(1, 65) / 4, 1.0)
    start = np.zeros((1, 12))
    start[0, 0] = 1.0
    alone, together = (
        method().prepare(replace(problem, groups=groups), 1e-6)(start) for groups in ((), (0,) * 6 + (1,) * 6)
    )
    assert alone.stopped is together.stopped is None
    assert 0 < (alone.steps or 0) < most * (together.steps or 0), (
        "the steps of a geometric growth from the first step on"
    )
    assert np.max(np.abs(alone.states - together.states)) < 1e-4


@pytest.mark.parametrize("method", [Dop853, DormandPrinceNystrom6, GraggBulirschStoer])
def test_a_motion_of_round_off_alone_does_not_stop_the_steps(method: type[Integrator]) -> None:
    """An upright pendulum: its rate is sin pi with the rounding of pi, which no shorter step makes smoother."""
    case = get("pendulum_simple", "upright").rounded()
    assert solved(method(), case, 1e-10).steps < 5000, "a hundred to a thousand, for 1e5 and more"


def still(t: float, state: Values, parameters: Values) -> Values:
    return (0.0 * state[0], state[1] - state[1])


@pytest.mark.parametrize("method", [Dop853, GraggBulirschStoer])
def test_a_motion_without_any_size_is_left_alone(method: type[Integrator]) -> None:
    problem = Problem(FirstOrder(still), 2, np.zeros(0), np.arange(1, 65) / 4, 1.0)
    found = method().prepare(problem, 1e-6)(np.zeros((1, 2)))
    assert found.stopped is None
    assert not np.any(found.states)


GROUPS = np.array([0, 1])


@pytest.mark.parametrize("phase", [0.0, 1e-19, 0.5, np.pi / 2, 2.0])
def test_an_oscillator_leaves_its_tangent_within_a_radian_or_two(phase: float) -> None:
    """At any phase, also where its position or its rate is zero or nearly so."""
    omega, most = 3.0, 100.0
    y = np.array([np.cos(phase), -omega * np.sin(phase)])
    rates = np.array([y[1], -(omega**2) * y[0]])
    h = trial_step(y, rates, GROUPS, most)
    later = np.array([y[1] + h * rates[1], -(omega**2) * (y[0] + h * rates[0])])
    assert 0.9 / omega < turning_time(y, rates, later, h, GROUPS, most) < 2.0 / omega


def test_groups_are_those_of_the_metric() -> None:
    """The last component of an attitude in `lagrange_top` is a separate group; a formulation has none."""
    case = get("kepler_orbit")
    assert groups_of(case) == (0, 0, 1, 1)
    assert groups_of(case, case.formulations[0]) == ()
    assert problem_of(case.rounded(), (FirstOrder,)).groups == (0, 0, 1, 1)


def test_groups_of_another_number_are_refused() -> None:
    problem = Problem(FirstOrder(spring), 2, np.zeros(0), np.arange(1, 65) / 4, 1.0, groups=(0, 0, 1))
    with pytest.raises(ValueError, match="3 numbers of groups for 2 components"):
        Dop853().prepare(problem, 1e-6)
