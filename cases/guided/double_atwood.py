"""A double Atwood machine: one of the masses is a pulley with two masses of its own."""

from gnomon.cases.declare import *
from gnomon.cases.guided.uniform import fall_time
from gnomon.reference.guided.double_atwood import DoubleAtwood as Motion


def double_atwood_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """y'' = g (4 m2 m3 - m1 (m2 + m3))/D, z'' = 2 g m1 (m2 - m3)/D, D = m1 (m2 + m3) + 4 m2 m3.

    The first numerator is written so that masses in balance lose no digits: m2 (2 m3 - m1) + m3 (2 m2 - m1).
    """
    g, m1, m2, m3 = parameters
    share = g / (m1 * (m2 + m3) + 4 * m2 * m3)
    return share * (m2 * (2 * m3 - m1) + m3 * (2 * m2 - m1)), share * (2 * m1 * (m2 - m3))


def double_atwood_energy(t: Any, state: Values, parameters: Values) -> Values:
    y, z, V, v = state
    g, m1, m2, m3 = parameters
    kinetic = (m1 * V * V + m2 * (V + v) * (V + v) + m3 * (V - v) * (V - v)) / 2
    return (kinetic - g * ((m2 + m3 - m1) * y + (m2 - m3) * z),)


def double_atwood_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """The momentum along displacements that keep the centre of mass at its height, so that gravity does no work."""
    _, _, V, v = state
    _, m1, m2, m3 = parameters
    along_y, along_z = (m1 + m2 + m3) * V + (m2 - m3) * v, (m2 - m3) * V + (m2 + m3) * v
    return ((m2 - m3) * along_y - (m2 + m3 - m1) * along_z,)


class DoubleAtwood(Case):
    """A mass on a string over a fixed pulley, whose other end carries a second pulley with two masses."""

    name = "double_atwood"
    title = "Double Atwood machine"
    section = "8.8-8.9"
    conventions = (
        "[inferred] m1 hangs on one side of a fixed pulley, a movable pulley on the other side, and m2 and m3 over the "
        "movable pulley; pulleys and strings are massless, without friction. y is the distance by which the movable "
        "pulley has descended, z the distance by which m2 has descended below it."
    )
    y = Coordinate("m", 0, typical(-3, 3), group="place of the pulley")
    z = Coordinate("m", 0, typical(-3, 3))
    V = Coordinate("m/s", "-0.5", typical(-3, 3), group="velocity of the pulley")
    v = Coordinate("m/s", "0.8", typical(-3, 3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    m1 = Parameter("kg", 3, "mass against the movable pulley", positive())
    m2 = Parameter("kg", "1.5", "first mass on the movable pulley", positive())
    m3 = Parameter("kg", 2, "second mass on the movable pulley", positive())
    exact_motion = bind(Motion, places="y z", velocities="V v")
    default_span = Span(3.3, "time scale")
    quantity_names = ("pulley_acceleration relative_acceleration=rates", "tension_1 tension_2=tensions")
    variants = (
        Variant(
            "balance",
            "m1 = 2 m3, and m2 is the double next above m3: only its last bit accelerates the masses",
            {"m1": 4, "m2": 2.0000000000000004},
            (0, 0, 0, 0),
            span=1000,
        ),
        Variant(
            "still_pulley",
            "m2 rises, m3 falls, and their pulley nearly rests: its acceleration is a difference of terms 1e9 times as large",
            {"m1": "3.190000001", "m2": "1.1", "m3": "2.9"},
            (0, 0, 0, 0),
        ),
        Variant("light_mass", "m3 = 1e-8 kg rises with 3 g: the other masses fall freely", {"m3": "1e-8"}),
        Variant("heavy_counterweight", "m1 = 1e8 kg falls freely: the strings hardly brake it", {"m1": 10**8}),
    )
    invariants = conserved(energy=double_atwood_energy, momentum=double_atwood_momentum)
    forms = (SecondOrder(double_atwood_acceleration),)

    @property
    def time_scale(self) -> float:
        """With the larger speed and acceleration of the two coordinates."""
        speed, rate = max(abs(self.V), abs(self.v)), max(map(abs, self.exact_motion.rates))
        return fall_time(float(speed), float(rate))
