"""Exact derivatives of traced equations, by the rule of differentiation of each operation."""

from collections.abc import Callable, Sequence

from gnomon.harness.kernels.traced import ROUND, Node, Value, sequence


def jacobian(values: Sequence[Value], by: Sequence[Node]) -> tuple[Value, ...]:
    """The exact derivatives of m `values` by n components `by` of the state: m n expressions, row by row."""
    zeros = [0] * len(by)
    known: dict[Node, list[Value]] = {y: [int(y is other) for other in by] for y in by}

    def row(value: Value) -> list[Value]:
        return known.get(value, zeros) if isinstance(value, Node) else zeros

    for node in sequence(values):
        if node.level == ROUND and node.arguments:
            columns = zip(*(row(x) for x in node.arguments), strict=True)
            known[node] = [derivative(node, d) for d in columns]
    return tuple(d for value in values for d in row(value))


def derivative(node: Node, d: Sequence[Value]) -> Value:
    """The derivative of an operation, from the derivatives `d` of its arguments."""
    a, b = (*node.arguments, None)[:2]
    match node.operation:
        case "+":
            return d[0] + d[1]
        case "-":
            return d[0] - d[1]
        case "neg":
            return -d[0]
        case "*":
            return d[0] * b + a * d[1]
        case "/":
            return node.trace.shared_quotient(d[0] - node * d[1], b)
        case "**" if not isinstance(b, Node):
            return d[0] * b * a ** (b - 1)
        case "**":
            return node * (d[1] * node.trace.functions["log"](a) + b * d[0] * (1 / a))
        case "atan2":
            return (d[0] * b - a * d[1]) * (1 / (a * a + b * b))
        case "hypot":
            return (a * d[0] + b * d[1]) * (1 / node)
    return slope(node) * d[0]


def slope(node: Node) -> Value:
    """The derivative of a function of one argument with respect to that argument."""
    f, (u,) = node.trace.functions, node.arguments
    rules: dict[str, Callable[[], Value]] = {
        "sin": lambda: f["cos"](u),
        "cos": lambda: -f["sin"](u),
        "tan": lambda: 1 + node * node,
        "asin": lambda: 1 / f["sqrt"](1 - u * u),
        "acos": lambda: -1 / f["sqrt"](1 - u * u),
        "atan": lambda: 1 / (1 + u * u),
        "sinh": lambda: f["cosh"](u),
        "cosh": lambda: f["sinh"](u),
        "tanh": lambda: 1 - node * node,
        "asinh": lambda: 1 / f["sqrt"](u * u + 1),
        "acosh": lambda: 1 / f["sqrt"](u * u - 1),
        "atanh": lambda: 1 / (1 - u * u),
        "sqrt": lambda: 0.5 / node,
        "exp": lambda: node,
        "log": lambda: 1 / u,
    }
    return rules[node.operation]()
