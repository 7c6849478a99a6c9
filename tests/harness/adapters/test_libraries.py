"""Adapters import their library in `prepare`, not earlier; a missing library is an ImportError."""

import subprocess
import sys

import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.adapters import (
    diffrax,
    heyoka,
    rebound_nbody,
    rebound_ode,
    scipy_ivp,
    scipy_ode,
    scipy_odeint,
    sksundae,
    sundials,
)
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.problem import problem_of

MODULES = (scipy_ivp, scipy_ode, scipy_odeint, rebound_nbody, rebound_ode, heyoka, sundials, sksundae, diffrax)
ALL = tuple(kind for module in MODULES for kind in module.INTEGRATORS)
every = pytest.mark.parametrize("integrator", ALL, ids=lambda kind: kind().id)


def test_importing_adapters_imports_no_library() -> None:
    """`gnomon list` is fast, and works where a library is missing."""
    names = ", ".join(module.__name__ for module in MODULES)
    found = f"import sys, {names}; print(*({{'scipy', 'rebound', 'heyoka', 'sksundae', 'diffrax', 'jax', 'numba'}} & set(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", found], capture_output=True, text=True, check=True)
    assert result.stdout.split() == []


@every
def test_a_missing_library_is_an_import_error(integrator: type[Integrator], monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [integrator.library, *(name for name in sys.modules if name.startswith(f"{integrator.library}."))]:
        monkeypatch.setitem(sys.modules, name, None)
    problem = problem_of(get("kepler_orbit").rounded(), integrator.accepts)
    with pytest.raises(ImportError, match=integrator.library):
        integrator().prepare(problem, problem.interval)


def test_ids_are_unique() -> None:
    assert len({kind().id for kind in ALL}) == len(ALL)
