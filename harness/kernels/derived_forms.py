"""The forms that tracing derives from equations y' = f(t, y, p): accelerations, a linear part, one mode without events."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from gnomon.cases.core.forms import FirstOrder, Form, Hybrid, Mode, NBody, SecondOrder, SemiLinear, Values
from gnomon.harness.kernels.derivatives import jacobian
from gnomon.harness.kernels.read_function import formulas, write_function
from gnomon.harness.kernels.traced import RUN, Node, Trace, is_number, level, list_reached, trace_form

MODE = "motion"
"""The only mode of a motion without events."""
MOST_SYMBOLS = 4000
"""Operations of a Jacobian above which no linear part is looked for."""


@dataclass(frozen=True)
class DerivedForms:
    """The forms of a system, the most structured first, for a state in the sequence `order` of the user's coordinates."""

    forms: tuple[Form, ...]
    order: tuple[int, ...]
    autonomous: bool
    lacking: str
    """The reason why no accelerations depend only on positions; "" if some do."""
    factors: Callable[[Values], Values] | None = None
    """parameters -> the velocity over the user's coordinate of each component, by the user's sequence, where the user's are
    momenta; None if all are 1."""


def derive_forms(form: FirstOrder, dimension: int, parameters: int) -> DerivedForms:
    """The forms of equations that can be traced.

    Each pair of a coordinate and its rate among the state makes a position and its velocity. If all components are in such
    pairs, the state is put in the sequence (q..., q'...).
    """
    trace = Trace(dimension, parameters)
    values = trace_form(form, trace)
    factors = _momenta(values, trace)
    if factors is not None:
        form = _of_velocities(form, factors, dimension, parameters)
        trace = Trace(dimension, parameters)
        values = trace_form(form, trace)
    pairs, lacking = _positions(values, trace)
    order = (*pairs, *pairs.values()) if pairs else tuple(range(dimension))
    places = [order.index(i) for i in range(dimension)]
    if order != tuple(range(dimension)):
        form = FirstOrder(write_function([values[i] for i in order], "equations", places))
    forms: list[Form] = [form]
    lacking = lacking or _velocities_in(values, pairs, trace)
    if not lacking:
        forms = [SecondOrder(write_function([values[i] for i in pairs.values()], "acceleration", places)), form]
    linear = _linear_part(values, trace, order, places, form)
    forms += [linear] if linear is not None else []
    forms.append(Hybrid((Mode(MODE, form.equations),), _only_mode, ()))
    autonomous = all(node is not trace.t for node in list_reached(values))
    of_parameters = None if factors is None else _at_rest(factors[0], dimension)
    return DerivedForms(tuple(forms), order, autonomous, lacking, of_parameters)


def _momenta(values: Sequence[Any], trace: Trace) -> tuple[Callable[..., Any], dict[int, int]] | None:
    """The function of the factors of all components, and the momentum of each position; None without momenta.

    A momentum is a coordinate whose multiple, by a number or by parameters, is the rate of another one.
    """
    places, factors, pairs = {node: i for i, node in enumerate(trace.state)}, dict[int, Any](), dict[int, int]()
    for i, value in enumerate(values):
        for j, factor in _multiple(value, places):
            if i != j and i not in factors and j not in factors and j not in pairs:
                factors[j], pairs[i] = factor, j
    if not factors or len(pairs) * 2 != len(values) or all(is_number(x, 1) for x in factors.values()):
        return None
    return write_function([factors.get(j, 1) for j in range(len(values))], "factors"), pairs


def _multiple(value: Any, places: dict[Node, int]) -> list[tuple[int, Any]]:
    """The coordinate and the factor, if a value is a coordinate or a constant multiple of one."""
    if not isinstance(value, Node):
        return []
    if value in places:
        return [(places[value], 1)]
    a, b = (*value.arguments, None)[:2] if value.arguments else (None, None)
    if value.operation == "neg" and a in places:
        return [(places[a], -1)]
    if value.operation == "/" and isinstance(a, Node) and a in places and level(b) == RUN:
        return [(places[a], 1 / b)]
    for x, y in ((a, b), (b, a)):
        if value.operation == "*" and isinstance(x, Node) and x in places and level(y) == RUN:
            return [(places[x], y)]
    return []


def _of_velocities(
    form: FirstOrder, momenta: tuple[Callable[..., Any], dict[int, int]], dimension: int, parameters: int
) -> FirstOrder:
    """The equations of positions and velocities, from equations of positions and momenta."""
    equations, (factors, pairs) = form.equations, momenta

    def of_velocities(t: Any, state: Values, p: Values) -> Values:
        c = factors(t, state, p)
        own = tuple(state[i] / c[i] if i in pairs.values() else state[i] for i in range(dimension))
        rates = equations(t, own, p)
        return tuple(state[pairs[i]] if i in pairs else c[i] * rates[i] for i in range(dimension))

    return FirstOrder(formulas(of_velocities, lambda own: own, "equations", (dimension, parameters, dimension)))


def _at_rest(function: Callable[..., Any], dimension: int) -> Callable[[Values], Values]:
    """A function of the parameters with the values of `function`, which does not depend on time and state."""

    def of_parameters(p: Values) -> Values:
        values: Values = function(0.0, (0.0,) * dimension, p)
        return values

    return of_parameters


def of_bodies(form: NBody, dimension: int, parameters: int) -> FirstOrder:
    """The equations of motion of gravitating bodies, whose state is linear in places and velocities."""
    masses, bodies, state_of = form.masses, form.bodies, form.state

    def equations(t: Any, state: Values, p: Values) -> Values:
        pulls, each = masses(p), bodies(state)
        rates = []
        for i, (x, y, z, u, v, w) in enumerate(each):
            a = b = c = 0.0
            for j, (xj, yj, zj, *_) in enumerate(each):
                if i != j:
                    r2 = (xj - x) ** 2 + (yj - y) ** 2 + (zj - z) ** 2
                    pull = pulls[j] / (r2 * r2**0.5)
                    a, b, c = a + pull * (xj - x), b + pull * (yj - y), c + pull * (zj - z)
            rates.append((u, v, w, a, b, c))
        return state_of(tuple(rates))

    return FirstOrder(formulas(equations, lambda own: own, "equations", (dimension, parameters, dimension)))


def _positions(values: Sequence[Any], trace: Trace) -> tuple[dict[int, int], str]:
    """The velocity of each position by their places, or why the state does not consist of such pairs."""
    places = {node: i for i, node in enumerate(trace.state)}
    rates = {i: places[value] for i, value in enumerate(values) if isinstance(value, Node) and value in places}
    pairs: dict[int, int] = {}
    velocities = set[int]()
    for i, j in rates.items():  # of a chain q' = v, v' = w the first pair counts
        if i not in velocities and j not in pairs and j not in velocities and i != j:
            pairs[i] = j
            velocities.add(j)
    alone = [i for i in range(len(values)) if i not in pairs and i not in velocities]
    if alone:
        return {}, f"y[{alone[0]}] is not a position whose rate is another coordinate, nor such a rate"
    return pairs, ""


def _velocities_in(values: Sequence[Any], pairs: dict[int, int], trace: Trace) -> str:
    rates = {trace.state[j]: j for j in pairs.values()}
    for j in pairs.values():
        used = [rates[node] for node in list_reached([values[j]]) if node in rates]
        if used:
            return f"the acceleration y[{j}]' depends on the velocity y[{used[0]}]"
    return ""


def _only_mode(t: Any, state: Values, parameters: Values) -> str:
    return MODE


def _linear_part(
    values: Sequence[Any], trace: Trace, order: Sequence[int], places: Sequence[int], form: FirstOrder
) -> SemiLinear | None:
    """The equations with the constant part of their Jacobian as the linear part; None if no derivative is constant."""
    dimension = len(order)
    if len(trace.nodes) * dimension > MOST_SYMBOLS:
        return None
    derivatives = jacobian(values, trace.state)
    rows = [derivatives[i * dimension : (i + 1) * dimension] for i in range(dimension)]
    constant = [[x if level(x) == RUN else 0 for x in row] for row in rows]
    if all(is_number(x, 0) for row in constant for x in row):
        return None
    rest = []
    for i in order:
        linear = sum((x * y for x, y in zip(constant[i], trace.state, strict=True) if not is_number(x, 0)), 0)
        rest.append(values[i] - linear)
    matrix = _at_rest(write_function([constant[i][j] for i in order for j in order], "linear"), dimension)
    return SemiLinear(form.equations, linear=matrix, rest=write_function(rest, "rest", places))
