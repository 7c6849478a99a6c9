"""Radau IIA 5: coefficients, order at fixed steps, stiff equations in few steps, failures with their reason."""

from itertools import pairwise
from math import cos, sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.contract.problem import counting, initial_state, problem_of
from gnomon.harness.integrators.gauss import radau, radau_steps
from gnomon.harness.integrators.gauss.gauss import integrals
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.gauss.radau_steps import BACK, BASIS, EIGENVALUES, ERROR, FORWARD, basis
from gnomon.harness.results.convergence_order import fit_order
from gnomon.reference.numerics.precision import working
from on_cases import exact_states, of_order, solved

SIXTY = 1e-56
"""Sixty digits, of which sums of a few terms of size 10 and a small linear system lose three."""


def test_the_last_stage_is_the_end_of_the_step() -> None:
    """Its order is tested with the other tableaux, in test_tableau.py."""
    with working(60) as mp:
        *_, last, end = Radau5.tableau(mp).rows(mp)
    assert last[1:] == end[1:]


def test_the_transformation_block_diagonalizes_the_inverse_matrix() -> None:
    with working(60) as mp:
        table = radau.rows(mp)
        gamma, alpha, beta = table[EIGENVALUES]
        forward, back = (mp.matrix([list(table[first + i]) for i in range(3)]) for first in (FORWARD, BACK))
        blocks = mp.matrix([[gamma, 0, 0], [0, alpha, -beta], [0, beta, alpha]])
        matrix = mp.matrix([integrals(mp, table[0], node) for node in table[0]])
        assert mp.mnorm(matrix * (forward * blocks * back) - mp.eye(3)) < SIXTY


def test_stages_are_interpolated() -> None:
    """The polynomials are 1 at their own node and 0 at the others; the binary64 table is the rounding of the rows."""
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
    exact, start = exact_states(case), initial_state(case)[None]
    steps = [problem.interval * k for k in (8, 4, 2, 1, 0.5, 0.25)]
    errors = []
    for h in steps:
        states = radau.prepare_solver(problem, 1e-14, h)(start).states[0]
        # Between steps the collocation polynomial is of order 3: samples that are steps count.
        errors.append(float(np.max(case.metric.distance(states[7::8], exact[7::8]))))
    assert fit_order(steps, errors, floor=1e-14) == of_order(5)


@pytest.mark.parametrize("variant", ["stiff_1e6", "stiff_1e9", "stiff_1e12"])
def test_stiffness_takes_no_more_steps(variant: str) -> None:
    """A mode faster by 1e6 to 1e12 takes no more steps than the slow motion needs."""
    case = get("damped_oscillator", variant).rounded()
    found = solved(Radau5(), case, 1e-8, counted=True)
    assert found.steps < 150
    assert found.calls < 20 * found.steps, "a few iterations of three stages"
    # At each step the error of order 3 is below 0.1 tol^(2/3), the error of order 5 about tol.
    assert found.error < 100 * 1e-8


def test_errors_fall_with_the_tolerance() -> None:
    case = get("pendulum_simple").rounded()
    errors = [solved(Radau5(), case, tolerance).error for tolerance in (1e-4, 1e-7, 1e-10)]
    # h^4 follows tol^(2/3), so the error of order 5 follows tol^(5/6): 2.5 decades of 3.
    assert errors[0] / errors[1] == pytest.approx(10**2.5, rel=0.6)
    assert errors[1] / errors[2] == pytest.approx(10**2.5, rel=0.6)


def follow(t: Any, state: Values, parameters: Values) -> Values:
    """Prothero and Robinson's equation: u = cos t, which other solutions approach at a rate of L."""
    (u,) = state
    (rate,) = parameters
    return (-rate * (u - cos(t)) - sin(t),)


@pytest.mark.parametrize("rate", [1e2, 1e4, 1e6, 1e8])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-7, 1e-10])
def test_a_sample_is_as_good_as_a_step(rate: float, tolerance: float) -> None:
    """The polynomial of steps of half a radian to five, at a rate that needs no shorter ones, errs by up to 1.

    A sample is compared with the end of a separate run to its time, with other steps before it: the largest error and the
    root mean square over the same 64 times. Single ones differ more, as errors pass through zero.
    """
    times = np.arange(1, 65) * (10 / 64)

    def errors(chosen: Any) -> Any:
        problem = Problem(FirstOrder(follow), 1, np.array([rate]), chosen, 1.0)
        solution = Radau5().prepare(problem, tolerance)(np.array([[1.0]]))
        assert solution.stopped is None
        return np.abs(solution.states[0, :, 0] - np.cos(chosen))

    as_steps = np.array([float(errors(times[k : k + 1])[0]) for k in range(64)])
    found = errors(times)
    # Measured: 0.36 to 1.00 and 0.53 to 1.00.
    assert np.max(found) < 1.5 * np.max(as_steps)
    assert np.mean(found**2) < 1.5**2 * np.mean(as_steps**2)


@pytest.mark.parametrize("name", ["pendulum_simple", "kepler_orbit", "damped_oscillator"])
def test_samples_of_equations_that_are_not_stiff_take_no_right_hand_sides(name: str) -> None:
    case = get(name).rounded()
    spent = []
    for samples in (slice(None), slice(63, None)):
        problem = problem_of(case, Radau5.accepts)
        problem = counting(
            Problem(problem.form, problem.dimension, problem.parameters, problem.times[samples], problem.time_scale)
        )
        Radau5().prepare(problem, 1e-6)(initial_state(case)[None])
        spent.append(problem.buffer[-1])
    assert spent[0] == spent[1]


def swing(t: Any, state: Values, parameters: Values) -> Values:
    """With a pull that grows as t squared: steps become shorter all the time, and some are rejected."""
    x, v = state
    return v, -(1 + 4 * t * t) * sin(x)


def swing_derivative(t: Any, state: Values, parameters: Values) -> Values:
    x, _ = state
    return 0, 1, -(1 + 4 * t * t) * np.cos(x), 0


def run(monkeypatch: pytest.MonkeyPatch, f: Any, derivative: Any, start: Any, times: Any) -> tuple[Any, Any, list[Any]]:
    """The loop of steps, uncompiled, at 1e-5: states, why it stopped, and for each attempt t, h, error, iterations."""
    attempts: list[Any] = []
    newton, estimate = radau_steps.newton, radau_steps.estimate
    iterations = [0]

    def counted(*arguments: Any) -> int:
        iterations[0] = newton(*arguments)
        return iterations[0]

    def watched(f: Any, t: Any, h: Any, *rest: Any) -> float:
        norm = estimate(f, t, h, *rest)
        attempts.append((t, h, norm, iterations[0]))
        return norm

    monkeypatch.setattr(radau_steps, "newton", counted)
    monkeypatch.setattr(radau_steps, "estimate", watched)
    out, stop = np.full((1, len(times), len(start)), np.nan), np.zeros(2, dtype=np.int64)
    radau_steps.integrate(
        f,
        derivative,
        (),
        radau.table(),
        np.array([start]),
        np.array(times),
        1e-5,
        0.0,
        np.arange(len(start)),
        np.array([1e4, np.inf, 0.0]),
        out,
        stop,
    )
    return out[0], stop, attempts


def test_steps_follow_the_predictive_controller(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hairer and Wanner, IV.8 (8.21), (8.25): fac = 0.9 (2 k + 1) / (2 k + n) for n of k iterations; the next step is
    fac h err^(-1/4), times h / h' (err' / err)^(1/4) where the step before, h', and its error predict a shorter one;
    between a fifth and eight times h; after a rejection at most h. An error before below 1e-2 counts as 1e-2."""
    _, stop, attempts = run(monkeypatch, swing, swing_derivative, [2.0, 0.0], [4.0])
    assert not stop.any()
    most = radau_steps.MOST_ITERATIONS
    before, rejected, seen = None, False, set()
    for (t, h, error, iterations), (after, wanted, _, _) in pairwise(attempts[:-1]):
        factor = 0.9 * (2 * most + 1) / (2 * most + iterations)
        ratio = error**-0.25
        if before is not None and not rejected:
            foretold = ratio * h / before[0] * (max(before[1], 1e-2) / error) ** 0.25
            seen.add("shorter" if foretold < ratio else "plain")
            ratio = min(ratio, foretold)
        ratio = min(8.0, max(0.2, factor * ratio))
        if error < 1:
            assert after == pytest.approx(t + h, rel=1e-15)
            ratio = min(ratio, 1.0) if rejected else ratio
            before, rejected = (h, error), False
        else:
            assert after == t
            rejected = True
            seen.add("rejected")
        # Steps are rounded so that times are exact sums.
        assert wanted == pytest.approx(h * ratio, rel=1e-12)
    assert seen == {"shorter", "plain", "rejected"}


def test_a_sample_that_no_step_reaches_becomes_the_end_of_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the iteration of a sample's separate step fails, the step is repeated, ending at the sample or before."""
    rate = 1e4
    times = [float(x) for x in np.arange(1, 17) / 2]

    def f(t: Any, state: Values, parameters: Values) -> Values:
        return follow(t, state, (rate,))

    def derivative(t: Any, state: Values, parameters: Values) -> Values:
        return (-rate,)

    inside, newton = [0], radau_steps.newton

    def failing(f: Any, t: Any, h: Any, *rest: Any) -> int:
        # Samples within steps take their scratch from `error`; a step that has been accepted ends beyond them.
        aside = any(t < sample - 1e-9 and t + h == sample and ends[0] > sample for sample in times)
        inside[0] += aside
        return 0 if aside else newton(f, t, h, *rest)

    ends, estimate = [0.0], radau_steps.estimate

    def noted(f: Any, t: Any, h: Any, *rest: Any) -> float:
        ends[0] = t + h
        return estimate(f, t, h, *rest)

    monkeypatch.setattr(radau_steps, "newton", failing)
    monkeypatch.setattr(radau_steps, "estimate", noted)
    states, stop, _ = run(monkeypatch, f, derivative, [1.0], times)
    assert inside[0] > 0
    assert not stop.any()
    assert np.max(np.abs(states[:, 0] - np.cos(times))) < 1e-4


def test_changes_that_do_not_shrink_are_no_solution() -> None:
    """With changes of two percent of the tolerance each, the iteration might never end: the error left is unknown."""
    calls = [0]

    def drifting(t: Any, state: Values, parameters: Values) -> Values:
        calls[0] += 1
        return (1e-2 * ((calls[0] + 2) // 3),)

    def empty(*shape: int, kind: type = float) -> Any:
        return np.zeros(shape, dtype=kind)

    s = radau_steps.RadauData(
        f=drifting, y=empty(1), p=(), table=radau.table(), x=empty(1), slopes=empty(3, 1), weight=np.ones(1), slope=empty(1),
        start=empty(1), error=empty(1), real=empty(1, 1), pivots=empty(1, kind=int), both=empty(1, 1, kind=complex),
        pivots_both=empty(1, kind=int), right=empty(1), pair=empty(1, kind=complex), w=empty(3, 1), z=empty(3, 1),
    )  # fmt: skip
    assert radau_steps.factor_shifted(s, 1.0, empty(1))
    iterations = radau_steps.newton(s, 0.0, 1.0, 1.0)
    assert calls[0] > 6, "the changes were small enough to go on"
    assert iterations == 0
