"""Properties of every in-house method: impossible settings are refused, failures reported, results repeat to the bit,
steps allocate nothing, and every claim of conservation is tested."""

import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from breadth import marks
from gnomon.cases.core.case import Case
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.contract.problem import find_accepted_form, initial_state, problem_of
from gnomon.harness.registry.lookup import in_house, own

ALL = in_house()
EVERY = pytest.mark.parametrize("method", [pytest.param(one, id=one.id, marks=marks(one)) for one in ALL])
CASES = (
    "pendulum_simple", "charge_in_E_and_B", "relativistic_charge", "holonomic_constraint_dae", "damped_oscillator",
    "euler_top", "coulomb_friction_oscillator",
)  # fmt: skip
TESTED_CLAIMS = {
    "splitting": {"symplectic", "reversible", "momentum"},  # test_properties
    "gauss": {"symplectic", "reversible", "momentum"},  # test_properties
    "boris": {"volume", "reversible"},  # test_boris
    "constrained_radau": {"constraint"},  # test_constrained_radau
    "projected": {"constraint"},  # test_projected
    "rattle": {"symplectic", "reversible", "momentum", "constraint"},  # test_rattle
    "lie": {"symplectic", "reversible", "momentum", "attitude"},  # test_lie
    "rebound_nbody": {"symplectic", "reversible", "momentum"},  # test_rebound
}
"""For each family the claims that the named tests verify, for each of its methods that declares them."""


def case_for(method: Integrator) -> Case:
    """The first of these cases that the method accepts."""
    for name in CASES:
        case = get(name).rounded()
        form = find_accepted_form(case, method.accepts)
        if form is not None and method.unsupported(form) is None:
            return case
    raise LookupError(f"{method.id} takes none of {CASES}")


def ordinary(method: Integrator, problem: Any) -> float:
    return 1e-6 if method.sweep.kind == "tolerance" else problem.interval / 16


def answer(method: Integrator) -> Any:
    """States on the method's case at an ordinary setting."""
    case = case_for(method)
    problem = problem_of(case, method.accepts)
    solution = method.prepare(problem, ordinary(method, problem))(initial_state(case)[None])
    assert solution.stopped is None
    return solution.states


@EVERY
def test_impossible_settings_are_refused_with_their_value(method: Integrator) -> None:
    """A tolerance below round-off; a step that does not divide the sampling interval, or would take for ever."""
    problem = problem_of(case_for(method), method.accepts)
    impossible = [0.0, -0.1, math.nan, math.inf]
    if method.sweep.kind == "tolerance":
        impossible += [1e-17, 1.0, 2.0]
    else:
        impossible += [1e-300, problem.interval / 2.5, problem.interval * 2]
    for setting in impossible:
        with pytest.raises(Refused, match=r"^(tolerance|step size) (-?[\d.e+-]+|nan|inf) "):
            method.prepare(problem, setting)


@EVERY
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_equations_that_are_not_finite_end_the_trajectory_at_once(method: Integrator, value: float) -> None:
    problem = problem_of(case_for(method), method.accepts)
    solution = method.prepare(problem, ordinary(method, problem))(np.full((1, problem.dimension), value))
    assert "sample 1" in str(solution.stopped)
    assert not np.all(np.isfinite(solution.states))
    assert (solution.steps or 0) < 1000


@EVERY
def test_the_same_bits_again(method: Integrator) -> None:
    assert np.array_equal(answer(method), answer(method))


@EVERY
def test_nothing_is_allocated_in_a_step(method: Integrator) -> None:
    """A call with several times as many steps makes as many allocations."""
    from numba.core.runtime import _nrt_python, rtsys

    _nrt_python.memsys_enable_stats()
    case = case_for(method)
    start, counts, steps = initial_state(case)[None], [], []
    # A quarter of the span as well: the steps of high orders hardly get shorter. But the same events, which may allocate.
    short = case if case.hybrid else case.with_span(case.span / 4)
    for part, tolerance, share in ((short, 1e-3, 8), (case, 1e-12, 32)):
        problem = problem_of(part, method.accepts)
        setting = tolerance if method.sweep.kind == "tolerance" else problem.interval / share
        solve = method.prepare(problem, setting)
        solve(start.copy())
        before = rtsys.get_allocation_stats().alloc
        steps.append(solve(start.copy()).steps or 0)
        counts.append(rtsys.get_allocation_stats().alloc - before)
    assert steps[1] > 1.5 * steps[0] > 0
    assert counts[0] == counts[1]


@pytest.mark.parametrize("method", own().values(), ids=lambda method: method.id)
def test_no_claim_without_a_test(method: Integrator) -> None:
    bases = [kind.__module__.rpartition(".")[2] for kind in type(method).__mro__]
    tested = next((TESTED_CLAIMS[module] for module in bases if module in TESTED_CLAIMS), set())
    untested = ", ".join(set(method.conserves) - tested)
    told = f"write a test of it, and a line of {bases[0]!r} into TESTED_CLAIMS of tests/harness/integrators/test_promises.py"
    assert not untested, f"{method.id} claims {untested}: {told}"


@pytest.mark.slow
def test_the_same_bits_in_another_process_that_compiles_anew(tmp_path: Path) -> None:
    """The other process takes machine code from the cache, or compiles with an empty cache."""
    program = (
        f"import sys; sys.path[:] = {[str(Path(__file__).parent), *sys.path]!r}\n"
        "import numpy as np, test_promises as here\n"
        "np.savez(sys.argv[1], **{m.id: here.answer(m) for m in here.ALL})"
    )
    cold = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "numba"), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    subprocess.run([sys.executable, "-c", program, str(tmp_path / "found.npz")], check=True, env=cold)
    with np.load(tmp_path / "found.npz") as found:
        different = [m.id for m in ALL if not np.array_equal(found[m.id], answer(m))]
    assert len(found.files) == len(ALL)
    assert not different
