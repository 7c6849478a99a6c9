"""Traced equations computed on numbers and lanes in three stages: values for a run, for a step and for a round.

Sine and cosine of one angle are computed together. To divide lanes by a number, its inverse, which an earlier stage
computes, is multiplied and the quotient corrected (`over`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from gnomon.cases.core.arithmetic import FUNCTIONS
from gnomon.harness.integrators.gauss.lanes import Lanes, each, lanes, over, power, root
from gnomon.harness.integrators.gauss.lanes_math import (
    Near,
    cos_lanes,
    exp_lanes,
    sin_lanes,
    turn_lanes,
    turn_lanes_first,
)
from gnomon.harness.kernels.straight_line import OPERATORS
from gnomon.harness.kernels.traced import ROUND, RUN, STEP, Node, Value, level, list_reached

EXPENSIVE = {"/", "**", *FUNCTIONS}
"""Operations that take several times longer than a product."""

ON_LANES: dict[str, Callable[..., Lanes]] = {"sin": sin_lanes, "cos": cos_lanes, "exp": exp_lanes, "sqrt": root}
"""The functions on lanes that are not computed lane by lane."""

Turn = Callable[[Lanes, int], tuple[Lanes, Lanes, Near]]

PLAIN = {name: getattr(math, name) for name in FUNCTIONS}


class Staged:
    """The values of equations and of their derivatives, in three stages, and the divisors `poles`.

    `bind` translates a function of lanes for symbolic values, and returns it unchanged for arrays of NumPy. `functions` has
    the functions of numbers, by their names in `math`, for the same values.
    """

    def __init__(
        self,
        values: Sequence[Value],
        poles: Sequence[Value] = (),
        bind: Callable[[Any], Any] = lambda function: function,
        functions: Mapping[str, Callable[..., Any]] = PLAIN,
    ) -> None:
        self.values, self.divisors, self.functions = tuple(values), tuple(poles), functions
        every = dict.fromkeys(x for node in list_reached(values) for x in (*inverses(node), node))
        self.stages = [[x for x in every if x.level == stage and x.arguments] for stage in (RUN, STEP, ROUND)]
        self.variables = [x for x in every if not x.arguments]
        last: dict[Value, int] = {}
        users = [(x.level, y) for x in every for y in (*x.arguments, *inverses(x))] + [(ROUND, x) for x in values]
        for at, x in users:
            last[x] = max(at, last.get(x, RUN))
        self.lent = [[x for x in every if x.level == stage < last[x]] for stage in (RUN, STEP)]
        self.pairs = pairs(list(every))
        self.lanes, self.over, self.power, self.each = map(bind, (lanes, over, power, each))
        self.turned, self.turned_first = bind(turn_lanes), bind(turn_lanes_first)
        self.on_lanes = {name: bind(function) for name, function in ON_LANES.items()}

    def constants(self, p: Sequence[float]) -> tuple[Any, ...]:
        """The numbers of a run, from the parameters."""
        known = {x: p[int(x.operation[2:-1])] for x in self.variables if x.level == RUN}
        self._add(self.stages[RUN], known)
        return tuple(known[x] for x in self.lent[RUN])

    def forcing(self, t: Lanes, k: tuple[Any, ...]) -> tuple[Any, ...]:
        """The values of a step, from its times and `constants`."""
        known = dict(zip(self.lent[RUN], k, strict=True)) | {x: t for x in self.variables if x.level == STEP}
        self._add(self.stages[STEP], known)
        return tuple(known[x] for x in self.lent[STEP])

    def slopes(self, y: Sequence[Lanes], w: tuple[Any, ...], k: tuple[Any, ...], group: Sequence[int] = ()) -> Any:
        """The values at a state y, or only those with the indices `group`; w from `forcing`, k from `constants`."""
        chosen = [self.values[i] for i in group] or self.values
        return self._results(chosen, y, w, k)[0]

    def poles(self, y: Sequence[Lanes], w: tuple[Any, ...], k: tuple[Any, ...]) -> Any:
        """The divisors at a state."""
        return self._results(self.divisors, y, w, k)[0]

    def slopes_first(self, y: Sequence[Lanes], w: tuple[Any, ...], k: tuple[Any, ...]) -> Any:
        """The values, and the sines and cosines for `slopes_again`."""
        return self._results(self.values, y, w, k)

    def slopes_again(self, y: Sequence[Lanes], w: tuple[Any, ...], k: tuple[Any, ...], near: tuple[Near, ...]) -> Any:
        """`slopes_first` from the sines and cosines at a nearby state, which takes less time."""
        return self._results(self.values, y, w, k, lambda angle, n: self.turned(angle, near[n]))

    def _results(self, values: Sequence[Value], y: Any, w: Any, k: Any, turn: Turn | None = None) -> tuple[Any, Any]:
        known = dict(zip(self.lent[RUN], k, strict=True)) | dict(zip(self.lent[STEP], w, strict=True))
        known |= {x: y[int(x.operation[2:-1])] for x in self.variables if x.level == ROUND}
        wanted = {x for node in list_reached(values) for x in (*inverses(node), node)}
        near = self._add([x for x in self.stages[ROUND] if x in wanted], known, turn)
        return tuple(self.lanes(known[x] if isinstance(x, Node) else x) for x in values), near

    def _add(self, nodes: Sequence[Node], known: dict[Any, Any], turn: Turn | None = None) -> tuple[Near, ...]:
        """Add the values of nodes, each after its arguments. `turn` gives sine and cosine of the n-th angle."""
        kept: list[Near] = []
        turn = turn or (lambda angle, _: self.turned_first(angle))
        for x in nodes:
            given = [known[a] if isinstance(a, Node) else a for a in (*x.arguments, *inverses(x))]
            if x in known:
                continue
            if x in self.pairs:
                sine, cosine = self.pairs[x]
                known[sine], known[cosine], near = turn(self.lanes(given[0]), len(kept))
                kept.append(near)
            elif divides_by_number(x):
                known[x] = self.over(*map(self.lanes, given))
            else:
                known[x] = self._value(x, given)
        return tuple(kept)

    def _value(self, x: Node, given: list[Any]) -> Any:
        if x.operation == "**" and x.level > RUN:
            return self.power(self.lanes(given[0]), given[1])
        if x.operation in OPERATORS:
            return OPERATORS[x.operation](*given)
        if x.level == RUN:
            return self.functions[x.operation](*given)
        function = self.on_lanes.get(x.operation)
        return self.each(x.operation, *given) if function is None else function(self.lanes(given[0]))


def inverses(node: Node) -> tuple[Value, ...]:
    """The inverse of the divisor of a vector, if the divisor is a number of an earlier stage; else ()."""
    return (1 / node.arguments[1],) if divides_by_number(node) else ()


def divides_by_number(node: Node) -> bool:
    """Whether an operation divides a vector by a number that an earlier stage computes."""
    if node.operation != "/" or node.level < ROUND:
        return False
    divisor = node.arguments[1]
    return isinstance(divisor, Node) and divisor.level < ROUND


def is_expensive(node: Node) -> bool:
    return node.operation in EXPENSIVE and not divides_by_number(node)


def pairs(nodes: Sequence[Node]) -> dict[Node, tuple[Node, Node]]:
    """Pairs (sine, cosine) of each angle whose sine and cosine are both used, by each of the two nodes.

    Angles that depend on parameters alone are left out.
    """
    known = {(x.operation, x.arguments[0]): x for x in nodes if x.operation in ("sin", "cos") and x.level > RUN}
    both = [(x, known["cos", angle]) for (name, angle), x in known.items() if name == "sin" and ("cos", angle) in known]
    return {x: pair for pair in both for x in pair}


def poles(values: Sequence[Value]) -> tuple[Node, ...]:
    """The divisors, in these values, that may change their sign: at the zero of a divisor the values have a pole."""
    signs: dict[Node, int | None] = {}
    divisors: dict[Node, None] = {}
    for node in list_reached(values):
        signs[node] = sign(node, signs)
        match node.operation, node.arguments:
            case "/", (_, below):
                pass
            case "**", (below, int() | float() as exponent) if exponent < 0:
                pass
            case _:
                continue
        if level(below) == ROUND and signs[below] is None:
            divisors[below] = None
    return tuple(divisors)


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
