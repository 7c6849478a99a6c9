"""Recurrences for the Taylor coefficients of a solution, as source text, from the traced equations.

Coefficients are normalised: a_k is the k-th derivative over k!. With them products are convolutions, and every function
with derivative g follows from k f_k = sum of j u_j g_(k-j) over 0 < j <= k (Jorba and Zou, Experimental Mathematics 14,
2005, section 2). The inner terms, 0 < j < k, need only lower orders: all nodes share one loop for them, in which the
sums are independent; the terms j = 0 and j = k are added node by node.
"""

from collections.abc import Iterable

from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.kernels.derivatives import slope
from gnomon.harness.kernels.straight_line import definitions, name
from gnomon.harness.kernels.traced import RUN, Node, ReducedTrace, Value, level, sequence, traced

STRIDE = 24
"""The number of coefficients stored for each node: orders 0 to 23."""

FEW = 4
"""Up to this number of sums in the loop, each is split in two."""

ARITHMETIC = ("+", "-", "neg", "*", "/", "**", "sqrt")
"""Operations with recurrences of their own; the other operations are functions of one argument with a derivative."""


class Recurrences:
    """The nodes of traced equations, and the recurrences of their Taylor coefficients."""

    def __init__(self, form: FirstOrder, dimension: int, parameters: int) -> None:
        trace = ReducedTrace(dimension, parameters)
        self.outputs = traced(form, trace)
        self.places = {y: i for i, y in enumerate(trace.state)}
        self.derivative: dict[Node, Node] = {}
        self._find_derivatives(self.outputs)
        self.sequence = sequence((*self.outputs, *self.derivative.values()))
        self.rows, self.rows_of_slopes = dict(self.places), dict[Node, int]()

    def _find_derivatives(self, values: Iterable[Value]) -> None:
        """Find f' for each function f of a series in `values`; f' may have new functions."""
        for node in reversed(sequence(values)):
            if varying(node) and node.arguments and node.operation not in ARITHMETIC and node not in self.derivative:
                if len(node.arguments) > 1:
                    raise ValueError(f"{node.operation} has no recurrence for Taylor coefficients")
                self.derivative[node] = slope(node)
                self._find_derivatives([self.derivative[node]])

    def row(self, node: Node) -> int:
        """The index of the first coefficient of a node in the array w of all coefficients that are read again."""
        return self._row(self.rows, node)

    def _row(self, rows: dict[Node, int], node: Node) -> int:
        return STRIDE * rows.setdefault(node, len(self.rows) + len(self.rows_of_slopes))

    def slope_node(self, u: Node) -> Node | None:
        """The node whose coefficients are (j + 1) u_(j+1): the derivative of a variable if that varies; else None."""
        output = self.outputs[self.places[u]] if u in self.places else None
        return output if varying(output) else None

    def slopes(self, u: Node) -> int:
        """The index of the first of the numbers (j + 1) u_(j+1) in w."""
        node = self.slope_node(u)
        return self.row(node) if node is not None else self._row(self.rows_of_slopes, u)

    def inside(self, node: Node) -> str | None:
        """The term that a series sums over 0 < j < k; None for a series without such a sum."""
        if not varying(node):
            return None
        match node.operation, node.arguments:
            case "*", (u, v) if varying(u) and varying(v):
                return f"w[{self.row(u)} + j] * w[{self.row(v)} + k - j]"
            case "/", (_, v) if varying(v):
                return f"w[{self.row(node)} + j] * w[{self.row(v)} + k - j]"
            case "sqrt", _:
                return f"w[{self.row(node)} + j] * w[{self.row(node)} + k - j]"
            case "**", (u, exponent):
                weight = f"({exponent!r} * (k - j) - j)"
                return f"{weight} * w[{self.row(u)} + k - j] * w[{self.row(node)} + j]"
            case _, (u,) if node in self.derivative:
                return f"w[{self.slopes(u)} + j - 1] * w[{self.row(self.derivative[node])} + k - j]"
        return None

    def coefficient(self, node: Node) -> str:
        """The coefficient k > 0 of a series, with s{index} for its inner sum."""
        if not node.arguments:
            return f"w[{self.row(node)} + k]" if node in self.places else "ONE if k == 1 else 0 * ONE"
        n, a = [name(x) for x in node.arguments], [f"a{x.index}" if varying(x) else "" for x in node.arguments]
        own, inner = name(node), f"s{node.index}"
        match node.operation:
            case "neg":
                return f"-{a[0]}"
            case "+" | "-" if all(a):
                return f" {node.operation} ".join(a)
            case "+" | "-":
                return a[0] or (a[1] if node.operation == "+" else f"-{a[1]}")
            case "*":
                ends = [f"{n[0]} * {a[1]}"] * bool(a[1]) + [f"{a[0]} * {n[1]}"] * bool(a[0])
                return " + ".join([inner, *ends] if all(a) else ends)
            case "/" if not a[1]:
                return f"{a[0]} / {n[1]}"
            case "/":
                return f"({f'{a[0]} - ' if a[0] else '-'}({inner} + {own} * {a[1]})) / {n[1]}"
            case "sqrt":
                return f"({a[0]} - {inner}) / (2 * {own})"
            case "**":
                return f"(per * {inner} + {n[1]} * {a[0]} * {own}) / {n[0]}"
        return f"per * {inner} + {a[0]} * {name(self.derivative[node])}"


def varying(value: Value) -> bool:
    """Whether a value changes along a solution: a series, not a constant."""
    return level(value) > RUN


def coefficients_text(form: FirstOrder, dimension: int, parameters: int) -> tuple[str, int]:
    """Source text of `kernel(t, y, p, w)` and the length of `w`.

    y: the state, then the highest order; w gets coefficient k of y_i at STRIDE i + k. The text uses globals ONE and
    math, the number 1 and the functions of the arithmetic that runs it. Raises ValueError for equations that cannot be
    traced.
    """
    r = Recurrences(form, dimension, parameters)
    sums = {x.index: term for x in r.sequence if (term := r.inside(x)) is not None}
    stored = r.rows.keys() - r.places.keys()
    lines = definitions(r.sequence)
    lines += [f"    w[{r.row(x)}] = {name(x)}" for x in r.sequence if x in stored]
    outputs = list(enumerate(r.outputs))
    lines += [f"    w[{STRIDE * i}] = y[{i}]\n    w[{STRIDE * i + 1}] = {name(x)}" for i, x in outputs]
    lines += [f"    for k in range(1, int(y[{dimension}])):", "        per, ahead = ONE / k, ONE / (k + 1)"]
    lines += _loop(sums)
    for x in filter(varying, r.sequence):
        lines.append(f"        a{x.index} = {r.coefficient(x)}")
        lines += [f"        w[{r.row(x)} + k] = a{x.index}"] * (x in stored)
        lines += [f"        w[{r.slopes(x)} + k - 1] = k * a{x.index}"] * (x in r.rows_of_slopes)
    for i, x in outputs:
        following = f"a{x.index} * ahead" if varying(x) else "0 * ONE"
        lines.append(f"        w[{STRIDE * i} + k + 1] = {following}")
    text = "\n".join(["def kernel(t, y, p, w):", *lines, ""])
    return text, STRIDE * (len(r.rows) + len(r.rows_of_slopes))


def _loop(sums: dict[int, str]) -> list[str]:
    """The loop over 0 < j < k that adds each term to its sum.

    A few sums would wait for their own additions, so each is split in two, over odd and even j. The parts of many sums
    would not fit into the registers.
    """
    lines = [f"        s{i} = 0 * ONE" for i in sums]
    added = [f"s{i} += {term}" for i, term in sums.items()]
    if not sums:
        return []
    if len(sums) > FEW:
        return [*lines, "        for j in range(1, k):", *(f"            {line}" for line in added)]
    return [
        *lines,
        *(f"        e{i} = 0 * ONE" for i in sums),
        "        for i in range((k - 1) // 2):",
        "            j = 2 * i + 1",
        *(f"            {line}" for line in added),
        "            j += 1",
        *(f"            e{i} += {term}" for i, term in sums.items()),
        "        if k % 2 == 0:",
        "            j = k - 1",
        *(f"            {line}" for line in added),
        *(f"        s{i} += e{i}" for i in sums),
    ]
