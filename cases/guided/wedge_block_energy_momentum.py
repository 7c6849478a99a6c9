"""A block on a wedge that is free to slide."""

from gnomon.cases.declare import *
from gnomon.cases.guided.uniform import fall_time
from gnomon.cases.scenes.cart import WEDGE
from gnomon.reference.guided.wedge_block_energy_momentum import Wedge


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


class WedgeBlock(Case):
    """A block that slides down a wedge, which slides on the floor; all contacts are smooth."""

    name = "wedge_block_energy_momentum"
    title = "Block on a movable wedge"
    section = "8.10, 8.11"
    conventions = (
        "[inferred] The book names the system; the model is a block m on the face of a wedge M on a floor, all smooth. "
        "X of the wedge, in the direction in which its face descends; s of the block down the face, relative to the wedge."
    )
    X = Coordinate("m", 0, typical(-3, 3), group="place of the wedge")
    s = Coordinate("m", 0, typical(-3, 3))
    V = Coordinate("m/s", 0, typical(-3, 3), group="velocity of the wedge")
    v = Coordinate("m/s", -2, typical(-3, 3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    m = Parameter("kg", 1, "mass of the block", positive())
    M = Parameter("kg", 3, "mass of the wedge", positive())
    alpha = Parameter("rad", "0.5", "angle of the face", Range(0.0, pi / 2, typical=(0.05, 1.5)))
    exact_motion = bind(Wedge, places="X s", velocities="V v")
    default_span = Span(3.3, "time scale")
    variants = (
        Variant("light_wedge", "M = 1e-8 kg: the wedge is pushed aside, the block falls freely", {"M": "1e-8"}),
        Variant(
            "heavy_block",
            "m/M = 1e8: the momentum of the wedge is lost in the momentum of the block",
            {"m": 10**8, "M": 1},
        ),
        Variant("light_block", "m/M = 1e-8: the wedge moves by 1e-8 of the block", {"m": "3e-8"}),
    )
    invariants = conserved(energy=wedge_energy, momentum=wedge_momentum)
    forms = (SecondOrder(wedge_acceleration),)
    scene = WEDGE

    @property
    def time_scale(self) -> float:
        """Of the block, relative to the wedge."""
        return fall_time(abs(float(self.v)), abs(float(self.exact_motion.acceleration(1))))

    def derived(self, digits: int) -> dict[str, Any]:
        motion = self.exact_motion
        return {
            "wedge_acceleration": motion.acceleration(0, digits),
            "relative_acceleration": motion.acceleration(1, digits),
            "normal_force": motion.normal_force(digits),
        }
