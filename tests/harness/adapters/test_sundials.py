"""SUNDIALS by its C interface and by its binding: errors, agreement, messages where it fails, remains in memory."""

import gc
import math
from concurrent.futures import ThreadPoolExecutor
from math import cos, log, sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.registry import get
from gnomon.harness.adapters import sksundae, sundials
from gnomon.harness.contract.integrator import Problem, Solution, solver_of
from gnomon.harness.contract.problem import counting
from gnomon.harness.kernels import emission, equations, straight_line
from gnomon.harness.kernels.equations import Kernel
from gnomon.harness.kernels.traced import ReducedTrace
from gnomon.harness.registry import lookup
from on_cases import exact_states, solved

pytest.importorskip("sksundae", reason="scikit-sundae is optional")
ALL = (*sundials.INTEGRATORS, *sksundae.INTEGRATORS)
each = pytest.mark.parametrize("kind", ALL, ids=lambda kind: kind().id)
native = pytest.mark.parametrize("kind", sundials.INTEGRATORS, ids=lambda kind: kind.name)
newton = pytest.mark.parametrize("kind", [sundials.Bdf, sundials.Ida], ids=lambda kind: kind.name)
pairs = pytest.mark.parametrize(
    ("kind", "binding"), list(zip(sundials.INTEGRATORS, sksundae.INTEGRATORS, strict=True)), ids=lambda kind: kind().id
)


def turning(t: Any, y: Any, p: Any) -> Any:
    return y[1], -p[0] * y[0]


def escaping(t: Any, y: Any, p: Any) -> Any:
    return (y[0] * y[0],)


def stiff(t: Any, y: Any, p: Any) -> Any:
    """x relaxes to sin t, a million times faster than sin t changes."""
    return (-1e6 * p[0] * (y[0] - sin(y[1])) + cos(y[1]), 1.0)


def opaque(t: Any, y: Any, p: Any) -> Any:
    """The equations of `stiff`, with a function that has no expression."""
    return (-1e6 * p[0] * (y[0] - sin(y[1])) + cos(y[1]) + 0 * abs(y[0]), 1.0)


def ending(t: Any, y: Any, p: Any) -> Any:
    """Not finite from time 1/2 on."""
    return (-y[0] + 0 * log(1 / 2 - t),)


def limit_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few steps are allowed to the binding, which else takes ever smaller ones."""
    monkeypatch.setattr(sksundae, "STEPS", 500)


def problem(equations: Any, dimension: int, times: Any, parameters: Any = (1.0,)) -> Problem:
    return Problem(FirstOrder(equations), dimension, np.array(parameters), np.array(times), 1.0)


@each
def test_the_error_follows_the_tolerance(kind: Any) -> None:
    times = np.linspace(0.1, 6.4, 64)
    exact = np.column_stack([np.cos(times), -np.sin(times)])
    errors = []
    for tolerance in (1e-4, 1e-8):
        states = solver_of(kind(), problem(turning, 2, times), tolerance)(np.array([[1.0, 0.0]])).states[0]
        errors.append(float(np.max(np.abs(states - exact))))
        assert errors[-1] < 300 * tolerance
    assert errors[1] < errors[0] / 100


@each
def test_one_sample_is_the_state_there_and_not_a_step(kind: Any) -> None:
    states = solver_of(kind(), problem(turning, 2, [1.3]), 1e-9)(np.array([[1.0, 0.0], [0.0, 1.0]])).states
    turn = [[math.cos(1.3), -math.sin(1.3)], [math.sin(1.3), math.cos(1.3)]]
    assert states[:, 0] == pytest.approx(np.array(turn), abs=1e-6)


@each
def test_samples_that_were_not_reached_are_nan_with_the_reason(
    kind: Any, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """y' = y^2 from 1 is infinite at t = 1. A motion whose steps no longer advance ends long before the limit of ten millions."""
    limit_steps(monkeypatch)
    found = solver_of(kind(), problem(escaping, 1, [0.5, 0.9, 2.0, 3.0]), 1e-6)(np.array([[1.0]]))
    assert found.states[0, :2, 0] == pytest.approx([2.0, 10.0], rel=1e-3)
    assert np.all(np.isnan(found.states[0, 2:]))
    assert found.stopped is not None
    assert "at t = 0.9999" in found.stopped or "max_num_steps" in found.stopped
    assert (found.steps or 0) < 100_000
    assert capfd.readouterr().err == ""


@each
def test_one_sample_that_was_not_reached_is_nan(kind: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Given two times CVODE returns its own steps. It stopped at the last one, which is not the state at the sample."""
    limit_steps(monkeypatch)
    found = solver_of(kind(), problem(escaping, 1, [2.0]), 1e-6)(np.array([[1.0]]))
    assert np.all(np.isnan(found.states))
    assert found.stopped is not None


@each
@pytest.mark.parametrize("name", ["pendulum_simple", "kepler_orbit"])
def test_follows_the_exact_motion(kind: Any, name: str) -> None:
    """1e3 to 1e4 steps, each allowed the tolerance relative to the state, phase errors growing with time."""
    case = get(name).rounded()
    assert np.max(np.abs(solved(kind(), case, 1e-10).states - exact_states(case))) < 1e5 * 1e-10


@pairs
@pytest.mark.parametrize("name", ["pendulum_simple", "kepler_orbit", "euler_top"])
def test_both_ways_take_the_same_steps(kind: Any, binding: Any, name: str) -> None:
    """The same code of SUNDIALS is called with the same numbers: it rounds alike but for the compiler's contractions. Adams
    iterates in another way, to the same tolerance."""
    case, tolerance = get(name).rounded(), 1e-8
    both = [solved(one(), case, tolerance, counted=True) for one in (kind, binding)]
    distance = float(np.max(case.metric.distance(both[0].states, both[1].states)))
    if kind is sundials.Adams:
        assert distance < 10 * max(one.error for one in both)
    else:
        assert both[0].calls == pytest.approx(both[1].calls, abs=1, rel=0), (
            "the binding evaluates IDA's residual once more"
        )
        assert distance < tolerance


@native
def test_counts_are_those_of_right_hand_sides(kind: Any) -> None:
    """A step of a multistep method takes one or more; the plain run leaves the count alone."""
    plain, counted = problem(turning, 2, np.linspace(0.1, 6.4, 64)), None
    counted = counting(plain)
    plain_run, counted_run = (solver_of(kind(), one, 1e-6)(np.array([[1.0, 0.0]])) for one in (plain, counted))
    assert plain_run.steps == counted_run.steps
    assert counted_run.steps is not None
    assert plain.buffer[-1] == 0
    assert counted_run.steps <= counted.buffer[-1] < 4 * counted_run.steps


def run_stiff(kind: Any, equations: Any = stiff) -> tuple[Solution, float]:
    counted = counting(problem(equations, 2, np.linspace(0.05, 3.2, 64)))
    found = solver_of(kind(), counted, 1e-6)(np.array([[0.0, 0.0]]))
    return found, float(counted.buffer[-1])


@newton
def test_stiff_equations_take_few_right_hand_sides(kind: Any) -> None:
    """An explicit method, stable up to h rate = 3, would take more than 1e6."""
    found, calls = run_stiff(kind)
    assert found.states[0, :, 0] == pytest.approx(np.sin(np.linspace(0.05, 3.2, 64)), abs=1e-5)
    assert calls < 1000


def changed(change: Any) -> Any:
    """A function that compiles the Jacobian with its elements changed."""

    def compiled(form: FirstOrder, dimension: int, parameters: int) -> Kernel:
        trace = ReducedTrace(dimension, parameters)
        values = change(straight_line.derivatives(form, trace))

        def body(t: Any, y: Any, p: Any, out: Any) -> None:
            equations.write(out, straight_line.compute(values, trace, t, [y[0], y[1]], [p[0]], emission.MATH))

        return Kernel(change.__name__, body, (dimension, parameters, len(values)))

    return compiled


@newton
def test_the_jacobian_is_used_with_its_sign_and_its_place(kind: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """It saves the right-hand sides of differences; with the other sign, or by rows, Newton's method needs many more."""
    _, right = run_stiff(kind)
    _, differences = run_stiff(kind, opaque)
    assert right < differences
    limit_steps(monkeypatch)

    def negative(values: Any) -> Any:
        return tuple(-value for value in values)

    def transposed(values: Any) -> Any:
        return values[0], values[2], values[1], values[3]

    for wrong in (negative, transposed):
        monkeypatch.setattr(sundials, "derivatives_if_traced", changed(wrong))
        found, calls = run_stiff(kind)
        assert found.stopped is not None or calls > 1.5 * right, wrong.__name__


@native
def test_a_derivative_that_is_not_finite_ends_the_run(kind: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Later than the start, steps get smaller up to their limit and samples up to there are kept; at the start at once."""
    limit_steps(monkeypatch)
    late, at_once = (
        solver_of(kind(), problem(ending, 1, np.arange(1, 65) / 16), 1e-6)(np.array([[start]]))
        for start in (1.0, math.nan)
    )
    assert late.states[0, :7, 0] == pytest.approx(np.exp(-np.arange(1, 8) / 16), rel=1e-4)
    assert np.all(np.isnan(late.states[0, 8:]))
    assert late.stopped is not None
    assert np.all(np.isnan(at_once.states))
    assert str(at_once.stopped).endswith("at t = 0")


@native
def test_the_same_bits_again_and_after_a_failure(kind: Any) -> None:
    solve = solver_of(kind(), problem(turning, 2, np.linspace(0.1, 6.4, 64)), 1e-9)
    start = np.array([[1.0, 0.5]])
    first = solve(start.copy()).states
    assert np.all(np.isnan(solve(np.array([[math.inf, 0.0]])).states))
    assert np.array_equal(solve(np.repeat(start, 3, axis=0)).states[2], first[0])


@native
def test_solvers_are_independent_and_closed_ones_decline(kind: Any) -> None:
    times = np.linspace(0.1, 6.4, 64)
    first, second = (solver_of(kind(), problem(turning, 2, times, [w]), 1e-9) for w in (1.0, 4.0))
    start = np.array([[1.0, 0.0]])
    before = first(start.copy()).states
    assert second(start.copy()).states[0, :, 0] == pytest.approx(np.cos(2 * times), abs=1e-6)
    second.close()
    second.close()
    with pytest.raises(RuntimeError, match="after close"):
        second(start.copy())
    assert np.array_equal(first(start.copy()).states, before)


FREED_BY = {
    "SUNContext_Create": "SUNContext_Free", "N_VMake_Serial": "N_VDestroy", "SUNDenseMatrix": "SUNMatDestroy",
    "SUNLinSol_Dense": "SUNLinSolFree", "SUNNonlinSol_FixedPoint": "SUNNonlinSolFree",
    "CVodeCreate": "CVodeFree", "IDACreate": "IDAFree",
}  # fmt: skip


@native
@pytest.mark.parametrize("end", ["closed", "forgotten", "failed"])
def test_all_that_is_created_is_freed_in_the_opposite_sequence(
    kind: Any, end: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    functions, version = sundials.interface(kind.solver)
    calls: list[str] = []

    def noted(name: str) -> Any:
        return lambda *given: calls.append(name) or functions[name](*given)

    ends = {name: noted(name) for pair in FREED_BY.items() for name in pair if name in functions}
    monkeypatch.setattr(sundials, "interface", lambda solver: (functions | ends, version))
    if end == "failed":
        monkeypatch.setitem(ends, f"{kind.solver}SetMaxNumSteps", lambda *given: -22)
        with pytest.raises(RuntimeError, match="SetMaxNumSteps returned -22"):
            kind().prepare(problem(turning, 2, [1.0]), 1e-6)
    else:
        solve = solver_of(kind(), problem(turning, 2, [1.0]), 1e-6)
        solve(np.array([[1.0, 0.0]]))
        if end == "closed":
            solve.close()
        del solve
    gc.collect()
    created = [name for name in calls if name in FREED_BY]
    assert created[0] == "SUNContext_Create"
    assert calls == created + [FREED_BY[name] for name in reversed(created)]


@native
def test_another_version_of_sundials_is_not_driven(kind: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its structures may have another layout; the binding stays."""
    monkeypatch.setattr(sundials, "VERSIONS", ("0.1.0",))
    sundials.interface.cache_clear()
    try:
        assert "0.1.0 only; the binding runs" in str(lookup.missing(kind()))
        assert lookup.missing(sksundae.Adams()) is None
        with pytest.raises(ImportError, match="its C interface was tried"):
            kind().prepare(problem(turning, 2, [1.0]), 1e-6)
    finally:
        sundials.interface.cache_clear()


def test_another_layout_of_its_structures_is_not_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sundials, "DATA", 0)
    with pytest.raises(RuntimeError, match="another layout"):
        sundials.Adams().prepare(problem(turning, 2, [1.0]), 1e-6)


@native
def test_threads_have_solvers_of_their_own(kind: Any) -> None:
    """Four at a time give the bits of one at a time."""
    times = np.linspace(0.1, 6.4, 64)

    def run(w: float) -> Any:
        solve = solver_of(kind(), problem(turning, 2, times, [w]), 1e-8)
        return [solve(np.array([[1.0, 0.0]])).states for _ in range(5)][-1]

    alone = [run(w) for w in (1.0, 2.0, 3.0, 4.0)]
    with ThreadPoolExecutor(4) as threads:
        together = list(threads.map(run, (1.0, 2.0, 3.0, 4.0)))
    assert np.array_equal(alone, together)
