"""The equations of a case as straight-line code, and their derivatives.

The equations are evaluated once on symbols. Equal values are computed once. Values are separated by what they depend on:
parameters (computed once a run), parameters and t (once a step), the state (once a round of the iteration). Arithmetic is
kept operation by operation; only + 0, * 1, * 0 and x - x are removed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from gnomon.cases.core.arithmetic import FUNCTIONS, Unbranching, rebind
from gnomon.cases.core.forms import FirstOrder, Form, RigidBody, SecondOrder, euler_equations
from gnomon.harness.kernels.equations import check_values

RUN, STEP, ROUND = 0, 1, 2
"""Levels: when a value is computed. RUN: it depends on parameters only; STEP: on t too; ROUND: on the state."""

EXPENSIVE = {"/", "**", *FUNCTIONS}
"""Operations that take several times as long as a product."""

Value = Any
"""A Node, or a plain number."""


class Node(Unbranching):
    """A value of the traced equations: an operation and its arguments."""

    def __init__(self, trace: Trace, operation: str, arguments: tuple[Value, ...], level: int) -> None:
        self.trace, self.operation, self.arguments, self.level = trace, operation, arguments, level

    def __add__(self, other: Value) -> Value:
        return self.trace.sum(self, other)

    def __radd__(self, other: Value) -> Value:
        return self.trace.sum(other, self)

    def __sub__(self, other: Value) -> Value:
        return self.trace.difference(self, other)

    def __rsub__(self, other: Value) -> Value:
        return self.trace.difference(other, self)

    def __mul__(self, other: Value) -> Value:
        return self.trace.product(self, other)

    def __rmul__(self, other: Value) -> Value:
        return self.trace.product(other, self)

    def __truediv__(self, other: Value) -> Value:
        return self.trace.quotient(self, other)

    def __rtruediv__(self, other: Value) -> Value:
        return self.trace.quotient(other, self)

    def __pow__(self, other: Value) -> Value:
        return self.trace.node("**", self, other)

    def __rpow__(self, other: Value) -> Value:
        return self.trace.node("**", other, self)

    def __neg__(self) -> Value:
        return self.trace.node("neg", self)

    def __pos__(self) -> Value:
        return self


class Trace:
    """Symbols for t, the state and the parameters, and every value computed from them, each stored once."""

    def __init__(self, dimension: int, parameters: int, frozen: tuple[int, ...] = ()) -> None:
        self.nodes: dict[tuple[Any, ...], Node] = {}
        self.t = self._leaf("t", STEP)
        places = iter(range(dimension))
        self.state = tuple(
            self._leaf(f"p[{parameters + frozen.index(i)}]", RUN)
            if i in frozen
            else self._leaf(f"y[{next(places)}]", ROUND)
            for i in range(dimension)
        )
        self.parameters = tuple(self._leaf(f"p[{i}]", RUN) for i in range(parameters))

    def _leaf(self, name: str, level: int) -> Node:
        return self.nodes.setdefault((name,), Node(self, name, (), level))

    def node(self, operation: str, *arguments: Value) -> Value:
        key = (operation, *(id(x) if isinstance(x, Node) else (type(x), x) for x in arguments))
        if key not in self.nodes:
            level = max(x.level for x in arguments if isinstance(x, Node))
            self.nodes[key] = Node(self, operation, arguments, level)
        return self.nodes[key]

    def sum(self, a: Value, b: Value) -> Value:
        if number(a, 0) or number(b, 0):
            return b if number(a, 0) else a
        return self.node("+", a, b)

    def difference(self, a: Value, b: Value) -> Value:
        if number(b, 0):
            return a
        if a is b:
            return 0
        return -b if number(a, 0) else self.node("-", a, b)

    def product(self, a: Value, b: Value) -> Value:
        if number(a, 0) or number(b, 0):
            return 0
        if number(a, 1) or number(b, 1):
            return b if number(a, 1) else a
        return self.node("*", a, b)

    def quotient(self, a: Value, b: Value) -> Value:
        if number(a, 0) or number(b, 1):
            return a
        if level(a) == ROUND and level(b) < ROUND and isinstance(b, Node):
            return self.node("over", a, b, 1 / b)
        return self.node("/", a, b)

    def function(self, name: str) -> Callable[..., Value]:
        """A function of `math` on numbers or on nodes."""
        plain = getattr(math, name)

        def either(*arguments: Value) -> Value:
            return self.node(name, *arguments) if any(isinstance(x, Node) for x in arguments) else plain(*arguments)

        return either

    def derivative(self, value: Value, by: Node, done: dict[int, Value]) -> Value:
        """d value / d by, a component of the state; `done` keeps derivatives by the same component."""
        if not isinstance(value, Node) or value.level < ROUND:
            return 0
        if value is by:
            return 1
        if not value.arguments:
            return 0
        if id(value) not in done:
            inner = [self.derivative(x, by, done) for x in value.arguments]
            done[id(value)] = chained(self, value, inner) if any(not number(x, 0) for x in inner) else 0
        return done[id(value)]


def level(value: Value) -> int:
    return value.level if isinstance(value, Node) else RUN


def number(value: Value, which: int) -> bool:
    return isinstance(value, int | float) and value == which


def chained(trace: Trace, value: Node, d: Sequence[Value]) -> Value:
    """The derivative of an operation from those of its arguments."""
    f = {name: trace.function(name) for name in FUNCTIONS}
    a, b = (*value.arguments, None)[:2]
    match value.operation:
        case "+":
            return d[0] + d[1]
        case "-":
            return d[0] - d[1]
        case "neg":
            return -d[0]
        case "*":
            return d[0] * b + a * d[1]
        case "/":
            return (d[0] - value * d[1]) * (1 / b)
        case "over":
            return d[0] * value.arguments[2]
        case "**" if not isinstance(b, Node):
            return b * a ** (b - 1) * d[0]
        case "**":
            return value * (d[1] * f["log"](a) + b * d[0] * (1 / a))
        case "atan2":
            return (d[0] * b - a * d[1]) * (1 / (a * a + b * b))
        case "hypot":
            return (a * d[0] + b * d[1]) * (1 / value)
    slope: dict[str, Callable[[], Value]] = {
        "sin": lambda: f["cos"](a),
        "cos": lambda: -f["sin"](a),
        "tan": lambda: 1 + value * value,
        "asin": lambda: 1 / f["sqrt"](1 - a * a),
        "acos": lambda: -1 / f["sqrt"](1 - a * a),
        "atan": lambda: 1 / (1 + a * a),
        "sinh": lambda: f["cosh"](a),
        "cosh": lambda: f["sinh"](a),
        "tanh": lambda: 1 - value * value,
        "asinh": lambda: 1 / f["sqrt"](a * a + 1),
        "acosh": lambda: 1 / f["sqrt"](a * a - 1),
        "atanh": lambda: 1 / (1 - a * a),
        "sqrt": lambda: 0.5 / value,
        "exp": lambda: value,
        "log": lambda: 1 / a,
    }
    return slope[value.operation]() * d[0]


def traced(
    form: Form, dimension: int, parameters: int, frozen: tuple[int, ...] = ()
) -> tuple[Trace, tuple[Value, ...]]:
    """The first-order right-hand side of a form, traced; for SecondOrder only the accelerations.

    Components of the state in `frozen` are constant, and read from the parameters, after those of the case.
    """
    trace = Trace(dimension, parameters, frozen)
    functions = {name: trace.function(name) for name in FUNCTIONS}
    t, y, p = trace.t, trace.state, trace.parameters
    if isinstance(form, SecondOrder):
        half = dimension // 2
        check_values({"acceleration": form.acceleration}, "acceleration(t, y, p)", half, parameters, half)
        return trace, tuple(rebind(form.acceleration, functions)(t, y[:half], p))
    if isinstance(form, RigidBody):
        check_values({"inertia": form.inertia}, "inertia(p)", 0, parameters, 3)
        check_values({"torque": form.torque}, "torque(t, y, p)", dimension, parameters, 3)
        inertia, torque = rebind(form.inertia, functions), rebind(form.torque, functions)
        return trace, tuple(euler_equations(y, inertia(p), torque(t, y, p)))
    assert isinstance(form, FirstOrder)
    check_values({"equations": form.equations}, "equations(t, y, p)", dimension, parameters, dimension)
    return trace, tuple(rebind(form.equations, functions)(t, y, p))


def reached(values: Sequence[Value]) -> list[Node]:
    """All nodes that values depend on, each after its arguments."""
    found: dict[int, Node] = {}

    def visit(value: Value) -> None:
        if isinstance(value, Node) and id(value) not in found:
            for argument in value.arguments:
                visit(argument)
            found[id(value)] = value

    for value in values:
        visit(value)
    return list(found.values())


def poles(values: Sequence[Value]) -> tuple[Node, ...]:
    """The divisors in values that may change their sign: where one passes 0 the values have a pole."""
    signs: dict[int, int | None] = {}
    found: dict[int, Node] = {}
    for node in reached(values):
        signs[id(node)] = sign(node, signs)
        match node.operation, node.arguments:
            case "/", (_, below):
                pass
            case "**", (below, int() | float() as exponent) if exponent < 0:
                pass
            case _:
                continue
        if level(below) == ROUND and signs[id(below)] is None:
            found[id(below)] = below
    return tuple(found.values())


def sign(value: Value, known: Mapping[int, int | None]) -> int | None:
    """1 if known to be >= 0, 0 if the sign is known to be constant, None if unknown."""
    if not isinstance(value, Node):
        return 1 if value >= 0 else 0
    if id(value) in known:
        return known[id(value)]
    parts = [sign(x, known) for x in value.arguments]
    match value.operation, value.arguments:
        case (("sqrt" | "exp" | "cosh" | "hypot"), _):
            return 1
        case "*", (a, b) if a is b:
            return 1
        case "**", (_, int() as exponent) if exponent % 2 == 0:
            return 1
        case "**", _ if parts[0] is not None:
            return parts[0]
        case (("*" | "/" | "over"), _) if None not in parts[:2]:
            return 1 if parts[:2] == [1, 1] else 0
        case "neg", _ if parts[0] is not None:
            return 0
        case "+", _ if parts == [1, 1]:
            return 1
    return 0 if value.level == RUN else None


def code(values: Sequence[Value], groups: Sequence[Sequence[int]] = (), below: Sequence[Value] = ()) -> tuple[str, ...]:
    """Source of functions for numba: `constants(p)`, `forcing(t, k)` and `slopes(y, w, k)`, which returns the values.

    `constants` returns the tuple k and `forcing` the tuple w of what later functions need; y holds vectors, k numbers. For
    the n-th group of values `slopes_n(y, w, k)` returns only these; `poles(y, w, k)` returns the values `below`. Where both
    the sine and the cosine of an angle are needed, `slopes_first(y, w, k)` also returns them, and `slopes_again(y, w, k,
    near)` computes those at a nearby y from them; it also returns the ones for the next call.
    """
    nodes = reached(values)
    local: dict[int, str] = {}
    lines: tuple[list[str], list[str], list[str]] = ([], [], [])
    made_by: list[set[int]] = []
    handed: tuple[list[str], list[str], list[str]] = ([], [], [])
    wanted = {(id(x), node.level) for node in nodes for x in node.arguments if isinstance(x, Node)}
    wanted |= {(id(x), ROUND) for x in values if isinstance(x, Node)}

    def name(value: Value, level: int) -> str:
        if not isinstance(value, Node):
            return f"({value!r})"
        if value.level == level:
            return local[id(value)]
        return f"{'kw'[value.level]}[{lent[id(value)]}]"

    lent: dict[int, int] = {}
    both = pairs(nodes)
    written: dict[int, str] = {}
    angles: list[tuple[str, str]] = []
    for i, node in enumerate(nodes):
        local[id(node)] = f"n{i}" if node.arguments else node.operation
        if node.arguments and id(node) in both:
            sine, cosine = both[id(node)]
            if id(sine) not in written:
                argument = name(node.arguments[0], node.level)
                lines[node.level].append(f"    n{i}s, n{i}c = sin_and_cos(lanes({argument}))\n")
                angles += [(f"lanes({argument})", f"n{i}s, n{i}c")] * (node.level == ROUND)
                made_by += [{id(sine), id(cosine)}] * (node.level == ROUND)
                written.update({id(sine): f"n{i}s", id(cosine): f"n{i}c"})
            local[id(node)] = written[id(node)]
        elif node.arguments:
            text = expression(node.operation, [name(x, node.level) for x in node.arguments])
            lines[node.level].append(f"    n{i} = {text}\n")
            made_by += [{id(node)}] * (node.level == ROUND)
        if node.level < ROUND and any((id(node), level) in wanted for level in range(node.level + 1, ROUND + 1)):
            lent[id(node)] = len(handed[node.level])
            handed[node.level].append(local[id(node)])
    functions = [
        ("constants(p)", lines[RUN], "".join(f"{x}, " for x in handed[RUN]) + "0.0,"),
        ("forcing(t, k)", lines[STEP], "".join(f"{x}, " for x in handed[STEP]) + "0.0,"),
    ]
    grouped = {f"slopes_{n}": [values[i] for i in group] for n, group in enumerate(groups)}
    for head, chosen in ({"slopes": values} | grouped | ({"poles": below} if below else {})).items():
        needed = {id(x) for x in reached(chosen)}
        body = [line for line, makes in zip(lines[ROUND], made_by, strict=True) if makes & needed]
        results = "".join(f"lanes({name(x, ROUND)}), " for x in chosen)
        functions.append((f"{head}(y, w, k)", body, results))
    functions += from_nearby_angles(*functions[2][1:], angles) if angles else []
    return tuple(
        f"@njit(forceinline=True, INNER)\ndef {head}:\n{''.join(body)}    return ({returned})\n"
        for head, body, returned in functions
    )


def from_nearby_angles(
    body: list[str], results: str, angles: list[tuple[str, str]]
) -> list[tuple[str, list[str], str]]:
    """`slopes_first` and `slopes_again` (see `code`): the body of `slopes` with other sines and cosines of `angles`."""
    first = again = "".join(body)
    for n, (angle, names) in enumerate(angles):
        plain = f"{names} = sin_and_cos({angle})"
        first = first.replace(plain, f"{names}, near{n} = turned_first({angle})")
        again = again.replace(plain, f"{names}, near{n} = turned({angle}, near[{n}])")
    nearest = "".join(f"near{n}, " for n in range(len(angles)))
    return [
        ("slopes_first(y, w, k)", [first], f"({results}), ({nearest})"),
        ("slopes_again(y, w, k, near)", [again], f"({results}), ({nearest})"),
    ]


def pairs(nodes: Sequence[Node]) -> dict[int, tuple[Node, Node]]:
    """For the id of each sine and cosine on vectors: (sine, cosine) of its angle, where both are needed."""
    found = {(x.operation, id(x.arguments[0])): x for x in nodes if x.operation in ("sin", "cos") and x.level > RUN}
    both = [(x, found["cos", key]) for (name, key), x in found.items() if name == "sin" and ("cos", key) in found]
    return {id(x): pair for pair in both for x in pair}


def expression(operation: str, arguments: Sequence[str]) -> str:
    if operation == "over":
        return f"over({', '.join(f'lanes({x})' for x in arguments)})"
    if operation in FUNCTIONS:
        return f"math.{operation}({', '.join(arguments)})"
    return f"-{arguments[0]}" if operation == "neg" else f" {operation} ".join(arguments)
