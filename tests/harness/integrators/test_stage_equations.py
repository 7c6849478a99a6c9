"""Accepted steps of implicit methods solve the stage equations: thousands of random steps, independent solutions.

A linear step against Padé's approximant in extended precision, a nonlinear one against Newton's method continued from a
step of length 0 to the whole step, one on a circle against the root of a quadratic equation.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, Form, SecondOrder, Values
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.integrators.base.fixed_step import FixedStep
from gnomon.harness.integrators.base.tableau import ButcherTableau
from gnomon.harness.integrators.gauss import radau
from gnomon.harness.integrators.gauss.gauss import (
    INTEGRATORS,
    Gauss,
    Gauss2,
    Gauss4,
    ImplicitMidpoint,
    collocation,
    newton_rows,
    nodes,
)
from gnomon.harness.integrators.gauss.gauss_steps import CLOSE, NOISE, STALLED_ROUNDS, has_settled
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.geometric import rattle
from gnomon.reference.numerics.precision import working
from numpy.typing import NDArray
from on_cases import solved

METHODS = pytest.mark.parametrize("method", [method for method in INTEGRATORS if issubclass(method, Gauss)])
ULP = 2.0**-52
Extended = NDArray[np.longdouble]


def one_step(form: Form, dimension: int, *parameters: float, time_scale: float = 1.0) -> Problem:
    """A step of 1 is one sample."""
    return Problem(form, dimension, np.array(parameters), np.array([1.0]), time_scale)


def linear(t: Any, state: Values, parameters: Values) -> Values:
    """(u + i v)' = (a + i b) (u + i v): the rate is part of the state, so that each trajectory has another."""
    a, b, u, v = state
    return 0 * a, 0 * b, a * u - b * v, b * u + a * v


def spring(t: Any, place: Values, parameters: Values) -> Values:
    x, k = place
    return -k * x, 0 * k


def pade(below: int, above: int, z: NDArray[np.clongdouble]) -> NDArray[np.clongdouble]:
    """The approximant of exp with polynomials of these degrees: the stability function of a collocation method."""
    total, divisor, both = np.zeros_like(z), np.zeros_like(z), above + below
    for j in range(above + 1):
        total += np.longdouble(math.comb(above, j)) / math.perm(both, j) * z**j
    for j in range(below + 1):
        divisor += np.longdouble(math.comb(below, j)) / math.perm(both, j) * (-z) ** j
    return total / divisor


def rates(count: int) -> NDArray[np.complex128]:
    """From 1e-3 to 1e8: half of them oscillations, the others in the left half-plane; and 2 i, 4 i, where rounds cycle."""
    source = np.random.default_rng(1)
    size = 10 ** source.uniform(-3, 8, count)
    turn = np.where(np.arange(count) % 2, np.pi / 2, source.uniform(np.pi / 2, np.pi, count))
    found = np.where(np.arange(count) % 2, 1j * size, size * np.exp(1j * turn))
    found[:4] = [2j, 4j, 2j, -2]
    return found


def starts(count: int) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """On the unit circle, every seventh at 1, which has no imaginary part; and the powers of 2 they are multiplied by.

    Not above 1: the rate's column of the Jacobian is as large, and would determine the pivots."""
    source = np.random.default_rng(2)
    unit = np.exp(1j * source.uniform(0, 2 * np.pi, count))
    unit[::7] = 1
    return unit, 2.0 ** source.integers(-500, 1, count)


def most_weight(method: type[Gauss], second_order: bool) -> float:
    """The sum of the weights by which a change of the stages changes the end of a step."""
    with working(30) as mp:
        rows = newton_rows(mp, method.stages, second_order, mp.mpf(0))
        chosen = [rows[method.stages], *([rows[method.stages + 2]] if second_order else [])]
        return float(max(mp.fsum(abs(x) for x in row[1:]) for row in chosen))


@METHODS
def test_linear_steps_are_those_of_the_stability_function(method: type[Gauss]) -> None:
    """Steps of 5000 rates: no fixed point is accepted before its stages are within CLOSE units of round-off."""
    z, (unit, scale) = rates(5000), starts(5000)
    initial = np.stack([z.real, z.imag, unit.real * scale, unit.imag * scale], 1)
    solution = method().prepare(one_step(FirstOrder(linear), 4), 1.0)(initial)
    assert solution.stopped is None
    found = (solution.states[:, 0, 2] + 1j * solution.states[:, 0, 3]) / scale
    exact = pade(method.stages, method.stages, z.astype(np.clongdouble)) * unit
    assert np.max(np.abs(found - exact)) < CLOSE * most_weight(method, False) * ULP


@METHODS
def test_linear_steps_of_second_order_are_those_of_the_stability_function(method: type[Gauss]) -> None:
    size = np.abs(rates(5000))
    unit, scale = starts(5000)
    initial = np.stack([unit.real * scale, size**2, unit.imag * size * scale, 0 * size], 1)
    solution = method().prepare(one_step(SecondOrder(spring), 4), 1.0)(initial)
    assert solution.stopped is None
    frequency = np.sqrt((size**2).astype(np.longdouble))
    start = unit.real - 1j * ((unit.imag * size).astype(np.longdouble) / frequency)
    exact = start * pade(method.stages, method.stages, 1j * frequency)
    found = solution.states[:, 0, 0] / scale - 1j * (solution.states[:, 0, 2] / scale / frequency)
    assert np.max(np.abs(found - exact)) < CLOSE * most_weight(method, True) * ULP


@dataclass(frozen=True)
class Tableau:
    a: Extended
    change: Extended
    """b A^-1: the weights of the stages' differences in the change of the state."""

    @classmethod
    def of(cls, mp: Any, tableau: ButcherTableau) -> Tableau:
        *a, b = (row[1:] for row in tableau.rows(mp))
        change = mp.matrix([b]) * mp.matrix(a) ** -1
        return cls(
            *(np.array([[np.longdouble(mp.nstr(x, 25)) for x in row] for row in rows]) for rows in (a, [change]))
        )


@cache
def gauss_tableau(stages: int) -> Tableau:
    with working(40) as mp:
        return Tableau.of(mp, collocation(mp, nodes(mp, stages), 2 * stages))


Field = Callable[[Any], Any]


def followed(
    tableau: Tableau, f: Field, jacobian: Field, start: Any, lengths: Any
) -> tuple[Extended, NDArray[np.float64]]:
    """The ends of steps of 1 from `start` (n, d), and the least determinant met on the way to each.

    The stage equations of steps of each of `lengths` in turn, from the solution for the last, by Newton's method; the
    last of them again with residuals in extended precision.
    """
    n, d = start.shape
    stages = len(tableau.a)
    a = tableau.a.astype(np.float64)
    z = np.zeros((n, stages, d), dtype=np.longdouble)
    least = np.full(n, np.inf)
    for length in (*lengths, 1.0):
        for _ in range(4 if length < 1 else 12):
            x = start[:, None] + z
            residual = z - length * np.einsum("jm,nmi->nji", tableau.a, f(x))
            blocks = np.einsum("jm,nmik->njimk", a, jacobian(x.astype(np.float64)))
            matrix = np.eye(stages * d) - length * blocks.reshape(n, stages * d, stages * d)
            correction = np.linalg.solve(matrix, residual.astype(np.float64).reshape(n, -1, 1))
            z = z - correction.reshape(n, stages, d)
        least = np.minimum(least, np.linalg.det(matrix))
    assert np.max(np.abs(correction)) < 1e-17 * (1 + np.max(np.abs(z)))
    return start + np.einsum("j,nji->ni", tableau.change[0], z), least


def pendulum(t: Any, state: Values, parameters: Values) -> Values:
    x, v, w = state
    return w * v, -w * sin(x), 0 * w


def pendulum_by_place(t: Any, place: Values, parameters: Values) -> Values:
    x, w = place
    return -w * w * sin(x), 0 * w


def swing(x: Any) -> Any:
    return np.stack([x[..., 2] * x[..., 1], -x[..., 2] * np.sin(x[..., 0]), 0 * x[..., 2]], -1)


def swing_jacobian(x: Any) -> Any:
    zero = 0 * x[..., 0]
    rows = [
        [zero, x[..., 2], x[..., 1]],
        [-x[..., 2] * np.cos(x[..., 0]), zero, -np.sin(x[..., 0])],
        [zero, zero, zero],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


@cache
def swings(stages: int) -> tuple[NDArray[np.float64], Extended]:
    """Starts (x, v / w, w) with w up to 1.9, below which the midpoint rule has one solution, and where a step ends."""
    source, count = np.random.default_rng(3), 400
    start = np.stack([source.uniform(-3, 3, count), source.uniform(-2, 2, count), source.uniform(0.01, 1.9, count)], 1)
    end, least = followed(gauss_tableau(stages), swing, swing_jacobian, start, [0.25, 0.5, 0.75])
    assert np.all(least > 0)
    return start, end


@METHODS
@pytest.mark.parametrize("second_order", [False, True])
def test_long_steps_of_a_pendulum(method: type[Gauss], second_order: bool) -> None:
    start, exact = swings(method.stages)
    x, v, w = start.T
    if second_order:
        initial = np.stack([x, w, w * v, 0 * w], 1)
        states = method().prepare(one_step(SecondOrder(pendulum_by_place), 4), 1.0)(initial).states[:, 0]
        found = np.stack([states[:, 0], states[:, 2] / w], 1)
    else:
        found = method().prepare(one_step(FirstOrder(pendulum), 3), 1.0)(start).states[:, 0, :2]
    failed = np.isnan(found[:, 0])
    assert np.mean(failed) < 0.05, "Newton's iteration may leave for elsewhere where steps are a third of a period"
    # Near the fold at w = 2 the determinant of one stage is 0.1, and magnifies round-off by 10. Stages are up to 6.
    assert np.max(np.abs(found - exact[:, :2])[~failed]) < 10 * 6 * CLOSE * most_weight(method, second_order) * ULP


def relax(t: Any, state: Values, parameters: Values) -> Values:
    """A contracting fall to 0: the distance of any two solutions shrinks, so that stages are unique."""
    x, k = state
    return -k * (x + x * x * x), 0 * k


def fall(x: Any) -> Any:
    return np.stack([-x[..., 1] * (x[..., 0] + x[..., 0] ** 3), 0 * x[..., 1]], -1)


def fall_jacobian(x: Any) -> Any:
    zero = 0 * x[..., 0]
    rows = [[-x[..., 1] * (1 + 3 * x[..., 0] ** 2), -(x[..., 0] + x[..., 0] ** 3)], [zero, zero]]
    return np.stack([np.stack(row, -1) for row in rows], -2)


@cache
def radau_falls(count: int) -> tuple[NDArray[np.float64], Extended]:
    return falls(count, radau_tableau())


def falls(count: int, tableau: Tableau) -> tuple[NDArray[np.float64], Extended]:
    source = np.random.default_rng(4)
    start = np.stack([source.uniform(-2, 2, count), 10 ** source.uniform(-2, 7, count)], 1)
    end, _ = followed(tableau, fall, fall_jacobian, start, 10 ** np.arange(-9, 0, 0.25))
    return start, end


@METHODS
def test_stiff_falls_end_where_they_should_or_fail_by_name(method: type[Gauss]) -> None:
    start, exact = falls(150, gauss_tableau(method.stages))
    solution = method().prepare(one_step(FirstOrder(relax), 2), 1.0)(start)
    found = solution.states[:, 0, 0]
    failed = np.isnan(found)
    assert (solution.stopped is None) == (not failed.any())
    assert solution.stopped is None or "the stages of a step did not converge before sample 1" in solution.stopped
    assert np.mean(failed) < 0.5
    assert np.max(np.abs(found - exact[:, 0])[~failed]) < 2 * CLOSE * most_weight(method, False) * ULP


def oscillate(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    (w,) = parameters
    return v, -w * w * x


def test_a_cycle_of_rounds_is_no_solution() -> None:
    """At omega h = 2 rounds of the midpoint rule return after four, through components that are 0: from (1, 0) the step
    leads to (0, -2). One change over a size of 0 was infinite, beside which all later ones seemed to vanish."""
    solution = ImplicitMidpoint().prepare(one_step(FirstOrder(oscillate), 2, 2.0), 1.0)(np.array([[1.0, 0.0]]))
    assert solution.states[0, 0].tolist() == [0.0, -2.0]


def test_a_large_change_is_never_accepted() -> None:
    for least in (1.0, 1e300, math.inf):
        assert not has_settled(3, 1e-3, least, 0, ULP)
        assert not has_settled(3, 2 * NOISE * ULP, least, STALLED_ROUNDS, ULP)
    assert has_settled(3, 1e-13, 1e-4, 0, ULP), "the next one is 1e-22"
    assert not has_settled(3, 1e-16, 2e-15, 0, ULP), "the next one is 5e-18, in every step of the same sign"
    assert not has_settled(3, 1e-12, 1e-12, 1, ULP), "changes of an oscillation rise and fall"
    assert has_settled(3, 1e-12, 1e-12, STALLED_ROUNDS, ULP)


def pull_back(t: Any, place: Values, parameters: Values) -> Values:
    (x,) = place
    (w,) = parameters
    return (-w * w * sin(x),)


def test_a_small_swing_stays_small_where_a_far_solution_attracts_the_rounds() -> None:
    """At omega h = 4.35 the midpoint u of a step has u + 4.73 sin u = a, with a second pair of roots near 4.2 and 4.8 from
    omega h = 4.292 on. Rounds leave the near root, which repels them, and come to rest at 4.8, which attracts."""
    for w in np.linspace(4.343, 4.357, 15):
        quarter = w * w / 4
        assert 1 + quarter * math.cos(0.05) > 4, "rounds of the fixed point leave the near root"
        problem = Problem(SecondOrder(pull_back), 2, np.array([w]), np.arange(1.0, 1025.0), 1.0)
        states = ImplicitMidpoint().prepare(problem, 1.0)(np.array([[0.05, 0.0]])).states[0]
        before = np.concatenate([[[0.05, 0.0]], states[:-1]])
        middle = before[:, 0] + before[:, 1] / 2 - (before[:, 1] - states[:, 1]) / 4
        a = before[:, 0] + before[:, 1] / 2
        root = a / (1 + quarter)
        for _ in range(5):
            root -= (root + quarter * np.sin(root) - a) / (1 + quarter * np.cos(root))
        assert np.max(np.abs(middle - root)) < CLOSE * ULP


@pytest.mark.parametrize("method", [ImplicitMidpoint, Gauss2, Gauss4])
@pytest.mark.parametrize("numbers", [{"span": 4000}, {"span": 800, "c": 2, "k": 1}])
def test_what_decays_beyond_the_smallest_number_comes_to_rest(method: type[Gauss], numbers: dict[str, float]) -> None:
    """exp(-800) is below it. A change of the last digit of a subnormal number is never below relative round-off."""
    case = get("damped_oscillator", **numbers).rounded()
    for count in (4, 16, 64):
        found = solved(method(), case, steps=count)
        # A quarter of a step's angle is below 1 only in the finer ones; the others lose less than the motion does.
        assert count < 64 or np.max(np.abs(found.states[-1])) < 1e-50


@pytest.mark.parametrize("form", [FirstOrder(oscillate), SecondOrder(pull_back)], ids=lambda form: type(form).__name__)
@pytest.mark.parametrize("method", [ImplicitMidpoint, Gauss2, Gauss4])
def test_rounds_come_to_rest_below_the_smallest_number(
    method: type[Gauss], form: Form, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without Newton's iteration, which is tried where rounds fail and would hide it. At amplitudes of 2^-1060 a unit in
    the last place is 2^-14 of them."""
    monkeypatch.setattr(Gauss, "by_newton", lambda *_: None)
    problem = Problem(form, 2, np.array([0.5]), np.arange(1.0, 33.0), 1.0)
    initial = 2.0**-1060 * np.random.default_rng(6).uniform(-1, 1, (50, 2))
    assert method().prepare(problem, 1.0)(initial).stopped is None


def drop(q: Extended, v: Extended, h: Extended, g: float, square: Any) -> tuple[Extended, Extended, Any]:
    """One RATTLE step on a circle: the near root of its quadratic equation; and its discriminant over that for h = 0."""
    force = np.array([0, -g], dtype=np.longdouble)
    half = v + h / 2 * force
    place = q + h * half
    along, off = np.sum(q * place, 1, keepdims=True), np.sum(place**2, 1, keepdims=True) - square
    root = along**2 - square * off
    share = off / (along + np.sign(along) * np.sqrt(np.maximum(root, 0)))
    place, half = place - share * q, half - share * q / h
    end = half + h / 2 * force
    return place, end - np.sum(end * place, 1, keepdims=True) / square * place, (root / square**2)[:, 0]


@pytest.mark.parametrize("method", rattle.INTEGRATORS, ids=lambda method: method.name)
def test_steps_on_a_circle_end_at_the_near_root_or_fail_by_name(method: type[FixedStep]) -> None:
    """10,000 steps, of which the longest leave the circle so far that no correction along the gradient leads back."""
    source, count, g = np.random.default_rng(5), 10000, 9.75
    angle, radius = source.uniform(0, 2 * np.pi, count), 10 ** source.uniform(-1, 1, count)
    speed = source.uniform(-1.5, 1.5, count) * radius
    # The state's own numbers are the exact ones; that it is tangent to round-off is not needed.
    start = np.stack([radius * np.sin(angle), -radius * np.cos(angle)], 1)
    velocity = speed[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)
    initial = np.concatenate([start, velocity], 1)
    form = get("holonomic_constraint_dae").forms[0]
    h = 0.75
    problem = Problem(form, 4, np.array([g]), np.array([h]), 1.0)
    solution = method().prepare(problem, h)(initial)
    found = solution.states[:, 0]

    q, v = start.astype(np.longdouble), velocity.astype(np.longdouble)
    square, least = np.sum(q**2, 1, keepdims=True), np.full(count, np.inf)
    with working(40) as mp:
        lengths = [np.longdouble(mp.nstr(x * mp.mpf(h), 25)) for x in method.coefficients(mp)[0]]
    with np.errstate(all="ignore"):  # where there is no root, the rest is ignored
        for length in lengths:
            if length != 0:
                q, v, root = drop(q, v, length, g, square)
                least = np.fmin(least, root).astype(np.float64)
    failed = np.isnan(found[:, 0])
    assert "the stages of a step did not converge before sample 1" in str(solution.stopped)
    assert np.all(failed[least < -1e-9]), "there is no root"
    assert 0.1 < np.mean(failed) < 0.9
    assert np.max(np.abs(np.sum(found[:, :2] ** 2, 1) / square[:, 0] - 1)[~failed]) < CLOSE * ULP
    # Round-off is magnified by each substep's 1 / sqrt(least); at most nine follow one another.
    clear = least > 0.01
    assert np.all(~failed[clear])
    sizes = np.sqrt(square) * np.array([1, 1, 1 / h, 1 / h])
    error = np.max(np.abs(found - np.concatenate([q, v], 1)) / sizes, 1)[clear]
    assert np.quantile(error, 0.5) < CLOSE * ULP * len(lengths)
    assert np.max(error) < 1e-9


def radau_tableau() -> Tableau:
    with working(40) as mp:
        return Tableau.of(mp, Radau5.tableau(mp))


def test_radau_solves_linear_steps() -> None:
    """Its iteration ends below 2e-15 of 1 + |y|; the transformation's matrices magnify that less than 10 times."""
    z, (unit, _) = rates(5000), starts(5000)
    initial = np.stack([z.real, z.imag, unit.real, unit.imag], 1)
    solution = radau.prepare_solver(one_step(FirstOrder(linear), 4), 1e-14, 1.0)(initial)
    assert solution.stopped is None
    found = solution.states[:, 0, 2] + 1j * solution.states[:, 0, 3]
    exact = pade(3, 2, z.astype(np.clongdouble)) * unit
    assert np.max(np.abs(found - exact)) < 10 * 2e-15 * 2


@pytest.mark.parametrize("count", [340, pytest.param(3400, marks=pytest.mark.slow)])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-8])
def test_adaptive_radau_solves_its_stages_to_a_part_of_its_tolerance(tolerance: float, count: int) -> None:
    """`count` steps of 1, the first of their runs; iteration leaves a few per cent of the tolerance in those that
    error control accepts.

    The norm is a mean over six numbers, two of which are of the last stage: 3.5. The rate of the first two changes, the
    only rate known after them, can be a third of the rate of later changes.
    """
    start, exact = radau_falls(count)
    solve = Radau5().prepare(one_step(FirstOrder(relax), 2, time_scale=1e6), tolerance)
    inner = 0.1 * tolerance ** (2 / 3)
    enough = max(2e-15 / inner, min(0.03, math.sqrt(inner)))
    accepted = 0
    for state, end in zip(start, exact, strict=True):
        solution = solve(state[None])
        assert solution.stopped is None
        if solution.steps == 1:
            accepted += 1
            assert abs(solution.states[0, 0, 0] - end[0]) < 3.5 * 4 * enough * inner * (1 + abs(state[0]))
    assert accepted > count / 34
