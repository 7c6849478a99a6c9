"""Recurrences for the Taylor coefficients of a solution, as source text, from the graph of the equations.

Coefficients are normalised: a_k is the k-th derivative over k!. With them products are convolutions, and every function
with derivative g follows from k f_k = sum of (j + 1) u_(j+1) g_(k-1-j) over j < k (Jorba and Zou, Experimental
Mathematics 14, 2005, section 2). Convolutions that do not wait for one another share a loop: each alone would wait for
its own sums.
"""

from __future__ import annotations

from gnomon.cases.forms import FirstOrder
from gnomon.harness.trace import Graph, Number, Trace, arguments, expression, needed, slope, traced

STRIDE = 24
"""Room for the coefficients of one node: orders 0 to 23."""

FEW = 4
"""Up to so many sums in a loop, each is split in two."""

OWN = ("add", "sub", "neg", "mul", "div", "sqrt", "pow")
"""Operations with recurrences of their own; the others are functions with a derivative."""


class Recurrences:
    """The nodes of a trace, told apart: constants, series, what is convolved with what and when."""

    def __init__(self, form: FirstOrder, dimension: int, parameters: int) -> None:
        self.trace = traced(form, dimension, parameters)
        self.dimension = dimension
        self.graph: Graph = self.trace.graph
        for i in range(dimension):
            self.graph.node("y", i)
        self.derivative = self._derivatives()
        everything = (*self.trace.outputs, *(Number(self.graph, g) for g in self.derivative.values()))
        self.order = needed(Trace(self.graph, everything))
        self.varying: set[int] = set()
        for i in self.order:
            if self.graph.nodes[i][0] in ("t", "y") or any(a in self.varying for a in arguments(self.graph.nodes[i])):
                self.varying.add(i)
        self.level = self._levels()
        self.rows: dict[str, int] = {f"y{i}": i for i in range(dimension)}

    def _derivatives(self) -> dict[int, int]:
        """The node of f' for each function node; those nodes may bring new functions."""
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

    def convolved(self, i: int) -> bool:
        """Whether a node's coefficient is a sum over those of lower order."""
        operation, *where = self.graph.nodes[i]
        if i not in self.varying or operation in ("t", "y", "add", "sub", "neg"):
            return False
        if operation == "mul":
            return where[0] in self.varying and where[1] in self.varying
        return operation != "div" or where[1] in self.varying

    def _levels(self) -> dict[int, int]:
        """After how many loops the coefficient of order k of each node is known."""
        found: dict[int, int] = {}
        for i in self.order:
            if i in self.varying:
                before = max((found[a] for a in arguments(self.graph.nodes[i]) if a in self.varying), default=0)
                found[i] = before + self.convolved(i)
        return found

    def row(self, i: int) -> str:
        """Where the coefficients of node i start in the array of all."""
        operation, *where = self.graph.nodes[i]
        name = f"y{where[0]}" if operation == "y" else f"n{i}"
        return str(STRIDE * self.rows.setdefault(name, len(self.rows)))

    def slope_node(self, u: int) -> int | None:
        """The node whose coefficients are (j + 1) u_(j+1): of a variable its derivative; else None."""
        operation, *where = self.graph.nodes[u]
        output = self.trace.outputs[where[0]].index if operation == "y" else None
        return output if output in self.varying else None

    def slopes(self, u: int) -> str:
        """Where (j + 1) u_(j+1) stand."""
        node = self.slope_node(u)
        return self.row(node) if node is not None else str(STRIDE * self.rows.setdefault(f"d{u}", len(self.rows)))


def coefficients_text(form: FirstOrder, dimension: int, parameters: int) -> tuple[str, int]:
    """Source text of `kernel(t, y, p, w)` and the length that `w` must have.

    y: the state and after it the highest order; w gets y_i's coefficient of order k at STRIDE i + k. The text uses a
    global ONE, the number one of the arithmetic that it is run in. Raises ValueError for equations it cannot trace.
    """
    r = Recurrences(form, dimension, parameters)
    stored = _stored(r)
    lines = [f"    n{i} = {expression(r.graph.nodes[i])}" for i in r.order]
    lines += [f"    w[{r.row(i)}] = n{i}" for i in r.order if i in stored]
    lines += [f"    w[{STRIDE * i}] = y[{i}]\n    w[{STRIDE * i + 1}] = n{x.index}" for i, x in _outputs(r)]
    lines += [f"    for k in range(1, int(y[{dimension}])):", "        per, ahead = ONE / k, ONE / (k + 1)"]
    for level in range(max(r.level.values(), default=0) + 1):
        chosen = [i for i in r.order if r.level.get(i) == level]
        lines += _loop(r, [i for i in chosen if r.convolved(i)])
        for i in chosen:
            if not r.convolved(i):
                lines.append(f"        a{i} = {_linear(r, i)}")
            if i in stored:
                lines.append(f"        w[{r.row(i)} + k] = a{i}")
    for i, x in _outputs(r):
        following = f"a{x.index} * ahead" if x.index in r.varying else "0 * ONE"
        lines.append(f"        w[{STRIDE * i} + k + 1] = {following}")
    text = "\n".join(["def kernel(t, y, p, w):", *lines, ""])
    return text, STRIDE * len(r.rows)


def _outputs(r: Recurrences) -> list[tuple[int, Number]]:
    return list(enumerate(r.trace.outputs))


def _stored(r: Recurrences) -> set[int]:
    """The nodes whose coefficients of all orders are read again."""
    found: set[int | None] = set()
    for i in r.order:
        operation, *where = r.graph.nodes[i]
        if r.convolved(i):
            if operation in ("mul", "div", "pow"):
                found |= {a for a in arguments(r.graph.nodes[i]) if a in r.varying}
            if operation in ("div", "sqrt", "pow"):
                found.add(i)
            if i in r.derivative:
                found.add(r.derivative[i])
                found.add(r.slope_node(where[0]))
    return {i for i in found if i is not None and i in r.varying and r.graph.nodes[i][0] != "y"}


def _linear(r: Recurrences, i: int) -> str:
    """The coefficient of order k > 0 of a node that is no sum over lower orders."""
    operation, *where = r.graph.nodes[i]
    if operation == "t":
        return "ONE if k == 1 else 0 * ONE"
    if operation == "y":
        return f"w[{STRIDE * where[0]} + k]"
    a = [f"a{j}" if j in r.varying else None for j in where]
    if operation == "neg":
        return f"-{a[0]}"
    if operation in ("add", "sub"):
        sign = "+" if operation == "add" else "-"
        if a[1] is None:
            return f"{a[0]}"
        return f"{a[0]} {sign} {a[1]}" if a[0] is not None else f"{'' if sign == '+' else '-'}{a[1]}"
    symbol = "*" if operation == "mul" else "/"
    return f"{a[0] or f'n{where[0]}'} {symbol} {a[1] or f'n{where[1]}'}"


def _loop(r: Recurrences, convolved: list[int]) -> list[str]:
    """One loop for the sums of several nodes, and their coefficients of order k."""
    if not convolved:
        return []
    before: list[str] = []
    inside: list[tuple[str, str]] = []
    after: list[str] = []
    for i in convolved:
        operation, *where = r.graph.nodes[i]
        start = "0 * ONE"
        if operation == "mul":
            u, v = where
            start = f"a{u} * n{v}"
            term, total = f"w[{r.row(u)} + j] * w[{r.row(v)} + k - j]", f"s{i}"
        elif operation == "div":
            u, v = where
            term = f"w[{r.row(i)} + j] * w[{r.row(v)} + k - j]"
            total = f"({f'a{u} - s{i}' if u in r.varying else f'-s{i}'}) / n{v}"
        elif operation == "sqrt":
            before.append(f"w[{r.row(i)} + k] = 0 * ONE")
            term = f"w[{r.row(i)} + j + 1] * w[{r.row(i)} + k - 1 - j]"
            total = f"(a{where[0]} - s{i}) / (2 * n{i})"
        elif operation == "pow":
            u, exponent = where[0], repr(where[1])
            term = f"({exponent} * (k - j) - j) * w[{r.row(u)} + k - j] * w[{r.row(i)} + j]"
            total = f"per * s{i} / n{u}"
        else:
            u, g = where[0], r.derivative[i]
            if r.slope_node(u) is None:
                before.append(f"w[{r.slopes(u)} + k - 1] = k * a{u}")
            if g in r.varying:
                term, total = f"w[{r.slopes(u)} + j] * w[{r.row(g)} + k - 1 - j]", f"per * s{i}"
            else:
                term, total = "", f"n{g} * a{u}"
        before.append(f"s{i} = {start}")
        if term:
            inside.append((f"s{i}", term))
        after.append(f"a{i} = {total}")
    lines = [f"        {line}" for line in dict.fromkeys(before)]
    return lines + _sums(inside) + [f"        {line}" for line in after]


def _sums(terms: list[tuple[str, str]]) -> list[str]:
    """The loop over j < k that adds each term to its sum.

    A short list would wait for its additions: two sums each, of even and of odd j. More would not fit the registers.
    """
    if not terms:
        return []
    if len(terms) > FEW:
        return ["        for j in range(k):", *(f"            {name} += {term}" for name, term in terms)]
    both = [line for x in ("", "o") for line in ([f"j += {len(x)}"] * len(x) + [f"{n}{x} += {t}" for n, t in terms])]
    return [
        *(f"        {name}o = 0 * ONE" for name, _ in terms),
        "        for i in range(k // 2):",
        "            j = 2 * i",
        *(f"            {line}" for line in both),
        "        if k % 2 == 1:",
        "            j = k - 1",
        *(f"            {name} += {term}" for name, term in terms),
        *(f"        {name} += {name}o" for name, _ in terms),
    ]
