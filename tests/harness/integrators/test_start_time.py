"""Every integrator starts at `Problem.t0`: equations that depend on the time since the start give the same states."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from breadth import marks
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.harness.adapters import heyoka
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator
from gnomon.harness.contract.integrator import Integrator, Problem, Solution, Solver
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast
from gnomon.harness.integrators.runge_kutta.explicit import RK4
from gnomon.harness.registry.lookup import missing, own
from planted_methods import good_pair, good_rk4
from timed_forms import FORMS

LATE = 3.25
"""A late start, in seconds: a multiple of 1/4, so that sums with the times of samples are exact."""
TIMES = np.arange(1, 17) * 0.125
TOLERANCE, SUBSTEPS = 1e-8, 4
EXACT = ("Explicit Euler", "RK4", "Störmer-Verlet", "Position Verlet", "Symplectic Euler", "Moreau", "RATTLE")
"""Methods whose times are all multiples of a power of two: there the late start changes no bit."""
MISSED = {"arkode:ARKStep DIRK 5": 1e3}
"""By what factor the step control of a method misses its tolerance on these equations: by 340 and 1100 from the two starts."""


def problem(kind: type, t0: float) -> tuple[Problem, Any]:
    form, start = FORMS[kind]
    return Problem(form, len(start), np.array([t0]), TIMES + t0, 0.5, t0=t0), np.array([start], dtype=np.float64)


def solved(integrator: Integrator, kind: type, t0: float) -> Solution:
    given, start = problem(kind, t0)
    found = integrator.prepare(given, setting(integrator, given))(start)
    assert found.stopped is None
    return found


def setting(integrator: Integrator, given: Problem) -> float:
    return TOLERANCE if integrator.sweep.kind == "tolerance" else given.interval / SUBSTEPS


def same_from_both(integrator: Integrator, kind: type) -> None:
    early, late = (solved(integrator, kind, t0) for t0 in (0.0, LATE))
    size = np.max(np.abs(early.states))
    # 64 steps of a few roundings each; or the tolerance in each sample interval: round-off may change decisions of a
    # step control, and each choice is within the tolerance.
    allowed = len(TIMES) * TOLERANCE if integrator.sweep.kind == "tolerance" else 2**-52 * 64 * 16
    allowed *= MISSED.get(integrator.id, 1.0)
    assert np.max(np.abs(late.states - early.states)) <= allowed * size
    if early.events is None:
        assert integrator.name not in EXACT or np.array_equal(late.states, early.states)
    else:
        assert len(early.events) > 1
        assert [name for _, name in late.events or ()] == [name for _, name in early.events]
        at_both = np.array([t for t, _ in early.events]), np.array([t for t, _ in late.events or ()]) - LATE
        assert np.max(np.abs(np.subtract(*at_both))) <= max(allowed, 1e-12)


def pairs() -> list[Any]:
    found = [
        pytest.param(integrator, kind, id=f"{integrator.id}-{kind.__name__}", marks=marks(integrator))
        for integrator in own().values()
        for kind in integrator.accepts
        if integrator.unsupported(FORMS[kind][0]) is None
        and (kind is SecondOrder or not isinstance(integrator, GaussFast))  # compiles for seconds for each form
    ]
    tried = {id(param.values[0]) for param in found}
    # An engine may lack the rail of this scene, and a tighter solver runs only where there is a solver.
    assert all(isinstance(one, SceneIntegrator) for one in own().values() if id(one) not in tried)
    return found


@pytest.mark.parametrize(("integrator", "kind"), pairs())
def test_a_late_start_gives_the_same_states(integrator: Integrator, kind: type) -> None:
    if (why := missing(integrator)) is not None:
        pytest.skip(why)
    same_from_both(integrator, kind)


@pytest.mark.parametrize("integrator", [good_rk4, good_pair], ids=["from_step", "from_solve"])
def test_methods_made_of_functions_get_the_start(integrator: Integrator) -> None:
    same_from_both(integrator, FirstOrder)


def test_batches_of_heyoka_start_late_too() -> None:
    pytest.importorskip("heyoka", reason="heyoka is not installed")
    (early, start), (late, _) = problem(FirstOrder, 0.0), problem(FirstOrder, LATE)
    many = start * np.linspace(0.5, 1, heyoka.ENSEMBLE)[:, None]
    found = [heyoka.Taylor().prepare(given, TOLERANCE)(many.copy()).states for given in (early, late)]
    assert np.max(np.abs(found[0] - found[1])) <= len(TIMES) * TOLERANCE


class StartsAtZero(RK4):
    """Integrates from 0 to the absolute times."""

    def prepare(self, problem: Problem, setting: float) -> Solver:
        return super().prepare(replace(problem, t0=0.0), setting)


class KeepsEquations(RK4):
    """Integrates over the right span, and evaluates the equations at the time since the start."""

    def prepare(self, problem: Problem, setting: float) -> Solver:
        return super().prepare(replace(problem, t0=0.0, times=problem.elapsed), setting)


@pytest.mark.parametrize("method", [StartsAtZero, KeepsEquations])
def test_a_method_that_ignores_the_start_is_found(method: type[RK4]) -> None:
    with pytest.raises(AssertionError):
        same_from_both(method(), FirstOrder)
