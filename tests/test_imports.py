"""Imports run down, in no circle, and stand at the head of a module where nothing speaks against it."""

from __future__ import annotations

import ast
import importlib
import shutil
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp
import pytest
from importlinter.application.use_cases import lint_imports
from importlinter.configuration import configure

import gnomon

ROOT = Path(__file__).parents[1]
FOLDERS = ("reference", "cases", "harness")


@pytest.fixture(scope="module")
def one_tree(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The sources of the installed package in one folder, where grimp looks for them while this lasts.

    An editable install maps `gnomon.cases` to a folder that is not in that of `gnomon`: grimp walks the latter alone.
    """
    tree = tmp_path_factory.mktemp("one_tree") / "gnomon"
    for name in ("gnomon", *(f"gnomon.{folder}" for folder in FOLDERS)):
        (source,) = importlib.import_module(name).__path__
        into = tree / name.partition(".")[2]
        for path in Path(source).rglob("*.py"):
            place = into / path.relative_to(source)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, place)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(gnomon.__spec__, "submodule_search_locations", [str(tree)])
        yield


@pytest.mark.usefixtures("one_tree")
def test_imports_run_down(capsys: pytest.CaptureFixture[str]) -> None:
    """By the contracts of pyproject.toml."""
    configure()
    kept = lint_imports(str(ROOT / "pyproject.toml"), cache_dir=None, no_logo=True)
    assert kept, capsys.readouterr().out


@pytest.mark.usefixtures("one_tree")
def test_no_two_modules_import_each_other() -> None:
    """Through others either, inside functions and for types alone: each can be read, and changed, without the other."""
    graph = grimp.build_graph("gnomon", cache_dir=None)
    imported = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    assert len(imported) > 350
    try:
        TopologicalSorter(imported).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))


SOURCES = [path for folder in (*FOLDERS, "src", "tests") for path in sorted((ROOT / folder).rglob("*.py"))]


def in_functions(tree: ast.Module) -> list[ast.Import | ast.ImportFrom]:
    """The imports that a call makes, in the order of their lines."""
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    found = {n for function in functions for n in ast.walk(function) if isinstance(n, ast.Import | ast.ImportFrom)}
    return sorted(found, key=lambda node: node.lineno)


def test_an_import_in_a_function_has_a_reason() -> None:
    """In a comment on its line or above it, at the first one of the module: what is loaded late surprises a reader."""
    missing = []
    for path in (path for path in SOURCES if not path.is_relative_to(ROOT / "tests")):
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines()
        for node in in_functions(ast.parse(text))[:1]:
            if "#" not in lines[node.lineno - 1] and not lines[node.lineno - 2].lstrip().startswith("#"):
                missing.append(f"{path.relative_to(ROOT)}:{node.lineno}: {lines[node.lineno - 1].strip()}")
    assert not missing, "say why, or import at the head of the module:\n" + "\n".join(missing)


def test_a_module_has_one_name() -> None:
    """Who searches for the uses of a module searches for its name."""
    renamed = []
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("gnomon"):
                continue
            for one in node.names:
                place = ROOT.joinpath(*f"{node.module}.{one.name}".split(".")[1:])
                is_module = place.with_suffix(".py").exists() or place.is_dir()
                if one.asname not in (None, one.name) and is_module:
                    renamed.append(f"{path.relative_to(ROOT)}:{node.lineno}: {one.name} as {one.asname}")
    assert not renamed, "call a module by its name:\n" + "\n".join(renamed)
