"""An Atwood machine whose pulley has a moment of inertia."""

from gnomon.cases.declare import *
from gnomon.cases.guided.uniform import fall_time
from gnomon.cases.scenes.rope import ATWOOD
from gnomon.reference.guided.atwood_pulley_systems import Atwood


def atwood_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = g (m1 - m2)/(m1 + m2 + I/R^2)."""
    g, m1, m2, inertia, radius = parameters
    return (g * (m1 - m2) / (m1 + m2 + inertia / (radius * radius)),)


def atwood_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    g, m1, m2, inertia, radius = parameters
    return ((m1 + m2 + inertia / (radius * radius)) * v * v / 2 - g * (m1 - m2) * x,)


class AtwoodPulleySystems(Case):
    """Two masses on a rope over a pulley that turns without slip."""

    name = "atwood_pulley_systems"
    title = "Atwood machine with a heavy pulley"
    section = "8.8, 8.9"
    conventions = "x is the distance by which m1 has descended; the rope is massless and does not slip."
    x = Coordinate("m", 0, typical(-3, 3))
    v = Coordinate("m/s", "-0.5", typical(-3, 3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    m1 = Parameter("kg", 2, "mass 1", positive())
    m2 = Parameter("kg", "1.5", "mass 2", positive())
    I = Parameter("kg m^2", "0.005", "moment of inertia of the pulley", nonnegative(0, 1))
    R = Parameter("m", "0.1", "radius of the pulley", positive())
    exact_motion = bind(lambda c: Atwood((c.x,), (c.v,), *c.parameter_values()))
    default_span = Span(3.3, "time scale")
    quantity_names = ("acceleration=rate", "tension_1 tension_2=tensions")
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
    invariants = conserved(energy=atwood_energy)
    forms = (SecondOrder(atwood_acceleration),)
    scene = ATWOOD

    @property
    def time_scale(self) -> float:
        return fall_time(abs(float(self.v)), abs(float(self.exact_motion.rate)))
