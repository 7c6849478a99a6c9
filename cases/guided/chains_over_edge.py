"""Chains that slide over an edge by their own weight: off a table, with or without friction, or over a small pulley.

Cases: chain_off_table, chain_over_pulley.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from math import sqrt
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Event, Invariant, Variant
from gnomon.cases.core.forms import Hybrid, Mode, Transition, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, Rule, positive
from gnomon.cases.core.rail_scene import railed
from gnomon.cases.core.scene import SceneForm
from gnomon.reference.guided.chains_over_edge import SlidingChain
from gnomon.reference.numerics.precision import Number, quantity
from mpmath import mpf


def sliding_off(t: Any, state: Values, parameters: Values) -> Values:
    """s'' = (g/L) ((1 + mu) s - mu L)."""
    s, v = state
    g, length, mu = parameters
    return v, (g / length) * ((1 + mu) * s - mu * length)


def over_pulley(t: Any, state: Values, parameters: Values) -> Values:
    """s'' = (2 g/L) s."""
    s, v = state
    g, length = parameters
    return v, (2 * g / length) * s


def free_fall(t: Any, state: Values, parameters: Values) -> Values:
    _, v = state
    return v, parameters[0]


def to_table_end(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - parameters[1],)


def to_pulley_end(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - parameters[1] / 2,)


def goes_on(t: Any, state: Values, parameters: Values) -> Values:
    """Nothing jumps."""
    s, v = state
    return s, v


def table_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Over the mass, from all of it on the table; what hangs, min(s, L), without a branch. Friction takes of it."""
    s, v = state
    g, length, _mu = parameters
    hangs = (s + length - sqrt((s - length) * (s - length))) / 2
    return (v * v / 2 - g * (hangs * hangs / (2 * length) + s - hangs),)


def pulley_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Over the mass, from balance."""
    s, v = state
    g, length = parameters
    over = (s + length / 2 - sqrt((s - length / 2) * (s - length / 2))) / 2
    return (v * v / 2 - g * (over * over / length + s - over),)


def on_the_table(t: Any, state: Values, parameters: Values) -> str:
    return "sliding" if state[0] < parameters[1] else "falling"


def on_the_pulley(t: Any, state: Values, parameters: Values) -> str:
    return "sliding" if state[0] < parameters[1] / 2 else "falling"


def table_force(t: float, s: float, parameters: tuple[float, ...]) -> float:
    """Over the mass, on the table and off it."""
    mode = sliding_off if s < parameters[1] else free_fall
    return float(mode(t, (s, 0.0), parameters)[1])


def pulley_force(t: float, s: float, parameters: tuple[float, ...]) -> float:
    mode = over_pulley if s < parameters[1] / 2 else free_fall
    return float(mode(t, (s, 0.0), parameters)[1])


class _ChainOverEdge(Case):
    """A chain that leaves its support in one event, `leaves`, and falls freely from there on."""

    state = (Coordinate("s", "m", "length"), Coordinate("v", "m/s", "velocity"))

    @cached_property
    def _exact(self) -> SlidingChain:
        raise NotImplementedError

    _SLIDING: ClassVar[Mode]
    _END: ClassVar[Any]
    _START: ClassVar[Any]
    _SCENE: ClassVar[SceneForm]

    def motion(self) -> SlidingChain:
        return self._exact

    @property
    def forms(self) -> tuple[Hybrid, ...]:
        kind = type(self)
        return (
            Hybrid(
                modes=(kind._SLIDING, Mode("falling", free_fall)),
                start=kind._START,
                transitions=(Transition("leaves", "sliding", kind._END, 1, goes_on, "falling"),),
                settle=1e-9 * self.time_scale,
                terminal=frozenset({"falling"}),
            ),
        )

    @property
    def scene(self) -> SceneForm:
        return self._SCENE

    @property
    def time_scale(self) -> float:
        """The time in which the chain's motion grows e times."""
        return 1 / sqrt(float(self._exact.square))

    def natural_span(self) -> Number:
        """Until well after the end has left; ten time scales in equilibrium."""
        if self._exact.rests:
            return 10 * self.time_scale
        return 1.15 * float(self._exact.end_time()) + 0.1 * self.time_scale

    def _listed(self, digits: int) -> tuple[Event, ...]:
        motion = self._exact
        if motion.rests or motion.s0 >= motion.end or motion.end_time(20) > self.span:
            return ()
        with_end = (motion._quantity(digits, lambda mp: mp.mpf(motion.end)), motion.end_speed(digits))
        return (Event(motion.end_time(digits), "leaves", with_end, with_end),)

    def same_course(self, other: Case) -> bool:
        """One double off the equilibrium the chain runs away."""
        return isinstance(other, _ChainOverEdge) and other._exact.rests == self._exact.rests

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        motion = self._exact
        if motion.rests:
            return {"leaving_time": mpf("inf")}
        return {"leaving_time": motion.end_time(digits), "leaving_speed": motion.end_speed(digits)}


def _reach(n: Mapping[str, Fraction]) -> bool:
    return n["s"] * (1 + n["mu"]) >= n["mu"] * n["L"] and n["v"] >= 0


class ChainOffTable(_ChainOverEdge):
    """A uniform chain that slides off a table, guided at the edge, until its end leaves it."""

    name = "chain_off_table"
    title = "Chain sliding off a smooth table edge"
    section = "8.12"
    conventions = (
        "s overhanging length; chain inextensible, guided at the edge; the friction mu acts on the part on the table. "
        "From s = L on the whole chain falls freely and s is the depth of its lower end."
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("L", "m", 1, "length of the chain"),
        Parameter("mu", "1", 0, "coefficient of friction on the table"),
    )
    default_state = ("0.3", 0)
    domain = Domain(
        {
            "g": positive(),
            "L": positive(1.0, 5.0),
            "mu": Range(low=0.0, typical=(0.0, 0.5)),
            "s": Range(low=0.0, typical=(0.0, 1.0)),
            "v": Range(low=0.0, typical=(0.0, 3.0)),
        },
        (
            Rule("s <= L (the chain is on the table)", lambda n: n["s"] <= n["L"]),
            Rule("s >= mu L/(1 + mu) and v >= 0 (else friction holds the chain)", _reach),
        ),
    )
    variants = (
        Variant("hair", "1e-12 m hang over: leaves after 28 e-foldings of that", initial_state=("1e-12", 0)),
        Variant("pushed", "starts with speed and nothing over the edge", initial_state=(0, "0.5")),
        Variant("friction", "mu = 0.3", {"mu": "0.3"}),
        Variant("friction_limit", "exactly the overhang that friction holds: must not creep", {"mu": 1}, ("0.5", 0)),
        Variant(
            "friction_limit_above",
            "one double more than friction holds: leaves after 37 e-foldings of that",
            {"mu": 1},
            (0.5000000000000001, 0),
        ),
    )
    invariants: ClassVar = {"energy": Invariant(table_energy, "decays")}
    _SLIDING = Mode("sliding", sliding_off)
    _END = staticmethod(to_table_end)
    _START = staticmethod(on_the_table)
    _SCENE = railed(table_force)

    @cached_property
    def _exact(self) -> SlidingChain:
        g, length, mu = self.parameter_values()
        return SlidingChain(g * (1 + mu) / length, mu * length / (1 + mu), length, g, *self.initial_state)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """Tension at the edge over the mass per length, (1 + mu) (L - s) g s/L (m^2/s^2), at the start and at its largest.

        It is largest where half of the chain hangs, or at the start where more does.
        """
        g, length, mu = self.parameter_values()
        s = self.initial_state[0]
        most = s if self._exact.rests else max(s, length / 2)
        first, largest = ((1 + mu) * (length - x) * g * x / length for x in (s, most))
        found = {"edge_tension": first, "largest_edge_tension": largest}

        def rounded(value: Fraction) -> Any:
            return quantity(digits, lambda mp: mp.mpf(value))

        return super().quantities(digits) | {name: rounded(value) for name, value in found.items()}


class ChainOverPulley(_ChainOverEdge):
    """A uniform chain that hangs over a small smooth pulley and runs off it."""

    name = "chain_over_pulley"
    title = "Chain running off a small smooth pulley"
    section = "8.12"
    conventions = (
        "s: by how much each end has moved from balance, L/2 on either side; the pulley is a point and keeps the chain "
        "to itself. From s = L/2 on the whole chain falls freely."
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("L", "m", 2, "length of the chain"),
    )
    default_state = ("0.1", 0)
    domain = Domain(
        {
            "g": positive(),
            "L": positive(2.0, 5.0),
            "s": Range(low=0.0, typical=(0.0, 1.0)),
            "v": Range(low=0.0, typical=(0.0, 3.0)),
        },
        (Rule("s <= L/2 (the chain lies over the pulley)", lambda n: 2 * n["s"] <= n["L"]),),
    )
    variants = (
        Variant("balanced", "exactly balanced: must not run", initial_state=(0, 0)),
        Variant("hair", "1e-12 m off balance: runs off after 28 e-foldings of that", initial_state=("1e-12", 0)),
    )
    invariants: ClassVar = {"energy": Invariant(pulley_energy)}
    _SLIDING = Mode("sliding", over_pulley)
    _END = staticmethod(to_pulley_end)
    _START = staticmethod(on_the_pulley)
    _SCENE = railed(pulley_force)

    @cached_property
    def _exact(self) -> SlidingChain:
        g, length = self.parameter_values()
        return SlidingChain(2 * g / length, Fraction(0), length / 2, g, *self.initial_state)
