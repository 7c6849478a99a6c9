"""A user's own module: which classes in it are integrators, and the messages for those that are not."""

import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from gnomon.harness.registry import lookup, references

SHARED = """
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Integrator, Tolerance

class Shared(Integrator):
    library, accepts, sweep = "mine", (FirstOrder,), Tolerance()
    def prepare(self, problem, setting):
        raise NotImplementedError

class One(Shared):
    name = "one"

class Two(Shared):
    name = "two"
"""
"""Two integrators and the base class that they share, which has no name."""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "of_a_user.py").write_text(SHARED, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "of_a_user", raising=False)
    return "of_a_user"


@pytest.mark.parametrize("name", ["One", "Two"])
def test_integrators_with_a_base_without_a_name_are_found(module: str, name: str) -> None:
    """A worker searches the classes of the module for the one that it must run."""
    (found,) = lookup.find(f"{module}:{name}")
    assert references.dereference(references.reference(found)).id == f"mine:{name.lower()}"


def test_a_base_without_a_name_is_refused_in_one_line_with_the_way_out(module: str) -> None:
    with pytest.raises(
        ValueError, match=r"of_a_user:Shared: .*Shared does not declare name; .* name a subclass"
    ) as said:
        lookup.find(f"{module}:Shared")
    assert "\n" not in str(said.value)


def test_a_base_without_a_name_is_no_entry_point(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    points = [EntryPoint(name, f"{module}:{name}", lookup.GROUP) for name in ("Shared", "One")]
    monkeypatch.setattr(lookup, "entry_points", lambda group: points)
    with pytest.warns(UserWarning, match="Shared does not declare name"):
        assert set(lookup.list_registered()) == {"mine:one"}


@pytest.mark.parametrize(
    "source",
    ["import sys\nsys.exit(0)", "raise KeyboardInterrupt", "raise RuntimeError('boom')", "import no_such_module"],
)
def test_an_entry_point_that_ends_its_import_affects_no_other(
    source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every run loads all installed entry points."""
    (tmp_path / "ends_its_import.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    paths = {"broken": "ends_its_import:Thing", "sound": "planted:Sound"}
    points = [EntryPoint(name, path, lookup.GROUP) for name, path in paths.items()]
    monkeypatch.setattr(lookup, "entry_points", lambda group: points)
    with pytest.warns(UserWarning, match=r"broken \(ends_its_import:Thing\) cannot be loaded: \w+: "):
        assert set(lookup.list_registered()) == {"planted:sound"}


def test_an_integrator_that_several_names_select_is_taken_once() -> None:
    """Twice in a run, its trials would have the same keys."""
    library = [one.id for one in lookup.find("scipy")]
    assert [one.id for one in lookup.find_all([library[0], "scipy"])] == library
