"""A bead on a wire that rotates in a vertical plane: a rheonomic constraint."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed_point
from gnomon.reference.guided.bead_rotating_wire_vertical_plane import BeadOnTurningWire


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
    r = Coordinate("m", "0.1", typical(-2, 2))
    v = Coordinate("m/s", 0, typical(-5, 5))
    O = Parameter("rad/s", 2, "rate of rotation of the wire", positive(0.2, 5))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    exact_motion = bind(BeadOnTurningWire)
    quantity_names = ("growing_part=growing", "dying_part=decaying", "bounded_amplitude=swing")
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
    invariants = conserved(deviation=bead_wire_deviation)
    autonomous = False
    forms = (FirstOrder(bead_wire_equations),)
    scene = SCENE

    @property
    def time_scale(self) -> float:
        return 1 / float(self.O)

    def natural_span(self) -> Number:
        """1.37 turns; 2.87 turns on bounded orbits, after which binary64 no longer follows them."""
        return (2.87 if self.exact_motion.growing == 0 else 1.37) * 2 * pi * self.time_scale
