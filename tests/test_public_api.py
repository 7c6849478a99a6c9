"""What outsiders import: one package, light and whole in any order; its names have docstrings with examples that run."""

import doctest
import importlib
import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import gnomon

ROOT = Path(__file__).parent.parent
PACKAGES = ("gnomon", "gnomon.verify", "gnomon.cases", "gnomon.cases.declare")
IMPORT = re.compile(r"^ *from (gnomon[\w.]*) import (?:\(([^)]*)\)|([^(\n;]*))", re.M)


def _names() -> Iterator[tuple[str, str]]:
    for package in PACKAGES:
        yield from ((package, name) for name in importlib.import_module(package).__all__)
    for page in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md")):
        for module, inside, plain in IMPORT.findall(page.read_text(encoding="utf-8")):
            names = (word.split(" as ")[0].strip() for word in (inside or plain).replace("\n", " ").split(","))
            yield from ((module, name) for name in names if name and name != "*")


def _public() -> dict[str, Any]:
    """Classes and functions by their full names, each once."""
    found = {}
    for module, name in sorted(set(_names())):
        value = getattr(importlib.import_module(module), name)
        if (inspect.isclass(value) or inspect.isfunction(value)) and value.__module__.startswith("gnomon."):
            found[f"{value.__module__}.{value.__qualname__}"] = value
    return found


PUBLIC = _public()


def test_pages_import_nothing_deeper_than_the_three_modules() -> None:
    """A user learns `gnomon`, `gnomon.cases` and `gnomon.verify`; pages on gnomon's own machine code may look inside."""
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    inside = {ROOT / "docs" / "theory" / "machine_code.md", ROOT / "docs" / "development.md"}
    lines = re.compile(r"^ *(?:from|import) (gnomon\.\S+)|python -c [\"'].*?(?:from|import) (gnomon\.[\w.]+)", re.M)
    found = {
        page.name: [a or b for a, b in lines.findall(page.read_text("utf-8"))] for page in pages if page not in inside
    }
    assert any(found.values()), "the search finds imports"
    deeper = {name: set(used) - {"gnomon.cases", "gnomon.verify"} for name, used in found.items()}
    assert not any(deeper.values()), deeper


def ran(script: str) -> str:
    """The output of a script in a process of its own."""
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout


def test_import_loads_no_numbers_and_no_libraries() -> None:
    """A command line, a notebook and a test suite import gnomon long before they use it."""
    heavy = ran("import sys, gnomon; print(*sys.modules)").split()
    assert "gnomon" in heavy
    assert not {"numpy", "scipy", "mpmath", "numba", "llvmlite", "pandas", "rich", "importlib.metadata"} & set(heavy)


def test_every_name_is_there_whichever_comes_first() -> None:
    """A submodule that is imported takes the place of a name of the package: none has the name of a function."""
    script = """
import importlib, os, sys, types
import flint, mpmath, numba, scipy.integrate, scipy.special  # once for all forks, each of which imports gnomon anew

def look(first):
    if first in ("case", "solve"):
        import gnomon
        getattr(gnomon, first)
    else:
        importlib.import_module(f"gnomon.{first}")
    import gnomon, gnomon.verify, gnomon.cases
    assert all(getattr(gnomon, name) is not None for name in dir(gnomon))
    assert isinstance(gnomon.verify, types.ModuleType) and callable(gnomon.verify.verify) and callable(gnomon.case)
    assert len(dir(gnomon)) > 20

for first in ("cases", "verify", "harness", "case", "solve"):
    assert "gnomon" not in sys.modules
    if (child := os.fork()) == 0:
        try:
            look(first)
        except BaseException as error:
            print(first, repr(error), flush=True)
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    print(first, flush=True)
"""
    assert ran(script).split("\n") == ["cases", "verify", "harness", "case", "solve", ""]


def test_a_name_that_does_not_exist_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'gnomon' has no attribute 'solv'"):
        getattr(importlib.import_module("gnomon"), "solv")  # noqa: B009 - the name is the point


def test_help_begins_with_every_function() -> None:
    """`help(gnomon)` in a session is where a user looks first; the functions of `gnomon.verify` are in the table too."""
    (table, *_) = re.findall(r"(?:^    \S.*\n)+", gnomon.__doc__ or "", re.M)
    listed = dict(re.findall(r"^    ([\w.]+)\(.*?\) +(\S.*)$", table, re.M))
    functions = {name for name in gnomon.__all__ if inspect.isfunction(getattr(gnomon, name))}
    functions |= {
        f"verify.{name}" for name in gnomon.verify.__all__ if inspect.isfunction(getattr(gnomon.verify, name))
    }
    assert functions == listed.keys()


@pytest.mark.parametrize("name", PUBLIC)
def test_the_sections_are_there(name: str) -> None:
    value = PUBLIC[name]
    text = inspect.getdoc(value) or ""
    sections = set(re.findall(r"^(\w+)\n-+$", text, re.M))
    assert text.split("\n\n")[0].endswith("."), "a sentence says what it is"
    assert "Examples" in sections
    if inspect.isfunction(value):
        signature = inspect.signature(value)
        assert "Parameters" in sections or not signature.parameters
        assert "Returns" in sections or signature.return_annotation in ("None", None)
        described = re.findall(r"^\*{0,2}([\w, *]+) : ", text, re.M)
        known = {each.strip(" *") for line in described for each in line.split(",")}
        assert set(signature.parameters) <= known


METHODS = {
    f"{kind}.{name}": method
    for kind in (gnomon.ExactCase, gnomon.Comparison)
    for name, method in vars(kind).items()
    if inspect.isfunction(method) and not name.startswith("_")
}


@pytest.mark.parametrize("name", METHODS)
def test_the_methods_of_a_result_are_described(name: str) -> None:
    """A notebook shows this text on demand; an example of the class shows them at work."""
    text = inspect.getdoc(METHODS[name]) or ""
    assert re.search(r"^Returns\n-+$", text, re.M)
    assert set(inspect.signature(METHODS[name]).parameters) - {"self"} <= set(re.findall(r"^(\w+) : ", text, re.M))


@pytest.mark.parametrize("name", PUBLIC)
def test_the_examples_run(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    value = PUBLIC[name]
    monkeypatch.chdir(tmp_path)  # examples may write results there
    module = importlib.import_module(value.__module__)
    tests = [each for each in doctest.DocTestFinder(recurse=False).find(value, name, module) if each.examples]
    printed: list[str] = []
    for each in tests:
        doctest.DocTestRunner().run(each, out=printed.append)
    assert tests
    assert not printed, "".join(printed)
