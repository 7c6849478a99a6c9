"""Read a user's function as formulas: call it on symbols once, and write the values as a function that can be compiled.

The function may be anything that computes with numbers: a lambda, a method, NumPy or `math`, loops over a known range.
It must not decide by a value of the motion (`if`, `abs`, `max`, a table): such a function has no formulas.
"""

import hashlib
import math
import types
from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

import numpy as np
from gnomon.cases.core.arithmetic import FUNCTIONS, rebind, written
from gnomon.harness.kernels.traced import Node, Trace, Value, sequence

MOST_OPERATIONS = 20_000
"""Operations of formulas that are compiled: with more of them LLVM needs half a minute."""
CONSTANTS = {"inf": math.inf, "nan": math.nan}


class NoFormulasError(Exception):
    """A function has no formulas; the message says why."""


class ArraysOfObjects(types.ModuleType):
    """NumPy whose new arrays can hold symbols, so that a function may fill an array that it has made."""

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(np, name)
        return partial(_of_objects, attribute) if name in ("empty", "zeros", "ones") else attribute


def _of_objects(make: Callable[..., Any], shape: Any, dtype: Any = None) -> Any:
    return make(shape, dtype=object)


NUMPY = ArraysOfObjects("numpy")


def formulas(
    function: Callable[..., Any], bound: Callable[..., Callable[..., Any]], name: str, sizes: tuple[int, int, int]
) -> Callable[..., Any]:
    """The function (t, state, parameters) of formulas that has the values of `bound(function)`.

    `bound` makes a function (t, state, parameters) from a function with the arguments of `function`. `sizes`: the numbers
    of coordinates, parameters and values. Raises NoFormulasError.
    """
    states, parameters, outputs = sizes
    trace = Trace(states, parameters)
    try:
        with np.errstate(all="ignore"):
            raw = bound(on_symbols(function, trace))(trace.t, np.array(trace.state, dtype=object), trace.parameters)
        values = np.asarray(raw, dtype=object).reshape(outputs).tolist()
    except Exception as error:  # whatever a function raises that needs numbers
        raise NoFormulasError(f"{type(error).__name__}: {error}") from error
    nodes = sequence(values)
    if len(nodes) > MOST_OPERATIONS:
        raise NoFormulasError(f"it has more than {MOST_OPERATIONS} operations")
    numbers = [x for x in (*values, *(a for node in nodes for a in node.arguments)) if not isinstance(x, Node)]
    if not all(isinstance(x, int | float | np.integer) for x in numbers):
        raise NoFormulasError("it computes with other values than real numbers")
    return write_function(values, name)


def write_function(values: Sequence[Value], name: str, places: Sequence[int] | None = None) -> Callable[..., Any]:
    """The function (t, state, parameters) with these traced values; component i of the trace is `state[places[i]]`."""
    return _write(name, *_text(sequence(values), values, places))


def on_symbols(function: Any, trace: Trace) -> Callable[..., Any]:
    """The function, and all functions that it calls, with functions of symbols for `math` and arrays of objects for NumPy's.

    A callable without Python code, such as one written in C, stays as it is: it refuses symbols when it is called.
    """
    if isinstance(function, partial):
        return partial(on_symbols(function.func, trace), *function.args, **function.keywords)
    if isinstance(function, types.MethodType):
        return types.MethodType(on_symbols(function.__func__, trace), function.__self__)
    if isinstance(function, types.FunctionType):
        return rebind(function, trace.functions | {"numpy": NUMPY})
    method = function.__call__
    traced: Callable[..., Any] = on_symbols(method, trace) if isinstance(method, types.MethodType) else function
    return traced


def _text(nodes: Sequence[Node], values: Sequence[Value], places: Sequence[int] | None) -> tuple[tuple[str, ...], str]:
    """Source text: a line for each operation, and the tuple of the values."""
    names: dict[Node, str] = {}

    def word(value: Value) -> str:
        if isinstance(value, Node):
            return names[value]
        number = int(value) if isinstance(value, int | np.integer) else float(value)
        return f"({number!r})" if math.copysign(1, number) < 0 else repr(number)

    lines: list[str] = []
    for node in nodes:
        if not node.arguments:
            names[node] = node.operation.replace("p[", "parameters[")
            if node.operation.startswith("y["):
                place = int(node.operation[2:-1])
                names[node] = f"state[{place if places is None else places[place]}]"
            continue
        operands = [word(x) for x in node.arguments]
        if node.operation in FUNCTIONS:
            text = f"{node.operation}({', '.join(operands)})"
        else:
            text = f"-{operands[0]}" if node.operation == "neg" else f"{operands[0]} {node.operation} {operands[1]}"
        names[node] = f"c{len(lines) + 1}"
        lines.append(f"{names[node]} = {text}")
    return tuple(lines), f"({', '.join(map(word, values))},)"


@cache
def _write(name: str, lines: tuple[str, ...], value: str) -> Callable[..., Any]:
    """One function for equal formulas, so that they are compiled once."""
    content = hashlib.sha256("\n".join([*lines, value]).encode()).hexdigest()[:16]
    names = {each: getattr(math, each) for each in FUNCTIONS} | CONSTANTS
    return written(value, name, f"<formulas of {name} {content}>", names | {"__name__": "formulas"}, lines)
