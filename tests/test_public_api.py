"""Names that outsiders import have a docstring with the sections that their signature needs, and an example that runs.

These names are the ones that the README and docs/ import, and all names of the packages in PACKAGES.
"""

import doctest
import importlib
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("gnomon.verify", "gnomon.harness", "gnomon.cases", "gnomon.cases.declare")
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


def test_the_pages_import_more_than_the_packages_name() -> None:
    """The search for imports works: the documents show classes of `contract`, which no package above names."""
    assert "gnomon.harness.contract.integrator.Solution" in PUBLIC


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
