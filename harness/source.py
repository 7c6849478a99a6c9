"""The text of what a result depends on: the functions of a form, the modules behind an integrator or a case."""

from __future__ import annotations

import ast
import dataclasses
import hashlib
import importlib.util
import inspect
import types
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from gnomon.cases.arithmetic import _names


def digest(parts: Iterable[str]) -> str:
    """A hash of several texts that no other division of the same characters gives."""
    hasher = hashlib.sha256()
    for part in parts:
        data = part.encode()
        hasher.update(len(data).to_bytes(8, "big") + data)
    return hasher.hexdigest()[:32]


def of_value(value: Any) -> str:
    """The text of a form or any value in it: functions by their source with all that they call, the rest by repr."""
    parts: list[str] = []
    _collect(value, parts, set())
    return "\n".join(parts)


def _collect(value: Any, parts: list[str], seen: set[int]) -> None:
    if isinstance(value, types.MethodType):
        value = value.__func__
    if isinstance(value, types.FunctionType):
        if id(value) in seen:
            return
        seen.add(id(value))
        parts.append(_source(value))
        for name in sorted(_names(value.__code__)):
            used = value.__globals__.get(name)
            if isinstance(used, types.FunctionType | int | float | tuple):
                parts.append(f"{name} =")
                _collect(used, parts, seen)
        for name, cell in zip(value.__code__.co_freevars, value.__closure__ or (), strict=True):
            parts.append(f"{name} =")
            _collect(cell.cell_contents, parts, seen)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts.append(type(value).__name__)
        for field in dataclasses.fields(value):
            parts.append(f"{field.name} =")
            _collect(getattr(value, field.name), parts, seen)
    elif isinstance(value, tuple | list):
        for item in value:
            _collect(item, parts, seen)
    elif isinstance(value, frozenset | set):
        parts.append(repr(sorted(value)))
    elif isinstance(value, type | types.BuiltinFunctionType):
        parts.append(value.__qualname__)
    elif isinstance(value, str | int | float | None):
        parts.append(repr(value))
    else:
        parts.append(type(value).__qualname__)  # a repr could hold an address, which is new in every process


@cache
def _source(function: types.FunctionType) -> str:
    return inspect.getsource(function)


@cache
def of_module(module: str, within: tuple[str, ...]) -> str:
    """A hash of a module's file and of every module under the packages `within` that it imports, at any depth."""
    seen: dict[str, str] = {}
    _follow(module, within, seen)
    return digest(f"{name}\n{text}" for name, text in sorted(seen.items()))


def _follow(module: str, within: tuple[str, ...], seen: dict[str, str]) -> None:
    if module in seen:
        return
    text = _text(module)
    if text is None:
        return
    seen[module] = text
    for name in sorted(_imports(text)):
        if name.startswith(within):
            _follow(name, within, seen)


@cache
def _imports(text: str) -> set[str]:
    """Absolute imports anywhere in the text, those inside functions too; `from a import b` may mean module a.b."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def _text(module: str) -> str | None:
    """The source of a module; None where there is none (compiled, or a name that is no module)."""
    try:
        specification = importlib.util.find_spec(module)
    except (ImportError, ValueError):
        specification = None
    origin = specification.origin if specification is not None else None
    return Path(origin).read_text() if origin is not None and origin.endswith(".py") else None
