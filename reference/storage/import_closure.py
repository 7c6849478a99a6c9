"""What a result depends on: the sources of a module and of all that it imports, as one hash in the result's key."""

from __future__ import annotations

import ast
import dataclasses
import hashlib
import importlib.util
import sys
from collections.abc import Iterator
from functools import cache
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

OURS = "gnomon"


class _Source(NamedTuple):
    """A module's file, a hash of it, the names that it imports (functions or classes among them), whether it acts.

    A module acts where it does more, when it is imported, than import, define functions and state `__all__`.
    """

    file: Path
    digest: str
    imports: frozenset[str]
    acts: bool


@cache
def closure(*modules: str, within: tuple[str, ...] = (OURS,)) -> str | None:
    """One hash of `sources`. None where one of `modules` has no file: nothing that depends on it may be kept."""
    found = sources(*modules, within=within)
    if not found.keys() >= {*modules}:
        return None
    return hashlib.sha256("\n".join(f"{name} {found[name]}" for name in sorted(found)).encode()).hexdigest()[:32]


def sources(*modules: str, within: tuple[str, ...] = (OURS,)) -> dict[str, str]:
    """The hash of each module's source, by name: `modules` and all that they import, at any depth, inside functions too.

    Imports are followed under the packages `within` and, of a user's own module, in its top-level package, or in its
    folder where it has no package. The packages of an imported module are executed with it: their `__init__` counts
    where it does more than import, define functions and state `__all__`. What has no file, as a notebook, is left out.
    """
    found: dict[str, str] = {}
    waiting, folders = list(modules), set[Path]()
    packages = {*within, *(module.partition(".")[0] for module in modules)} - ({OURS} - {*within})
    while waiting:
        name = waiting.pop()
        source = None if name in found else _source(name)
        if source is None:
            continue
        if name in modules and "." not in name:
            folders.add(source.file.parent)
        found[name] = source.digest
        waiting += [used for used in source.imports if _is_followed(used, packages, folders)]
        waiting += [above for above in _packages(name) if _is_under(above, packages) and _acts(above)]
    return found


def forget() -> None:
    """Read all sources again at the next call: for a process in which they are edited."""
    closure.cache_clear()
    _source.cache_clear()


def modules_of(value: Any) -> tuple[str, ...]:
    """The modules that define what a motion consists of: its class, its functions, and those of its fields."""
    found = set[str]()
    if isinstance(value, FunctionType):
        found.add(value.__module__)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        found.add(type(value).__module__)
        for field in dataclasses.fields(value):
            found |= {*modules_of(getattr(value, field.name))}
    elif isinstance(value, tuple | list):
        for item in value:
            found |= {*modules_of(item)}
    return tuple(sorted(found))


def _is_followed(name: str, packages: set[str], folders: set[Path]) -> bool:
    top = name.partition(".")[0]
    return _is_under(name, packages) or any(
        (folder / f"{top}.py").is_file() or (folder / top).is_dir() for folder in folders
    )


def _is_under(name: str, packages: set[str]) -> bool:
    return any(f"{name}.".startswith(f"{package}.") for package in packages)


def _packages(name: str) -> Iterator[str]:
    """The packages that a module lies in, innermost first."""
    while name := name.rpartition(".")[0]:
        yield name


def _acts(package: str) -> bool:
    source = _source(package)
    return source is not None and source.acts


@cache
def _source(module: str) -> _Source | None:
    """None for what has no file, or is no module."""
    specification = _specification(module)
    origin = getattr(sys.modules.get(module), "__file__", None) if specification is None else specification.origin
    if origin is None or not Path(origin).is_file():
        return None
    content, file = Path(origin).read_bytes(), Path(origin)
    digest = hashlib.sha256(content).hexdigest()
    if file.suffix != ".py":  # compiled
        return _Source(file, digest, frozenset(), True)
    tree = ast.parse(content)
    package = "" if specification is None else specification.parent or ""
    return _Source(file, digest, frozenset(_imports(tree, package)), not all(map(_only_declares, tree.body)))


def _specification(module: str) -> ModuleSpec | None:
    """Where a module is found; no module is executed for it, only the packages that it lies in."""
    package = module.rpartition(".")[0]
    if package:
        above = _specification(package)
        if above is None or above.submodule_search_locations is None:
            return None
    try:
        return importlib.util.find_spec(module)
    except (ImportError, ValueError):  # ValueError: a script, or what stands in sys.modules without a specification
        return None


def _imports(tree: ast.Module, package: str) -> Iterator[str]:
    """Names imported anywhere in the text; `from a import b` may mean the module a.b."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            levels = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*levels, *([node.module] if node.module else [])])
            yield base
            yield from (f"{base}.{alias.name}" for alias in node.names)


def _only_declares(statement: ast.stmt) -> bool:
    if isinstance(statement, ast.Import | ast.ImportFrom | ast.FunctionDef | ast.AsyncFunctionDef):
        return True
    if isinstance(statement, ast.Expr):
        return isinstance(statement.value, ast.Constant)
    if isinstance(statement, ast.If):
        return ast.unparse(statement.test).endswith("TYPE_CHECKING")
    return isinstance(statement, ast.Assign) and all(ast.unparse(target) == "__all__" for target in statement.targets)
