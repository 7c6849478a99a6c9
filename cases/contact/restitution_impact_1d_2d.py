"""Two blocks and a wall: an exact count of elastic impacts."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Event, Invariant, Variant
from gnomon.cases.core.forms import Hybrid, Mode, Transition, Values
from gnomon.cases.core.impact_scene import ball_line
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, Rule, positive
from gnomon.reference.contact.restitution_impact_1d_2d import TwoBlocks
from gnomon.reference.numerics.precision import Number
from mpmath import mpf


def uniform_motion(t: Any, state: Values, parameters: Values) -> Values:
    _, _, v1, v2 = state
    return v1, v2, 0, 0


def gap(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] - state[0],)


def distance_to_wall(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0],)


def blocks_collide(t: Any, state: Values, parameters: Values) -> Values:
    """v -> 2 v_C - v for both blocks."""
    x1, x2, v1, v2 = state
    m1, m2 = parameters
    mean = (m1 * v1 + m2 * v2) / (m1 + m2)
    return x1, x2, 2 * mean - v1, 2 * mean - v2


def wall_returns(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, v1, v2 = state
    return x1, x2, -v1, v2


def onto_each_other(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, v1, v2 = state
    return (x1 + x2) / 2, (x1 + x2) / 2, v1, v2


def onto_wall(t: Any, state: Values, parameters: Values) -> Values:
    _, x2, v1, v2 = state
    return 0, x2, v1, v2


def blocks_kinetic(t: Any, state: Values, parameters: Values) -> Values:
    _, _, v1, v2 = state
    m1, m2 = parameters
    return ((m1 * v1 * v1 + m2 * v2 * v2) / 2,)


def blocks_mode(t: Any, state: Values, parameters: Values) -> str:
    return "free"


def _one_after_the_other(n: Mapping[str, Fraction]) -> bool:
    return n["x2"] * n["v1"] != n["x1"] * n["v2"] or n["v2"] >= 0


SCENE = ball_line(lambda parameters: parameters, lambda parameters: 1.0, wall=True)


class RestitutionImpact(Case):
    """A block moves towards a second one, which rests in front of a wall; all impacts are elastic."""

    name = "restitution_impact_1d_2d"
    title = "Two blocks and a wall: exact count of elastic impacts"
    section = "8.13"
    conventions = (
        "The wall is at x = 0, 0 < x1 < x2; the blocks are points; the coefficient of restitution is always 1."
    )
    state = (
        Coordinate("x1", "m", "length"),
        Coordinate("x2", "m", "length"),
        Coordinate("v1", "m/s", "velocity", "velocity of block 1"),
        Coordinate("v2", "m/s", "velocity", "velocity of block 2"),
    )
    parameter_list = (
        Parameter("m1", "kg", 1, "mass of the block next to the wall"),
        Parameter("m2", "kg", 100, "mass of the other block"),
    )
    default_state = (1, 2, 0, -1)
    domain = Domain(
        {
            "m1": positive(0.5, 2.0),
            "m2": positive(0.5, 100.0),
            "x1": positive(0.5, 1.0),
            "x2": positive(1.1, 3.0),
            "v1": Range(typical=(-1.0, 1.0)),
            "v2": Range(typical=(-2.0, -0.5)),
        },
        (
            Rule("x1 < x2 (block 1 is between the wall and block 2)", lambda n: n["x1"] < n["x2"]),
            Rule("the blocks do not reach the wall at the same time", _one_after_the_other),
            Rule("m2 <= 1e7 m1 (at most 10,000 impacts)", lambda n: n["m2"] <= 10**7 * n["m1"]),
        ),
    )
    variants = (
        Variant("equal", "equal masses: 3 impacts, in which the blocks exchange their velocities", {"m2": 1}),
        Variant("ratio_1e4", "m2/m1 = 1e4: exactly 314 impacts, digits of pi", {"m2": 10**4}),
        Variant("ratio_1e6", "m2/m1 = 1e6: 3141 impacts, at the wall 1e-6 s apart", {"m2": 10**6}),
    )

    invariants: ClassVar = {"energy": Invariant(blocks_kinetic)}
    scene = SCENE

    @cached_property
    def _exact(self) -> TwoBlocks:
        m1, m2 = self.parameter_values()
        x1, x2, v1, v2 = self.initial_state
        return TwoBlocks(m1, m2, x1, x2, v1, v2)

    def motion(self) -> TwoBlocks:
        return self._exact

    @property
    def forms(self) -> tuple[Hybrid, ...]:
        return (
            Hybrid(
                modes=(Mode("free", uniform_motion),),
                start=blocks_mode,
                transitions=(
                    Transition("blocks", "free", gap, -1, blocks_collide, "free", onto_each_other),
                    Transition("wall", "free", distance_to_wall, -1, wall_returns, "free", onto_wall),
                ),
                settle=1e-9 * self.time_scale,
            ),
        )

    @property
    def time_scale(self) -> float:
        """The distance of block 2 from the wall over its speed; 1 s if it is at rest."""
        speed = max(abs(float(v)) for v in self.initial_state[2:])
        return float(self.initial_state[1]) / speed if speed else 1.0

    def natural_span(self) -> Number:
        """A third longer than the time until the last impact."""
        return float(self._exact.impact_time(self._exact.impacts)) * 4 / 3 if self._exact.impacts else self.time_scale

    def _listed(self, digits: int) -> tuple[Event, ...]:
        """`blocks` and `wall`, sorted by time."""
        found = []
        for n in range(1, self._exact.passed(self.span) + 1):
            impact = self._exact.impact(n, digits)
            places = impact.places
            found.append(Event(impact.time, impact.name, places + impact.before, places + impact.after))
        return tuple(found)

    def event_time(self, n: int, digits: int = 15) -> Any:
        """Computed without the earlier events."""
        return self._exact.impact_time(n, digits) if n <= self._exact.passed(self.span) else mpf("inf")

    def same_course(self, other: Case) -> bool:
        return isinstance(other, RestitutionImpact) and other._exact.passed(self.span) == self._exact.passed(self.span)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`impacts`: the number of all impacts, also after the span."""
        count = self._exact.impacts
        found = {"impacts": mpf(count)}
        return found | {"last_impact": self._exact.impact_time(count, digits)} if count else found
