"""A bead on a wire that rotates in a vertical plane: a rheonomic constraint."""

from __future__ import annotations

from functools import cached_property
from math import cos, pi, sin
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.core.point_scene import railed_point
from gnomon.reference.guided.bead_rotating_wire_vertical_plane import BeadOnTurningWire
from gnomon.reference.numerics.precision import Number, publish, working


def bead_wire_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Centrifugal force and gravity along the wire."""
    r, v = state
    rate, g = parameters
    return v, rate * rate * r - g * sin(rate * t)


def bead_wire_deviation(t: Any, state: Values, parameters: Values) -> Values:
    """s'^2 - O^2 s^2, s the distance from the bounded orbit: the product of the growing and the decaying part."""
    r, v = state
    rate, g = parameters
    s = r - g / (2 * rate * rate) * sin(rate * t)
    speed = v - g / (2 * rate) * cos(rate * t)
    return (speed * speed - rate * rate * s * s,)


SCENE = railed_point(bead_wire_equations, "time_force", token="position_force")
"""In the frame of the wire: a fixed rail with the centrifugal force and rotating gravity."""


class BeadOnRotatingWire(Case):
    name = "bead_rotating_wire_vertical_plane"
    title = "Bead on a smooth straight wire rotating uniformly in a vertical plane"
    section = "11.7"
    conventions = (
        "r from the axis along the wire, which is at the angle O t above the horizontal: r'' = O^2 r - g sin(O t)."
    )
    state = (Coordinate("r", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("O", "rad/s", 2, "rate of rotation of the wire"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
    )
    default_state = ("0.1", 0)
    domain = Domain(
        {"O": positive(0.2, 5.0), "g": positive(), "r": Range(typical=(-2.0, 2.0)), "v": Range(typical=(-5.0, 5.0))}
    )
    variants = (
        Variant(
            "bounded",
            "exactly on the bounded orbit r = g/(2 O^2) sin(O t), from which errors grow as e^(O t)",
            {"g": 10},
            (0, "2.5"),
        ),
        Variant(
            "bounded_above",
            "the double above it: leaves the bounded orbit as 1e-16 e^(O t)",
            {"g": 10},
            (0, 2.5000000000000004),
        ),
        Variant(
            "dying",
            "exactly on the branch that approaches the bounded orbit: the growing part is exactly zero",
            {"g": 10},
            (1, "0.5"),
        ),
        Variant("thrown_out", "grows by e^20", span=10),
    )
    invariants: ClassVar = {"deviation": Invariant(bead_wire_deviation)}
    autonomous = False
    forms = (FirstOrder(bead_wire_equations),)
    scene = SCENE

    @cached_property
    def _exact(self) -> BeadOnTurningWire:
        return BeadOnTurningWire(*self.parameter_values(), *self.initial_state)

    def motion(self) -> BeadOnTurningWire:
        return self._exact

    @property
    def time_scale(self) -> float:
        return 1 / float(self.parameters["O"])

    def natural_span(self) -> Number:
        """1.37 turns; 2.87 turns on bounded orbits, after which binary64 no longer follows them."""
        return (2.87 if self._exact.growing() == 0 else 1.37) * 2 * pi * self.time_scale

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        with working(digits + 10) as mp:
            growing, decaying = mp.mpf(self._exact.growing()), mp.mpf(self._exact.decaying())
            first, second = publish((growing, decaying), digits)
        return {"growing_part": first, "dying_part": second, "bounded_amplitude": self._exact.swing(digits)}
