"""Imports run down, in no circle, and stand at the head of a module unless a comment says why not."""

import ast
import importlib
import re
import shutil
from collections.abc import Iterable, Iterator
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

    An editable install maps `gnomon.cases` to a folder outside the folder of `gnomon`: grimp reads only the latter.
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
    """Imports keep the contracts of pyproject.toml."""
    configure()
    kept = lint_imports(str(ROOT / "pyproject.toml"), cache_dir=None, no_logo=True)
    assert kept, capsys.readouterr().out


@pytest.mark.usefixtures("one_tree")
def test_no_two_modules_import_each_other() -> None:
    """Through others either, inside functions and for types alone: each can be read, and changed, without the other."""
    graph = grimp.build_graph("gnomon", cache_dir=None)
    imported = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    assert {f"gnomon.{folder}" for folder in FOLDERS} <= graph.modules
    try:
        TopologicalSorter(imported).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))


def sources(folders: Iterable[str], pattern: str) -> Iterator[tuple[Path, list[str], ast.Module]]:
    """Path, lines and syntax tree of the sources that hold a pattern: to parse all of them takes seconds."""
    for path in sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if re.search(pattern, text, re.MULTILINE):
            yield path.relative_to(ROOT), text.splitlines(), ast.parse(text)


def in_functions(tree: ast.Module) -> list[ast.stmt]:
    """The imports that calls make, by line."""
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    found = {n for function in functions for n in ast.walk(function) if isinstance(n, ast.Import | ast.ImportFrom)}
    return sorted(found, key=lambda node: node.lineno)


def test_an_import_in_a_function_has_a_reason() -> None:
    """A comment on the line of the first such import of a module, or above it, says why. A circle is not a reason."""
    missing = []
    for path, lines, tree in sources((*FOLDERS, "src"), r"^[ \t]+(import|from) "):
        for node in in_functions(tree)[:1]:
            if "#" not in lines[node.lineno - 1] and not lines[node.lineno - 2].lstrip().startswith("#"):
                missing.append(f"{path}:{node.lineno}: {lines[node.lineno - 1].strip()}")
    assert not missing, "say why, or import at the head of the module:\n" + "\n".join(missing)


def test_a_module_has_one_name() -> None:
    """A search for the name of a module finds its uses: it is not imported under another one."""
    renamed = []
    for path, _, tree in sources((*FOLDERS, "src", "tests"), r"^[ \t]*from gnomon.* as |^ +\w+ as \w+,$"):
        for node in ast.walk(tree):
            if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("gnomon"):
                continue
            for one in node.names:
                place = ROOT.joinpath(*f"{node.module}.{one.name}".split(".")[1:])
                is_module = place.with_suffix(".py").exists() or place.is_dir()
                if one.asname not in (None, one.name) and is_module:
                    renamed.append(f"{path}:{node.lineno}: {one.name} as {one.asname}")
    assert not renamed, "call a module by its name:\n" + "\n".join(renamed)
