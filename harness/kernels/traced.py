"""Trace the equations of a case: call its functions on symbols, and store each value once as an expression.

Other modules turn the expressions into exact derivatives (`derivatives.py`), compiled functions (`straight_line.py`), code
in three stages for vectors (`staged_equations.py`), the recurrences of Taylor's method, and equations for readers
(`equation_text.py`).

A `Trace` keeps each arithmetic operation, so that its nodes give the same numbers as the case's own function; it only
removes + 0, * 1, * 0, / 1 and x - x. A `ReducedTrace` has fewer operations.
"""

import math
from collections.abc import Callable, Iterable
from functools import partial, reduce
from operator import add
from typing import Any

from gnomon.cases.core.arithmetic import FUNCTIONS, Unbranching, pairwise, rebind, to_any_base
from gnomon.cases.core.forms import Form, SecondOrder, Values, first_order
from gnomon.harness.kernels.equations import check_form, check_values

RUN, STEP, ROUND = 0, 1, 2
"""Levels of a value. RUN: it depends on parameters only; STEP: also on t; ROUND: also on the state."""

Value = Any
"""A Node, or a plain number."""

UFUNCS = {name: name for name in FUNCTIONS} | {
    f"arc{name[1:]}": name for name in FUNCTIONS if name.startswith("a")
}  # fmt: skip
"""The functions of `math` by their names in `math` and in NumPy."""


def _operators(name: str) -> tuple[Any, Any]:
    """The operator that a method of the trace computes, and the operator with exchanged operands."""
    return (
        lambda node, other: getattr(node.trace, name)(node, other),
        lambda node, other: getattr(node.trace, name)(other, node),
    )


class Node(Unbranching):
    """A value of the traced equations: an operation and its arguments, or the name of a variable (t, y[0], p[0]).

    `index` counts the nodes of the trace, each after its arguments.
    """

    def __init__(self, trace: "Trace", operation: str, arguments: tuple[Value, ...], level: int) -> None:
        self.trace, self.operation, self.arguments, self.level = trace, operation, arguments, level
        self.index = len(trace.nodes)

    __add__, __radd__ = _operators("sum")
    __sub__, __rsub__ = _operators("difference")
    __mul__, __rmul__ = _operators("product")
    __truediv__, __rtruediv__ = _operators("quotient")
    __pow__, __rpow__ = _operators("power")

    def __getattr__(self, name: str) -> Callable[..., Value]:
        """The method that a function of NumPy calls on each element of an array of objects, as `numpy.sin` calls `sin`."""
        operation = UFUNCS.get(name)
        if operation is None:
            raise AttributeError(f"a symbol has no {name}")
        return lambda *others: self.trace.functions[operation](self, *others)

    def __float__(self) -> float:
        raise TypeError("it gives a value of the motion to a function that takes numbers alone")

    def __neg__(self) -> Value:
        return self.trace.node("neg", self)

    def __pos__(self) -> Value:
        return self


class Trace:
    """Symbols for t, the state and the parameters, and every value computed from them, each stored once.

    Components of the state in `frozen` are constants: they stand in the array p after the parameters of the case.
    """

    def __init__(self, dimension: int, parameters: int, frozen: tuple[int, ...] = ()) -> None:
        self.nodes: dict[tuple[Any, ...], Node] = {}
        self.t = self._variable("t", STEP)
        places = iter(range(dimension))
        self.state = tuple(
            self._variable(f"p[{parameters + frozen.index(i)}]", RUN)
            if i in frozen
            else self._variable(f"y[{next(places)}]", ROUND)
            for i in range(dimension)
        )
        self.parameters = tuple(self._variable(f"p[{i}]", RUN) for i in range(parameters))
        self.functions: dict[str, Callable[..., Node]] = {name: partial(self.node, name) for name in FUNCTIONS}
        """The functions of `math`. Even for a number they give a node, so that the nodes work in other arithmetics."""
        self.functions["hypot"] = pairwise(self.functions["hypot"])
        self.functions["log"] = to_any_base(self.functions["log"])

    def _variable(self, name: str, level: int) -> Node:
        return self.nodes.setdefault((name,), Node(self, name, (), level))

    def node(self, operation: str, *arguments: Value) -> Node:
        key = (operation, *(x.index if isinstance(x, Node) else (type(x), x) for x in arguments))
        if key not in self.nodes:
            self.nodes[key] = Node(self, operation, arguments, max(level(x) for x in arguments))
        return self.nodes[key]

    def sum(self, a: Value, b: Value) -> Value:
        if is_number(a, 0) or is_number(b, 0):
            return b if is_number(a, 0) else a
        return self.node("+", a, b)

    def difference(self, a: Value, b: Value) -> Value:
        if is_number(b, 0):
            return a
        if a is b:
            return 0
        return -b if is_number(a, 0) else self.node("-", a, b)

    def product(self, a: Value, b: Value) -> Value:
        if is_number(a, 0) or is_number(b, 0):
            return 0
        if is_number(a, 1) or is_number(b, 1):
            return b if is_number(a, 1) else a
        return self.node("*", a, b)

    def quotient(self, a: Value, b: Value) -> Value:
        return a if is_number(a, 0) or is_number(b, 1) else self.node("/", a, b)

    def power(self, a: Value, b: Value) -> Value:
        return self.node("**", a, b)

    def shared_quotient(self, a: Value, b: Value) -> Value:
        """a / b to round-off as a times the inverse of b, computed once for all values that are divided by b."""
        return a * (1 / b)


class ReducedTrace(Trace):
    """A trace with fewer operations, each of which becomes a recurrence of Taylor's method.

    x y and y x are one value. u sqrt(u) is the power u^1.5, and a division by it is a product with u^-1.5: one
    recurrence instead of three. Integer powers up to the eighth are products; hypot is written with sqrt.
    """

    def __init__(self, dimension: int, parameters: int) -> None:
        super().__init__(dimension, parameters)
        self.functions["hypot"] = lambda *x: self.functions["sqrt"](reduce(add, (each * each for each in x)))

    def node(self, operation: str, *arguments: Value) -> Node:
        if operation in ("+", "*"):
            arguments = tuple(sorted(arguments, key=lambda x: x.index if isinstance(x, Node) else math.inf))
        return super().node(operation, *arguments)

    def product(self, a: Value, b: Value) -> Value:
        for u, root in ((a, b), (b, a)):
            if isinstance(root, Node) and root.operation == "sqrt" and root.arguments[0] is u:
                return self.node("**", u, 1.5)
        return super().product(a, b)

    def quotient(self, a: Value, b: Value) -> Value:
        if isinstance(b, Node) and b.operation == "**":
            u, exponent = b.arguments
            return self.product(a, self.node("**", u, -exponent))
        return super().quotient(a, b)

    def power(self, a: Value, b: Value) -> Value:
        if isinstance(b, Node):
            return self.node("exp", b * self.node("log", a))
        if isinstance(b, int) and 0 <= b <= 8:
            return math.prod([a] * b)
        return self.node("**", a, b)

    def shared_quotient(self, a: Value, b: Value) -> Value:
        return self.quotient(a, b)


def level(value: Value) -> int:
    return value.level if isinstance(value, Node) else RUN


def is_number(value: Value, which: int) -> bool:
    return isinstance(value, int | float) and value == which


def trace_form(form: Form, trace: Trace) -> tuple[Value, ...]:
    """Trace the first-order right-hand side of a form; for SecondOrder trace only the accelerations.

    Raises ValueError for code that has no expression: a branch on a value, abs, floor.
    """
    try:
        return _right_hand_side(form, trace.t, trace.state, trace.parameters, trace.functions)
    except TypeError as error:  # from a function that takes numbers only
        raise ValueError(f"the equations cannot be traced: {error}") from error


def _right_hand_side(form: Form, t: Node, y: Values, p: Values, functions: dict[str, Any]) -> Values:
    if isinstance(form, SecondOrder):
        half = len(y) // 2
        check_values(form.acceleration, (half, len(p)), half)
        return tuple(rebind(form.acceleration, functions)(t, y[:half], p))
    first = first_order(form)
    assert first is not None
    check_form(first, len(y), len(p))
    return tuple(rebind(first.equations, functions)(t, y, p))


def list_reached(values: Iterable[Value]) -> list[Node]:
    """All nodes on which `values` depend, each after its arguments."""
    reached: dict[Node, None] = {}

    def visit(value: Value) -> None:
        if isinstance(value, Node) and value not in reached:
            for argument in value.arguments:
                visit(argument)
            reached[value] = None

    for value in values:
        visit(value)
    return list(reached)


def sequence(values: Iterable[Value]) -> list[Node]:
    """All nodes on which `values` depend, in the sequence in which they were traced."""
    return sorted(list_reached(values), key=lambda x: x.index)
