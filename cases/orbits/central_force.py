"""Central motions in a plane: isotropic oscillator, string through a hole, attraction k/r, dumbbell with a spring.

Cases: central_force_conservation, central_force_hanging_mass, central_force_logarithmic, dumbbell_spring.
"""

from gnomon.cases.declare import *
from gnomon.cases.orbits.kepler_orbit import angular_momentum
from gnomon.cases.oscillators.well import WellCase
from gnomon.cases.scenes.rope import HANGING
from gnomon.cases.scenes.two_masses import polar_pair, polar_point
from gnomon.reference.orbits.central_force import HangingMass, Logarithmic, SpringDumbbell
from gnomon.reference.orbits.isotropic_oscillator import IsotropicOscillator

TURNS = Rule("omega is not zero (else the mass passes through the centre)", lambda n: n["omega"] != 0)


def hanging_equations(t: Any, state: Values, parameters: Values) -> Values:
    """(m1 + m2) r'' = m1 r theta'^2 - m2 g, theta'' = -2 r' theta'/r."""
    r, _, vr, omega = state
    g, m1, m2 = parameters
    return vr, omega, (m1 * r * omega * omega - m2 * g) / (m1 + m2), -2 * vr * omega / r


def hanging_energy(t: Any, state: Values, parameters: Values) -> Values:
    r, _, vr, omega = state
    g, m1, m2 = parameters
    return (((m1 + m2) * vr * vr + m1 * r * r * omega * omega) / 2 + m2 * g * r,)


def areal_spin(t: Any, state: Values, parameters: Values) -> Values:
    """r^2 theta'."""
    r, _, _, omega = state
    return (r * r * omega,)


def logarithmic_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = r theta'^2 - k/r, theta'' = -2 r' theta'/r."""
    r, _, vr, omega = state
    (k,) = parameters
    return vr, omega, r * omega * omega - k / r, -2 * vr * omega / r


def logarithmic_energy(t: Any, state: Values, parameters: Values) -> Values:
    r, _, vr, omega = state
    (k,) = parameters
    return ((vr * vr + r * r * omega * omega) / 2 + k * log(r),)


def spring_dumbbell_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = r theta'^2 - (k/mu) (r - l), theta'' = -2 r' theta'/r, mu = m1 m2/(m1 + m2)."""
    r, _, vr, omega = state
    m1, m2, k, length = parameters
    return vr, omega, r * omega * omega - k * (1 / m1 + 1 / m2) * (r - length), -2 * vr * omega / r


def spring_dumbbell_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the reduced mass."""
    r, _, vr, omega = state
    m1, m2, k, length = parameters
    return ((vr * vr + r * r * omega * omega + k * (1 / m1 + 1 / m2) * (r - length) * (r - length)) / 2,)


def isotropic_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """r'' = -(k/m) r."""
    x, y = q
    m, k = parameters
    return -(k / m) * x, -(k / m) * y


def isotropic_potential(t: Any, q: Values, parameters: Values) -> Values:
    x, y = q
    m, k = parameters
    return ((k / m) * (x * x + y * y) / 2,)


def isotropic_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    m, k = parameters
    return ((m * (vx * vx + vy * vy) + k * (x * x + y * y)) / 2,)


def isotropic_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    x, y, vx, vy = state
    m, k = parameters

    def spring(t: float, position: Vector, velocity: Vector) -> Vector:
        return -k * position[0], -k * position[1], 0.0

    body = Body("mass", m, (0.0, 0.0, 0.0), (x, y, 0.0), velocity=(vx, vy, 0.0))
    return Scene((0.0, 0.0, 0.0), (body,), forces=(Force("mass", "position_force", spring),))


ISOTROPIC = SceneForm(isotropic_scene, free_body("mass", 0, 1), frozenset({"position_force"}))


class CentralForceConservation(Case):
    """A mass in a plane on a spring of natural length zero: an ellipse about the centre."""

    name = "central_force_conservation"
    title = "Central force: the isotropic oscillator"
    section = "7.8"
    conventions = (
        "The force is -k r towards the origin; the orbit is an ellipse about it, with the same period for all."
    )
    x = Coordinate("m", 1, typical(-5, 5))
    y = Coordinate("m", 0, typical(-5, 5))
    vx = Coordinate("m/s", "0.5", typical(-5, 5))
    vy = Coordinate("m/s", "1.2", typical(-5, 5))
    m = Parameter("kg", 1, "mass", positive())
    k = Parameter("N/m", 4, "stiffness", positive())
    exact_motion = bind(IsotropicOscillator, mass="m", stiffness="k")
    default_span = Span(10.37, "turn")
    quantity_names = ("period", "semi_major_axis semi_minor_axis=semi_axes")
    variants = (
        Variant(
            "thin",
            "passes 5e-7 m from the centre: the direction turns by pi within 5e-7 rad of phase",
            initial_state=(1, 0, 0, "1e-6"),
        ),
        Variant("long_1e5", "100,000 periods: phase error", periods=100_000.37),
    )
    invariants = conserved(energy=isotropic_energy, angular_momentum=angular_momentum)
    forms = (Separable(isotropic_acceleration, isotropic_potential),)
    scene = ISOTROPIC

    @property
    def time_scale(self) -> float:
        return sqrt(float(self.m) / float(self.k))


class _Central(WellCase):
    reversal = ("vr", "omega")

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """`apsidal_angle`: the growth of theta from the least to the largest distance (rad)."""
        return () if self.exact_motion.rests else ("apsidal_angle",)


class CentralForceHangingMass(_Central):
    """A mass on a smooth table, joined to a hanging mass by a string through a hole."""

    name = "central_force_hanging_mass"
    title = "Mass on a table, string through a hole, hanging mass"
    section = "7.8"
    conventions = "Polar coordinates of m1 about the hole; m2 hangs and moves only up and down; the string stays taut."
    r = Coordinate("m", 1, positive(0.9, 1.5))
    theta = Coordinate("rad", 0, typical(-3, 3))
    vr = Coordinate("m/s", 0, typical(-0.2, 0.2))
    omega = Coordinate("rad/s", 4, typical(1.5, 3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 10))
    m1 = Parameter("kg", 1, "mass on the table", positive(0.5, 3))
    m2 = Parameter("kg", "0.5", "hanging mass", positive(0.5, 3))
    rules = (TURNS,)
    exact_motion = bind(HangingMass)
    variants = (
        Variant("circle", "exactly the circle: r must not move", {"g": 10, "m2": 1, "m1": "2.5"}, (1, 0, 0, 2)),
        Variant(
            "near_hole", "passes 0.1 m from the hole, where it turns 100 times faster", initial_state=(1, 0, 0, "0.3")
        ),
        Variant("light", "m2 = 1e-6 m1: nearly free motion, to 47 m and back", {"m2": "1e-6"}, (1, 0, 0, "0.03")),
    )
    invariants = conserved(energy=hanging_energy, areal_spin=areal_spin)
    forms = (FirstOrder(hanging_equations),)
    scene = HANGING


LOGARITHMIC = polar_point(lambda r, parameters: parameters[0] / r)


class CentralForceLogarithmic(_Central):
    """The attraction k/r per unit mass."""

    name = "central_force_logarithmic"
    title = "Central force k/r: the logarithmic potential"
    section = "7.8"
    conventions = (
        "Polar coordinates; the attraction per unit mass is k/r, so the circular speed is sqrt(k) at any radius."
    )
    r = Coordinate("m", 1, positive(0.9, 1.5))
    theta = Coordinate("rad", 0, typical(-3, 3))
    vr = Coordinate("m/s", "0.5", typical(-0.2, 0.2))
    omega = Coordinate("rad/s", "0.8", typical(0.8, 1.2))
    k = Parameter("m^2/s^2", 1, "attraction times distance, per unit mass", positive(0.8, 1.5))
    rules = (TURNS,)
    exact_motion = bind(Logarithmic)
    variants = (
        Variant("circle", "exactly the circle: r must not move", initial_state=(1, 0, 0, 1)),
        Variant(
            "eccentric",
            "from 1 m to 0.02 m: the pericentre passage is 50 times faster",
            initial_state=(1, 0, 0, "0.06"),
        ),
    )
    invariants = conserved(energy=logarithmic_energy, areal_spin=areal_spin)
    forms = (FirstOrder(logarithmic_equations),)
    scene = LOGARITHMIC


DUMBBELL = polar_pair(lambda parameters: parameters[:2], lambda r, parameters: parameters[2] * (r - parameters[3]))


class DumbbellSpring(_Central):
    """Two masses joined by a spring in free flight, which rotate and vibrate about each other."""

    name = "dumbbell_spring"
    title = "Rotating vibrating dumbbell: two masses on a spring of natural length l"
    section = "8.6, 8.7"
    conventions = "Distance and direction of m2 relative to m1; the centre of mass moves like a free particle."
    r = Coordinate("m", "1.4", positive(0.9, 1.5))
    theta = Coordinate("rad", 0, typical(-3, 3))
    vr = Coordinate("m/s", 0, typical(-0.2, 0.2))
    omega = Coordinate("rad/s", 3, typical(1, 2))
    m1 = Parameter("kg", 1, "mass 1", positive(0.5, 3))
    m2 = Parameter("kg", 2, "mass 2", positive(0.5, 3))
    k = Parameter("N/m", 20, "stiffness of the spring", positive(10, 30))
    l = Parameter("m", 1, "natural length of the spring", nonnegative(0.5, 1))
    rules = (TURNS,)
    exact_motion = bind(lambda c: SpringDumbbell(c.r, c.theta, c.vr, c.omega, c.k * (1 / c.m1 + 1 / c.m2), c.l))
    variants = (
        Variant(
            "steady",
            "rotates with exactly the stretch that balances the centrifugal force",
            {"m2": 1, "k": 4},
            (2, 0, 0, 2),
        ),
        Variant("stiff", "k = 1e10 N/m: 4e4 vibrations in one turn", {"k": 10**10}, ("1.0001", 0, 0, 3)),
        Variant("ellipse", "no natural length: an ellipse about the centre", {"l": 0}),
    )
    invariants = conserved(energy=spring_dumbbell_energy, areal_spin=areal_spin)
    forms = (FirstOrder(spring_dumbbell_equations),)
    scene = DUMBBELL
