"""The chilled can that slides when its air has warmed."""

from __future__ import annotations

import math
from functools import cached_property
from math import cos, exp, sin
from typing import Any

from gnomon.cases.case import Case, Event, Variant
from gnomon.cases.forms import Hybrid, Mode, Transition, Values
from gnomon.cases.numbers import Coordinate, Domain, Parameter, Range, Rule, positive
from gnomon.reference.precision import Number, exact
from gnomon.reference.sliding_can import SlidingCan
from mpmath import mpf


def can_slides(t: Any, state: Values, parameters: Values) -> Values:
    """v' = g sin(alpha) - mu_k N/m, N = m g cos(alpha) - P (1 - e^(-t/T))."""
    _s, v = state
    m, g, alpha, _mu_s, mu_k, lift, warming = parameters
    return v, g * sin(alpha) - mu_k * (g * cos(alpha) - lift / m * (1 - exp(-t / warming)))


def can_stands(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def grip(t: Any, state: Values, parameters: Values) -> Values:
    """Weight along the slope beyond what friction holds."""
    m, g, alpha, mu_s, _mu_k, lift, warming = parameters
    return (m * g * sin(alpha) - mu_s * (m * g * cos(alpha) - lift * (1 - exp(-t / warming))),)


def set_off(t: Any, state: Values, parameters: Values) -> Values:
    return state


def can_mode(t: Any, state: Values, parameters: Values) -> str:
    numbers = [exact(value) for value in (*parameters[:7], *state)]
    return "slide" if SlidingCan(*numbers).slides_first else "stick"


class SlidingCanCase(Case):
    name = "sliding_can"
    title = "A chilled can, inverted on an incline, slides when its air has warmed"
    section = "5.12.1 (model inferred from the section's title)"
    conventions = (
        "[inferred] s down the slope; the enclosed air carries P (1 - e^(-t/T)) of the can's pressure N on the plane; it "
        "slides when m g sin(alpha) = mu_s N. P < m g cos(alpha): it does not lift off. The warming begins at t = 0."
    )
    state = (Coordinate("s", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("m", "kg", "0.02", "mass of the can"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("alpha", "rad", "0.1", "angle of the incline"),
        Parameter("mu_s", "1", "0.3", "coefficient of static friction"),
        Parameter("mu_k", "1", "0.25", "coefficient of kinetic friction"),
        Parameter("P", "N", "0.17", "final lift of the air, p1 A"),
        Parameter("T", "s", 5, "time constant of the warming"),
    )
    default_state = (0, 0)
    domain = Domain(
        {
            "m": positive(0.5, 2.0),
            "g": positive(5.0, 15.0),
            "alpha": Range(0.0, math.pi / 2, low_open=True, typical=(0.05, 0.6)),
            "mu_s": Range(low=0.0, typical=(0.1, 0.8)),
            "mu_k": Range(low=0.0, typical=(0.0, 0.5)),
            "P": positive(0.1, 4.0),
            "T": positive(0.5, 5.0),
            "s": Range(typical=(-1.0, 1.0)),
            "v": Range(low=0.0, high=0.0, typical=(0.0, 0.0)),
        },
        (
            Rule("mu_k <= mu_s (friction does not grow when sliding begins)", lambda n: n["mu_k"] <= n["mu_s"]),
            Rule(
                "P < m g cos(alpha) (no lift-off)",
                lambda n: float(n["P"]) < float(n["m"] * n["g"]) * cos(float(n["alpha"])),
            ),
            Rule("the can starts at rest (v = 0)", lambda n: n["v"] == 0),
        ),
    )
    variants = (
        Variant("late", "P 1e-5 above what is needed: slides after 11.6 time constants", {"P": "0.12993"}, span=100),
        Variant("never", "P just below what is needed: must not creep", {"P": "0.1299"}, span=60),
        Variant("at_once", "too steep from the start", {"alpha": "0.4"}, span=3),
    )
    autonomous = False

    @cached_property
    def _exact(self) -> SlidingCan:
        return SlidingCan(*self.parameter_values(), *self.initial_state)

    def motion(self) -> SlidingCan:
        return self._exact

    @property
    def forms(self) -> tuple[Hybrid, ...]:
        return (
            Hybrid(
                modes=(Mode("stick", can_stands), Mode("slide", can_slides)),
                start=can_mode,
                transitions=(Transition("sets_off", "stick", grip, 1, set_off, "slide"),),
                settle=1e-9 * self.time_scale,
            ),
        )

    @property
    def time_scale(self) -> float:
        """The time constant of the warming."""
        return float(self.parameters["T"])

    def natural_span(self) -> Number:
        """The onset and 0.97 time constants more; 5.1 time constants where it holds."""
        return 5.1 * self.time_scale if self._exact.holds else float(self._exact.onset()) + 0.97 * self.time_scale

    def _listed(self, digits: int) -> tuple[Event, ...]:
        motion = self._exact
        if motion.holds or motion.slides_first or motion.onset(20) > self.span:
            return ()
        there = (self.exact(0, digits)[0], mpf(0))
        return (Event(motion.onset(digits), "sets_off", there, there),)

    def same_course(self, other: Case) -> bool:
        theirs = SlidingCan(*other.parameter_values(), *other.initial_state)
        return (theirs.holds, theirs.slides_first) == (self._exact.holds, self._exact.slides_first)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        return {"onset": mpf("inf") if self._exact.holds else self._exact.onset(digits)}
