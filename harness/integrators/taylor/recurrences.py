"""Recurrences for the Taylor coefficients of a solution, from the traced equations, in any arithmetic.

Coefficients are normalised: a_k is the k-th derivative over k!. With them products are convolutions, and every function
with derivative g follows from k f_k = sum of j u_j g_(k-j) over 0 < j <= k (Jorba and Zou, Experimental Mathematics 14,
2005, section 2). The inner terms, 0 < j < k, need only lower orders: all nodes share one loop for them, in which the
sums are independent; the terms j = 0 and j = k are added node by node.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.sources import cache_by_content
from gnomon.harness.kernels import emission, ir
from gnomon.harness.kernels.derivatives import slope
from gnomon.harness.kernels.equations import Kernel, content
from gnomon.harness.kernels.straight_line import evaluate
from gnomon.harness.kernels.traced import RUN, Node, ReducedTrace, Value, level, sequence, trace_form

STRIDE = 24
"""The number of coefficients stored for each node: orders 0 to 23."""

FEW = 4
"""Up to this number of sums in the loop, each is split in two."""

ARITHMETIC = ("+", "-", "neg", "*", "/", "**", "sqrt")
"""Operations with recurrences of their own; the other operations are functions of one argument with a derivative."""

Term = Callable[[Any, Any, Any], Any]
"""A function (w, k, j) -> the term j of a sum for the coefficient k."""


class Recurrences:
    """The nodes of traced equations, and the recurrences of their Taylor coefficients.

    The coefficients that are read again stand in an array w of `length` numbers: coefficient k of y_i at STRIDE i + k.
    Raises ValueError for equations that cannot be traced.
    """

    def __init__(self, form: FirstOrder, dimension: int, parameters: int) -> None:
        self.trace, self.dimension = ReducedTrace(dimension, parameters), dimension
        self.outputs = trace_form(form, self.trace)
        self.places = {y: i for i, y in enumerate(self.trace.state)}
        self.derivative: dict[Node, Node] = {}
        self._find_derivatives(self.outputs)
        self.sequence = sequence((*self.outputs, *self.derivative.values()))
        self.series = [x for x in self.sequence if is_varying(x)]
        self.rows = {y: STRIDE * i for y, i in self.places.items()}
        self.rows_of_slopes: dict[Node, int] = {}
        terms = {x: self.inside(x) for x in self.series}
        self.sums = {x: term for x, term in terms.items() if term is not None}

    @property
    def length(self) -> int:
        return STRIDE * (len(self.rows) + len(self.rows_of_slopes))

    def _find_derivatives(self, values: Iterable[Value]) -> None:
        """Find f' for each function f of a series in `values`; f' may have new functions."""
        for node in reversed(sequence(values)):
            if is_varying(node) and node.arguments and node.operation not in ARITHMETIC and node not in self.derivative:
                if len(node.arguments) > 1:
                    raise ValueError(f"{node.operation} has no recurrence for Taylor coefficients")
                self.derivative[node] = slope(node)
                self._find_derivatives([self.derivative[node]])

    def row(self, node: Node) -> int:
        """The index of the first coefficient of a node in w."""
        return self.rows.setdefault(node, self.length)

    def slopes(self, u: Node) -> int:
        """The index of the first of the numbers (j + 1) u_(j+1) in w: of the derivative, if u is a variable of y."""
        output: Value = self.outputs[self.places[u]] if u in self.places else None
        return self.row(output) if is_varying(output) else self.rows_of_slopes.setdefault(u, self.length)

    def inside(self, node: Node) -> Term | None:
        """The term that a series sums over 0 < j < k; None for a series without such a sum."""
        match node.operation, node.arguments:
            case "*", (u, v) if is_varying(u) and is_varying(v):
                return convolution(self.row(u), self.row(v))
            case "/", (_, v) if is_varying(v):
                return convolution(self.row(node), self.row(v))
            case "sqrt", _:
                return convolution(self.row(node), self.row(node))
            case "**", (u, exponent):
                base, own = self.row(u), self.row(node)
                return lambda w, k, j: (exponent * (k - j) - j) * w[base + k - j] * w[own + j]
            case _, (u,) if node in self.derivative:
                return convolution(self.slopes(u) - 1, self.row(self.derivative[node]))
        return None

    def start(self, functions: Mapping[str, Any], t: Any, y: Any, p: Any) -> dict[Node, Any]:
        """The coefficients 0 of all nodes."""
        return evaluate(self.sequence, self.trace, t, [y[i] for i in range(self.dimension)], p, functions)

    def value(self, x: Value, values: Mapping[Node, Any]) -> Any:
        return values[x] if isinstance(x, Node) else x

    def coefficient(
        self, node: Node, w: Any, k: Any, per: Any, start: Mapping[Node, Any], now: Mapping[Node, Any],
        sums: Mapping[Node, Any],
    ) -> Any:  # fmt: skip
        """The coefficient k > 0 of a series.

        `per`: 1/k. `start`: the coefficients 0 of all nodes. `now`: the coefficients k of series before this one.
        """
        if not node.arguments:
            return w[self.rows[node] + k] if node in self.places else now[node]
        n, inner = [self.value(x, start) for x in node.arguments], sums.get(node)
        a: list[Any] = [now[x] if is_varying(x) else None for x in node.arguments]
        first, last = a[0], a[-1]
        match node.operation:
            case "neg":
                return -first
            case "+" | "-" if last is None:
                return first
            case "+":
                return last if first is None else first + last
            case "-":
                return -last if first is None else first - last
            case "*" if first is None or last is None:
                return n[0] * last if first is None else first * n[1]
            case "*":
                return inner + n[0] * last + first * n[1]
            case "/" if last is None:
                return first / n[1]
            case "/":
                known = inner + start[node] * last
                return (-known if first is None else first - known) / n[1]
            case "sqrt":
                return (first - inner) / (2 * start[node])
            case "**":
                return (per * inner + n[1] * first * start[node]) / n[0]
        return per * inner + first * start[self.derivative[node]]


def is_varying(value: Value) -> bool:
    """Whether a value changes along a solution: a series, not a constant."""
    return level(value) > RUN


def convolution(a: int, b: int) -> Term:
    return lambda w, k, j: w[a + j] * w[b + k - j]


def coefficients(r: Recurrences, functions: Mapping[str, Any], t: Any, y: Any, p: Any, w: Any) -> None:
    """Write the Taylor coefficients at t into w.

    y: the state, then the highest order. `functions`: the functions for this type of numbers, by their names in `math`.
    """
    start, one = r.start(functions, t, y, p), functions["sqrt"](1)
    for node in r.rows:
        w[r.rows[node]] = start[node]
    for i, output in enumerate(r.outputs):
        w[STRIDE * i + 1] = r.value(output, start)
    for k in range(1, int(y[r.dimension])):
        per, ahead = one / k, one / (k + 1)
        sums = dict(zip(r.sums, inner_sums(r, w, k), strict=True))
        now = {r.trace.t: one if k == 1 else 0.0}
        for node in r.series:
            now[node] = r.coefficient(node, w, k, per, start, now, sums)
            if node in r.rows:
                w[r.rows[node] + k] = now[node]
            if node in r.rows_of_slopes:
                w[r.rows_of_slopes[node] + k - 1] = k * now[node]
        for i, output in enumerate(r.outputs):
            w[STRIDE * i + k + 1] = now[output] * ahead if is_varying(output) else 0.0


def inner_sums(r: Recurrences, w: Any, k: Any) -> tuple[Any, ...]:
    """The sums of all terms over 0 < j < k.

    A few sums would wait for their own additions, so each is split in two, over odd and even j. The parts of many sums
    would not fit into the registers.
    """
    terms = tuple(r.sums.values())
    sums = tuple(0.0 for _ in terms)
    even = sums
    if len(terms) > FEW:
        for j in range(1, k):
            sums = tuple(total + term(w, k, j) for total, term in zip(sums, terms, strict=True))
        return sums
    for i in range((k - 1) // 2):
        sums = tuple(total + term(w, k, 2 * i + 1) for total, term in zip(sums, terms, strict=True))
        even = tuple(total + term(w, k, 2 * i + 2) for total, term in zip(even, terms, strict=True))
    if k % 2 == 0:
        sums = tuple(total + term(w, k, k - 1) for total, term in zip(sums, terms, strict=True))
    return tuple(a + b for a, b in zip(sums, even, strict=True))


@cache_by_content
def recurrences_kernel(form: FirstOrder, dimension: int, parameters: int) -> Kernel:
    """The compiled `coefficients`. Raises ValueError for equations without recurrences."""
    r = Recurrences(form, dimension, parameters)

    def body(t: ir.Value, y: ir.Array, p: ir.Array, w: ir.Array) -> None:
        run = emission.Translation(inlined={"inner_sums"}).inline(coefficients)
        run(r, emission.MATH, t, y, content(p), w)

    return Kernel(f"Taylor\n{emission.fingerprint(form.equations)}", body, (dimension + 1, parameters, r.length))
