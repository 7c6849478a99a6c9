"""One hash of the sources of a module and of all that it imports: the part of a result's key that stands for code."""

from __future__ import annotations

import ast
import dataclasses
import hashlib
import importlib.util
import inspect
import sys
import time
from collections.abc import Iterator
from functools import cache
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

OURS = "gnomon"
STARTED = time.time()


class _Source(NamedTuple):
    """A module's file, its text (empty for a compiled file), a hash of it, and the package that contains the module.

    The hash is empty for a file that was edited after this process had loaded the module.
    """

    file: Path
    text: bytes
    digest: str
    package: str


@cache
def closure(*modules: str, within: tuple[str, ...] = (OURS,)) -> str | None:
    """One hash of `sources`; None if results of them must not be kept.

    That is if one of `modules` has no file, or if this process has loaded a file of `sources` before its last edit: a result
    of the old code, kept under a hash of the new one, would be wrong for ever.
    """
    digests = sources(*modules, within=within)
    if not digests.keys() >= {*modules} or not all(digests.values()):
        return None
    return hashlib.sha256("\n".join(f"{name} {digests[name]}" for name in sorted(digests)).encode()).hexdigest()[:32]


def sources(*modules: str, within: tuple[str, ...] = (OURS,)) -> dict[str, str]:
    """The hash of each module's source, by name: `modules` and all that they import, at any depth, inside functions too.

    Imports are followed under the packages `within` and, for a user's own module, in its top-level package, or in its
    folder if it has no package. The packages of an imported module are executed with it: their `__init__` is included
    if it does more than import, define functions and set `__all__`. Modules without a file (notebooks) are left out.
    """
    digests: dict[str, str] = {}
    waiting, folders = list(modules), set[Path]()
    packages = {*within, *(module.partition(".")[0] for module in modules)} - ({OURS} - {*within})
    while waiting:
        name = waiting.pop()
        source = None if name in digests else _source(name)
        if source is None:
            continue
        if name in modules and "." not in name:
            folders.add(source.file.parent)
        digests[name] = source.digest
        if packages or folders:
            waiting += [used for used in _read(name).imports if _is_followed(used, packages, folders)]
        waiting += [above for above in _packages(name) if _is_under(above, packages) and _acts(above)]
    return digests


@cache
def imports(module: str, packages: tuple[str, ...], within: tuple[str, ...]) -> bool:
    """Whether one of `sources` imports from one of the `packages`."""
    return any(_is_under(used, {*packages}) for name in sources(module, within=within) for used in _read(name).imports)


def forget() -> None:
    """Read all sources again at the next call, for a process in which they are edited."""
    closure.cache_clear()
    imports.cache_clear()
    _source.cache_clear()
    _read.cache_clear()


def modules_of(value: Any) -> tuple[str, ...]:
    """The modules that define the parts of a motion: its class, its functions, and the parts of its fields."""
    names = set[str]()
    if isinstance(value, FunctionType):
        names.add(value.__module__)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        names.add(type(value).__module__)
        for field in dataclasses.fields(value):
            names |= {*modules_of(getattr(value, field.name))}
    elif isinstance(value, tuple | list):
        for item in value:
            names |= {*modules_of(item)}
    return tuple(sorted(names))


def _is_followed(name: str, packages: set[str], folders: set[Path]) -> bool:
    top = name.partition(".")[0]
    return _is_under(name, packages) or any(
        (folder / f"{top}.py").is_file() or (folder / top).is_dir() for folder in folders
    )


def _is_under(name: str, packages: set[str]) -> bool:
    return any(f"{name}.".startswith(f"{package}.") for package in packages)


def _packages(name: str) -> Iterator[str]:
    """The packages that contain a module, innermost first."""
    while name := name.rpartition(".")[0]:
        yield name


def _acts(package: str) -> bool:
    return _source(package) is not None and _read(package).acts


@cache
def _source(module: str) -> _Source | None:
    """None if there is no such module, or if it has no file."""
    specification = _specification(module)
    origin = getattr(sys.modules.get(module), "__file__", None) if specification is None else specification.origin
    if origin is None or not Path(origin).is_file():
        return None
    content, file = Path(origin).read_bytes(), Path(origin)
    digest, text = hashlib.sha256(content).hexdigest(), content if file.suffix == ".py" else b""
    if text and file.stat().st_mtime > STARTED and module in sys.modules:
        digest = "" if _differs(sys.modules[module], ast.parse(text)) else digest
    return _Source(file, text, digest, "" if specification is None else specification.parent or "")


class _Read(NamedTuple):
    """The names that a module imports (functions and classes included), and whether it acts.

    A module acts if its import does more than import, define functions and set `__all__`, or if it is compiled.
    """

    imports: frozenset[str]
    acts: bool


@cache
def _read(module: str) -> _Read:
    source = _source(module)
    assert source is not None
    tree = ast.parse(source.text)
    acts = source.file.suffix != ".py" or not all(map(_only_declares, tree.body))
    return _Read(frozenset(_imports(tree, source.package)), acts)


def _differs(module: ModuleType, tree: ast.Module) -> bool:
    """Whether a loaded module has a function that is not in the text, or another value of a constant."""
    codes, waiting = set[CodeType](), [compile(tree, "text", "exec", dont_inherit=True)]
    while waiting:
        codes.add(code := waiting.pop())
        waiting += [constant for constant in code.co_consts if isinstance(constant, CodeType)]
    values = [value for value in vars(module).values() if getattr(value, "__module__", None) == module.__name__]
    values += [part for value in values if isinstance(value, type) for part in vars(value).values()]
    # Also functions that a decorator replaced.
    functions = [inspect.unwrap(value) for value in values if callable(value)]
    loaded = [f.__code__ for f in functions if isinstance(f, FunctionType) and f.__module__ == module.__name__]
    if not codes.issuperset(code for code in loaded if not code.co_filename.startswith("<")):  # "<string>": generated
        return True
    for statement in tree.body:
        if isinstance(statement, ast.Assign) and isinstance(statement.value, ast.Constant):
            for target in statement.targets:
                if isinstance(target, ast.Name) and vars(module).get(target.id) != statement.value.value:
                    return True
    return False


def _specification(module: str) -> ModuleSpec | None:
    """The specification of a module, which is not executed; only the packages that contain it are."""
    package = module.rpartition(".")[0]
    if package:
        above = _specification(package)
        if above is None or above.submodule_search_locations is None:
            return None
    try:
        return importlib.util.find_spec(module)
    except (ImportError, ValueError):  # ValueError: a script, or an entry of sys.modules without a specification
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
