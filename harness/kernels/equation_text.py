"""Equations of motion as plain arithmetic, for readers and for programs in other languages than Python."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.forms import Equations, Form, SecondOrder
from gnomon.harness.kernels.traced import Node, Trace, Value, list_reached, trace_form

_STRENGTH = {"+": 1, "-": 1, "*": 2, "/": 2, "neg": 3}
"""The precedence of each operation. Names, numbers and calls have the precedence ATOM."""
ATOM = 4


@dataclass(frozen=True)
class EquationText:
    """The right-hand side of first-order equations as text.

    `where` holds lines "name = expression" for values that are used more than once, each after the lines that it uses.
    `derivatives` holds an expression for each coordinate.

    Expressions have + - * /, parentheses, numbers, the names of coordinates, parameters and t, and calls of functions
    by their names in `math`; powers are pow(base, exponent).
    """

    where: tuple[str, ...]
    derivatives: tuple[str, ...]


def equation_text(form: Form, coordinates: Sequence[str], parameters: Sequence[str]) -> EquationText:
    """Write a form (FirstOrder, SecondOrder or RigidBody) as first-order equations in plain text.

    Sums and products keep the sequence of the case's own function. Raises ValueError for equations that branch.
    """
    written = _write(trace_form(form, Trace(len(coordinates), len(parameters))), coordinates, parameters)
    if isinstance(form, SecondOrder):
        return replace(written, derivatives=(*coordinates[len(coordinates) // 2 :], *written.derivatives))
    return written


def function_text(function: Equations, coordinates: Sequence[str], parameters: Sequence[str]) -> EquationText:
    """The values of any function of (t, state, parameters), such as a guard. Raises ValueError if it branches."""
    trace = Trace(len(coordinates), len(parameters))
    try:
        values = rebind(function, trace.functions)(trace.t, trace.state, trace.parameters)
    except TypeError as error:  # from a function that takes numbers only
        raise ValueError(f"it cannot be traced: {error}") from error
    return _write(values, coordinates, parameters)


def _write(values: Sequence[Value], coordinates: Sequence[str], parameters: Sequence[str]) -> EquationText:
    names = {"t": "t"}
    names |= {f"y[{i}]": name for i, name in enumerate(coordinates)}
    names |= {f"p[{i}]": name for i, name in enumerate(parameters)}
    writer = _Writer(values, names)
    return EquationText(tuple(writer.where), tuple(writer.text(value)[0] for value in values))


class _Writer:
    """Write a definition for each value that is used more than once, and all other values inside the expressions."""

    def __init__(self, values: Sequence[Value], names: dict[str, str]) -> None:
        self.names, self.where = names, list[str]()
        self.written: dict[Node, str] = {}
        nodes = list_reached(values)
        used = [*values, *(x for node in nodes for x in node.arguments)]
        uses = Counter(x for x in used if isinstance(x, Node))
        free = (name for name in (f"c{k}" for k in range(1, len(nodes) + len(names) + 2)) if name not in names.values())
        for node in nodes:
            if node.arguments and uses[node] > 1:
                text, name = self.text(node)[0], next(free)
                self.where.append(f"{name} = {text}")
                self.written[node] = name

    def text(self, value: Value) -> tuple[str, int]:
        """The text of a value, and the precedence of its last operation."""
        if not isinstance(value, Node):
            negative = math.copysign(1.0, value) < 0
            return repr(value), _STRENGTH["neg"] if negative else ATOM
        if value in self.written:
            return self.written[value], ATOM
        if not value.arguments:
            return self.names[value.operation], ATOM
        operation, operands = value.operation, [self.text(x) for x in value.arguments]
        if operation not in _STRENGTH:
            name = "pow" if operation == "**" else operation
            return f"{name}({', '.join(text for text, _ in operands)})", ATOM
        strength = _STRENGTH[operation]
        if operation == "neg":
            return f"-{enclose(*operands[0], strength + 1)}", strength
        left, right = enclose(*operands[0], strength), enclose(*operands[1], strength + 1)
        return f"{left} {operation} {right if right[0] != '-' else f'({right})'}", strength


def enclose(text: str, strength: int, least: int) -> str:
    return text if strength >= least else f"({text})"
