"""Rotation-group methods: order, with and without torque; angular momentum and attitude to round-off.

The reference solution is the Taylor integration of Euler's equations in balls, which shares nothing with the methods.
"""

from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import RigidBody, Values, euler_equations
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Problem, Refused
from gnomon.harness.integrators.base.fixed_step import FixedStep
from gnomon.harness.integrators.geometric import lie
from gnomon.harness.integrators.geometric.lie import AxisSplitting2, AxisSplitting6, MuntheKaas4
from gnomon.harness.results.convergence_order import fit_order
from gnomon.harness.studies.orders import solve_exactly
from gnomon.reference.numerics import taylor
from gnomon.reference.numerics.precision import nearest_double, working
from numpy.typing import NDArray
from on_cases import of_order, solved

MOMENTS = (1.0, 2.0, 3.0)
START = (1.0, 0.6, 0.1, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
TIMES = np.arange(1, 65) * 0.25


def moments(parameters: Values) -> Values:
    return parameters


def no_torque(t: Any, state: Values, parameters: Values) -> Values:
    return 0.0, 0.0, 0.0


def gravity(t: Any, state: Values, parameters: Values) -> Values:
    """A top with a weight of 1/8 at the end of the third axis: e3 x R^T (0, 0, -1/8)."""
    r31, r32 = state[9], state[10]
    return r32 / 8, -r31 / 8, 0.0


def friction(t: Any, state: Values, parameters: Values) -> Values:
    return -state[0] / 8, -state[1] / 8, -state[2] / 8


FREE, HEAVY, DAMPED = (RigidBody(moments, torque) for torque in (no_torque, gravity, friction))
TORQUES = {"free": FREE, "heavy": HEAVY, "damped": DAMPED}


@cache
def exact(name: str) -> NDArray[np.float64]:
    form = TORQUES[name]

    def field(t: Any, y: Values) -> Values:
        return euler_equations(y, MOMENTS, form.torque(t, y, MOMENTS))

    found = taylor.integrate(field, [Fraction(x) for x in START], [Fraction(t) for t in TIMES.tolist()], 20)
    with working(30) as mp:
        return np.array([[nearest_double(mp.mpf(x.numerator) / x.denominator) for x in state] for state in found])


def states(method: FixedStep, form: RigidBody, substeps: int) -> NDArray[np.float64]:
    problem = Problem(form, 12, np.array(MOMENTS), TIMES, 1.0)
    solution = method.prepare(problem, problem.interval / substeps)(np.array([START]))
    assert solution.stopped is None
    return solution.states[0]


PAIRS = [
    (method, name)
    for method in lie.INTEGRATORS
    for name in TORQUES
    if not (name == "damped" and "symplectic" in method.conserves)
]


@pytest.mark.parametrize(("method", "name"), PAIRS, ids=lambda x: getattr(x, "name", x))
def test_order(method: type[FixedStep], name: str) -> None:
    counts = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32]
    errors = [float(np.max(np.abs(states(method(), TORQUES[name], n) - exact(name)))) for n in counts]
    # Round-off of a few thousand steps, each of an ulp: about 1e-14.
    assert fit_order([0.25 / n for n in counts], errors, floor=1e-14) == of_order(method.order)


@pytest.mark.parametrize("method", lie.INTEGRATORS, ids=lambda method: method.name)
@pytest.mark.parametrize("name", ["free", "heavy"])
def test_attitude_stays_a_rotation(method: type[FixedStep], name: str) -> None:
    attitude = states(method(), TORQUES[name], 1)[:, 3:].reshape(-1, 3, 3)
    defect = attitude.transpose(0, 2, 1) @ attitude - np.eye(3)
    # Each of the steps (at most nine symmetric ones of five rotations a sample) rounds by an ulp at random.
    assert np.max(np.abs(defect)) < 64 * 45 * np.finfo(float).eps


@pytest.mark.parametrize("method", lie.INTEGRATORS, ids=lambda method: method.name)
def test_angular_momentum_in_space_is_constant_without_torque(method: type[FixedStep]) -> None:
    found = states(method(), FREE, 1)
    momentum = np.einsum("kij,kj->ki", found[:, 3:].reshape(-1, 3, 3), found[:, :3] * MOMENTS)
    start = np.array(START[:3]) * MOMENTS
    assert np.max(np.abs(momentum - start)) < 64 * 45 * np.finfo(float).eps * np.linalg.norm(start)


@pytest.mark.parametrize("method", lie.INTEGRATORS, ids=lambda method: method.name)
def test_gravity_leaves_the_vertical_angular_momentum_alone(method: type[FixedStep]) -> None:
    """The torque of a weight is horizontal."""
    found = states(method(), HEAVY, 1)
    vertical = np.einsum("kj,kj->k", found[:, 9:], found[:, :3] * MOMENTS)
    start = np.array(START[:3]) * MOMENTS
    assert np.max(np.abs(vertical - start[2])) < 64 * 45 * np.finfo(float).eps * np.linalg.norm(start)


def test_an_attitude_that_is_not_orthogonal_is_rotated_too() -> None:
    """R(t) = R(0) Q(t) for any matrix R(0), on which the angular velocity does not depend."""
    skew = np.array([[1.0, 0.1, 0.0], [0.0, 1.0, 0.2], [0.0, 0.0, 1.25]])
    problem = Problem(FREE, 12, np.array(MOMENTS), TIMES, 1.0)
    solve = MuntheKaas4().prepare(problem, problem.interval)
    plain, skewed = (solve(np.array([[*START[:3], *matrix.ravel()]])).states[0] for matrix in (np.eye(3), skew))
    assert np.array_equal(plain[:, :3], skewed[:, :3])
    assert np.allclose(skewed[:, 3:].reshape(-1, 3, 3), skew @ plain[:, 3:].reshape(-1, 3, 3), rtol=0, atol=1e-13)


def test_splitting_refuses_a_torque_that_depends_on_velocity() -> None:
    problem = Problem(DAMPED, 12, np.array(MOMENTS), TIMES, 1.0)
    with pytest.raises(Refused, match="depends on angular velocity"):
        AxisSplitting2().prepare(problem, problem.interval)


@pytest.mark.parametrize("method", [m for m in lie.INTEGRATORS if "symplectic" in m.conserves], ids=lambda m: m.name)
@pytest.mark.parametrize("name", ["free", "heavy"])
def test_splitting_is_a_poisson_map(method: type[FixedStep], name: str) -> None:
    """D B D^T = B' with D the Jacobian of the step of (M, G), momentum and the vertical in the body, which is the last row
    of the attitude; B = ((M x, G x), (G x, 0)) the bracket of heavy tops; in 60 digits."""
    tiny = Fraction(1, 10**20)
    inertia = [Fraction(x) for x in MOMENTS]

    def step(point: list[Fraction]) -> Any:
        rates = (m / i for m, i in zip(point[:3], inertia, strict=True))
        start = [*rates, *map(Fraction, START[3:9]), *point[3:]]
        end = solve_exactly(method(), TORQUES[name], inertia, start, Fraction(3, 10), 1)
        return [*(w * int(i) for w, i in zip(end[:3], inertia, strict=True)), *end[9:]]

    def cross(m: Any) -> Any:
        return np.array([[0, -m[2], m[1]], [m[2], 0, -m[0]], [-m[1], m[0], 0]], dtype=object)

    def bracket(point: Any) -> Any:
        m, g = cross(point[:3]), cross(point[3:])
        return np.block([[m, g], [g, np.zeros((3, 3), dtype=int)]])

    with working(60) as mp:
        start = [Fraction(1), Fraction(6, 5), Fraction(3, 10), Fraction(2, 7), Fraction(3, 7), Fraction(6, 7)]
        columns = []
        for i in range(6):
            ahead = step([m + tiny * (i == j) for j, m in enumerate(start)])
            behind = step([m - tiny * (i == j) for j, m in enumerate(start)])
            columns.append([(a - b) * 10**20 / 2 for a, b in zip(ahead, behind, strict=True)])
        d = np.array(columns, dtype=object).T
        before = bracket([mp.mpf(m.numerator) / m.denominator for m in start])
        assert np.max(np.abs(d.dot(before).dot(d.T) - bracket(step(start)))) < 1e-35


@pytest.mark.parametrize("method", [m for m in lie.INTEGRATORS if "reversible" in m.conserves], ids=lambda m: m.name)
@pytest.mark.parametrize("name", ["free", "heavy"])
def test_splitting_is_reversible(method: type[FixedStep], name: str) -> None:
    """After reversal of the angular velocity the motion returns to its start."""
    problem = Problem(TORQUES[name], 12, np.array(MOMENTS), TIMES[:16].copy(), 1.0)
    solve = method().prepare(problem, problem.interval)
    turn = np.array([-1.0] * 3 + [1.0] * 9)
    there = solve(np.array([START])).states[0, -1]
    back = solve((there * turn)[None]).states[0, -1] * turn
    assert np.max(np.abs(back - START)) < 1e-13, "32 steps of a few ulps, hardly amplified in 8 s"


def test_short_steps_reach_the_conditioning_on_the_heavy_top() -> None:
    """Rotations are added as changes, with compensation: 16384 steps of 45 rotations each leave no drift."""
    case = get("lagrange_top_attitude").rounded()
    assert solved(AxisSplitting6(), case, steps=256).error < np.max(case.conditioning(case.times))
