"""Two bodies under their mutual attraction, neither of them fixed."""

import numpy as np
from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.cases.orbits.kepler_orbit import KeplerOrbit
from gnomon.cases.scenes.two_masses import attracting
from gnomon.reference.orbits.kepler_orbit import Kepler
from gnomon.reference.orbits.two_body import TwoBody as Motion


def mutual_attraction(t: Any, q: Values, parameters: Values) -> Values:
    """r1'' = G m2 (r2 - r1)/|r2 - r1|^3, and the same with the bodies exchanged."""
    x1, y1, x2, y2 = q
    G, m1, m2 = parameters
    x, y = x2 - x1, y2 - y1
    square = x * x + y * y
    pull = G / (square * sqrt(square))
    return pull * m2 * x, pull * m2 * y, -pull * m1 * x, -pull * m1 * y


def mutual_energy(t: Any, state: Values, parameters: Values) -> Values:
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    G, m1, m2 = parameters
    x, y = x2 - x1, y2 - y1
    kinetic = (m1 * (vx1 * vx1 + vy1 * vy1) + m2 * (vx2 * vx2 + vy2 * vy2)) / 2
    return (kinetic - G * m1 * m2 / sqrt(x * x + y * y),)


def momentum_x(t: Any, state: Values, parameters: Values) -> Values:
    _, m1, m2 = parameters
    return (m1 * state[4] + m2 * state[6],)


def momentum_y(t: Any, state: Values, parameters: Values) -> Values:
    _, m1, m2 = parameters
    return (m1 * state[5] + m2 * state[7],)


def total_angular_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the origin."""
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    _, m1, m2 = parameters
    return (m1 * (x1 * vy1 - y1 * vx1) + m2 * (x2 * vy2 - y2 * vx2),)


def centre_start_x(t: Any, state: Values, parameters: Values) -> Values:
    """x_C - V_C t, constant: the centre of mass moves uniformly."""
    _, m1, m2 = parameters
    return ((m1 * (state[0] - state[4] * t) + m2 * (state[2] - state[6] * t)) / (m1 + m2),)


def centre_start_y(t: Any, state: Values, parameters: Values) -> Values:
    """y_C - V_C t."""
    _, m1, m2 = parameters
    return ((m1 * (state[1] - state[5] * t) + m2 * (state[3] - state[7] * t)) / (m1 + m2),)


def gravitational_masses(parameters: Values) -> Values:
    G, m1, m2 = parameters
    return G * m1, G * m2


def both_bodies(state: Values) -> tuple[Values, ...]:
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    return (x1, y1, 0.0, vx1, vy1, 0.0), (x2, y2, 0.0, vx2, vy2, 0.0)


def both_states(bodies: tuple[Values, ...]) -> Values:
    first, second = bodies
    return first[0], first[1], second[0], second[1], first[3], first[4], second[3], second[4]


def _angular_momentum(n: Mapping[str, Fraction]) -> Fraction:
    x, y, vx, vy = (n[f"{name}2"] - n[f"{name}1"] for name in ("x", "y", "vx", "vy"))
    return x * vy - y * vx


SCENE = attracting(lambda p: p[1:], lambda r, p: p[0] / r**3, (0, 1))


class TwoBody(Case):
    name = "two_body"
    title = "Two-body problem (Kepler's corrected third law)"
    section = "8.3"
    conventions = "A plane motion; errors of each body's position and velocity are relative to their own size."
    x1 = Coordinate("m", 0, typical(-0.2, 0.2), group="length of body 1")
    y1 = Coordinate("m", 0, typical(-0.2, 0.2), group="length of body 1")
    x2 = Coordinate("m", 1, typical(0.8, 1.5), group="length of body 2")
    y2 = Coordinate("m", 0, typical(-0.2, 0.2), group="length of body 2")
    vx1 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 1")
    vy1 = Coordinate("m/s", "-0.25", typical(-0.2, 0.2), group="velocity of body 1")
    vx2 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 2")
    vy2 = Coordinate("m/s", "0.75", typical(0.5, 1), group="velocity of body 2")
    G = Parameter("m^3/(kg s^2)", 1, "constant of gravitation", positive(0.5, 2))
    m1 = Parameter("kg", 1, "mass of body 1", positive(0.5, 2))
    m2 = Parameter("kg", "0.5", "mass of body 2", positive(0.1, 1))
    rules = (
        Rule(
            "angular momentum about the centre of mass is not zero (else the bodies collide)",
            lambda n: _angular_momentum(n) != 0,
        ),
    )
    exact_motion = bind(Motion, places="x1 y1 x2 y2", velocities="vx1 vy1 vx2 vy2")
    default_span = Span(10.37, "period")
    variants = (
        Variant(
            "planet",
            "m2/m1 = 1e-9: the heavy body moves by 1e-9 of the distance, and its error counts relative to that",
            {"m2": "1e-9"},
            (0, 0, 1, 0, 0, 0, 0, "1.2"),
        ),
        Variant("equal", "equal masses about a centre at rest", {"m2": 1}, (0, 0, 1, 0, 0, "-0.5", 0, "0.5")),
        Variant(
            "e0999",
            "e = 0.999: both bodies turn within 3e-5 of a period",
            {"m2": 1},
            (0, 0, 1, 0, 0, "-0.02236", 0, "0.02236"),
        ),
        Variant("hyperbolic", "a flyby that deflects both", initial_state=(0, 0, -10, 1, 0, 0, 2, 0), span=15),
        Variant("orbits_1e5", "100,000 orbits: phase error", periods=100_000.37),
        Variant(
            "drifting",
            "the centre of mass moves at 1e6 m/s: few digits of the state are left for the orbit",
            initial_state=(0, 0, 1, 0, 10**6, "-0.25", 10**6, "0.75"),
        ),
    )
    invariants = conserved(
        energy=mutual_energy,
        momentum_x=momentum_x,
        momentum_y=momentum_y,
        angular_momentum=total_angular_momentum,
        centre_of_mass_start_x=centre_start_x,
        centre_of_mass_start_y=centre_start_y,
    )
    forms = (SecondOrder(mutual_attraction), NBody(gravitational_masses, both_bodies, both_states))
    scene = SCENE
    mirror = ("x1", "y1", "x2", "y2", "vx1", "vy1", "vx2", "vy2")
    alike = (("x1", "y1", "vx1", "vy1", "m1"), ("x2", "y2", "vx2", "vy2", "m2"))

    @property
    def orbit(self) -> Kepler:
        """The motion of body 2 about body 1."""
        return self.exact_motion.relative

    @property
    def time_scale(self) -> float:
        """The period over 2 pi; for an unbound orbit the time of a radian at the pericentre."""
        if self.orbit.conic > 0:
            return float(self.orbit.period()) / (2 * pi)
        return float(self.orbit.pericentre() ** 2) / abs(float(self.orbit.angular_momentum))

    def natural_span(self) -> Number:
        """10.37 periods; an unbound orbit passes its pericentre."""
        if self.orbit.conic > 0:
            return self.periods * float(self.orbit.period())
        return 40 * self.time_scale + 2 * abs(float(self.orbit.pericentre_time()))

    def scales(self) -> dict[str, float]:
        """On a grid, and at the pericentre, where the speeds have a peak narrower than the grid spacing."""
        scales = accuracy.grid_scales(self)
        moment = float(self.orbit.pericentre_time())
        if 0 < moment < self.times[-1]:
            state = self.sample(np.array([moment]))[0]
            for name in scales:
                members = [i for i, coordinate in enumerate(self.state) if coordinate.group == name]
                scales[name] = max(scales[name], float(np.linalg.norm(state[members])))
        return scales

    def derived(self, digits: int) -> dict[str, Any]:
        """`third_law_factor`: T^2 mu1 / (4 pi^2 a^3) with mu1 = G m1, which is 1/(1 + m2/m1); Kepler's law has 1."""
        bound = self.orbit.conic > 0
        return {
            "eccentricity": self.orbit.eccentricity(digits),
            "pericentre": self.orbit.pericentre(digits),
            "third_law_factor": self.exact_motion.share[0],
            "period": self.orbit.period(digits) if bound else None,
            "semi_major_axis": self.orbit.semi_major_axis(digits) if bound else None,
        }

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Body 1 fixed at its initial position: Kepler's third law without the correction."""
        if self.vx1 != 0 or self.vy1 != 0:
            return ()
        G, m1, _ = self.parameter_values()
        orbit = self.orbit
        first = np.array([float(x) for x in self.initial_state])

        def project(states: Floats) -> Floats:
            both = np.tile(first, (len(states), 1))
            both[:, 2:4] = first[0:2] + states[:, :2]
            both[:, 6:8] = states[:, 2:]
            return both

        start = (orbit.x, orbit.y, orbit.vx, orbit.vy)
        return (
            Level(KeplerOrbit(initial_state=start, span=self.span, mu=G * m1), project, "attraction of a fixed body"),
        )
