"""Two masses joined by a spring or a rod: the motion of the centre of mass and the motion about it.

Cases: two_mass_spring, center_of_mass_motion, dumbbell_free_flight.
"""

from gnomon.cases.declare import *
from gnomon.cases.scenes.two_masses import ON_A_LINE, ROD, attracting
from gnomon.reference.orbits.two_masses import RodPair, SpringPair


def spring_on_a_line(t: Any, q: Values, parameters: Values) -> Values:
    """x1'' = k (x2 - x1 - l)/m1, x2'' = -k (x2 - x1 - l)/m2."""
    x1, x2 = q
    m1, m2, k, length = parameters
    stretch = x2 - x1 - length
    return k / m1 * stretch, -k / m2 * stretch


def line_energy(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, v1, v2 = state
    m1, m2, k, length = parameters
    stretch = x2 - x1 - length
    return ((m1 * v1 * v1 + m2 * v2 * v2 + k * stretch * stretch) / 2,)


def line_momentum(t: Any, state: Values, parameters: Values) -> Values:
    _, _, v1, v2 = state
    m1, m2, _, _ = parameters
    return (m1 * v1 + m2 * v2,)


def line_centre_start(t: Any, state: Values, parameters: Values) -> Values:
    """x_C - v_C t."""
    x1, x2, v1, v2 = state
    m1, m2, _, _ = parameters
    return ((m1 * (x1 - v1 * t) + m2 * (x2 - v2 * t)) / (m1 + m2),)


def thrown_pair(t: Any, q: Values, parameters: Values) -> Values:
    """r1'' = (k/m1) (r2 - r1) + g, r2'' = -(k/m2) (r2 - r1) + g."""
    x1, y1, x2, y2 = q
    g, m1, m2, k = parameters
    x, y = x2 - x1, y2 - y1
    return k / m1 * x, k / m1 * y - g, -(k / m2) * x, -(k / m2) * y - g


def thrown_energy(t: Any, state: Values, parameters: Values) -> Values:
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    g, m1, m2, k = parameters
    x, y = x2 - x1, y2 - y1
    kinetic = m1 * (vx1 * vx1 + vy1 * vy1) + m2 * (vx2 * vx2 + vy2 * vy2)
    return ((kinetic + k * (x * x + y * y)) / 2 + g * (m1 * y1 + m2 * y2),)


def thrown_momentum_x(t: Any, state: Values, parameters: Values) -> Values:
    _, m1, m2, _ = parameters
    return (m1 * state[4] + m2 * state[6],)


def thrown_momentum_y(t: Any, state: Values, parameters: Values) -> Values:
    """P_y + (m1 + m2) g t."""
    g, m1, m2, _ = parameters
    return (m1 * state[5] + m2 * state[7] + (m1 + m2) * g * t,)


def thrown_centre_x(t: Any, state: Values, parameters: Values) -> Values:
    """x_C - v_C t."""
    x1, _, x2, _, vx1, _, vx2, _ = state
    _, m1, m2, _ = parameters
    return ((m1 * (x1 - vx1 * t) + m2 * (x2 - vx2 * t)) / (m1 + m2),)


def thrown_centre_y(t: Any, state: Values, parameters: Values) -> Values:
    """y_C - v_C t - g t^2/2."""
    _, y1, _, y2, _, vy1, _, vy2 = state
    g, m1, m2, _ = parameters
    return ((m1 * (y1 - vy1 * t) + m2 * (y2 - vy2 * t)) / (m1 + m2) - g * t * t / 2,)


def spin(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the centre of mass, over the reduced mass."""
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    return ((x2 - x1) * (vy2 - vy1) - (y2 - y1) * (vx2 - vx1),)


def dumbbell_equations(t: Any, state: Values, parameters: Values) -> Values:
    """The rod pulls mass 1 with m1 m2/(m1 + m2) l omega^2; omega' = 0."""
    _, _, theta, vx, vy, omega = state
    g, m1, m2, length = parameters
    pull = m2 / (m1 + m2) * length * omega * omega
    return vx, vy, omega, pull * cos(theta), pull * sin(theta) - g, 0


def dumbbell_energy(t: Any, state: Values, parameters: Values) -> Values:
    _, y, theta, vx, vy, omega = state
    g, m1, m2, length = parameters
    ux, uy = vx - length * omega * sin(theta), vy + length * omega * cos(theta)
    kinetic = (m1 * (vx * vx + vy * vy) + m2 * (ux * ux + uy * uy)) / 2
    return (kinetic + g * (m1 * y + m2 * (y + length * sin(theta))),)


def dumbbell_momentum_x(t: Any, state: Values, parameters: Values) -> Values:
    _, _, theta, vx, _, omega = state
    _, m1, m2, length = parameters
    return (m1 * vx + m2 * (vx - length * omega * sin(theta)),)


def dumbbell_momentum_y(t: Any, state: Values, parameters: Values) -> Values:
    """P_y + (m1 + m2) g t."""
    _, _, theta, _, vy, omega = state
    g, m1, m2, length = parameters
    return (m1 * vy + m2 * (vy + length * omega * cos(theta)) + (m1 + m2) * g * t,)


def dumbbell_spin(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the centre of mass."""
    _g, m1, m2, length = parameters
    return (m1 * m2 / (m1 + m2) * length * length * state[5],)


class TwoMassSpring(Case):
    """Two masses on a smooth rail, joined by a spring."""

    name = "two_mass_spring"
    title = "Two masses joined by a spring: reduced mass and drift"
    section = "8.9.4"
    conventions = "x1 and x2 along a smooth straight rail; the spring has its natural length at x2 - x1 = l."
    x1 = Coordinate("m", 0, typical(-3, 3))
    x2 = Coordinate("m", "1.3", typical(-3, 3))
    v1 = Coordinate("m/s", 0, typical(-3, 3))
    v2 = Coordinate("m/s", "0.5", typical(-3, 3))
    m1 = Parameter("kg", 1, "mass 1", positive())
    m2 = Parameter("kg", 2, "mass 2", positive())
    k = Parameter("N/m", 30, "stiffness of the spring", positive(0.1, 100))
    l = Parameter("m", 1, "natural length of the spring", nonnegative(0, 3))
    exact_motion = bind(lambda c: SpringPair(c.m1, c.m2, c.k, (c.l,), (Fraction(0),), ((c.x1, c.x2),), ((c.v1, c.v2),)))
    default_span = Span(10.37, "turn")
    variants = (
        Variant("stiff", "k = 1e10 N/m and a slow drift: 1e6 vibrations in the span", {"k": 10**10}, span="51.7"),
        Variant("mass_ratio", "m2/m1 = 1e9: the heavy mass moves by 1e-9 of the light one", {"m2": 10**9}),
        Variant("long_1e5", "100,000 periods: phase error beside a drift of 3e4 m", periods=100_000.37),
    )
    invariants = conserved(energy=line_energy, momentum=line_momentum, centre_of_mass_start=line_centre_start)
    forms = (SecondOrder(spring_on_a_line),)
    scene = ON_A_LINE

    @property
    def time_scale(self) -> float:
        """sqrt(reduced mass/k)."""
        return sqrt(float(self.exact_motion.reduced / self.exact_motion.k))

    def derived(self, digits: int) -> dict[str, Any]:
        vibration = self.exact_motion.vibration(0)
        return {
            "period": vibration.period(digits),
            "amplitude": vibration.amplitude(digits),
            "drift_speed": self.exact_motion.centre(0)[1],
        }


THROWN = attracting(lambda p: p[1:3], lambda r, p: p[3] / (p[1] * p[2]), (0, 2), lambda p: p[0])


def _thrown(c: "CenterOfMassMotion") -> SpringPair:
    zero = Fraction(0)
    speeds = (c.vx1, c.vx2), (c.vy1, c.vy2)
    return SpringPair(c.m1, c.m2, c.k, (zero, zero), (zero, -c.g), ((c.x1, c.x2), (c.y1, c.y2)), speeds)


class CenterOfMassMotion(Case):
    """Two masses joined by a spring of natural length zero, thrown in a vertical plane."""

    name = "center_of_mass_motion"
    title = "Two masses on a spring, thrown: parabola of the centre of mass and vibration about it"
    section = "8.2, 8.4"
    conventions = "y upward; the spring's natural length is zero, so the pair vibrates harmonically in both directions."
    x1 = Coordinate("m", 0, typical(-3, 3))
    y1 = Coordinate("m", 0, typical(-3, 3))
    x2 = Coordinate("m", "0.4", typical(-3, 3))
    y2 = Coordinate("m", 0, typical(-3, 3))
    vx1 = Coordinate("m/s", 3, typical(-3, 3))
    vy1 = Coordinate("m/s", 10, typical(-3, 3))
    vx2 = Coordinate("m/s", 3, typical(-3, 3))
    vy2 = Coordinate("m/s", 12, typical(-3, 3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", nonnegative())
    m1 = Parameter("kg", 1, "mass 1", positive())
    m2 = Parameter("kg", 2, "mass 2", positive())
    k = Parameter("N/m", 400, "stiffness of the spring", positive(1, 100))
    exact_motion = bind(_thrown)
    default_span = Span(10.37, "turn")
    variants = (
        Variant("stiff", "k = 1e10 N/m inside a slow parabola: 3.6e4 vibrations", {"k": 10**10}, span="1.87"),
        Variant("unequal", "m2/m1 = 1e-9: almost only the light mass vibrates", {"m2": "1e-9"}),
        Variant("long_1e5", "100,000 periods: phase error beside a fall of 3e9 m", periods=100_000.37),
    )
    invariants = conserved(
        energy=thrown_energy,
        momentum_x=thrown_momentum_x,
        momentum_y_and_weight=thrown_momentum_y,
        centre_of_mass_start_x=thrown_centre_x,
        centre_of_mass_start_y=thrown_centre_y,
        spin=spin,
    )
    forms = (SecondOrder(thrown_pair),)
    scene = THROWN
    mirror = ("x1", "x2", "vx1", "vx2")
    alike = (("x1", "y1", "vx1", "vy1", "m1"), ("x2", "y2", "vx2", "vy2", "m2"))

    @property
    def time_scale(self) -> float:
        """sqrt(reduced mass/k)."""
        return sqrt(float(self.exact_motion.reduced / self.exact_motion.k))

    def derived(self, digits: int) -> dict[str, Any]:
        motion, total = self.exact_motion, self.m1 + self.m2
        return {
            "period": motion.vibration(0).period(digits),
            "momentum_x": total * motion.centre(0)[1],
            "momentum_y": total * motion.centre(1)[1],
        }


class DumbbellFreeFlight(Case):
    """Two masses on a massless rigid rod, thrown in a vertical plane."""

    name = "dumbbell_free_flight"
    title = "Dumbbell in free flight: parabola of the centre of mass and uniform rotation"
    section = "8.6, 8.7"
    conventions = (
        "y upward; the state is the position of mass 1 and the angle from the x axis of the rod from mass 1 to mass 2."
    )
    x1 = Coordinate("m", 0, typical(-5, 5))
    y1 = Coordinate("m", 0, typical(-5, 5))
    theta = Coordinate("rad", "0.5", typical(-5, 5))
    vx1 = Coordinate("m/s", 2, typical(-5, 5))
    vy1 = Coordinate("m/s", 8, typical(-5, 5))
    omega = Coordinate("rad/s", 10, typical(-20, 20))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", nonnegative())
    m1 = Parameter("kg", 1, "mass 1", positive())
    m2 = Parameter("kg", 2, "mass 2", positive())
    l = Parameter("m", 1, "length of the rod", positive())
    exact_motion = bind(RodPair, length="l", x="x1", y="y1", vx="vx1", vy="vy1")
    quantity_names = ("tension",)
    """The tension of the rod, which is constant (N)."""
    variants = (
        Variant("fast_spin", "1e5 turns in one flight", initial_state=(0, 0, 0, 2, 8, 314159)),
        Variant("light_end", "mass 1 is 1e-9 of mass 2: mass 1 moves on a circle about mass 2", {"m1": "2e-9"}),
    )
    invariants = conserved(
        energy=dumbbell_energy,
        momentum_x=dumbbell_momentum_x,
        momentum_y_and_weight=dumbbell_momentum_y,
        spin=dumbbell_spin,
    )
    forms = (FirstOrder(dumbbell_equations),)
    scene = ROD
    reversal = ("vx1", "vy1", "omega")

    @property
    def time_scale(self) -> float:
        """The time of one radian; without rotation sqrt(1 m/g), or 1 s."""
        omega, g = abs(float(self.omega)), float(self.g)
        return 1 / max(omega, sqrt(g), 0.1)

    def natural_span(self) -> Number:
        """2.03 s, or 10.37 turns if these take longer."""
        return 2.03 if self.time_scale * 65 < 2.03 or self.omega == 0 else 10.37 * tau * self.time_scale
