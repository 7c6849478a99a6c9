"""Exponential Runge-Kutta: its matrix functions, order conditions as matrices, measured order, stiff linear parts."""

import random
from dataclasses import replace
from math import sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.forms import SemiLinear, Values
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.integrators.geometric.exponential import HochbruckOstermann4, phi_functions
from gnomon.harness.results.convergence_order import fit_order
from gnomon.harness.studies.orders import measure_order, solve_exactly
from gnomon.reference.numerics.precision import working
from on_cases import of_order, solved

CASES = ("damped_oscillator", "forced_oscillator", "projectile_stokes_drag")


@pytest.mark.parametrize("name", CASES)
def test_linear_part_and_rest_make_the_equations(name: str) -> None:
    case, source = get(name), random.Random(name)
    (form,) = case.forms
    assert isinstance(form, SemiLinear)
    with working(60) as mp:
        state = tuple(mp.mpf(source.uniform(-2, 2)) for _ in case.state)
        p = tuple(mp.mpf(source.uniform(1, 2)) for _ in case.parameter_list)
        t, n, arithmetic = mp.mpf(1) / 3, len(case.state), mpmath_arithmetic(mp)
        matrix = form.linear(p)
        whole, rest = (rebind(f, arithmetic)(t, state, p) for f in (form.equations, form.rest))
        for i in range(n):
            assert abs(mp.fdot(matrix[i * n : i * n + n], state) + rest[i] - whole[i]) < 1e-55


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e6])
def test_phi_functions(size: float) -> None:
    """For a diagonal matrix by their definition in far more digits; for a full one by the recurrence."""
    with working(60) as mp:
        values = [mp.mpf(-size), mp.mpf(size) / 7**8, mp.mpf(0)]
        diagonal = np.array(
            [[v if i == j else mp.mpf(0) for j in range(3)] for i, v in enumerate(values)], dtype=object
        )
        found = phi_functions(mp, diagonal)
        for i, v in enumerate(values):
            for k in range(4):
                with mp.workdps(120):
                    rest = mp.exp(v) - mp.fsum(v**j / mp.factorial(j) for j in range(k))
                    wanted = rest / v**k if v else 1 / mp.factorial(k)
                assert abs(found[k][i, i] - wanted) <= 1e-55 * abs(wanted)
        full = np.array([[mp.mpf(0), mp.mpf(1)], [-mp.mpf(size), -mp.mpf(size) - 1]], dtype=object)
        phi = phi_functions(mp, full)
        for k in range(1, 4):
            gap = full.dot(phi[k]) - phi[k - 1] + np.eye(2, dtype=int) / mp.factorial(k - 1)
            assert max(abs(x) for x in gap.ravel()) < 1e-50 * size


def test_stiff_order_conditions_hold_as_matrices() -> None:
    """Sums of the rows are c phi_1(c z); b, b c and b c^2/2 sum to phi_1, phi_2, phi_3 (their paper, table 5.1)."""
    with working(60) as mp:
        z = np.array([[mp.mpf(-3), mp.mpf(1)], [mp.mpf(2), mp.mpf(-5)]], dtype=object)
        nodes = (*HochbruckOstermann4.nodes, 1)
        known = {c: phi_functions(mp, c * z) for c in set(nodes)}
        *stages, weights = HochbruckOstermann4.tableau(lambda k, c: known[c][k])
        for c, row in zip(nodes[1:], stages[1:], strict=False):
            assert np.max(np.abs(sum(row) - c * known[c][1])) < 1e-55
        for q, power in enumerate((1, 1, 2)):
            total = sum(b * (mp.mpf(c) ** q / power) for b, c in zip(weights, nodes[:-1], strict=True))
            assert np.max(np.abs(total - known[1][q + 1])) < 1e-55


def test_stiff_order_conditions_of_inner_stages_hold_as_matrices() -> None:
    """For any Jacobian of the rest: conditions 5, 8 and 9 of their table 5.1, and 7 with weights at z = 0.

    With psi_q,i = sum of a_ij c_j^(q-1)/(q-1)! less c_i^q phi_q(c_i z). Mistyped inner coefficients that keep the sums
    of rows fail here; where nothing is stiff no order would show it.
    """
    with working(60) as mp:
        z = np.array([[mp.mpf(-3), mp.mpf(1)], [mp.mpf(2), mp.mpf(-5)]], dtype=object)
        jacobian = np.array([[mp.mpf(1), mp.mpf(4)], [mp.mpf(-2), mp.mpf(7)]], dtype=object)
        nodes = HochbruckOstermann4.nodes
        known = {c: phi_functions(mp, c * z) for c in {*nodes, 1}}
        at_zero = {c: phi_functions(mp, 0 * z) for c in {*nodes, 1}}
        *stages, weights = HochbruckOstermann4.tableau(lambda k, c: known[c][k])
        *_, plain = HochbruckOstermann4.tableau(lambda k, c: at_zero[c][k])
        second, third = (
            [
                sum((a * (mp.mpf(c) ** (q - 1) / (q - 1)) for a, c in zip(row, nodes, strict=False)), 0 * z)
                - mp.mpf(node) ** q * known[node][q]
                for node, row in zip(nodes, stages, strict=True)
            ]
            for q in (2, 3)
        )
        inner = [sum((a.dot(jacobian).dot(d) for a, d in zip(row, second, strict=False)), 0 * z) for row in stages]
        for total in (
            sum(b.dot(jacobian).dot(d) for b, d in zip(weights, second, strict=True)),
            sum(b.dot(jacobian).dot(d) for b, d in zip(weights, inner, strict=True)),
            sum(b.dot(jacobian).dot(d) * mp.mpf(c) for b, d, c in zip(weights, second, nodes, strict=True)),
            sum(b.dot(jacobian).dot(d) for b, d in zip(plain, third, strict=True)),
        ):
            assert np.max(np.abs(total)) < 1e-55


def test_order_on_a_driven_oscillator() -> None:
    assert measure_order(HochbruckOstermann4(), get("forced_oscillator")) == of_order(4)


def pendulum_matrix(parameters: Values) -> Values:
    g, length = parameters
    return 0, 1, -g / length, 0


def pendulum_rest(t: Any, state: Values, parameters: Values) -> Values:
    theta, _omega = state
    g, length = parameters
    return 0 * theta, g / length * (theta - sin(theta))


def test_order_on_a_nonlinear_rest() -> None:
    """The pendulum as its small vibration and the rest, in sixty digits."""
    case = get("pendulum_simple", span=1)
    form = SemiLinear(len, linear=pendulum_matrix, rest=pendulum_rest)
    counts = (64, 96, 128, 192)
    with working(60):
        exact = case.exact(case.span, 50)
        errors = []
        for count in counts:
            found = solve_exactly(
                HochbruckOstermann4(), form, case.parameter_values(), case.initial_state, case.span, count
            )
            errors.append(float(max(abs(a - b) for a, b in zip(found, exact, strict=True))))
    assert fit_order([1 / count for count in counts], errors) == of_order(4)


@pytest.mark.parametrize(
    ("name", "variant"),
    [
        *(("damped_oscillator", v) for v in (None, "critical", "near_critical_below", "stiff_1e6", "stiff_1e12")),
        ("projectile_stokes_drag", "stiff"),
        ("projectile_stokes_drag", "no_drag"),
    ],
)
def test_linear_problems_are_solved_to_round_off_in_one_step_a_sample(name: str, variant: str | None) -> None:
    case = get(name, variant).rounded()
    # The coefficients are rounded once: an ulp each for a few terms, and 64 compensated steps.
    assert (
        solved(HochbruckOstermann4(), case, steps=1).error
        < np.max(case.conditioning(case.times)) + 4 * np.finfo(float).eps
    )


def test_samples_off_the_grid_are_refused() -> None:
    case = get("forced_oscillator").rounded()
    problem = problem_of(case, HochbruckOstermann4.accepts)
    shifted = replace(problem, times=problem.times * np.linspace(0.99, 1, 64))
    with pytest.raises(Refused, match="one step size"):
        HochbruckOstermann4().prepare(shifted, problem.interval)
    with pytest.raises(Refused, match="not a positive number"):
        HochbruckOstermann4().prepare(problem, float("nan"))
