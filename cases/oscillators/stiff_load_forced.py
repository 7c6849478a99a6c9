"""A load on a stiff rope, forced fast: a hoist whose motor shakes a crane on a soft mount."""

from gnomon.cases.declare import *
from gnomon.reference.oscillators.stiff_load_forced import HoistedLoad


def hoist_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """The force of the rope on both, of the mount and of the motor on the crane."""
    x1, x2 = q
    crane, load, mount, rope, f, w = parameters
    pull = rope * (x2 - x1)
    return (pull - mount * x1 + f * cos(w * t)) / crane, -pull / load


def hoist_equations(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, v1, v2 = state
    return (v1, v2, *hoist_acceleration(t, (x1, x2), parameters))


def hoist_matrix(parameters: Values) -> Values:
    crane, load, mount, rope, _f, _w = parameters
    first = -(mount + rope) / crane, rope / crane, 0, 0
    second = rope / load, -rope / load, 0, 0
    return (0, 0, 1, 0, 0, 0, 0, 1, *first, *second)


def hoist_force(t: Any, state: Values, parameters: Values) -> Values:
    crane, _load, _mount, _rope, f, w = parameters
    return 0, 0, f * cos(w * t) / crane, 0


class StiffLoadForced(Case):
    """Vertical motion of a crane on a soft mount and of the load on its stiff rope."""

    name = "stiff_load_forced"
    title = "A load on a stiff rope, forced fast"
    section = "6.18"
    conventions = (
        "[inferred] x1 of the crane and x2 of the load, up from the equilibrium under their weights; the rope never goes "
        "slack. The motor shakes the crane with F cos(w t), starting at t = 0."
    )
    x1 = Coordinate("m", "0.1", typical(-0.2, 0.2))
    x2 = Coordinate("m", "0.101", typical(-0.2, 0.2))
    v1 = Coordinate("m/s", 0, typical(-1, 1))
    v2 = Coordinate("m/s", 0, typical(-1, 1))
    M = Parameter("kg", 2, "mass of the crane", positive(1, 4))
    m = Parameter("kg", 1, "mass of the load", positive(0.5, 2))
    K = Parameter("N/m", 3, "stiffness of the mount", positive(1, 10))
    k = Parameter("N/m", 666667, "stiffness of the rope", positive(10**4, 10**6))
    F = Parameter("N", 100, "amplitude of the force", typical(-200, 200))
    w = Parameter("rad/s", 900, "frequency of the force", nonnegative(100, 1500))
    exact_motion = bind(HoistedLoad)
    autonomous = False
    default_span = "20.3"
    variants = (
        Variant("near_resonance", "the force is 1e-3 beside the frequency of the rope: beats", {"w": 1001}),
        Variant(
            "at_rest", "both begin at rest: the force alone makes all of the vibration", initial_state=(0, 0, 0, 0)
        ),
        Variant("long", "200,000 radians of the rope's vibration", span="203.7"),
        Variant("rigid", "a rope of frequency 1e6 beside a slow vibration", {"k": 666666666667}, ("0.1", "0.1", 0, 0)),
    )
    forms = (SecondOrder(hoist_acceleration), SemiLinear(hoist_equations, linear=hoist_matrix, rest=hoist_force))
    quantity_names = ("slow_frequency", "fast_frequency")
    mirror = ("x1", "x2", "v1", "v2", "F")

    @property
    def time_scale(self) -> float:
        """One radian of the rope's vibration, or of the force if that is shorter."""
        return min(1 / float(self.exact_motion.fast_frequency()), 1 / float(self.w) if self.w else inf)
