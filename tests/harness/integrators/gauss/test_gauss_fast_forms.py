"""The fast Gauss method on arrays of NumPy and compiled: the same states; its tuned numbers; kept code; threads."""

import ast
import inspect
import threading
from dataclasses import FrozenInstanceError, fields
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.integrators.gauss import (
    gauss_fast,
    gauss_fast_control,
    gauss_fast_ensemble,
    gauss_fast_kernel,
    gauss_fast_layout,
    gauss_fast_stages,
    gauss_fast_steps,
)
from gnomon.harness.integrators.gauss.constants import TUNING, Tuning
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast, bandwidth, lines, table
from gnomon.harness.integrators.gauss.gauss_fast_layout import layout
from gnomon.harness.kernels import machine

MODULES = (gauss_fast_control, gauss_fast_ensemble, gauss_fast_stages, gauss_fast_steps)
STRUCTURE = {0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 15, 16, 27, 64, 0.125, 1e15, gauss_fast_control.ONE}
"""Numbers that are not chosen: of stages, powers of the tolerance in the error, the mean of eight, the largest whole
number of steps, bits of doubles."""

CASES = (
    "pendulum_simple", "kepler_orbit", "euler_top", "lagrange_top", "rubber_tube_thin", "lagrange_top_attitude",
    "forced_oscillator", "kepler_orbit in Sundman time",
)  # fmt: skip
"""Turns of angles; derivatives; first order; velocities; poles; groups; a force; components that never change."""


def arguments(name: str) -> tuple[Any, Any, Any, Any]:
    """The equations of a case as the method takes them, its problem, and a start at random near that of the case."""
    case = get(name.partition(" in ")[0]).rounded()
    formulation = case.formulations[0] if " in " in name else None
    problem = problem_of(case, GaussFast.accepts, formulation)
    form = getattr(problem.form, "source", None) or problem.form
    start = np.array(initial_state(case, formulation))
    draw = np.random.default_rng(39).uniform(0.99, 1.01, (9, len(start)))
    return (form, len(problem.parameters), problem.dimension), problem, start, start * draw


def ulps(a: Any, b: Any) -> float:
    """The largest difference in units of the last place of the largest component."""
    return float(np.max(np.abs(a - b)) / np.spacing(np.max(np.abs(a))))


@pytest.mark.parametrize("name", CASES)
def test_arrays_of_numpy_and_compiled_code_give_the_same_states(name: str) -> None:
    """At 1e-16, where only round-off is left: compiled code may contract a product and a sum into one rounding."""
    given, problem, start, _ = arguments(name)
    times, tolerance = problem.times[:5] / 4, 1e-16
    coefficients, results = table(layout(*given).second_order, bandwidth(tolerance)), []
    for run in (gauss_fast_kernel.compile_advance(*given), gauss_fast_kernel.on_arrays(*given)):
        out, stop = np.full((len(times), len(start)), np.nan), np.zeros(4, dtype=np.int64)
        run(problem.buffer, coefficients, start, times, tolerance, out, stop)
        assert stop[0] == 0
        results.append(out)
    assert ulps(*results) < 16


@pytest.mark.parametrize("name", CASES)
def test_the_same_for_an_ensemble_of_nine(name: str) -> None:
    """Of which eight share a vector, and one has the next vector alone."""
    given, problem, _, starts = arguments(name)
    times, tolerance, results = problem.times[:2] / 4, 1e-16, []
    coefficients = table(layout(*given).second_order, bandwidth(tolerance))
    for one, rows in (gauss_fast_kernel.compile_ensemble(*given), gauss_fast_kernel.ensemble_on_arrays(*given)):
        out, left_over = np.full((9, len(times), starts.shape[1]), np.nan), np.zeros(3, dtype=np.int64)
        one(problem.buffer, coefficients, starts, times, tolerance, out, left_over, lines(rows))
        assert not left_over[:2].any()
        results.append(out)
    assert ulps(*results) < 16


def test_two_threads_give_the_states_of_one() -> None:
    """Both write to the scratch rows of one table."""
    given, problem, start, _ = arguments("lagrange_top")
    run, coefficients = gauss_fast_kernel.compile_advance(*given), table(layout(*given).second_order, bandwidth(1e-12))
    found: list[Any] = []

    def solve() -> None:
        out = np.empty((len(problem.times), len(start)))
        run(problem.buffer, coefficients, start, problem.times, 1e-12, out, np.zeros(4, dtype=np.int64))
        found.append(out)

    threads = [threading.Thread(target=lambda: [solve() for _ in range(20)]) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 40
    assert all(np.array_equal(one, found[0]) for one in found)


def test_kept_code_is_used_until_a_source_of_the_method_changes(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    given, _, _, _ = arguments("pendulum_simple")
    compilations = []
    compiled = machine.compile_ir
    monkeypatch.setattr(machine, "compile_ir", lambda text: compilations.append(text) or compiled(text))
    for sources in (gauss_fast_kernel.SOURCES, gauss_fast_kernel.SOURCES, "others"):
        monkeypatch.setattr(machine, "_linked", {})  # as in another process
        monkeypatch.setattr(gauss_fast_kernel, "SOURCES", sources)
        gauss_fast_kernel.compile_advance.__wrapped__(*given)
    assert len(compilations) == 2


def numbers(module: ModuleType) -> set[float]:
    functions = [one for one in ast.parse(inspect.getsource(module)).body if isinstance(one, ast.FunctionDef)]
    every = [one for function in functions for one in ast.walk(function) if isinstance(one, ast.Constant)]
    return {one.value for one in every if isinstance(one.value, int | float) and not isinstance(one.value, bool)}


def test_numbers_that_were_tuned_stand_in_their_structure_alone() -> None:
    """Every other number in the method's functions is part of the structure."""
    for module in MODULES:
        assert numbers(module) <= STRUCTURE, module.__name__


def test_every_tuned_number_is_used_and_cannot_be_changed() -> None:
    text = "".join(map(inspect.getsource, (gauss_fast, gauss_fast_layout, *MODULES)))
    used = {one.attr for one in ast.walk(ast.parse(text)) if isinstance(one, ast.Attribute)}
    assert {field.name for field in fields(Tuning)} <= used
    with pytest.raises(FrozenInstanceError):
        TUNING.hold = 2.0  # type: ignore[misc]
