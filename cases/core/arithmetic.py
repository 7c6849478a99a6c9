"""A case's equations in another arithmetic, by replacing the globals of their functions, or with other arguments."""

import builtins
import linecache
import math
import types
from collections.abc import Callable, Mapping, Sequence
from functools import cache, reduce
from typing import Any

FUNCTIONS = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2",
    "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "sqrt", "exp", "log", "hypot",
)  # fmt: skip
"""The functions of `math` that equations may use."""


def pairwise(hypot: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    """`math.hypot`, which takes any number of arguments, from a hypot of two."""
    return lambda first, *others: reduce(hypot, others or (0.0,), first)


def to_any_base(log: Callable[[Any], Any]) -> Callable[..., Any]:
    """`math.log`, which takes a base too, from the natural logarithm."""
    return lambda x, *base: log(x) / log(*base) if base else log(x)


def rebind(function: Callable[..., Any], arithmetic: dict[str, Any]) -> Callable[..., Any]:
    """The same function with `arithmetic` ({"sin": ...}) in place of `math`, also in its imports and the functions that it calls."""
    rebound: Callable[..., Any] = _rebound(function, arithmetic, {})
    return rebound


def _rebound(function: Any, arithmetic: dict[str, Any], copies: dict[Any, Any]) -> Any:
    if function in copies:
        return copies[function]

    def import_module(*given: Any) -> Any:
        return _value("", builtins.__import__(*given), arithmetic, copies)

    namespace: dict[str, Any] = {"__builtins__": vars(builtins) | {"__import__": import_module}}
    cells = tuple(types.CellType() for _ in function.__closure__ or ())
    copy = types.FunctionType(function.__code__, namespace, function.__name__, function.__defaults__, cells)
    copies[function] = copy
    for name in _names(function.__code__):
        if name in function.__globals__:
            namespace[name] = _value(name, function.__globals__[name], arithmetic, copies)
    for name, cell, source in zip(function.__code__.co_freevars, cells, function.__closure__ or (), strict=True):
        cell.cell_contents = _value(name, source.cell_contents, arithmetic, copies)
    return copy


def _names(code: types.CodeType) -> set[str]:
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            names |= _names(constant)
    return names


def _value(name: str, value: Any, arithmetic: dict[str, Any], copies: dict[Any, Any]) -> Any:
    if value is math:
        return types.SimpleNamespace(**(vars(math) | arithmetic))
    if isinstance(value, types.ModuleType):
        return arithmetic.get(value.__name__, value)
    if name in FUNCTIONS and value is getattr(math, name):
        if name not in arithmetic:
            raise ValueError(f"{name} has no counterpart in this arithmetic, which has {', '.join(sorted(arithmetic))}")
        return arithmetic[name]
    return _rebound(value, arithmetic, copies) if isinstance(value, types.FunctionType) else value


@cache
def calling(function: Callable[..., Any], arguments: str, what: str, before: str = "") -> Callable[..., Any]:
    """A function of (t, state, parameters) that returns function(`arguments`).

    `arguments` is the text of expressions in t, state and parameters. `before`, the text of a tuple of such expressions,
    comes before the values of the function. The result has source text of its own, because equations are compiled from
    source text. Its name ends in `what`.
    """
    name = function.__name__ if function.__name__.isidentifier() else "function"
    value = f"{before} + {name}({arguments})" if before else f"{name}({arguments})"
    file = f"<{function.__module__}.{function.__qualname__} ({value})>"
    return written(value, f"{name}_{what}", file, {name: function, "__name__": function.__module__})


def written(
    value: str, name: str, file: str, names: Mapping[str, Any], before: Sequence[str] = ()
) -> Callable[..., Any]:
    """The function of (t, state, parameters) that returns `value`, an expression in the three and in `names`.

    `file` is where its source text is kept, as equations are compiled from that. `before` holds statements.
    """
    text = "\n    ".join([f"def {name}(t, state, parameters):", *before, f"return {value}\n"])
    linecache.cache[file] = len(text), None, text.splitlines(keepends=True), file
    known = dict(names)
    exec(compile(text, file, "exec"), known)
    function: Callable[..., Any] = known[name]
    return function


class Unbranching:
    """A number of a traced arithmetic. bool() of it and comparisons raise: equations must not branch on a value."""

    def __bool__(self) -> bool:
        raise ValueError("equations must not branch on computed values")

    def __lt__(self, other: Any) -> bool:
        return bool(self)

    __le__ = __gt__ = __ge__ = __lt__

    def __eq__(self, other: object) -> bool:
        return bool(self)

    __hash__ = object.__hash__


def mpmath_arithmetic(mp: Any) -> dict[str, Any]:
    """The functions of an mpmath context by their names in `math`."""
    return {name: getattr(mp, name) for name in FUNCTIONS}
