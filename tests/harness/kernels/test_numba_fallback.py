"""Where numba's version is not known, its own cache keeps compiled functions: the states have the same bits."""

import ctypes
import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.kernels import equations, machine_code, numba_fallback
from gnomon.harness.kernels.equations import IMPORTS, OPTIONS
from gnomon.harness.registry import lookup

from gnomon import cases

METHODS = ("gnomon:Gauss 8-stage SIMD",)

ELSEWHERE = """
import sys
import numba

numba.__version__ = "0.0.1"
from numba.core import event
from test_numba_fallback import METHODS, states

with event.install_recorder("numba:compile") as compilations:
    print(*map(states, METHODS))
print(len(compilations.buffer))
"""
SOURCE = "\n".join(
    [
        *IMPORTS,
        f'@njit("float64(float64[::1], float64)", {OPTIONS})',
        "def scaled(x, factor):",
        "    return factor * x[0] / x[1]",
        f"@njit({OPTIONS})",
        "def doubled(x):",
        "    return 2.0 * x",
    ]
)


def states(name: str) -> str:
    """A hash of the states of a method on the pendulum."""
    (method,) = lookup.find(name)
    case = cases.get("pendulum_simple").rounded()
    problem = problem_of(case, method.accepts)
    setting = 1e-8 if method.sweep.kind == "tolerance" else problem.interval / 16
    solution = method.prepare(problem, setting)(initial_state(case)[None])
    assert solution.stopped is None
    return hashlib.sha256(np.ascontiguousarray(solution.states).tobytes()).hexdigest()


def test_private_parts_are_used_of_known_versions_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    for version, keeper in ((numba.__version__, machine_code), ("0.67.0", numba_fallback), ("0.680.0", numba_fallback)):
        monkeypatch.setattr(numba, "__version__", version)
        equations.keeper.cache_clear()
        assert equations.keeper() is keeper
    equations.keeper.cache_clear()


def test_another_version_gives_the_same_states_and_a_second_process_compiles_nothing(tmp_path: Path) -> None:
    """The method goes through numba's cache in both directions."""
    paths = [str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    fresh = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(paths)}
    runs = [
        subprocess.run([sys.executable, "-c", ELSEWHERE], check=True, capture_output=True, text=True, env=fresh)
        for _ in range(2)
    ]
    (*first, compiled), (*second, compiled_again) = (run.stdout.split() for run in runs)
    assert first == second == [states(name) for name in METHODS]
    assert int(compiled) > 0
    assert int(compiled_again) == 0
    assert not list(tmp_path.glob("kernels/*.kernel.*"))  # files of machine code


@pytest.mark.parametrize("writable", [True, False])
def test_functions_are_those_of_machine_code(
    writable: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recwarn: pytest.WarningsRecorder
) -> None:
    """Called with other types both raise TypeError; without a folder to write to they work, and are not kept."""
    if not writable:
        (tmp_path / "kernels").write_text("a file where the folder should be")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    for kept in (numba_fallback.function, numba_fallback.address, numba_fallback._module):
        kept.cache_clear()
    scaled, x = numba_fallback.function(SOURCE, "scaled"), np.array([6.0, 4.0])
    doubled = numba_fallback.function(SOURCE, "doubled", "float64(float64)")
    by_address = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(
        numba_fallback.address(SOURCE, "doubled", "float64(float64)")
    )
    assert (scaled(x, 5.0), doubled(1.5), by_address(1.5)) == (7.5, 3.0, 3.0)
    assert np.isinf(scaled(np.array([6.0, 0.0]), 5.0))
    for function, other in ((scaled, (x.astype(int), 5.0)), (scaled, (x[:, None], 5.0)), (doubled, (x,))):
        with pytest.raises(TypeError):
            function(*other)
    assert bool(list(tmp_path.glob("**/*.nbi"))) == writable
    assert len(recwarn.list) == (not writable)
