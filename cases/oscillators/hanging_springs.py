"""A mass that hangs on two springs in series."""

from __future__ import annotations

from functools import cached_property
from math import pi, sqrt
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import Separable, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.core.point_scene import railed_pull
from gnomon.reference.numerics.precision import Number
from gnomon.reference.oscillators.hanging_springs import HangingSprings


def hanging_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """Gravity less the force of both springs, each stretched by its share."""
    (x,) = q
    m, k1, k2, g = parameters
    return (g - (k1 * k2 / (k1 + k2)) * x / m,)


def hanging_potential(t: Any, q: Values, parameters: Values) -> Values:
    (x,) = q
    m, k1, k2, g = parameters
    return ((k1 * k2 / (k1 + k2)) * x * x / (2 * m) - g * x,)


def hanging_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    x, v = state
    return (v * v / 2 + hanging_potential(t, (x,), parameters)[0],)


SCENE = railed_pull(hanging_acceleration)


class HangingSpringsCase(Case):
    name = "hanging_springs"
    title = "Mass on two springs in series, under gravity"
    section = "6.7"
    conventions = "x downward from where both springs are unstretched; springs in series add 1/k, in parallel k."
    state = (Coordinate("x", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("m", "kg", 2, "mass"),
        Parameter("k1", "N/m", 100, "upper spring"),
        Parameter("k2", "N/m", 300, "lower spring"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
    )
    default_state = (0, 0)
    domain = Domain(
        {name: positive() for name in ("m", "k1", "k2", "g")}
        | {name: Range(typical=(-5.0, 5.0)) for name in ("x", "v")}
    )
    variants = (
        Variant("unlike", "stiffnesses 1e12 apart: in series the soft spring alone counts", {"k1": 10**12, "k2": 1}),
        Variant(
            "sagged",
            "released 2e-7 m above its equilibrium: a small vibration on a large offset",
            {"k2": 100, "g": 10},
            ("0.3999998", 0),
        ),
    )
    invariants: ClassVar = {"energy": Invariant(hanging_energy)}
    forms = (Separable(hanging_acceleration, hanging_potential),)
    scene = SCENE
    reversal = ("v",)

    @cached_property
    def _exact(self) -> HangingSprings:
        return HangingSprings(*self.parameter_values(), *self.initial_state)

    def motion(self) -> HangingSprings:
        return self._exact

    @property
    def time_scale(self) -> float:
        return sqrt(float(self.parameters["m"] / self._exact.in_series))

    def natural_span(self) -> Number:
        """10.37 periods."""
        return 10.37 * 2 * pi * self.time_scale

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        motion = self._exact
        return {
            "period": motion.period(digits),
            "stiffness_in_series": motion.stiffness(digits),
            "stiffness_in_parallel": motion.side_by_side(digits),
            "static_deflection": motion.sag(digits),
        }
