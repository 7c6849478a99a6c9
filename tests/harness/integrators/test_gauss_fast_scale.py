"""The fast Gauss method has no absolute scale: the same bits in other units; sizes outside its range are refused."""

from dataclasses import replace
from math import sqrt
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Problem, Solution
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.integrators.gauss import gauss_fast_kernel, gauss_fast_steps, radau
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast
from numpy.typing import NDArray
from on_cases import exact_states, solved

Floats = NDArray[np.float64]


def oscillating_first_order(t: Any, y: Any, parameters: Any) -> Any:
    x, v = y
    return v, -x


def pulled_sideways(t: Any, q: Any, parameters: Any) -> Any:
    """Nonlinear, with derivatives that the method uses, and homogeneous: twice the state has twice the acceleration."""
    x, y = q
    r = sqrt(x * x + y * y)
    return -2 * x - x * y / r, -y - x * x / r


TIMES = np.linspace(0.0, 20.0, 8)[1:]
PROBLEMS = {
    # x'' = -x: the case, for whose equations other tests compile too
    "oscillator": problem_of(get("harmonic_oscillator", m=1, k=1).rounded(), GaussFast.accepts),
    "oscillator, first order": Problem(FirstOrder(oscillating_first_order), 2, np.zeros(0), TIMES, 1.0),
    "pulled sideways": Problem(SecondOrder(pulled_sideways), 4, np.zeros(0), TIMES, 1.0),
}


def motions(name: str, starts: Floats, tolerance: float) -> Solution:
    return GaussFast().prepare(replace(PROBLEMS[name], times=TIMES), tolerance)(starts)


def motion(name: str, scale: float, tolerance: float, count: int) -> Solution:
    start = [1.0, 0.5, 0.25, -0.25][: PROBLEMS[name].dimension]
    return motions(name, np.repeat(np.array([start]) * scale, count, axis=0), tolerance)


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("oscillator", 1), ("oscillator", 16), ("oscillator, first order", 1), ("pulled sideways", 1),
        pytest.param("pulled sideways", 16, marks=pytest.mark.slow),
    ],
)  # fmt: skip
@pytest.mark.parametrize("tolerance", [1e-6, 1e-16])
def test_the_unit_of_length_changes_no_bit(name: str, tolerance: float, count: int) -> None:
    """Powers of two are exact: 2^960 is 1e289. Where r^2 is formed it stays above the underflow up to 2^-500.

    `make test` has the ensemble of the oscillator only: the other form takes 20 s to compile.
    """
    expected = motion(name, 1.0, tolerance, count)
    assert expected.stopped is None
    for power in (-500, -30, 30, 500) if name == "pulled sideways" else (-960, -500, 700, 960):
        found = motion(name, 2.0**power, tolerance, count)
        assert found.stopped is None
        assert found.steps == expected.steps
        assert np.array_equal(found.states * 2.0**-power, expected.states)


def test_a_small_trajectory_among_large_ones_is_as_good() -> None:
    """In an ensemble, the round-off of the largest trajectory does not affect the others."""
    scales = 2.0 ** -(60.0 * np.arange(16))[:, None]
    states = motions("oscillator", np.array([[1.0, 0.5]]) * scales, 1e-9).states / scales[:, :, None]
    assert np.max(np.abs(states - states[0])) < 1e-15


@pytest.mark.parametrize("count", [1, 16])
@pytest.mark.parametrize("scale", [1e-291, 1e-310, 1e292])
def test_a_start_that_binary64_cannot_carry_is_refused(scale: float, count: int) -> None:
    found = motion("oscillator", scale, 1e-9, count)
    assert "largest component of the start is not between 1e-290 and 1e+290" in str(found.stopped)
    assert np.isnan(found.states).all()


def test_a_motion_may_decay_to_zero() -> None:
    """exp(-t), with critical damping, goes below 1e-300 of its start."""
    case = get("damped_oscillator", initial_state=(1, -1), m=1, c=2, k=1, span=800).rounded()
    problem = replace(problem_of(case, GaussFast.accepts), times=np.linspace(0.0, 800.0, 9)[1:])
    found = GaussFast().prepare(problem, 1e-9)(initial_state(case)[None])
    assert found.stopped is None
    assert np.max(np.abs(found.states[0, :, 0] - np.exp(-problem.times))) < 1e-9


@pytest.fixture
def on_arrays(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """For patches of the method's functions, which NumPy runs."""
    monkeypatch.setattr(gauss_fast_kernel, "compile_advance", gauss_fast_kernel.on_arrays)
    return monkeypatch


@pytest.mark.parametrize("longest", [0.0, 0.3])
def test_a_sample_whose_stages_are_not_found_is_taken_within_a_shorter_step(
    longest: float, on_arrays: pytest.MonkeyPatch
) -> None:
    """No equations are known whose steps converge while their samples do not: here samples fail within longer steps.

    If they fail in every step, they are no results.
    """
    sample_at = gauss_fast_steps.sample_at

    def failing(equations: Any, part: float, start: Any, *others: Any) -> tuple[bool, int, Any]:
        unsolved, rounds, place = sample_at(equations, part, start, *others)
        return unsolved or start.h > longest, rounds, place

    on_arrays.setattr(gauss_fast_steps, "sample_at", failing)
    found = motion("oscillator", 1.0, 1e-9, 1)
    if longest == 0:
        assert found.stopped is not None
        assert np.isnan(found.states[0, -1]).all()
    else:
        assert found.stopped is None
        assert np.max(np.abs(found.states[0, :, 0] - (np.cos(TIMES) + 0.5 * np.sin(TIMES)))) < 1e-8


def test_stiff_motion_is_handed_over_with_the_tolerance_that_was_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Radau IIA 5 errs far less than its tolerance here, so its errors do not show which tolerance it was given."""
    asked = []
    prepared = radau.prepare_solver

    def watched(problem: Problem, tolerance: float, relative: float) -> Any:
        asked.append(tolerance)
        return prepared(problem, tolerance, relative)

    monkeypatch.setattr(radau, "prepare_solver", watched)
    case = get("damped_oscillator", "stiff_1e6").rounded()
    for tolerance in (1e-5, 1e-9):
        asked.clear()
        sizes = np.max(np.abs(solved(GaussFast(), case, tolerance).states), axis=0)
        # The tolerance is absolute: a second time, finer by the size of a component that stays below 1.
        wanted = [tolerance] + [tolerance * np.min(sizes)] * bool(np.min(sizes) < 1)
        assert asked == pytest.approx(wanted, rel=1e-3)


def test_stiff_motion_too_small_for_an_absolute_tolerance_is_not_handed_over() -> None:
    """Radau IIA 5 goes down to an absolute tolerance of 1e-16, which does not limit the error of a motion of 1e-100."""
    case = get("damped_oscillator", "stiff_1e6").rounded()
    solve = GaussFast().prepare(problem_of(case, GaussFast.accepts), 1e-6)
    found = solve(initial_state(case)[None] * 2.0**-330)
    assert "stiff" in str(found.stopped)


def test_an_ensembles_iteration_leaves_a_part_of_the_tolerance() -> None:
    """The oscillator is solved without derivatives, and its truncation between so many samples is small: the error is that
    of the iteration, which may leave a tenth of the tolerance in a step."""
    case = get("harmonic_oscillator").rounded()
    starts, exact = np.repeat(initial_state(case)[None], 16, axis=0), exact_states(case)
    for tolerance in 10.0 ** -np.arange(5, 13):
        found = GaussFast().prepare(problem_of(case, GaussFast.accepts), tolerance)(starts)
        assert found.steps is not None
        assert np.max(case.metric.distance(found.states[0], exact)) < 0.1 * tolerance * found.steps / 16
