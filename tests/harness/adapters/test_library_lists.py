"""A library is declared once: every list of libraries has it, and the files that repeat a declaration agree with it."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from gnomon.harness.adapters import library_copies
from gnomon.harness.adapters.absent import ABSENT
from gnomon.harness.adapters.libraries import LIBRARIES

ROOT = Path(__file__).parents[3]
WRITE = "`make libraries` writes it from harness/adapters/libraries.toml"
ADAPTER = """
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.contract.integrator import Tolerance

class One(Installed):
    name, library, accepts, sweep = "one", "newest", (FirstOrder,), Tolerance()
    def prepare(self, problem, setting):
        import newest

class Two(One):
    name = "two"

INTEGRATORS = (One, Two)
"""
TABLE = {
    "requirement": "newest-solvers>=1,<2",
    "extra": "newer",
    "depends": ["newest-arrays"],
    "licence": "MIT",
    "modules": ["newest_adapter"],
    "quick": ["two"],
    "calls": {"*": "python"},
    "colour": "teal",
}
PROGRAM = f"""
import importlib, json, sys, types
reader = importlib.import_module("gnomon.harness.contract.declared")
read = reader.read_declared
reader.read_declared = lambda package, name: read(package, name) | ({{"newest": {TABLE}}} if name == "libraries.toml" else {{}})
adapter = types.ModuleType("gnomon.harness.adapters.newest_adapter")
sys.modules[adapter.__name__] = adapter
exec({ADAPTER!r}, vars(adapter))

from gnomon.harness.adapters import library_copies
from gnomon.harness.registry import environment, lookup
from gnomon.harness.reporting import style
from gnomon.harness.reporting.page import case_tables
from gnomon.harness.running import plan

print(json.dumps({{
    "ids": [one.id for one in lookup.own().values()],
    "missing": [lookup.missing(one) for one in lookup.find("newest")],
    "versions": environment.VERSIONS,
    "quick": plan.SUITES["quick"].scope.integrators,
    "hues": style.HUES,
    "colours": style.COLOURS,
    "calls": case_tables.way("newest:one"),
    "ways": case_tables.WAYS,
    "page": library_copies.page(),
    "project": library_copies.project(sys.argv[1]),
}}))
"""
"""Declares a library before gnomon reads its declarations, with an adapter of two integrators, and prints the lists."""


@pytest.fixture(scope="module")
def lists() -> dict[str, Any]:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    done = subprocess.run([sys.executable, "-c", PROGRAM, project], capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_a_new_library_is_found_listed_and_run(lists: dict[str, Any]) -> None:
    """After the libraries that were declared before it, and in the suite `quick` by the integrator that it names."""
    assert lists["ids"][-2:] == ["newest:one", "newest:two"]
    assert lists["quick"][-1] == "newest:two"


def test_a_new_library_that_is_not_installed_is_reported_with_its_package(lists: dict[str, Any]) -> None:
    assert lists["missing"] == 2 * ["newest is not installed: pip install 'gnomon[newer]'"]


def test_the_versions_of_a_new_library_are_recorded(lists: dict[str, Any]) -> None:
    """With the versions of the distributions that its results depend on: a cluster and a merge compare all versions."""
    assert {"newest-solvers", "newest-arrays"} <= {*lists["versions"]}


def test_the_page_names_a_new_library(lists: dict[str, Any]) -> None:
    """By its colour, and by what a time of its integrators includes."""
    assert lists["calls"] == lists["ways"]["python"]
    assert lists["hues"]["newest"] == lists["colours"]["teal"]


def test_documents_and_project_file_name_a_new_library(lists: dict[str, Any]) -> None:
    assert "`newest-solvers>=1,<2`" in lists["page"]
    project = tomllib.loads(lists["project"])
    assert "newest-solvers>=1,<2" in project["project"]["optional-dependencies"]["newer"]
    assert "newest.*" in untyped(project)


def untyped(project: dict[str, Any]) -> set[str]:
    """The modules whose missing types mypy ignores."""
    overrides = project["tool"]["mypy"]["overrides"]
    return {name for one in overrides if one.get("ignore_missing_imports") for name in one["module"]}


def test_the_pages_of_the_libraries_are_those_of_the_declarations() -> None:
    """`make libraries` writes them."""
    readme = (ROOT / library_copies.README).read_text(encoding="utf-8")
    page = (ROOT / library_copies.PAGE).read_text(encoding="utf-8")
    assert page == library_copies.page(), f"{library_copies.PAGE} is of other declarations: {WRITE}"
    assert readme == library_copies.readme(readme), (
        f"a line of {library_copies.README} is of other declarations: {WRITE}"
    )
    assert all(one.readme in readme for one in ABSENT if one.readme)


def test_each_absent_integrator_is_named_once_with_a_reason() -> None:
    titles = [one.title for one in ABSENT]
    assert len({*titles}) == len(titles)
    assert all(one.reason.endswith(".") for one in ABSENT)


def test_the_project_file_installs_each_library_as_it_is_declared() -> None:
    """`make libraries` writes the extras and the names for mypy; the line of a library that comes with gnomon is written once."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wanted: dict[str | None, list[str]] = {}
    for library in LIBRARIES.values():
        if library.debian:
            continue  # the system installs it
        wanted.setdefault(library.extra, []).append(library.installs)
        assert f"{library.name}.*" in untyped(project), f"pyproject.toml lacks {library.name}: {WRITE}"
    for requirement in wanted.pop(None):
        told = f'write "{requirement}" into `dependencies` of pyproject.toml, or `extra` into harness/adapters/libraries.toml'
        assert requirement in project["project"]["dependencies"], told
    for extra, requirements in wanted.items():
        listed = project["project"]["optional-dependencies"].get(extra)
        assert listed == requirements, f"pyproject.toml has {extra} = {listed}: {WRITE}"
