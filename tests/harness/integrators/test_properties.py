"""Properties of methods apart from their order: symplectic, reversible, momentum, the same bits, compensated sums."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, SecondOrder, Values
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator, Problem
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.integrators.base.fixed_step import FixedStep
from gnomon.harness.integrators.gauss.gauss import Gauss2, Gauss4
from gnomon.harness.integrators.geometric.splitting import KahanLi6, KahanLi8, StormerVerlet, SymplecticEuler
from gnomon.harness.integrators.multistep_extrapolation.stormer import STARTER, Stormer8, Stormer12
from gnomon.harness.integrators.runge_kutta.explicit import RK4, ExplicitEuler
from gnomon.harness.registry import lookup
from gnomon.harness.studies.orders import solve_exactly
from gnomon.reference.numerics.precision import working
from on_cases import setting_of, solved

ALL: list[Any] = [type(one) for one in lookup.in_house() if {FirstOrder, SecondOrder} & {*one.accepts}]
FIXED = [method for method in ALL if issubclass(method, FixedStep)]
START = (Fraction(3, 10), Fraction(-1, 5), Fraction(1, 4), Fraction(2, 5))
STEP = Fraction(3, 10)


def henon_heiles(t: Any, q: Values, parameters: Values) -> Values:
    """Two coupled degrees of freedom with a cubic potential (Henon and Heiles, Astronomical Journal 69, 1964)."""
    x, y = q
    return -x - 2 * x * y, -y - x * x + y * y


def henon_heiles_first_order(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    return vx, vy, -x - 2 * x * y, -y - x * x + y * y


FORMS = {SecondOrder: SecondOrder(henon_heiles), FirstOrder: FirstOrder(henon_heiles_first_order)}
CLAIMS = [
    pytest.param(method, FORMS[kind], marks=[pytest.mark.slow] if method.order > 8 else [])
    for method in FIXED
    for kind in method.accepts
    if kind in FORMS and "symplectic" in method.conserves
]


def jacobian(step: Callable[[tuple[Fraction, ...]], tuple[Any, ...]], start: tuple[Fraction, ...]) -> Any:
    """The Jacobian of a step map by central differences of 1e-20: their error is 1e-40 times third derivatives."""
    tiny = Fraction(1, 10**20)
    columns = []
    for i in range(len(start)):
        ahead = step(tuple(x + tiny * (i == j) for j, x in enumerate(start)))
        behind = step(tuple(x - tiny * (i == j) for j, x in enumerate(start)))
        columns.append([(a - b) * 10**20 / 2 for a, b in zip(ahead, behind, strict=True)])
    return np.array(columns, dtype=object).T


def symplectic_defect(method: FixedStep, form: FirstOrder | SecondOrder) -> float:
    with working(60) as mp:
        derivative = jacobian(lambda start: solve_exactly(method, form, (), start, STEP, 1), START)
        zero, one = np.zeros((2, 2), dtype=int), np.eye(2, dtype=int)
        canonical = np.block([[zero, one], [-one, zero]]) * mp.mpf(1)
        return float(np.max(np.abs(derivative.T.dot(canonical).dot(derivative) - canonical)))


@pytest.mark.parametrize(("method", "form"), CLAIMS, ids=lambda x: getattr(x, "name", type(x).__name__))
def test_symplectic(method: type[FixedStep], form: FirstOrder | SecondOrder) -> None:
    assert symplectic_defect(method(), form) < 1e-35


def test_a_method_that_is_not_symplectic_is_detected() -> None:
    assert symplectic_defect(RK4(), FORMS[FirstOrder]) > 1e-6, "h^5 times a constant below 1"


def returned(method: FixedStep, form: FirstOrder | SecondOrder) -> float:
    """The distance from the start after ten steps, reversal of the velocities, and ten steps more."""
    with working(60) as mp:
        there = solve_exactly(method, form, (), START, 10 * STEP, 10)
        turned = [Fraction(str(x)) for x in (*there[:2], -there[2], -there[3])]
        back = solve_exactly(method, form, (), turned, 10 * STEP, 10)
        start = [mp.mpf(x.numerator) / x.denominator for x in (*START[:2], -START[2], -START[3])]
        return float(max(abs(a - b) for a, b in zip(back, start, strict=True)))


@pytest.mark.parametrize(("method", "form"), CLAIMS, ids=lambda x: getattr(x, "name", type(x).__name__))
def test_reversible(method: type[FixedStep], form: FirstOrder | SecondOrder) -> None:
    defect = returned(method(), form)
    if "reversible" in method.conserves:
        assert defect < 1e-50, "sixty digits, of which twenty steps lose a few"
    else:
        assert defect > 1e-6


def orbit(t: Any, q: Values, parameters: Values) -> Values:
    """A central force that is not a power of r."""
    x, y = q
    square = x * x + y * y
    return -x * (1 + square) / square, -y * (1 + square) / square


def orbit_first_order(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    return vx, vy, *orbit(t, (x, y), parameters)


ORBITS = {SecondOrder: SecondOrder(orbit), FirstOrder: FirstOrder(orbit_first_order)}


@pytest.mark.parametrize(
    ("method", "form"),
    [(method, ORBITS[kind]) for method in FIXED for kind in method.accepts if kind in ORBITS],
    ids=lambda x: getattr(x, "name", type(x).__name__),
)
def test_angular_momentum_under_a_central_force(method: type[FixedStep], form: FirstOrder | SecondOrder) -> None:
    count = 4 if "momentum" in method.conserves else 20  # more than the steps that start a multistep method
    with working(60) as mp:
        vx, vy = START[2:]
        before = START[0] * vy - START[1] * vx
        x, y, u, v = solve_exactly(method(), form, (), START, count * STEP / 8, count)
        defect = float(abs(x * v - y * u - mp.mpf(before.numerator) / before.denominator))
    if "momentum" in method.conserves:
        assert defect < 1e-50, "sixty digits, of which the steps lose a few"
    else:
        assert defect > 1e-20, "h to the order of the method and more, but not round-off"


def states(integrator: Integrator, problem: Problem, setting: float, start: Any) -> Any:
    return integrator.prepare(problem, setting)(start).states


@pytest.mark.parametrize("method", ALL, ids=lambda method: method.name)
def test_the_same_bits_alone_and_in_an_ensemble(method: type[Integrator]) -> None:
    case = get("pendulum_simple").rounded()
    problem = problem_of(case, method.accepts)
    setting, first = setting_of(method(), problem, 1e-9, 16), initial_state(case)
    pair = np.array([first, 0.5 * first])
    together = states(method(), problem, setting, pair)
    for index in range(2):
        alone = states(method(), problem, setting, pair[index : index + 1])
        assert np.array_equal(alone[0], together[index])
    assert np.array_equal(together, states(method(), problem, setting, pair))


@pytest.mark.parametrize("method", FIXED, ids=lambda method: method.name)
def test_samples_off_the_grid_do_not_feed_back(method: type[FixedStep]) -> None:
    case = get("pendulum_simple").rounded()
    problem = problem_of(case, method.accepts)
    h = problem.interval / 64
    start = initial_state(case)[None]
    uniform = states(method(), problem, h, start)[0]
    shifted = problem.times.copy()
    shifted[::2] -= 0.37 * h
    between = states(method(), replace(problem, times=shifted), h, start)[0]
    assert np.array_equal(between[1::2], uniform[1::2])
    error = case.metric.distance(between[::2], case.sample(shifted[::2]))
    on_grid = case.metric.distance(uniform[::2], case.sample(problem.times[::2]))
    assert np.max(error) < 2 * np.max(on_grid) + 1e-9, "one shorter step adds at most a local error"


def test_steps_sum_with_compensation() -> None:
    """At 2.6e5 steps of order 8 the error is round-off, over five times larger without compensation."""

    class Plain(KahanLi8):
        compensated = False

    case = get("pendulum_simple").rounded()
    assert solved(Plain(), case, steps=4096).error > 5 * solved(KahanLi8(), case, steps=4096).error


@pytest.mark.parametrize(
    ("method", "a_step", "once"),
    [
        (ExplicitEuler, 1, 0), (RK4, 4, 0), (SymplecticEuler, 1, 0), (StormerVerlet, 1, 1), (KahanLi6, 9, 1),
        *((method, 1, 1 + (method.order - 1) * (len(STARTER.a) - 1)) for method in (Stormer8, Stormer12)),
    ],
)  # fmt: skip
def test_right_hand_sides_are_counted(method: type[FixedStep], a_step: int, once: int) -> None:
    """Störmer's methods take one a step, after a start by another method."""
    found = solved(method(), get("pendulum_simple").rounded(), steps=4, counted=True)
    assert (found.steps, found.calls) == (4 * 64, a_step * 4 * 64 + once)


@pytest.mark.parametrize("method", [Gauss2, Gauss4])
def test_gauss_needs_few_iterations_where_steps_are_short(method: type[FixedStep]) -> None:
    found = solved(method(), get("pendulum_simple").rounded(), counted=True)
    assert found.steps == 64 * 64
    assert found.calls < 8 * method.order / 2 * found.steps
