"""The expression graph of a case's equations, recorded by evaluating them once on symbolic numbers.

From the graph come exact Jacobians (differentiated node by node) and the recurrences of Taylor's method.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from gnomon.cases.core.arithmetic import Unbranching, rebind
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.kernels.equations import OPTIONS, address, check_values

Key = tuple[Any, ...]
UNARY = (
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh",
    "sqrt", "exp", "log",
)  # fmt: skip
"""Functions that are nodes of the graph; hypot is written with sqrt."""


@dataclass
class Graph:
    """Nodes, each after those that it acts on; equal nodes are stored once.

    A node is a tuple: ("t",), ("y", i), ("p", i), ("number", value), ("pow", node, exponent), or the name of an
    operation (add, sub, mul, div, neg, a function) and the indices of its operands.
    """

    nodes: list[Key] = field(default_factory=list)
    known: dict[Key, int] = field(default_factory=dict)

    def node(self, *key: Any) -> Number:
        tagged = (*key, type(key[-1]).__name__)
        if tagged not in self.known:
            self.known[tagged] = len(self.nodes)
            self.nodes.append(key)
        return Number(self, self.known[tagged])

    def number(self, value: Any) -> Number:
        """The Number of a literal; a Number is returned as it is."""
        return value if isinstance(value, Number) else self.node("number", value)

    def variables(self, name: str, count: int) -> tuple[Number, ...]:
        return tuple(self.node(name, i) for i in range(count))

    def arithmetic(self) -> dict[str, Callable[..., Number]]:
        """The functions of `math` that equations may use, on Numbers."""

        def recorded(name: str) -> Callable[[Any], Number]:
            def function(x: Any) -> Number:
                return self.node(name, self.number(x).index)

            return function

        functions: dict[str, Callable[..., Number]] = {name: recorded(name) for name in UNARY}
        return functions | {"hypot": lambda x, y: functions["sqrt"](x * x + y * y)}


class Number(Unbranching):
    """A node of a graph with the operators of a number.

    Sums with 0 and products with 0 or 1 are simplified; u sqrt(u) becomes the power u^1.5 and a division by it u^-1.5, one
    recurrence in place of three.
    """

    def __init__(self, graph: Graph, index: int) -> None:
        self.graph, self.index = graph, index

    @property
    def literal(self) -> Any:
        """The value of a literal; None for other nodes."""
        key = self.graph.nodes[self.index]
        return key[1] if key[0] == "number" else None

    def _with(self, operation: str, a: Number, b: Number) -> Number:
        if operation in ("add", "mul") and a.index > b.index:
            a, b = b, a
        return self.graph.node(operation, a.index, b.index)

    def __add__(self, other: Any) -> Number:
        b = self.graph.number(other)
        if self.literal == 0:
            return b
        return self if b.literal == 0 else self._with("add", self, b)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Number:
        b = self.graph.number(other)
        if b.literal == 0:
            return self
        return -b if self.literal == 0 else self._with("sub", self, b)

    def __rsub__(self, other: Any) -> Number:
        return self.graph.number(other) - self

    def __mul__(self, other: Any) -> Number:
        for a, b in ((self, self.graph.number(other)), (self.graph.number(other), self)):
            if a.literal == 0:
                return a.graph.number(0)
            if a.literal == 1:
                return b
            if self.graph.nodes[b.index] == ("sqrt", a.index):
                return self.graph.node("pow", a.index, 1.5)
        return self._with("mul", self, self.graph.number(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Number:
        b = self.graph.number(other)
        if self.literal == 0 or b.literal == 1:
            return self
        operation, *where = self.graph.nodes[b.index]
        if operation == "pow":
            return self * self.graph.node("pow", where[0], -where[1])
        return self._with("div", self, b)

    def __rtruediv__(self, other: Any) -> Number:
        return self.graph.number(other) / self

    def __neg__(self) -> Number:
        if self.literal is not None:
            return self.graph.number(-self.literal)
        return self.graph.node("neg", self.index)

    def __pos__(self) -> Number:
        return self

    def __pow__(self, exponent: Any) -> Number:
        if isinstance(exponent, Number):
            functions = self.graph.arithmetic()
            return functions["exp"](exponent * functions["log"](self))
        if isinstance(exponent, int) and 0 <= exponent <= 8:
            found = self.graph.number(1)
            for _ in range(exponent):
                found = found * self
            return found
        return self.graph.node("pow", self.index, exponent)


@dataclass(frozen=True)
class Trace:
    """Traced equations: the graph, and the nodes of the values."""

    graph: Graph
    outputs: tuple[Number, ...]


def traced(form: FirstOrder, dimension: int, parameters: int) -> Trace:
    """The graph of first-order equations. Raises ValueError for what it cannot express (a branch, atan2)."""
    check_values({"equations": form.equations}, "equations(t, y, p)", dimension, parameters, dimension)
    graph = Graph()
    equations = rebind(form.equations, graph.arithmetic())
    found = equations(graph.node("t"), graph.variables("y", dimension), graph.variables("p", parameters))
    return Trace(graph, tuple(graph.number(x) for x in found))


def jacobian(trace: Trace, dimension: int) -> tuple[Number, ...]:
    """The nodes of df/dy, row by row; they are added to the graph of the trace."""
    graph = trace.graph
    known: dict[tuple[int, int], Number] = {}
    for index in needed(trace):
        for j in range(dimension):
            known[index, j] = _derivative(graph, index, j, known)
    return tuple(known[x.index, j] for x in trace.outputs for j in range(dimension))


def _derivative(graph: Graph, index: int, j: int, known: dict[tuple[int, int], Number]) -> Number:
    operation, *where = graph.nodes[index]
    if operation in ("t", "p", "number"):
        return graph.number(0)
    if operation == "y":
        return graph.number(int(where[0] == j))
    u = Number(graph, where[0])
    du = known[u.index, j]
    if operation == "neg":
        return -du
    if operation == "pow":
        exponent: float = where[1]
        return du * exponent * u ** (exponent - 1)
    if len(where) == 2:
        v = Number(graph, where[1])
        dv = known[v.index, j]
        if operation == "add":
            return du + dv
        if operation == "sub":
            return du - dv
        if operation == "mul":
            return du * v + u * dv
        return (du - Number(graph, index) * dv) / v
    return du * slope(graph, operation, u, Number(graph, index))


def slope(graph: Graph, name: str, u: Number, value: Number) -> Number:
    """The derivative of the function `name` at u; `value` is the function at u."""
    f = graph.arithmetic()
    rules: dict[str, Callable[[], Number]] = {
        "sin": lambda: f["cos"](u),
        "cos": lambda: -f["sin"](u),
        "tan": lambda: 1 + value * value,
        "sinh": lambda: f["cosh"](u),
        "cosh": lambda: f["sinh"](u),
        "tanh": lambda: 1 - value * value,
        "asin": lambda: 1 / f["sqrt"](1 - u * u),
        "acos": lambda: -1 / f["sqrt"](1 - u * u),
        "atan": lambda: 1 / (1 + u * u),
        "asinh": lambda: 1 / f["sqrt"](1 + u * u),
        "acosh": lambda: 1 / f["sqrt"](u * u - 1),
        "atanh": lambda: 1 / (1 - u * u),
        "sqrt": lambda: 1 / (2 * value),
        "exp": lambda: value,
        "log": lambda: 1 / u,
    }
    return rules[name]()


def needed(trace: Trace) -> list[int]:
    """The nodes that the outputs depend on, each after its operands."""
    nodes, wanted = trace.graph.nodes, set()
    waiting = [x.index for x in trace.outputs]
    while waiting:
        index = waiting.pop()
        if index not in wanted:
            wanted.add(index)
            waiting += arguments(nodes[index])
    return sorted(wanted)


def arguments(node: Key) -> list[int]:
    """The indices of the operands of a node."""
    if node[0] in ("t", "y", "p", "number"):
        return []
    return [node[1]] if node[0] == "pow" else list(node[1:])


SYMBOLS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}


def straight_line(trace: Trace) -> str:
    """Source text of a function `kernel(t, y, p, out)` that computes the outputs of a trace, each node once."""
    lines = [f"    n{i} = {expression(trace.graph.nodes[i])}" for i in needed(trace)]
    lines += [f"    out[{i}] = n{x.index}" for i, x in enumerate(trace.outputs)]
    return "\n".join(["def kernel(t, y, p, out):", *lines, ""])


def expression(node: Key) -> str:
    """Source text of a node, with its operands by name; ONE is the number 1 of the arithmetic that runs the text."""
    operation, *where = node
    if operation == "t":
        return "t"
    if operation in ("y", "p"):
        return f"{operation}[{where[0]}]"
    if operation == "number":
        return f"ONE * {where[0]!r}"
    names = [f"n{i}" for i in arguments(node)]
    if operation == "pow":
        return f"{names[0]} ** {where[1]!r}"
    if operation == "neg":
        return f"-{names[0]}"
    if operation in SYMBOLS:
        return f"{names[0]} {SYMBOLS[operation]} {names[1]}"
    return f"{operation}({names[0]})"


def jacobian_text(form: FirstOrder, dimension: int, parameters: int) -> str:
    """Source text of `kernel(t, y, p, out)`: df/dy row by row, exact. Raises ValueError where equations branch."""
    trace = traced(form, dimension, parameters)
    return straight_line(Trace(trace.graph, jacobian(trace, dimension)))


def counting_text(form: FirstOrder, dimension: int, parameters: int) -> str:
    """The same for f followed by df/dy; each call adds 1 to the element of p after the parameters."""
    trace = traced(form, dimension, parameters)
    both = Trace(trace.graph, trace.outputs + jacobian(trace, dimension))
    return f"{straight_line(both)}    p[{parameters}] += ONE\n"


def compiled(text: str) -> int:
    """The address of the C function void(double t, double *y, double *p, double *out) compiled from such a text."""
    return address(module_text(text), "kernel")


def module_text(text: str) -> str:
    """The source of a module in which numba compiles such a text."""
    used = [name for name in UNARY if f" {name}(" in text]
    lines = [f"from math import {', '.join(used)}"] if used else []
    return "\n".join([*lines, "from numba import njit", "ONE = 1.0", f"@njit({OPTIONS})", text])
