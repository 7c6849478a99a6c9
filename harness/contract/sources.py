"""Texts and hashes of the content on which a result depends: a form, its functions, and all values that these read."""

import dataclasses
import hashlib
import inspect
import numbers
import types
from collections.abc import Callable, Iterable, Iterator
from functools import cache, wraps
from typing import Any, TypeVar

import numpy as np
from gnomon.cases.core.arithmetic import _names

Result = TypeVar("Result")


def digest(parts: Iterable[str]) -> str:
    """A hash of several texts: another division of the same characters gives another hash."""
    hasher = hashlib.sha256()
    for part in parts:
        data = part.encode()
        hasher.update(len(data).to_bytes(8, "big") + data)
    return hasher.hexdigest()[:32]


def of_value(value: Any) -> str:
    """The text of a form or of a value in it: functions by their source and the values they read, others by repr."""
    parts: list[Any] = []
    _collect(value, parts, set(), _source)
    return "\n".join(parts)


def cache_by_content(function: Callable[..., Result]) -> Callable[..., Result]:
    """Cache a function by the content of its arguments; for functions among these, by everything that they read.

    This is, at any depth, their code, numbers at module level, closures and default values: if one of these has changed
    since the last call, the result is computed again. Raises ValueError for a function that reads a value whose changes
    cannot be detected.
    """
    results: dict[tuple[Any, ...], Result] = {}

    @wraps(function)
    def remembered(*arguments: Any) -> Result:
        parts: list[Any] = []
        _collect(arguments, parts, set(), None)
        key = tuple(parts)
        if key not in results:
            results[key] = function(*arguments)
        return results[key]

    return remembered


def _collect(value: Any, parts: list[Any], seen: set[int], text: Callable[[types.CodeType], str] | None) -> None:
    """Append the content of a value to `parts`; `text` gives the content of functions.

    Without `text` the content of a function is its code, and a value of an unknown type raises ValueError.
    """
    if isinstance(value, types.FunctionType):
        if id(value) in seen:
            return
        seen.add(id(value))
        parts.append(text(value.__code__) if text else value.__code__)
        for name, used in _read(value):
            parts.append(f"{name} =")
            try:
                _collect(used, parts, seen, text)
            except ValueError as error:
                raise ValueError(f"{value.__qualname__} reads {name}: {error}") from None
    elif isinstance(value, types.MethodType):
        parts.append(type(value.__self__).__qualname__)
        _collect(value.__func__, parts, seen, text)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts.append(type(value).__qualname__)
        for field in dataclasses.fields(value):
            parts.append(f"{field.name} =")
            _collect(getattr(value, field.name), parts, seen, text)
    elif isinstance(value, tuple | list):
        parts.append(f"{type(value).__name__} of {len(value)}")
        for item in value:
            _collect(item, parts, seen, text)
    elif isinstance(value, dict):
        _collect(sorted(value.items(), key=repr), parts, seen, text)
    elif isinstance(value, frozenset | set):
        parts.append(repr(sorted(value, key=repr)))
    elif isinstance(value, str | bytes | numbers.Number | None):
        parts.append(f"{type(value).__name__} {value!r}")
    elif isinstance(value, types.BuiltinFunctionType):
        parts.append(value.__qualname__)
    elif isinstance(value, np.ndarray):
        parts.append(f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}")
    elif text is None:
        if (refusal := getattr(value, "refusal", None)) is not None:
            raise ValueError(refusal)
        raise ValueError(
            f"{value!r} may change unseen, so that code compiled for it could be out of date; "
            "equations may use numbers, tuples, plain functions and math"
        )
    elif isinstance(value, type | types.ModuleType):
        parts.append(getattr(value, "__qualname__", value.__name__))
    else:
        parts.append(type(value).__qualname__)  # a repr could hold an address, which is new in every process


def _read(function: types.FunctionType) -> Iterator[tuple[str, Any]]:
    """The names that a function reads from outside its body, with their values: globals, closure, default values."""
    for name in sorted(_names(function.__code__)):
        if name in function.__globals__:
            yield name, function.__globals__[name]
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        yield name, cell.cell_contents
    if function.__defaults__ or function.__kwdefaults__:
        yield "default values", (function.__defaults__, function.__kwdefaults__)


@cache
def _source(code: types.CodeType) -> str:
    return inspect.getsource(code)
