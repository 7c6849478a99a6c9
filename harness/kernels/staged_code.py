"""Generate source code of traced equations for vectors in three stages: values for a run, for a step and for a round.

Sine and cosine of one angle are computed together. To divide a vector by a number, the code multiplies by the inverse
of the number, which an earlier stage computes, and corrects the quotient (`over`).
"""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass

from gnomon.cases.core.arithmetic import FUNCTIONS
from gnomon.harness.kernels.straight_line import expression
from gnomon.harness.kernels.traced import ROUND, RUN, STEP, Node, Value, level, reached

EXPENSIVE = {"/", "**", *FUNCTIONS}
"""Operations that take several times longer than a product."""


def code(values: Sequence[Value], groups: Sequence[Sequence[int]] = (), below: Sequence[Value] = ()) -> tuple[str, ...]:
    """Source of functions for numba: `constants(p)`, `forcing(t, k)` and `slopes(y, w, k)`, which returns the values.

    `constants` returns a tuple k of numbers and `forcing` a tuple w for the later functions; y holds vectors.
    `slopes_n(y, w, k)` returns only the n-th group of the values; `poles(y, w, k)` returns the values `below`. For
    equations with both the sine and the cosine of an angle there are two more functions: `slopes_first(y, w, k)` also
    returns these sines and cosines, and `slopes_again(y, w, k, near)` computes the sines and cosines at a nearby y from
    `near`, the values of the previous call, and returns them for the next call.
    """
    stages = Stages(values)
    functions = [
        ("constants(p)", stages.text(RUN), stages.handed(RUN)),
        ("forcing(t, k)", stages.text(STEP), stages.handed(STEP)),
        ("slopes(y, w, k)", stages.text(ROUND), stages.results(values)),
    ]
    parts = [(f"slopes_{n}", [values[i] for i in group]) for n, group in enumerate(groups)]
    for head, chosen in [*parts, *([("poles", below)] if below else [])]:
        functions.append((f"{head}(y, w, k)", stages.text(ROUND, set(reached(chosen))), stages.results(chosen)))
    angles = sum(line.angle is not None for line in stages.lines[ROUND])
    if angles:
        returned = f"({stages.results(values)}), ({''.join(f'near{n}, ' for n in range(angles))})"
        functions += [
            ("slopes_first(y, w, k)", stages.by_turns("turned_first({angle})"), returned),
            ("slopes_again(y, w, k, near)", stages.by_turns("turned({angle}, near[{n}])"), returned),
        ]
    return tuple(
        f"@njit(forceinline=True, INNER)\ndef {head}:\n{body}    return ({returned})\n"
        for head, body, returned in functions
    )


@dataclass(frozen=True)
class Line:
    """A statement: the names that it assigns, the text of their values, and the nodes that it computes.

    `angle`: the angle, if the statement computes a sine and a cosine.
    """

    names: str
    text: str
    makes: frozenset[Node]
    angle: str | None = None


class Stages:
    """The statements of each level in the sequence of evaluation, and the nodes that each level hands to later ones."""

    def __init__(self, values: Sequence[Value]) -> None:
        nodes: dict[Node, None] = {}
        for node in reached(values):
            nodes |= dict.fromkeys([*inverses(node), node])
        self.lines: tuple[list[Line], ...] = ([], [], [])
        self.lent: tuple[dict[Node, int], ...] = ({}, {}, {})
        self.local: dict[Node, str] = {}
        users = [(node.level, x) for node in nodes for x in (*node.arguments, *inverses(node))]
        users += [(ROUND, x) for x in values]
        last_use: dict[Node, int] = {}
        for at, x in users:
            if isinstance(x, Node):
                last_use[x] = max(at, last_use.get(x, RUN))
        both = pairs(list(nodes))
        for i, node in enumerate(nodes):
            if node in both:
                self._turn(i, both[node])
            else:
                self.local[node] = f"n{i}" if node.arguments else node.operation
                if node.arguments:
                    self.lines[node.level].append(Line(f"n{i}", self._expression(node), frozenset({node})))
            if last_use[node] > node.level:
                self.lent[node.level][node] = len(self.lent[node.level])

    def _turn(self, i: int, pair: tuple[Node, Node]) -> None:
        """Add the statement for the sine and cosine of an angle, unless it is there already."""
        if pair[0] not in self.local:
            argument, at = pair[0].arguments[0], pair[0].level
            angle = f"lanes({self.name(argument, at)})"
            self.local |= {pair[0]: f"n{i}s", pair[1]: f"n{i}c"}
            self.lines[at].append(Line(f"n{i}s, n{i}c", f"sin_and_cos({angle})", frozenset(pair), angle))

    def _expression(self, node: Node) -> str:
        arguments = [self.name(x, node.level) for x in (*node.arguments, *inverses(node))]
        if by_number(node):
            return f"over({', '.join(f'lanes({x})' for x in arguments)})"
        return expression(node.operation, arguments)

    def name(self, value: Value, at: int) -> str:
        """The text of a value inside a statement of level `at`."""
        if not isinstance(value, Node):
            return f"({value!r})"
        return self.local[value] if value.level == at else f"{'kw'[value.level]}[{self.lent[value.level][value]}]"

    def text(self, at: int, wanted: AbstractSet[Node] | None = None) -> str:
        """The statements of a level; with `wanted` only the statements that compute one of these nodes."""
        lines = [x for x in self.lines[at] if wanted is None or x.makes & wanted]
        return "".join(f"    {x.names} = {x.text}\n" for x in lines)

    def by_turns(self, call: str) -> str:
        """The statements of a round in which `call` computes each sine and cosine, and `near` for the next round."""
        body = self.text(ROUND)
        for n, x in enumerate(x for x in self.lines[ROUND] if x.angle is not None):
            body = body.replace(f"{x.names} = {x.text}", f"{x.names}, near{n} = {call.format(angle=x.angle, n=n)}")
        return body

    def handed(self, at: int) -> str:
        """The values that the function of a level returns; a number is added, so that the tuple is never empty."""
        return "".join(f"{self.local[x]}, " for x in self.lent[at]) + "0.0,"

    def results(self, values: Sequence[Value]) -> str:
        return "".join(f"lanes({self.name(x, ROUND)}), " for x in values)


def inverses(node: Node) -> tuple[Value, ...]:
    """The inverse of the divisor of a vector, if the divisor is a number of an earlier stage; else ()."""
    return (1 / node.arguments[1],) if by_number(node) else ()


def by_number(node: Node) -> bool:
    """Whether an operation divides a vector by a number that an earlier stage computes."""
    if node.operation != "/" or node.level < ROUND:
        return False
    divisor = node.arguments[1]
    return isinstance(divisor, Node) and divisor.level < ROUND


def expensive(node: Node) -> bool:
    return node.operation in EXPENSIVE and not by_number(node)


def pairs(nodes: Sequence[Node]) -> dict[Node, tuple[Node, Node]]:
    """Pairs (sine, cosine) of each angle whose sine and cosine are both used, by each of the two nodes.

    Angles that depend on parameters alone are left out.
    """
    found = {(x.operation, x.arguments[0]): x for x in nodes if x.operation in ("sin", "cos") and x.level > RUN}
    both = [(x, found["cos", angle]) for (name, angle), x in found.items() if name == "sin" and ("cos", angle) in found]
    return {x: pair for pair in both for x in pair}


def poles(values: Sequence[Value]) -> tuple[Node, ...]:
    """The divisors, in these values, that may change their sign: at the zero of a divisor the values have a pole."""
    signs: dict[Node, int | None] = {}
    found: dict[Node, None] = {}
    for node in reached(values):
        signs[node] = sign(node, signs)
        match node.operation, node.arguments:
            case "/", (_, below):
                pass
            case "**", (below, int() | float() as exponent) if exponent < 0:
                pass
            case _:
                continue
        if level(below) == ROUND and signs[below] is None:
            found[below] = None
    return tuple(found)


def sign(value: Value, known: Mapping[Node, int | None]) -> int | None:
    """1 if the value is known to be >= 0, 0 if its sign is known to be constant, None if its sign is not known."""
    if not isinstance(value, Node):
        return 1 if value >= 0 else 0
    if value in known:
        return known[value]
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
        case (("*" | "/"), _) if None not in parts:
            return 1 if parts == [1, 1] else 0
        case "neg", _ if parts[0] is not None:
            return 0
        case "+", _ if parts == [1, 1]:
            return 1
    return 0 if value.level == RUN else None
