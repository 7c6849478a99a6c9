"""Compute traced equations and their Jacobian node by node, in any arithmetic, and compile them."""

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gnomon.cases.core.arithmetic import FUNCTIONS
from gnomon.cases.core.forms import Equations, FirstOrder
from gnomon.harness.contract.sources import cache_by_content
from gnomon.harness.kernels import emission, ir
from gnomon.harness.kernels.derivatives import jacobian
from gnomon.harness.kernels.equations import Kernel, content, function_kernel, write
from gnomon.harness.kernels.traced import ROUND, Node, ReducedTrace, Trace, Value, sequence, trace_form

OPERATORS: dict[str, Callable[..., Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "**": operator.pow,
    "neg": operator.neg,
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class WithJacobian(FirstOrder):
    """Equations of first order whose derivatives in the state are stated, row by row, for libraries that take a Jacobian."""

    jacobian: Equations


def evaluate(
    nodes: Iterable[Node], trace: Trace, t: Any, y: Sequence[Any], p: Sequence[Any], functions: Mapping[str, Any]
) -> dict[Any, Any]:
    """The values of nodes, which come after their arguments, at a time t, a state y and parameters p.

    The numbers may be of any type with arithmetic; `functions` gives its functions by their names in `math`.
    """
    numbers, unit = dict[Any, Any]({trace.t: t}), functions["sqrt"](1)
    numbers |= zip(trace.parameters, p, strict=False)
    numbers |= zip(trace.state, y, strict=False)
    for node in nodes:
        if node.arguments:
            operation = OPERATORS.get(node.operation) or functions[node.operation]
            operands = [numbers[x] if isinstance(x, Node) else x for x in node.arguments]
            if node.operation == "/" and not isinstance(node.arguments[0], Node):
                operands[0] *= unit  # so that 1 / 3 is computed in the arithmetic
            numbers[node] = operation(*operands)
    return numbers


def compute(
    values: Sequence[Value], trace: Trace, t: Any, y: Sequence[Any], p: Sequence[Any], functions: Mapping[str, Any]
) -> list[Any]:
    """The numbers that traced `values` are (see `evaluate`); each node is computed only once."""
    numbers = evaluate(sequence(values), trace, t, y, p, functions)
    return [numbers[x] if isinstance(x, Node) else x for x in values]


def derivatives(form: FirstOrder, trace: Trace, slopes: bool = False, by_time: bool = False) -> tuple[Value, ...]:
    """The exact Jacobian df/dy, row by row; with `slopes`, f before it; with `by_time`, df/dt as a last column.

    Raises ValueError for equations that branch.
    """
    if by_time:
        trace.t.level = ROUND
    values = trace_form(form, trace)
    return (*(values if slopes else ()), *jacobian(values, (*trace.state, trace.t) if by_time else trace.state))


@cache_by_content
def derivatives_kernel(
    form: FirstOrder, dimension: int, parameters: int, slopes: bool = False, by_time: bool = False
) -> Kernel:
    """The compiled `derivatives`. Raises ValueError for equations that cannot be traced (a branch, abs)."""

    def body(t: ir.Value, y: ir.Array, p: ir.Array, out: ir.Array) -> None:
        trace = ReducedTrace(dimension, parameters)
        values = derivatives(form, trace, slopes, by_time)
        write(out, compute(values, trace, t, content(y), content(p), emission.MATH))

    key = f"derivatives {slopes} {by_time}\n{emission.fingerprint(form.equations)}"
    kernel = Kernel(key, body, (dimension, parameters, dimension * (dimension + slopes + by_time)))
    _ = kernel.code  # the equations are traced only if no code is kept
    return kernel


def derivatives_if_traced(
    form: FirstOrder, dimension: int, parameters: int, slopes: bool = False, by_time: bool = False
) -> Kernel | None:
    """`derivatives_kernel`, or the Jacobian that the form itself states; None for equations that cannot be traced."""
    if isinstance(form, WithJacobian) and not (slopes or by_time):
        return function_kernel(form.jacobian, dimension, parameters, dimension**2)
    try:
        return derivatives_kernel(form, dimension, parameters, slopes, by_time)
    except ir.Subset:
        raise
    except ValueError:
        return None


def expression(operation: str, arguments: Sequence[str]) -> str:
    """Source text of an operation on arguments; a variable is its own text."""
    if operation in FUNCTIONS:
        return f"math.{operation}({', '.join(arguments)})"
    if operation == "neg":
        return f"-{arguments[0]}"
    return f" {operation} ".join(arguments) or operation
