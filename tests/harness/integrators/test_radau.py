"""Radau IIA 5: coefficients, order at fixed steps, stiff equations in few steps, failures with their reason."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bad_equations import branching, scalar, squared, undefined
from gnomon.cases.registry import get
from gnomon.harness.integrator import Refused
from gnomon.harness.integrators import radau
from gnomon.harness.integrators.gauss import integrals
from gnomon.harness.integrators.radau import Radau5
from gnomon.harness.integrators.radau_steps import BACK, BASIS, EIGENVALUES, ERROR, FORWARD, basis
from gnomon.harness.order import fit_order
from gnomon.harness.problem import counting, initial_state, problem_of
from gnomon.reference.precision import working

SIXTY = 1e-56
"""Sixty digits, of which sums of a few terms of size 10 and a small linear system lose three."""


def test_collocation_at_the_radau_nodes() -> None:
    """B(5) and C(3), which make order 5, and the last stage is the end of the step."""
    with working(60) as mp:
        c = radau.nodes(mp)
        a = [integrals(mp, c, node) for node in c]
        for q in range(1, 6):
            assert abs(mp.fsum(b * x ** (q - 1) for b, x in zip(a[2], c, strict=True)) - mp.mpf(1) / q) < SIXTY
        for q in range(1, 4):
            for i in range(3):
                assert abs(mp.fsum(a[i][j] * c[j] ** (q - 1) for j in range(3)) - c[i] ** q / q) < SIXTY


def test_the_transformation_takes_the_inverse_matrix_apart() -> None:
    with working(60) as mp:
        table = radau.rows(mp)
        gamma, alpha, beta = table[EIGENVALUES]
        forward, back = (mp.matrix([list(table[first + i]) for i in range(3)]) for first in (FORWARD, BACK))
        blocks = mp.matrix([[gamma, 0, 0], [0, alpha, -beta], [0, beta, alpha]])
        matrix = mp.matrix([integrals(mp, table[0], node) for node in table[0]])
        assert mp.mnorm(matrix * (forward * blocks * back) - mp.eye(3)) < SIXTY


def test_stages_are_interpolated() -> None:
    """By polynomials that are 1 at their own node and 0 at the others; the binary64 table is the rounding of the rows."""
    with working(60) as mp:
        table = radau.rows(mp)
        for k in range(3):
            for j in range(3):
                assert abs(basis(k, table[0][j], np.array(table[: BASIS + 1], dtype=object)) - (j == k)) < SIXTY
        rounded = [[float(x) for x in row] for row in table]
    assert radau.table().tolist() == rounded


def test_the_error_estimate_vanishes_up_to_order_3() -> None:
    """For y' = t^q the stages are c^(q+1)/(q+1): f(0) and their weighted sum cancel for q up to 2."""
    with working(60) as mp:
        table = radau.rows(mp)
        c, weights = table[0], table[ERROR]
        sums = [
            (q == 0) + mp.fsum(e * x ** (q + 1) for e, x in zip(weights, c, strict=True)) / (q + 1) for q in range(4)
        ]
        assert all(abs(value) < SIXTY for value in sums[:3])
        assert abs(sums[3]) > 1e-3


@pytest.mark.parametrize("name", ["pendulum_simple", "damped_oscillator"])
def test_order_at_fixed_steps(name: str) -> None:
    case = get(name, span=3).rounded()
    problem = problem_of(case, Radau5.accepts)
    exact, start = case.sample(case.times), initial_state(case)[None]
    steps = [problem.interval * k for k in (8, 4, 2, 1, 0.5, 0.25)]
    errors = []
    for h in steps:
        states = radau.prepared(problem, 1e-14, h)(start).states[0]
        # Between steps the collocation polynomial is of order 3: samples that are steps count.
        errors.append(float(np.max(case.metric.distance(states[7::8], exact[7::8]))))
    measured = fit_order(steps, errors, floor=1e-14)
    assert measured is not None
    assert measured[0] == pytest.approx(5, abs=0.1)


@pytest.mark.parametrize("variant", ["stiff_1e6", "stiff_1e9", "stiff_1e12"])
def test_stiffness_costs_nothing(variant: str) -> None:
    """A mode a million to a million million times faster takes no more steps than the slow motion needs."""
    case = get("damped_oscillator", variant).rounded()
    problem = counting(problem_of(case, Radau5.accepts))
    solution = Radau5().prepare(problem, 1e-8)(initial_state(case)[None])
    assert solution.stopped is None
    assert solution.steps is not None
    assert solution.steps < 150
    assert problem.buffer[-1] < 20 * solution.steps, "a few iterations of three stages"
    # At each step the error of order 3 is below 0.1 tol^(2/3), that of order 5 about tol.
    assert np.max(case.metric.distance(solution.states[0], case.sample(case.times))) < 100 * 1e-8


def test_errors_fall_with_the_tolerance() -> None:
    case = get("pendulum_simple").rounded()
    problem = problem_of(case, Radau5.accepts)
    exact, start = case.sample(case.times), initial_state(case)[None]
    errors = [
        float(np.max(case.metric.distance(Radau5().prepare(problem, tolerance)(start).states[0], exact)))
        for tolerance in (1e-4, 1e-7, 1e-10)
    ]
    # h^4 follows tol^(2/3), so the error of order 5 follows tol^(5/6): 2.5 decades of 3.
    assert errors[0] / errors[1] == pytest.approx(10**2.5, rel=0.6)
    assert errors[1] / errors[2] == pytest.approx(10**2.5, rel=0.6)


def test_the_same_bits_alone_in_an_ensemble_and_again() -> None:
    case = get("pendulum_simple").rounded()
    solve = Radau5().prepare(problem_of(case, Radau5.accepts), 1e-7)
    first = initial_state(case)
    pair = np.array([first, 0.5 * first])
    together = solve(pair).states
    assert np.array_equal(together, solve(pair).states)
    assert np.array_equal(together[1], solve(pair[1:]).states[0])


def test_equations_that_branch_are_refused() -> None:
    with pytest.raises(Refused, match="must not branch"):
        Radau5().prepare(scalar(branching), 1e-6)


@pytest.mark.parametrize(("equations", "why"), [(squared, "fell below the spacing"), (undefined, "not finite")])
def test_failures_end_with_their_reason(equations: Any, why: str) -> None:
    solution = Radau5().prepare(scalar(equations), 1e-6)(np.array([[1.0]]))
    assert solution.stopped is not None
    assert why in solution.stopped
    assert "before sample" in solution.stopped
    assert np.isnan(solution.states[0, -1, 0])
