"""A mass that hangs on two springs in series."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed_pull
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
    x = Coordinate("m", 0, typical(-5, 5))
    v = Coordinate("m/s", 0, typical(-5, 5))
    m = Parameter("kg", 2, "mass", positive())
    k1 = Parameter("N/m", 100, "upper spring", positive())
    k2 = Parameter("N/m", 300, "lower spring", positive())
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    exact_motion = bind(HangingSprings, mass="m")
    default_span = Span(10.37, "turn")
    quantity_names = (
        "period",
        "stiffness_in_series=stiffness",
        "stiffness_in_parallel=side_by_side",
        "static_deflection=sag",
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
    invariants = conserved(energy=hanging_energy)
    forms = (Separable(hanging_acceleration, hanging_potential),)
    scene = SCENE

    @property
    def time_scale(self) -> float:
        return sqrt(float(self.m / self.exact_motion.in_series))
