"""Recurrences for the Taylor coefficients of a solution, as source text, from the graph of the equations.

Coefficients are normalised: a_k is the k-th derivative over k!. With them products are convolutions, and every function
with derivative g follows from k f_k = sum of j u_j g_(k-j) over 0 < j <= k (Jorba and Zou, Experimental Mathematics 14,
2005, section 2). The inner terms, 0 < j < k, need only lower orders: all nodes share one loop for them, in which the sums
are independent; the terms j = 0 and j = k are added node by node.
"""

from __future__ import annotations

from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.kernels.graph import Graph, Number, Trace, arguments, expression, needed, slope, traced

STRIDE = 24
"""The number of coefficients stored for each node: orders 0 to 23."""

FEW = 4
"""Up to this number of sums in the loop, each is split in two."""

OWN = ("add", "sub", "neg", "mul", "div", "sqrt", "pow")
"""Operations with recurrences of their own; the others are functions with a derivative."""


class Recurrences:
    """The nodes of a trace with their recurrences: which are constants, which are series, and their products."""

    def __init__(self, form: FirstOrder, dimension: int, parameters: int) -> None:
        self.trace = traced(form, dimension, parameters)
        self.graph: Graph = self.trace.graph
        self.derivative = self._derivatives()
        values = (*self.trace.outputs, *(Number(self.graph, g) for g in self.derivative.values()))
        self.sequence = needed(Trace(self.graph, values))
        self.varying: set[int] = set()
        for i in self.sequence:
            if self.graph.nodes[i][0] in ("t", "y") or any(a in self.varying for a in arguments(self.graph.nodes[i])):
                self.varying.add(i)
        self.rows: dict[str, int] = {f"y{i}": i for i in range(dimension)}

    def _derivatives(self) -> dict[int, int]:
        """The node of f' for each function node; these nodes may add new functions."""
        found: dict[int, int] = {}
        waiting = needed(self.trace)
        while waiting:
            i = waiting.pop()
            operation, *where = self.graph.nodes[i]
            if operation not in (*OWN, "t", "y", "p", "number") and i not in found:
                g = slope(self.graph, operation, Number(self.graph, where[0]), Number(self.graph, i))
                found[i] = g.index
                waiting += needed(Trace(self.graph, (g,)))
        return found

    def row(self, i: int) -> int:
        """The index of the first coefficient of node i in the array w of all coefficients."""
        operation, *where = self.graph.nodes[i]
        name = f"y{where[0]}" if operation == "y" else f"n{i}"
        return STRIDE * self.rows.setdefault(name, len(self.rows))

    def slope_node(self, u: int) -> int | None:
        """The node whose coefficients are (j + 1) u_(j+1): for a variable that of its derivative; else None."""
        operation, *where = self.graph.nodes[u]
        output = self.trace.outputs[where[0]].index if operation == "y" else None
        return output if output in self.varying else None

    def slopes(self, u: int) -> int:
        """The index of the first of the numbers (j + 1) u_(j+1) in w."""
        node = self.slope_node(u)
        return self.row(node) if node is not None else STRIDE * self.rows.setdefault(f"d{u}", len(self.rows))

    def inside(self, i: int) -> str | None:
        """The term that node i sums over 0 < j < k; None where there is none."""
        operation, *where = self.graph.nodes[i]
        if i not in self.varying or operation in ("t", "y", "add", "sub", "neg"):
            return None
        if operation in ("mul", "div"):
            u, v = (i, where[1]) if operation == "div" else where
            both = u in self.varying and v in self.varying
            return f"w[{self.row(u)} + j] * w[{self.row(v)} + k - j]" if both else None
        if operation == "sqrt":
            return f"w[{self.row(i)} + j] * w[{self.row(i)} + k - j]"
        if operation == "pow":
            weight = f"({where[1]!r} * (k - j) - j)"
            return f"{weight} * w[{self.row(where[0])} + k - j] * w[{self.row(i)} + j]"
        g = self.derivative[i]
        return f"w[{self.slopes(where[0])} + j - 1] * w[{self.row(g)} + k - j]" if g in self.varying else None

    def coefficient(self, i: int) -> str:
        """The coefficient k > 0 of node i, with s{i} for its inner sum."""
        operation, *where = self.graph.nodes[i]
        if operation == "t":
            return "ONE if k == 1 else 0 * ONE"
        if operation == "y":
            return f"w[{STRIDE * where[0]} + k]"
        u, v = where[0], where[-1]
        first, second = u in self.varying, v in self.varying
        summed = f"s{i}" if self.inside(i) is not None else None
        if operation == "neg":
            return f"-a{u}"
        if operation in ("add", "sub"):
            sign = "+" if operation == "add" else "-"
            both = f"a{u} {sign} a{v}" if first else f"a{v}" if sign == "+" else f"-a{v}"
            return both if second else f"a{u}"
        if operation == "mul":
            ends = [f"n{u} * a{v}"] * second + [f"a{u} * n{v}"] * first
            return " + ".join([summed, *ends] if summed else ends)
        if operation == "div":
            if not second:
                return f"a{u} / n{v}"
            return f"({f'a{u} - ' if first else '-'}(s{i} + n{i} * a{v})) / n{v}"
        if operation == "sqrt":
            return f"(a{u} - s{i}) / (2 * n{i})"
        if operation == "pow":
            return f"(per * s{i} + {where[1]!r} * a{u} * n{i}) / n{u}"
        end = f"a{u} * n{self.derivative[i]}"
        return f"per * {summed} + {end}" if summed else end


def coefficients_text(form: FirstOrder, dimension: int, parameters: int) -> tuple[str, int]:
    """Source text of `kernel(t, y, p, w)` and the length of `w`.

    y: the state, then the highest order; w gets coefficient k of y_i at STRIDE i + k. The text uses a global ONE, the
    number 1 of the arithmetic that runs it. Raises ValueError for equations that cannot be traced.
    """
    r = Recurrences(form, dimension, parameters)
    sums = {i: term for i in r.sequence if (term := r.inside(i)) is not None}
    stored, doubled = _stored(r, sums)
    lines = [f"    n{i} = {expression(r.graph.nodes[i])}" for i in r.sequence]
    lines += [f"    w[{r.row(i)}] = n{i}" for i in stored]
    outputs = list(enumerate(r.trace.outputs))
    lines += [f"    w[{STRIDE * i}] = y[{i}]\n    w[{STRIDE * i + 1}] = n{x.index}" for i, x in outputs]
    lines += [f"    for k in range(1, int(y[{dimension}])):", "        per, ahead = ONE / k, ONE / (k + 1)"]
    lines += _loop(sums)
    for i in r.sequence:
        if i in r.varying:
            lines.append(f"        a{i} = {r.coefficient(i)}")
            lines += [f"        w[{r.row(i)} + k] = a{i}"] * (i in stored)
            lines += [f"        w[{r.slopes(i)} + k - 1] = k * a{i}"] * (i in doubled)
    for i, x in outputs:
        following = f"a{x.index} * ahead" if x.index in r.varying else "0 * ONE"
        lines.append(f"        w[{STRIDE * i} + k + 1] = {following}")
    text = "\n".join(["def kernel(t, y, p, w):", *lines, ""])
    return text, STRIDE * len(r.rows)


def _stored(r: Recurrences, sums: dict[int, str]) -> tuple[list[int], set[int]]:
    """The nodes whose coefficients are read again, and those whose (j + 1) u_(j+1) are read and not stored elsewhere."""
    found: set[int] = set()
    doubled: set[int] = set()
    for i in sums:
        operation, *where = r.graph.nodes[i]
        if operation in ("mul", "div", "pow"):
            found |= {a for a in arguments(r.graph.nodes[i]) if a in r.varying}
        if operation in ("div", "sqrt", "pow"):
            found.add(i)
        if i in r.derivative:
            node = r.slope_node(where[0])
            found.add(r.derivative[i])
            if node is None:
                doubled.add(where[0])
            else:
                found.add(node)
    return [i for i in r.sequence if i in found and r.graph.nodes[i][0] != "y"], doubled


def _loop(sums: dict[int, str]) -> list[str]:
    """The loop over 0 < j < k that adds each term to its sum.

    Few sums would wait for their additions: each is split in two, over odd and even j. More would not fit the registers.
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
