"""The properties of a case's equations that the fast Gauss method uses: kind, derivatives, poles, groups."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gnomon.cases.core.forms import Form, SecondOrder
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.contract.sources import cache_by_content
from gnomon.harness.integrators.gauss.constants import TUNING
from gnomon.harness.integrators.gauss.staged_equations import PLAIN, Staged, is_expensive, poles
from gnomon.harness.kernels.derivatives import jacobian
from gnomon.harness.kernels.traced import ROUND, Node, Trace, Value, is_number, list_reached, trace_form

FIRST_ORDER, SECOND_ORDER, WITH_VELOCITY = range(3)
"""Kinds of equations: y' = f(t, y); q'' = a(t, q); q'' = a(t, q, q')."""


@dataclass(frozen=True)
class Layout:
    """The equations for which the method is compiled.

    `kind`: FIRST_ORDER, SECOND_ORDER or WITH_VELOCITY. `values`: the unknown slopes. `derivatives`: (slope, component
    of the state, value) of each derivative that is not 0; empty if derivatives save no time. `parameters`: the number
    of parameters. `dimension`: the number of components of the state, frozen ones included. `frozen`: components of the
    state that never change; the equations take them after the parameters. `groups`: the slopes that a round computes
    together, one group after the other; empty if it computes all slopes together.
    """

    kind: int
    values: tuple[Value, ...]
    derivatives: tuple[tuple[int, int, Value], ...]
    parameters: int
    dimension: int
    frozen: tuple[int, ...] = ()
    groups: tuple[tuple[int, ...], ...] = ()

    @property
    def count(self) -> int:
        """The number of unknown slopes."""
        return len(self.values)

    @property
    def all_values(self) -> tuple[Value, ...]:
        return (*self.values, *(value for _, _, value in self.derivatives))

    @property
    def poles(self) -> tuple[Value, ...]:
        """The divisors of the slopes that may change their sign."""
        return poles(self.values)

    @property
    def second_order(self) -> bool:
        return self.kind != FIRST_ORDER

    def text(self) -> str:
        """A text that changes whenever the equations do."""
        values = list_reached(self.all_values)
        lines = [f"{x.index} {x.operation} {[describe(a) for a in x.arguments]}" for x in values]
        places = [(i, j, describe(x)) for i, j, x in self.derivatives]
        facts = (
            self.kind,
            [describe(x) for x in self.values],
            places,
            self.parameters,
            self.dimension,
            self.frozen,
            self.groups,
        )
        return "\n".join([*lines, repr(facts)])


def describe(value: Value) -> Any:
    return f"node {value.index}" if isinstance(value, Node) else value


class Equations(Staged):
    """The equations of a layout, as the method uses them."""

    def __init__(
        self,
        layout: Layout,
        bind: Callable[[Any], Any] = lambda function: function,
        functions: Mapping[str, Callable[..., Any]] = PLAIN,
    ) -> None:
        super().__init__(layout.all_values, layout.poles, bind, functions)
        self.components = tuple(range(layout.count))
        """The indices of the slopes: a loop over a tuple is written out in compiled code, whatever its length."""
        self.count, self.groups, self.frozen, self.parameters = (
            layout.count,
            layout.groups,
            layout.frozen,
            layout.parameters,
        )
        self.second_order, self.with_velocity = layout.second_order, layout.kind == WITH_VELOCITY
        self.moving = tuple(i for i in range(layout.dimension) if i not in layout.frozen)
        self.derivatives = tuple((n, i, j) for n, (i, j, _) in enumerate(layout.derivatives, layout.count))
        """(index of the value, slope, component of the state) of each derivative."""
        self.by_position = tuple(n for n, _, j in self.derivatives if self.second_order and j < self.count)
        """The indices of the derivatives of accelerations by positions."""
        self.turns = any(x.level == ROUND for pair in self.pairs.values() for x in pair)
        """Whether a round computes the sine and cosine of an angle."""
        read = {x.operation for x in list_reached(layout.values)}
        self.read = frozenset(i for i in range(self.count) if f"y[{i}]" in read)
        """The components of the state that the slopes read."""

    def at_start(self, p_: Any, initial: Any) -> tuple[Any, Any]:
        """The moving components of an initial state, and `constants`."""
        known = (*(p_[i] for i in range(self.parameters)), *(initial[i] for i in self.frozen))
        return tuple(initial[i] for i in self.moving), self.constants(known)


@cache_by_content
def layout(form: Form, parameters: int, dimension: int, freezing: bool = True) -> Layout:
    """The layout that solves the equations of a form in the least time. Raises Refused if the equations branch."""
    trace = Trace(dimension, parameters)
    try:
        values = trace_form(form, trace)
    except ValueError as error:
        raise Refused(str(error)) from None
    still: tuple[int, ...] = ()
    kind, half, state = FIRST_ORDER, dimension // 2, trace.state
    if isinstance(form, SecondOrder):
        kind, state = SECOND_ORDER, state[:half]
    elif dimension % 2 == 0 and all(x is y for x, y in zip(values[:half], state[half:], strict=True)):
        kind, values = WITH_VELOCITY, values[half:]
    elif freezing and 0 < len(constant := [i for i, x in enumerate(values) if is_number(x, 0)]) < dimension:
        still = tuple(constant)
        trace = Trace(dimension, parameters, still)
        both = (trace_form(form, trace), trace.state)
        values, state = (tuple(x for i, x in enumerate(of) if i not in still) for of in both)
    partials = derivatives(values, state)
    grouped = kind == FIRST_ORDER and not partials and len(values) >= TUNING.fewest_grouped
    return Layout(kind, values, partials, parameters, dimension, still, groups(values, state) if grouped else ())


def groups(values: Sequence[Value], state: Sequence[Node]) -> tuple[tuple[int, ...], ...]:
    """Groups of slopes that do not depend on one another, from the last component to the first.

    An example: v' = a(q), then q' = v with the new v. If more than `most_groups` groups would be needed, a slope joins
    the group with the fewest slopes to which it is coupled.
    """
    place = {x: i for i, x in enumerate(state)}
    needs = [{place[x] for x in list_reached([value]) if x in place} for value in values]
    chosen: list[list[int]] = []
    for i in reversed(range(len(values))):
        met = [sum(i in needs[j] or j in needs[i] for j in group) for group in chosen]
        if min(met, default=1) > 0 and len(chosen) < TUNING.most_groups:
            chosen.append([i])
        else:
            chosen[met.index(min(met))].append(i)
    return tuple(tuple(sorted(group)) for group in chosen) if len(chosen) > 1 else ()


def derivatives(values: Sequence[Value], state: Sequence[Node]) -> tuple[tuple[int, int, Value], ...]:
    """The derivatives that are not 0; () if their computation takes more time than they save."""
    if len(values) > TUNING.most_derivatives or not any(
        is_expensive(x) for x in list_reached(values) if x.level == ROUND
    ):
        return ()
    places = [(i, j) for i in range(len(values)) for j in range(len(state))]
    partials = zip(places, jacobian(values, state), strict=True)
    return tuple((i, j, value) for (i, j), value in partials if not is_number(value, 0))
