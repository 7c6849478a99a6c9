"""Steps and solvers of numba and JAX, Jacobians, and forces that depend on velocities, through the function adapters."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import compiled_methods
import numba
import numpy as np
import planted_methods
import pytest
from command_line import gnomon
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import TooManyCalls, Unsupported
from gnomon.harness.contract.problem import counting, find_accepted_form, initial_state, problem_of
from gnomon.harness.contract.velocity_forces import VelocityForces
from gnomon.harness.registry import references
from gnomon.harness.results import reading
from gnomon.harness.verification.function_adapter import from_solve, from_step
from gnomon.harness.verification.functions.right_hand_side import Jacobian, RightHandSide
from gnomon.harness.verification.verify import plan_verification, verify

PENDULUM = get("pendulum_simple").rounded()
DAMPED = get("damped_oscillator").rounded()
LIKE = 1e-12
"""Solutions of one method by other machine code differ by rounding, here over at most 128 steps of a regular motion."""


def solved(integrator: Any, case: Any = PENDULUM, steps: int = 2) -> tuple[Any, int]:
    """The states, and the right-hand sides counted, with `steps` steps in a sampling interval."""
    problem = counting(problem_of(case, integrator.accepts))
    found = integrator.prepare(problem, problem.interval / steps)(initial_state(case)[None])
    return found.states[0], int(problem.buffer[-1])


@pytest.mark.parametrize(
    "one", [compiled_methods.compiled_rk4, compiled_methods.compiled_solve], ids=lambda one: one.name
)
def test_a_method_of_numba_is_the_method_of_python_with_the_same_counts(one: Any) -> None:
    states, calls = solved(one)
    wanted, counted = solved(planted_methods.good_rk4)
    assert np.max(PENDULUM.metric.distance(states, wanted)) < LIKE
    assert calls == counted == 4 * 2 * 64


def test_numba_compiles_a_step_once_for_all_cases() -> None:
    """Each verification has dozens of problems: a compilation of each would take minutes."""
    for name in ("pendulum_simple", "kepler_orbit", "damped_oscillator"):
        solved(compiled_methods.compiled_rk4, get(name).rounded())
    assert len(compiled_methods.rk4.signatures) == 1


def test_the_function_takes_whatever_a_function_of_numba_may_give() -> None:
    """Integers for the time, tuples, rows and columns of matrices, from a function that Python calls too."""
    problem = problem_of(get("kepler_orbit").rounded(), (FirstOrder,))
    f = RightHandSide(problem)
    y = np.array([1.0, 0.1, 0.2, 0.9])

    @numba.njit
    def several(f: Any, y: Any) -> Any:
        matrix = np.empty((4, 4))
        matrix[0] = y
        matrix[:, 1] = y
        return f(0, (y[0], y[1], y[2], y[3])), f(0.5, matrix[:, 1]), f(np.int32(1), y[::-1][::-1])

    for found in several(f, y):
        assert found == pytest.approx(f(0.0, y), rel=1e-14)


@pytest.mark.slow
def test_numba_may_keep_the_compiled_step(tmp_path: Path) -> None:
    """A second process, in which all addresses are others, calls the code that the first one has kept."""
    (tmp_path / "kept.py").write_text(
        "import numba, numpy as np\nfrom gnomon.verify import from_step\n\n\n@numba.njit(cache=True)\n"
        "def euler(f, t, y, h):\n    return y + h * f(t, y)\n\n\nmine = from_step(euler, name='Euler', order=1)\n"
    )
    program = (
        "import kept, test_compiled_functions as tests\nstates, calls = tests.solved(kept.mine)\n"
        "print(calls, states[-1].tolist(), sum(kept.euler.stats.cache_hits.values()))"
    )
    path = {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), str(tmp_path), *sys.path])}
    command, where = [sys.executable, "-c", program], {"NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    found = [
        subprocess.run(
            command, env=os.environ | path | where, capture_output=True, text=True, check=True
        ).stdout.rpartition(" ")
        for _ in range(2)
    ]
    assert found[0][0] == found[1][0]
    assert [int(hits) for *_, hits in found] == [0, 1]


def test_a_solver_of_numba_that_does_not_end_is_given_up() -> None:
    problem = replace(problem_of(PENDULUM, (FirstOrder,)), most_calls=100)
    with pytest.raises(TooManyCalls):
        compiled_methods.compiled_solve.prepare(problem, problem.interval / 64)(initial_state(PENDULUM)[None])


@pytest.mark.parametrize("name", ["pendulum_simple", "damped_oscillator", "charge_in_E_and_B"])
@pytest.mark.parametrize("velocities", [False, True])
@pytest.mark.parametrize("kind", [FirstOrder, SecondOrder])
def test_the_jacobian_is_the_derivative_of_the_right_hand_side(name: str, velocities: bool, kind: type) -> None:
    """By central differences, whose error is about the cube root of the round-off squared."""
    case = get(name).rounded()
    if find_accepted_form(case, (kind,)) is None:
        pytest.skip(f"{name} has no form {kind.__name__}")
    problem = problem_of(case, (kind,))
    f, jac = RightHandSide(problem, velocities), Jacobian(problem, velocities)
    y, half = initial_state(case) + 0.1, problem.dimension // 2

    def given(y: Any) -> tuple[Any, ...]:
        return (y[:half], y[half:]) if velocities else (y if kind is FirstOrder else y[:half],)

    found, step = jac(0.3, *given(y)), 1e-5
    sides = [(f(0.3, *given(y + step * e)) - f(0.3, *given(y - step * e))) / (2 * step) for e in np.eye(len(y))]
    wanted = np.array(sides).T[:, : found.shape[1]]
    assert found == pytest.approx(wanted, abs=1e-7 * max(1.0, float(np.max(np.abs(wanted)))))


def test_a_step_with_a_parameter_jac_is_given_the_jacobian() -> None:
    """Newton's iteration solves the implicit equation to rounding: the fixed point by Python's iteration is the same."""

    def by_iteration(f: Any, t: float, y: Any, h: float) -> Any:
        found = y
        for _ in range(60):
            found = y + h * f(t + h / 2, (y + found) / 2)
        return found

    def by_newton(f: Any, t: float, y: Any, h: float, jac: Any) -> Any:
        return compiled_methods.midpoint.py_func(f, t, y, h, jac)

    wanted, _ = solved(from_step(by_iteration, name="iterated", order=2), DAMPED)
    for one in (compiled_methods.compiled_midpoint, from_step(by_newton, name="Newton", order=2)):
        states, _ = solved(one, DAMPED)
        assert np.max(DAMPED.metric.distance(states, wanted)) < LIKE


def test_a_solver_with_a_parameter_jac_is_given_the_jacobian() -> None:
    """SciPy's Radau calls it, and then needs no differences: it makes fewer calls."""
    from scipy.integrate import solve_ivp

    def solve(f: Any, t0: float, y0: Any, times: Any, tolerance: float, jac: Any = None) -> Any:
        how = {"method": "Radau", "t_eval": times, "rtol": tolerance, "atol": tolerance}
        return solve_ivp(f, (t0, times[-1]), y0, jac=jac, **how).y.T

    given = from_solve(solve, name="Radau", order=5, dense_order=3)
    differences = from_solve(
        lambda f, t0, y0, times, tolerance: solve(f, t0, y0, times, tolerance), name="Radau by differences"
    )
    counts = []
    for one in (given, differences):
        problem = counting(problem_of(PENDULUM, one.accepts))
        states = one.prepare(problem, 1e-8)(initial_state(PENDULUM)[None]).states[0]
        assert np.max(PENDULUM.metric.distance(states, PENDULUM.sample(problem.times))) < 1e-3
        counts.append(problem.buffer[-1])
    assert 0 < counts[0] < counts[1]


def test_equations_that_branch_have_no_jacobian_and_say_so() -> None:
    def equations(t: Any, y: Any, p: Any) -> Any:
        return (y[1], -1.0 if y[0] > 0 else 1.0)

    problem = replace(problem_of(PENDULUM, (FirstOrder,)), form=FirstOrder(equations))
    with pytest.raises(Unsupported, match="branch"):
        Jacobian(problem)(0.0, np.ones(2))


def test_forces_of_velocities_are_those_of_equations_whose_first_half_are_the_velocities() -> None:
    """A rigid body's rates are not the velocities of the components before them; a pendulum needs no velocities."""
    one = compiled_methods.compiled_newmark
    for name in ("damped_oscillator", "charge_in_E_and_B", "pendulum_simple"):
        assert np.all(np.isfinite(solved(one, get(name).rounded())[0]))
    assert isinstance(find_accepted_form(PENDULUM, one.accepts), SecondOrder)
    with pytest.raises(Unsupported, match="velocities"):
        solved(one, get("euler_top").rounded())


def test_a_method_for_a_t_q_v_is_its_formula() -> None:
    """Newmark's method on a damped oscillator is the trapezoidal rule on the equations of first order."""

    def trapezoidal(f: Any, t: float, y: Any, h: float) -> Any:
        first = f(t, y)
        found = y + h * first
        for _ in range(60):
            found = y + h / 2 * (first + f(t + h, found))
        return found

    wanted, _ = solved(from_step(trapezoidal, name="trapezoidal", order=2), DAMPED, 8)
    python = from_step(compiled_methods.newmark.py_func, name="Newmark", order=2, velocities=True)
    for one in (compiled_methods.compiled_newmark, python):
        states, _ = solved(one, DAMPED, 8)
        assert np.max(DAMPED.metric.distance(states, wanted)) < 1e-9


def test_methods_of_velocities_are_verified_on_cases_whose_forces_have_them() -> None:
    one = compiled_methods.compiled_newmark
    cases = [case for case, _ in plan_verification(one, None, "normal", ["order"])]
    assert VelocityForces in one.accepts
    assert "euler_top" not in {case.name for case in cases}
    assert cases[0].second_order is None
    assert any(case.second_order is not None for case in cases)
    report = verify(one, ["damped_oscillator"], "low", ["order", "follows", "more_variables", "clock", "units"])
    assert report.checked >= 2, report
    assert not report.of(type(report.rows[0].finding.outcome).FAILED), report


def test_a_formula_that_forgets_the_velocities_fails() -> None:
    def forgets(f: Any, t: Any, y: Any, h: Any) -> Any:
        half = len(y) // 2
        after = compiled_methods.newmark(f, t, np.append(y[:half], 0 * y[half:]), h)
        return after + np.append(h * y[half:], y[half:])

    report = verify(
        from_step(forgets, name="forgets", order=2, velocities=True), ["damped_oscillator"], "low", ["follows"]
    )
    assert report.of(type(report.rows[0].finding.outcome).FAILED)


def test_a_step_of_numba_is_verified_as_it_is_written() -> None:
    report = verify(compiled_methods.compiled_rk4, ["pendulum_simple"], "low", ["order", "follows", "repeatable"])
    assert report.checked >= 2
    assert not report.gaps(), report


JAX = """
import jax
import jax.numpy as jnp
import numpy as np
from functools import partial
{x64}
from gnomon.verify import Steps, from_solve, from_step

WEIGHTS = jnp.array([1.0, 2.0, 2.0, 1.0]) / 6


def rk4(f, t, y, h):
    a = f(t, y)
    b = f(t + h / 2, y + h / 2 * a)
    c = f(t + h / 2, y + h / 2 * b)
    d = f(t + h, y + h * c)
    return y + h * (WEIGHTS @ jnp.stack([a, b, c, d]))


@jax.jit
def scan(f, t0, y0, times, h):
    def sample(y, ends):
        start, end = ends
        step = (end - start) / 8
        found = jax.lax.fori_loop(0, 8, lambda i, y: rk4(f, start + i * step, y, step), y)
        return found, found

    return jax.lax.scan(sample, y0, (jnp.append(t0, times[:-1]), times))[1]


@jax.jit
def midpoint(f, t, y, h, jac):
    found = y
    for _ in range(8):
        middle = (y + found) / 2
        matrix = jnp.eye(len(y)) - h / 2 * jac(t + h / 2, middle)
        found = found - jnp.linalg.solve(matrix, found - y - h * f(t + h / 2, middle))
    return found


plain = from_step(rk4, name="plain", order=4)
jitted = from_step(jax.jit(rk4), name="jitted", order=4)
static = from_step(partial(jax.jit, static_argnums=0)(rk4), name="static", order=4)
scanned = from_solve(scan, name="scanned", order=4, sweep=Steps())
newton = from_step(midpoint, name="newton", order=2)
"""
CALLED = """
import json, sys
import numpy as np
import of_jax
from gnomon.cases.core.registry import get
from gnomon.harness.contract.problem import counting, initial_state, problem_of

found = {}
for name in ("plain", "jitted", "static", "scanned", "newton"):
    one = getattr(of_jax, name)
    for number in ("1", "2"):
        case = get("pendulum_simple", L=number).rounded()
        problem = counting(problem_of(case, one.accepts))
        states = one.prepare(problem, problem.interval / 8)(initial_state(case)[None]).states[0]
        error = float(np.max(case.metric.distance(states, case.sample(problem.times))))
        found[f"{name} {number}"] = [error, problem.buffer[-1], str(states.dtype)]
print(json.dumps(found))
"""


def run_of_jax(folder: Path, x64: str, *words: str) -> subprocess.CompletedProcess[str]:
    (folder / "of_jax.py").write_text(JAX.format(x64=x64))
    command = [*words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)


GNOMON = str(Path(sys.executable).parent / "gnomon")
X64 = 'jax.config.update("jax_enable_x64", True)'


def test_methods_of_jax_work_as_they_are_written(tmp_path: Path) -> None:
    """f is an argument, static or not, or within a scan; errors are those of the methods, and counts are exact."""
    pytest.importorskip("jax", reason="JAX is optional")
    import json

    done = run_of_jax(tmp_path, X64, sys.executable, "-c", CALLED)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    for name, (error, calls, dtype) in found.items():
        case = get("pendulum_simple", L=name[-1]).rounded()
        states, _ = solved(planted_methods.good_rk4, case, 8)
        wanted = float(np.max(case.metric.distance(states, case.sample(case.times))))
        assert error == pytest.approx(wanted, rel=1e-6) if "newton" not in name else error < 0.1, name
        assert calls == (8 if "newton" in name else 4) * 8 * 64, name
        assert dtype == "float64"


def test_a_module_with_arrays_of_jax_is_verified(tmp_path: Path) -> None:
    """JAX has begun in the process that imports it: no copy of this process could compute with it."""
    pytest.importorskip("jax", reason="JAX is optional")
    words = [
        "verify",
        "of_jax:jitted",
        "--case",
        "pendulum_simple",
        "--claim",
        "order",
        "--claim",
        "follows",
        "--depth",
        "low",
    ]
    done = run_of_jax(tmp_path, X64, GNOMON, *words)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "passed order on pendulum_simple" in " ".join(done.stdout.split())


def test_float32_is_refused_with_the_way_out(tmp_path: Path) -> None:
    pytest.importorskip("jax", reason="JAX is optional")
    words = ["verify", "of_jax:jitted", "--case", "pendulum_simple", "--claim", "order", "--depth", "low"]
    done = run_of_jax(tmp_path, "", GNOMON, *words)
    assert done.returncode == 1
    assert "jax_enable_x64" in done.stderr
    assert "Traceback" not in done.stderr


def test_where_jax_has_begun_a_method_of_the_script_itself_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    from types import SimpleNamespace

    begun = SimpleNamespace(backends_are_initialized=lambda: True)
    monkeypatch.setitem(sys.modules, "jax._src.xla_bridge", begun)
    assert references.process_method(planted_methods.good_rk4) == "forkserver"
    monkeypatch.setattr(references, "reference", lambda one: one)
    with pytest.raises(ValueError, match="module of its own"):
        references.process_method(planted_methods.good_rk4)


def test_a_plain_function_is_verified_and_run_as_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A new user has a function in a file: its arguments say whether it is a step or a solver."""
    text = Path(compiled_methods.__file__).read_text().replace("@numba.njit\n", "")
    folder = tmp_path / "methods"
    folder.mkdir()
    (folder / "in_a_file.py").write_text(text.partition("compiled_rk4 =")[0])
    monkeypatch.chdir(tmp_path)
    asked = ["--case", "pendulum_simple"]
    verified = ["verify", "methods/in_a_file.py:rk4", *asked, "--claim", "follows", "--claim", "start_kept"]
    assert gnomon(*verified, "--depth", "low") == 0
    assert gnomon("run", "--integrator", "methods/in_a_file.py:midpoint", *asked, "--limit", "300",
                  "--settings", "0.1", "--out", "a.sqlite") == 0  # fmt: skip
    (row,) = reading.rows(tmp_path / "a.sqlite")
    assert (row["integrator_id"], row["status"]) == ("mine:midpoint", "ok")
    assert gnomon("verify", "methods/in_a_file.py:no_such", *asked) == 2
