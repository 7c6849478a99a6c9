"""RATTLE: order, constraint and tangency to round-off, symplectic on the constraint, reversible."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from constrained_forms import CHAIN, DRAGGED, SHAKEN, masses, varying_masses
from gnomon.cases.core.elimination import rows_of
from gnomon.cases.core.forms import Constrained, FirstOrder, Values
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Problem, Unsupported
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.integrators.base.fixed_step import FixedStep
from gnomon.harness.integrators.geometric import rattle
from gnomon.harness.integrators.geometric.rattle import Rattle
from gnomon.harness.results.convergence_order import fit_order
from gnomon.harness.running.solve import solve
from gnomon.harness.studies.orders import measure_order, solve_exactly
from gnomon.reference.numerics.precision import working
from on_cases import exact_states, of_order, solved

RISING = [x / 5 for x in (3, -4 + 1.25, 7, -7 + 1.25, 7, -12 + 1.25)] + [0, 1, 0, 1, 0, 1]
"""Three rods of length 1, which rise with a pivot at t^2 at t = 1/2."""
METHODS = pytest.mark.parametrize("method", rattle.INTEGRATORS, ids=lambda method: method.name)


def constrained(name: str) -> Constrained:
    case = get(name)
    forms = case.forms if name == "holonomic_constraint_dae" else case.formulations[0].forms
    assert isinstance(forms[0], Constrained)
    return forms[0]


@METHODS
@pytest.mark.parametrize("variant", [None, "rotation"])
def test_order_on_the_circle(method: type[FixedStep], variant: str | None) -> None:
    measured = measure_order(method(), get("holonomic_constraint_dae", variant), most_steps=20_000)
    assert measured == of_order(method.order)


@METHODS
def test_order_on_the_sphere(method: type[FixedStep]) -> None:
    case = get("spherical_pendulum", span=4).rounded()
    formulation = case.formulations[0]
    problem = problem_of(case, method.accepts, formulation)
    start, exact = initial_state(case, formulation)[None], exact_states(case)
    counts = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32]
    errors = []
    for count in counts:
        states = method().prepare(problem, problem.interval / count)(start).states[0]
        errors.append(float(np.max(case.metric.distance(formulation.decode(states, problem.parameters), exact))))
    assert fit_order([problem.interval / count for count in counts], errors, floor=1e-14) == of_order(method.order)


@METHODS
def test_order_on_two_rods(method: type[FixedStep]) -> None:
    """Two constraints and two masses, against the certified motion in angles; both kept to round-off on the way."""
    case = get("double_pendulum").rounded()
    (formulation,) = case.formulations
    problem = problem_of(case, method.accepts, formulation)
    start, exact = initial_state(case, formulation)[None], exact_states(case)
    counts, errors = [2**k for k in range(9)], []
    for count in counts:
        states = method().prepare(problem, problem.interval / count)(start).states[0]
        errors.append(float(np.max(case.metric.distance(formulation.decode(states, problem.parameters), exact))))
        x1, y1, x2, y2, u1, v1, u2, v2 = states.T
        rods = (x1, y1, u1, v1), (x2 - x1, y2 - y1, u2 - u1, v2 - v1)
        assert max(np.max(np.abs(np.hypot(x, y) - 1)) for x, y, _, _ in rods) < 8 * np.finfo(float).eps
        assert max(np.max(np.abs(x * u + y * v)) for x, y, u, v in rods) < 128 * np.finfo(float).eps
    assert fit_order([problem.interval / count for count in counts], errors, floor=1e-14) == of_order(method.order)


@METHODS
def test_order_with_time_in_a_constraint(method: type[FixedStep]) -> None:
    """Three rods under a pivot that rises as t^2 from t = 1/2, a coupled mass matrix, and a force of time.

    Against DOP853 on the equations of index 1.
    """
    p, span = (0.75, 1.25, 1.0, 1.75), (0.5, 1.5)
    free = solve(FirstOrder(SHAKEN.equations), span, RISING, "gnomon:DOP853", t_eval=[1.5], args=p, rtol=1e-13)
    steps, errors = [1 / n for n in (8, 16, 24, 32, 48, 64, 96, 128, 192, 256, 512)], []
    for step in steps:
        found = solve(SHAKEN, span, RISING, method, t_eval=[1.5], args=p, step=step)
        assert found.success, found.message
        errors.append(float(np.max(np.abs(found.y - free.y))))
    assert fit_order(steps, errors, floor=1e-12) == of_order(method.order)


def test_forces_of_velocities_and_masses_of_place_are_unsupported() -> None:
    assert "forces that depend on velocities" in str(Rattle().unsupported(DRAGGED))
    assert Rattle().unsupported(SHAKEN) is None
    form = replace(SHAKEN, mass=varying_masses)
    problem = Problem(form, 12, np.ones(4), np.arange(1, 65) * 0.125, 1.0)
    with pytest.raises(Unsupported, match="only for a constant mass"):
        Rattle().prepare(problem, 0.125)


@METHODS
def test_constraint_and_tangency_hold_to_round_off(method: type[FixedStep]) -> None:
    """Each step corrects the position: errors do not accumulate over a thousand periods."""
    case = get("holonomic_constraint_dae", "long_1e3").rounded()
    found = solved(method(), case, steps=1024).states
    length = float(np.sum(initial_state(case)[:2] ** 2))
    assert np.max(np.abs(np.sum(found[:, :2] ** 2, axis=1) / length - 1)) < 8 * np.finfo(float).eps
    assert np.max(np.abs(np.sum(found[:, :2] * found[:, 2:], axis=1))) < 32 * np.finfo(float).eps


def on_circle(mp: Any, angle: Any, rate: Any) -> tuple[Any, ...]:
    return mp.sin(angle), -mp.cos(angle), rate * mp.cos(angle), rate * mp.sin(angle)


def step(method: type[FixedStep], mp: Any, angle: Any, rate: Any) -> list[Any]:
    start = [Fraction(mp.nstr(x, 62)) for x in on_circle(mp, angle, rate)]
    return list(
        solve_exactly(method(), constrained("holonomic_constraint_dae"), [Fraction(2)], start, Fraction(3, 10), 1)
    )


@METHODS
def test_symplectic_on_the_constraint(method: type[FixedStep]) -> None:
    """dx ^ dv on the tangent vectors of angle and rate is the same before and after a step, in sixty digits."""
    with working(62) as mp:
        tiny, angle, rate = mp.mpf(10) ** -20, mp.mpf(3) / 4, mp.mpf(1) / 2
        for derivative in (lambda a, w: step(method, mp, a, w), lambda a, w: list(on_circle(mp, a, w))):
            columns = [
                [
                    (x - y) / (2 * tiny)
                    for x, y in zip(derivative(angle + a, rate + w), derivative(angle - a, rate - w), strict=True)
                ]
                for a, w in ((tiny, 0), (0, tiny))
            ]
            (x1, y1, u1, v1), (x2, y2, u2, v2) = columns
            # On the unit circle it is d angle ^ d rate.
            assert abs(x1 * u2 - x2 * u1 + y1 * v2 - y2 * v1 - 1) < 1e-35


@METHODS
def test_symplectic_under_three_constraints(method: type[FixedStep]) -> None:
    """M dq ^ dv is the same before and after a step, on tangent vectors of angles and rates."""
    p = [Fraction(n, 4) for n in (3, 5, 4, 7)]
    with working(62) as mp:
        numbers = tuple(mp.mpf(x.numerator) / x.denominator for x in p)
        inertia = rows_of(tuple(mp.mpf(x) for x in masses(0, (0,) * 6, numbers)), 6)
        tiny, middle = mp.mpf(10) ** -20, [mp.mpf(n) / 8 for n in (3, -5, 7, 2, 4, -3)]

        def state(moved: Any) -> list[Any]:
            parts = [on_circle(mp, a, w) for a, w in zip(moved[:3], moved[3:], strict=True)]
            sums = [[mp.fsum(part[i] for part in parts[: k + 1]) for i in range(4)] for k in range(3)]
            return [x for half in (slice(0, 2), slice(2, 4)) for each in sums for x in each[half]]

        def after(moved: Any) -> list[Any]:
            exact = [Fraction(mp.nstr(x, 62)) for x in state(moved)]
            return list(solve_exactly(method(), CHAIN, p, exact, Fraction(1, 10), 1))

        def form(function: Any, a: list[int], b: list[int]) -> Any:
            columns = []
            for way in (a, b):
                ahead, behind = (
                    function([x + sign * tiny * w for x, w in zip(middle, way, strict=True)]) for sign in (1, -1)
                )
                columns.append([(x - y) / (2 * tiny) for x, y in zip(ahead, behind, strict=True)])
            one, other = columns
            return mp.fsum(
                inertia[i][j] * (one[i] * other[6 + j] - other[i] * one[6 + j]) for i in range(6) for j in range(6)
            )

        ways = [1, 0, 2, 0, -1, 1], [0, 1, -1, 2, 0, 1]
        assert abs(form(state, *ways)) > 0.1
        assert abs(form(after, *ways) - form(state, *ways)) < 1e-33


@METHODS
def test_reversible(method: type[FixedStep]) -> None:
    form = constrained("holonomic_constraint_dae")
    start = [Fraction(3, 4), Fraction(-1), Fraction(2), Fraction(3, 2)]
    signs = (1, 1, -1, -1)
    with working(60) as mp:
        there = solve_exactly(method(), form, [Fraction(2)], start, Fraction(3), 10)
        turned = [Fraction(str(x * s)) for x, s in zip(there, signs, strict=True)]
        back = solve_exactly(method(), form, [Fraction(2)], turned, Fraction(3), 10)
        gaps = [a - mp.mpf(b.numerator) / b.denominator * s for a, b, s in zip(back, start, signs, strict=True)]
        assert max(map(abs, gaps)) < 1e-50, "sixty digits, of which twenty steps lose a few"


@METHODS
def test_angular_momentum_about_the_vertical(method: type[FixedStep]) -> None:
    start = [Fraction(n, 9) for n in (4, 4, -7)] + [Fraction(n, 9) for n in (8, 6, 8)]  # on the sphere, tangent to it
    with working(60):
        x, y, _, u, v, _ = solve_exactly(
            method(), constrained("spherical_pendulum"), [Fraction(2), Fraction(1), Fraction(1)], start, Fraction(2), 10
        )
        before = start[0] * start[4] - start[1] * start[3]
        assert abs(x * v - y * u - before.numerator / (x * 0 + before.denominator)) < 1e-50


def flat(t: Any, place: Values, parameters: Values) -> Values:
    x, _y = place
    return (0 * x,)


def no_gradient(t: Any, place: Values, parameters: Values) -> Values:
    x, y = place
    return 0 * x, 0 * y


def free(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    return vx, vy, 0 * x, 0 * y


def test_a_constraint_without_gradient_ends_the_trajectory() -> None:
    form = Constrained(free, force=no_gradient, constraint=flat, gradient=no_gradient)
    problem = Problem(form, 4, np.zeros(0), np.arange(1, 65) * 0.125, 1.0)
    solution = Rattle().prepare(problem, 0.125)(np.array([[1.0, 0.0, 0.0, 1.0]]))
    assert solution.stopped == "the stages of a step did not converge before sample 1; take shorter steps"
