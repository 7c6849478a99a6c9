"""Uniformly accelerated systems: an Atwood machine, and a block on a wedge that is free to slide.

Cases: atwood_pulley_systems, wedge_block_energy_momentum.
"""

from __future__ import annotations

import math
from functools import cached_property
from math import cos, sin, sqrt
from typing import Any, ClassVar

from gnomon.cases.core.cart_scene import WEDGE
from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import SecondOrder, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.core.rope_scene import ATWOOD
from gnomon.reference.flight.uniform_acceleration import Atwood, Wedge
from gnomon.reference.numerics.precision import Number


def atwood_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = g (m1 - m2)/(m1 + m2 + I/R^2)."""
    g, m1, m2, inertia, radius = parameters
    return (g * (m1 - m2) / (m1 + m2 + inertia / (radius * radius)),)


def atwood_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    g, m1, m2, inertia, radius = parameters
    return ((m1 + m2 + inertia / (radius * radius)) * v * v / 2 - g * (m1 - m2) * x,)


def wedge_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """X'' = -m g sin(a) cos(a)/(M + m sin^2(a)), s'' = (M + m) g sin(a)/(M + m sin^2(a))."""
    g, m, M, alpha = parameters
    common = g * sin(alpha) / (M + m * sin(alpha) * sin(alpha))
    return -m * cos(alpha) * common, (M + m) * common


def wedge_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Momentum of wedge and block along the floor."""
    _, _, V, v = state
    _, m, M, alpha = parameters
    return ((M + m) * V + m * v * cos(alpha),)


def wedge_energy(t: Any, state: Values, parameters: Values) -> Values:
    _, s, V, v = state
    g, m, M, alpha = parameters
    kinetic = ((M + m) * V * V + m * v * v) / 2 + m * V * v * cos(alpha)
    return (kinetic - m * g * s * sin(alpha),)


class AtwoodPulleySystems(Case):
    """Two masses on a rope over a pulley that turns without slip."""

    name = "atwood_pulley_systems"
    title = "Atwood machine with a heavy pulley"
    section = "8.8, 8.9"
    conventions = "x is the distance by which m1 has descended; the rope is massless and does not slip."
    state = (Coordinate("x", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("m1", "kg", 2, "mass 1"),
        Parameter("m2", "kg", "1.5", "mass 2"),
        Parameter("I", "kg m^2", "0.005", "moment of inertia of the pulley"),
        Parameter("R", "m", "0.1", "radius of the pulley"),
    )
    default_state = (0, "-0.5")
    domain = Domain(
        {"g": positive(), "m1": positive(), "m2": positive(), "I": Range(low=0.0, typical=(0.0, 1.0))}
        | {"R": positive(), "x": Range(typical=(-3.0, 3.0)), "v": Range(typical=(-3.0, 3.0))}
    )
    variants = (
        Variant("light_pulley", "a pulley without inertia: both parts of the rope have the same tension", {"I": 0}),
        Variant(
            "balance",
            "m1 is the double next above m2: only the tiny difference of the weights accelerates",
            {"m1": 1.5000000000000002},
            (0, 0),
            span=1000,
        ),
    )
    invariants: ClassVar = {"energy": Invariant(atwood_energy)}
    forms = (SecondOrder(atwood_acceleration),)
    scene = ATWOOD
    reversal = ("v",)

    @cached_property
    def _exact(self) -> Atwood:
        (x,), (v,) = self.initial_state[:1], self.initial_state[1:]
        return Atwood((x,), (v,), *self.parameter_values())

    def motion(self) -> Atwood:
        return self._exact

    @property
    def time_scale(self) -> float:
        """Initial speed over acceleration; from rest the time of the first metre; 1 s if both are zero."""
        rate, speed = abs(float(self._exact.rate)), abs(float(self.initial_state[1]))
        if rate == 0:
            return 1.0
        return speed / rate or sqrt(2 / rate)

    def natural_span(self) -> Number:
        """3.3 time scales: out, and back beyond the start."""
        return 3.3 * self.time_scale

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        first, second = self._exact.tensions(digits)
        return {"acceleration": self._exact.acceleration(0, digits), "tension_1": first, "tension_2": second}


class WedgeBlock(Case):
    """A block that slides down a wedge, which slides on the floor; all contacts are smooth."""

    name = "wedge_block_energy_momentum"
    title = "Block on a movable wedge"
    section = "8.10, 8.11"
    conventions = (
        "[inferred] The book names the system; the model is a block m on the face of a wedge M on a floor, all smooth. "
        "X of the wedge, in the direction in which its face descends; s of the block down the face, relative to the wedge."
    )
    state = (
        Coordinate("X", "m", "length", "place of the wedge"),
        Coordinate("s", "m", "length"),
        Coordinate("V", "m/s", "velocity", "velocity of the wedge"),
        Coordinate("v", "m/s", "velocity"),
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("m", "kg", 1, "mass of the block"),
        Parameter("M", "kg", 3, "mass of the wedge"),
        Parameter("alpha", "rad", "0.5", "angle of the face"),
    )
    default_state = (0, 0, 0, -2)
    domain = Domain(
        {"g": positive(), "m": positive(), "M": positive(), "alpha": Range(0.0, math.pi / 2, typical=(0.05, 1.5))}
        | {name: Range(typical=(-3.0, 3.0)) for name in ("X", "s", "V", "v")}
    )
    variants = (
        Variant("light_wedge", "M = 1e-8 kg: the wedge is pushed aside, the block falls freely", {"M": "1e-8"}),
        Variant(
            "heavy_block", "m/M = 1e8: the momentum of the wedge is lost in that of the block", {"m": 10**8, "M": 1}
        ),
        Variant("light_block", "m/M = 1e-8: the wedge moves by 1e-8 of the block", {"m": "3e-8"}),
    )
    invariants: ClassVar = {"energy": Invariant(wedge_energy), "momentum": Invariant(wedge_momentum)}
    forms = (SecondOrder(wedge_acceleration),)
    scene = WEDGE
    reversal = ("V", "v")

    @cached_property
    def _exact(self) -> Wedge:
        return Wedge(self.initial_state[:2], self.initial_state[2:], *self.parameter_values())

    def motion(self) -> Wedge:
        return self._exact

    @property
    def time_scale(self) -> float:
        """Speed of the block over its acceleration; from rest the time of the first metre."""
        rate, speed = abs(float(self._exact.acceleration(1))), abs(float(self.initial_state[3]))
        if rate == 0:
            return 1.0
        return speed / rate or sqrt(2 / rate)

    def natural_span(self) -> Number:
        """3.3 time scales: up the face, back and further down."""
        return 3.3 * self.time_scale

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        return {
            "wedge_acceleration": self._exact.acceleration(0, digits),
            "relative_acceleration": self._exact.acceleration(1, digits),
            "normal_force": self._exact.normal_force(digits),
        }
