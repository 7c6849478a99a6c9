"""Write traced equations and their Jacobian as one plain function, and compile it."""

from collections.abc import Iterable, Sequence

from gnomon.cases.core.arithmetic import FUNCTIONS
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.kernels.derivatives import jacobian
from gnomon.harness.kernels.equations import OPTIONS, Kernel, address
from gnomon.harness.kernels.traced import Node, ReducedTrace, Value, sequence, traced


def jacobian_text(form: FirstOrder, dimension: int, parameters: int) -> str:
    """Source text of `kernel(t, y, p, out)` for the exact Jacobian df/dy, row by row.

    Raises ValueError for equations that branch.
    """
    trace = ReducedTrace(dimension, parameters)
    return function_text(jacobian(traced(form, trace), trace.state))


def jacobian_kernel(form: FirstOrder, dimension: int, parameters: int) -> Kernel | None:
    """The compiled Jacobian df/dy; None for equations that cannot be traced (a branch, abs)."""
    try:
        return Kernel(module_text(jacobian_text(form, dimension, parameters)))
    except ValueError:
        return None


def counting_text(form: FirstOrder, dimension: int, parameters: int) -> str:
    """Source text of `kernel(t, y, p, out)` for f followed by df/dy; each call adds 1 to p[parameters]."""
    trace = ReducedTrace(dimension, parameters)
    values = traced(form, trace)
    return f"{function_text((*values, *jacobian(values, trace.state)))}    p[{parameters}] += 1.0\n"


def function_text(values: Sequence[Value]) -> str:
    """Source text of a function `kernel(t, y, p, out)` that computes `values` and each node only once."""
    lines = [*definitions(sequence(values)), *(f"    out[{i}] = {name(x)}" for i, x in enumerate(values))]
    return "\n".join(["def kernel(t, y, p, out):", *lines, ""])


def definitions(nodes: Iterable[Node]) -> list[str]:
    """A line for each node. The text runs in any arithmetic that its globals `math` and ONE give, such as mpmath's."""
    return [f"    {name(x)} = {_definition(x)}" for x in nodes]


def _definition(node: Node) -> str:
    names = [name(x) for x in node.arguments]
    if node.operation == "/" and not isinstance(node.arguments[0], Node):
        names[0] = f"ONE * {names[0]}"  # so that 1 / 3 is computed in the arithmetic of ONE
    return expression(node.operation, names)


def name(value: Value) -> str:
    return f"n{value.index}" if isinstance(value, Node) else f"({value!r})"


def expression(operation: str, arguments: Sequence[str]) -> str:
    """Source text of an operation on arguments; a variable is its own text."""
    if operation in FUNCTIONS:
        return f"math.{operation}({', '.join(arguments)})"
    if operation == "neg":
        return f"-{arguments[0]}"
    return f" {operation} ".join(arguments) or operation


def compiled(text: str) -> int:
    """Compile the text of a `kernel` to a C function (double t, double *y, double *p, double *out): its address."""
    return address(module_text(text), "kernel")


def module_text(text: str) -> str:
    """The source of a module in which numba compiles the text of a `kernel`."""
    return "\n".join(["import math", "from numba import njit", "ONE = 1.0", f"@njit({OPTIONS})", text])
