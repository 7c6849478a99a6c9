"""Adapters import their library in `prepare`, not earlier; a missing library is an ImportError."""

import subprocess
import sys
from ctypes import util
from importlib import import_module
from pathlib import Path

import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.adapters import libraries
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.problem import problem_of, takes
from gnomon.harness.registry.lookup import ADAPTERS, own

KEPLER = get("kepler_orbit").rounded()
ALL = [one for one in own().values() if type(one).__module__ in ADAPTERS]


def test_importing_adapters_imports_no_library() -> None:
    """`gnomon list` is fast, and works where a library is missing."""
    heavy = {*LIBRARIES, *(name for library in LIBRARIES.values() for name in library.depends), "numba"}
    found = f"import sys, {', '.join(ADAPTERS)}; print(*({heavy} & set(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", found], capture_output=True, text=True, check=True)
    assert result.stdout.split() == []


@pytest.mark.parametrize("integrator", [one for one in ALL if takes(one, KEPLER)], ids=lambda one: one.id)
def test_a_missing_library_is_an_import_error(integrator: Integrator, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [integrator.library, *(name for name in sys.modules if name.startswith(f"{integrator.library}."))]:
        monkeypatch.setitem(sys.modules, name, None)
    if LIBRARIES[integrator.library].debian:
        hide_from_the_system(type(integrator).__module__, monkeypatch)
    problem = problem_of(KEPLER, integrator.accepts)
    with pytest.raises(ImportError, match=integrator.library):
        integrator.prepare(problem, problem.interval)


def hide_from_the_system(adapter: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither a shared library nor a compiler is found, and what was found before is forgotten."""
    monkeypatch.setattr(util, "find_library", lambda name: None)
    monkeypatch.setenv("PATH", "")
    interface = sys.modules[adapter].interface  # type: ignore[attr-defined]
    monkeypatch.setattr(sys.modules[adapter], "interface", interface.__wrapped__)


def test_every_adapter_is_declared_by_its_library() -> None:
    """An adapter that no table of libraries.toml names would never run."""
    folder = Path(libraries.__file__).parent
    names = [".".join(path.relative_to(folder).with_suffix("").parts) for path in folder.rglob("*.py")]
    files = {name: import_module(f"gnomon.harness.adapters.{name}") for name in names}
    defined = {name for name, module in files.items() if hasattr(module, "INTEGRATORS")}
    assert defined == {name for library in LIBRARIES.values() for name in library.modules}
    declared = {f"gnomon.harness.adapters.{module}": one.name for one in LIBRARIES.values() for module in one.modules}
    assert {one.id: one.library for one in ALL} == {one.id: declared[type(one).__module__] for one in ALL}
