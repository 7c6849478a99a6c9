"""Impossible settings are refused with their value; equations that fail end a trajectory, with the reason."""

import math
from math import sqrt
from typing import Any

import numpy as np
import pytest
from bad_equations import none_at_all, raising, scalar, squared, stiff, too_many, undefined
from breadth import marks
from gnomon.cases.core.forms import SecondOrder, Values
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator, Problem, Refused
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.integrators.gauss.gauss import Gauss4
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.geometric.splitting import StormerVerlet
from gnomon.harness.integrators.multistep_extrapolation.extrapolation import GraggBulirschStoer
from gnomon.harness.integrators.multistep_extrapolation.stormer import Stormer8
from gnomon.harness.integrators.runge_kutta.dop853 import Dop853
from gnomon.harness.integrators.runge_kutta.explicit import RK4
from gnomon.harness.integrators.runge_kutta.explicit_pairs import DormandPrince5, Verner9
from gnomon.harness.integrators.runge_kutta.nystrom import DormandPrinceNystrom6, DormandPrinceNystrom12
from gnomon.harness.integrators.taylor.taylor import Taylor


@pytest.mark.parametrize("step", [0.0, -0.1, math.nan, math.inf])
@pytest.mark.parametrize("method", [RK4, StormerVerlet, Gauss4])
def test_a_step_that_is_no_positive_number(method: type[Integrator], step: float) -> None:
    problem = problem_of(get("pendulum_simple").rounded(), method.accepts)
    with pytest.raises(Refused, match=f"step size {step} is not a positive number"):
        method().prepare(problem, step)


def test_a_step_that_does_not_divide_the_interval() -> None:
    problem = problem_of(get("pendulum_simple").rounded(), RK4.accepts)
    for step, divisor in ((problem.interval / 2.6, problem.interval / 3), (problem.interval * 2, problem.interval)):
        with pytest.raises(Refused, match=rf"does not divide the sampling interval .*; {divisor!r} does$"):
            RK4().prepare(problem, step)
    RK4().prepare(problem, problem.interval / 3)


@pytest.mark.parametrize("step", [1e-300, 1e-12])
def test_a_step_that_would_take_too_many_steps(step: float) -> None:
    problem = problem_of(get("pendulum_simple").rounded(), RK4.accepts)
    with pytest.raises(Refused, match=f"step size {step:g} would take"):
        RK4().prepare(problem, step)


def root_of_what_is_left(t: Any, state: Values, parameters: Values) -> Values:
    """x' = 2 + sqrt(1 - x): not a number once x is above 1, at t < 1/2."""
    (x,) = state
    return (2 + sqrt(1 - x),)


METHODS = [
    (RK4, 2.0**-8), (Gauss4, 2.0**-8), (Dop853, 1e-8), (DormandPrince5, 1e-8), (Verner9, 1e-8),
    (GraggBulirschStoer, 1e-8),
]  # fmt: skip


def with_marks(rows: Any) -> list[Any]:
    return [pytest.param(method, setting, marks=marks(method)) for method, setting in rows]


@pytest.mark.parametrize("equations", [root_of_what_is_left, squared, undefined])
@pytest.mark.parametrize(("method", "setting"), with_marks(METHODS))
def test_equations_that_fail_end_the_trajectory(method: type[Integrator], setting: float, equations: Any) -> None:
    solution = method().prepare(scalar(equations), setting)(np.array([[1.0 if equations is squared else 0.5]]))
    assert solution.stopped is not None
    assert "before sample" in solution.stopped
    finite = np.isfinite(solution.states[0, :, 0])
    assert not finite[-1]
    assert np.all(np.diff(finite.astype(int)) <= 0), "finite states, then none"


@pytest.mark.parametrize("method", [Dop853, GraggBulirschStoer])
def test_a_step_that_shrinks_on_the_way_to_infinity_ends_at_the_spacing_of_times(method: type[Integrator]) -> None:
    solution = method().prepare(scalar(squared), 1e-8)(np.array([[1.0]]))
    assert solution.stopped == "the step size fell below the spacing of times, before sample 33"


def fall_into_a_root(t: Any, q: Values, parameters: Values) -> Values:
    """q'' = -1 - sqrt(q): not a number once q is below 0, at t < 1.5 from q = 1 at rest."""
    (x,) = q
    return (-1 - sqrt(x),)


@pytest.mark.parametrize(
    ("method", "setting"),
    with_marks([(Stormer8, 2.0**-8), (DormandPrinceNystrom6, 1e-8), (DormandPrinceNystrom12, 1e-8)]),
)
def test_accelerations_that_fail_end_the_trajectory(method: type[Integrator], setting: float) -> None:
    problem = Problem(SecondOrder(fall_into_a_root), 2, np.zeros(0), np.arange(1, 65) * 0.03125, 1.0)
    solution = method().prepare(problem, setting)(np.array([[1.0, 0.0]]))
    assert solution.stopped is not None
    finite = np.isfinite(solution.states[0, :, 0])
    assert finite[31], "q is above 0 until t = 1.1"
    assert not finite[-1]


def test_adaptive_steps_are_limited_in_number() -> None:
    """On stiff equations stability bounds the step: 3e7 would be needed."""
    solution = Dop853().prepare(scalar(stiff), 1e-6)(np.array([[1.0]]))
    assert solution.stopped is not None
    assert solution.stopped.startswith(f"more than {Dop853.most_steps} steps")


def test_one_trajectory_that_fails_leaves_the_others() -> None:
    """x' = x^2 from -1 decays: x = -1 / (1 + t)."""
    problem = scalar(squared)
    solution = RK4().prepare(problem, 2.0**-9)(np.array([[1.0], [-1.0]]))
    assert np.isnan(solution.states[0, -1, 0])
    assert np.allclose(solution.states[1, :, 0], -1 / (1 + problem.times), rtol=1e-9)


ADAPTIVE = [Dop853, GraggBulirschStoer, Taylor, Radau5, GaussFast]


@pytest.mark.parametrize("method", [RK4, Gauss4, *(m for m in ADAPTIVE if m is not GaussFast)])
@pytest.mark.parametrize(("equations", "count"), [(too_many, 2), (none_at_all, 0)])
def test_equations_of_the_wrong_length_are_refused(method: type[Integrator], equations: Any, count: int) -> None:
    setting = 1e-6 if method in ADAPTIVE else 2.0**-8
    with pytest.raises((ValueError, Refused), match=f"gives {count} values where 1 is wanted"):
        method().prepare(scalar(equations), setting)


@pytest.mark.parametrize("method", [RK4, Gauss4, *ADAPTIVE])
def test_equations_that_raise_are_refused(method: type[Integrator]) -> None:
    """Compiled code could not report the exception."""
    setting = 1e-6 if method in ADAPTIVE else 2.0**-8
    why = r"raising raises an exception|must not branch|'>' not supported"
    with pytest.raises((ValueError, TypeError, Refused), match=why):
        method().prepare(scalar(raising), setting)
