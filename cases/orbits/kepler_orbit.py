"""The Kepler problem in a plane: a central mass and a light body, on any conic."""

from collections.abc import Sequence

import numpy as np
from gnomon.cases.core.formulation import Floats
from gnomon.cases.declare import *
from gnomon.cases.flight.projectile_parabola import ProjectileParabola
from gnomon.reference.orbits.kepler_orbit import Kepler

TURN = 2 * pi


def attraction(t: Any, q: Values, parameters: Values) -> Values:
    """r'' = -mu r / |r|^3."""
    x, y = q
    (mu,) = parameters
    square = x * x + y * y
    pull = -mu / (square * sqrt(square))
    return pull * x, pull * y


def kepler_potential(t: Any, q: Values, parameters: Values) -> Values:
    x, y = q
    (mu,) = parameters
    return (-mu / sqrt(x * x + y * y),)


def kepler_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy per unit mass."""
    x, y, vx, vy = state
    (mu,) = parameters
    return ((vx * vx + vy * vy) / 2 - mu / sqrt(x * x + y * y),)


def angular_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum per unit mass, twice the areal rate."""
    x, y, vx, vy = state
    return (x * vy - y * vx,)


def runge_lenz_x(t: Any, state: Values, parameters: Values) -> Values:
    """The eccentricity vector, x."""
    x, y, vx, vy = state
    (mu,) = parameters
    return (vy * (x * vy - y * vx) / mu - x / sqrt(x * x + y * y),)


def runge_lenz_y(t: Any, state: Values, parameters: Values) -> Values:
    """The eccentricity vector, y."""
    x, y, vx, vy = state
    (mu,) = parameters
    return (-vx * (x * vy - y * vx) / mu - y / sqrt(x * x + y * y),)


def sundman_equations(s: Any, y: Values, parameters: Values) -> Values:
    """d(x, y, vx, vy, t)/ds with dt/ds = r."""
    qx, qy, vx, vy, _clock = y
    (mu,) = parameters
    square = qx * qx + qy * qy
    r = sqrt(square)
    pull = -mu / square
    return r * vx, r * vy, pull * qx, pull * qy, r


def masses(parameters: Values) -> Values:
    """The centre, and a test particle."""
    (mu,) = parameters
    return mu, 0.0


def bodies(state: Values) -> tuple[Values, ...]:
    x, y, vx, vy = state
    return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (x, y, 0.0, vx, vy, 0.0)


def relative(bodies: tuple[Values, ...]) -> Values:
    """The particle relative to the centre."""
    centre, particle = bodies
    return tuple(particle[i] - centre[i] for i in (0, 1, 3, 4))


def with_clock(mp: Any, state: Sequence[Any], parameters: Sequence[Any]) -> tuple[Any, ...]:
    return (*state, mp.mpf(0))


def without_clock(y: Floats, parameters: Sequence[float]) -> Floats:
    return y[..., :4]


def upright(states: Floats) -> Floats:
    """From (horizontal, up) to the axes of this case, where x is up."""
    return states[:, [1, 0, 3, 2]]


def pericentre_start(e: float) -> tuple[Number, ...]:
    """The state at pericentre for a = 1, mu = 1, rounded here to binary64; the case has these rounded numbers."""
    distance = Fraction(str(e))
    return 1 - distance, 0, 0, sqrt((1 + distance) / (1 - distance))


def kepler_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """A free point mass with the attraction as a force."""
    x, y, vx, vy = state
    (mu,) = parameters

    def attraction(t: float, position: Vector, velocity: Vector) -> Vector:
        x, y, _ = position
        factor = -mu / hypot(x, y) ** 3
        return factor * x, factor * y, 0.0

    planet = Body("planet", 1.0, (0.0, 0.0, 0.0), (x, y, 0.0), velocity=(vx, vy, 0.0))
    return Scene((0.0, 0.0, 0.0), (planet,), forces=(Force("planet", "position_force", attraction),))


SCENE = SceneForm(kepler_scene, free_body("planet", 0, 1), frozenset({"position_force"}))


class KeplerOrbit(Case):
    name = "kepler_orbit"
    title = "Kepler orbit"
    section = "7.12, 5.9, 8.3"
    conventions = "The centre is fixed at the origin. Without angular momentum the motion ends before the collision."
    x = Coordinate("m", "0.4", typical(0.5, 2))
    y = Coordinate("m", 0, typical(-0.4, 0.4))
    vx = Coordinate("m/s", 0, typical(-0.5, 0.5))
    vy = Coordinate("m/s", 2, typical(0.5, 2))
    mu = Parameter("m^3/s^2", 1, "gravitational parameter of the centre", positive(0.5, 2))
    rules = (Rule("x^2 + y^2 > 0 (the start is not at the centre)", lambda n: n["x"] != 0 or n["y"] != 0),)
    exact_motion = bind(Kepler)
    turning = Turning((("x", "y"), ("vx", "vy")))
    variants = (
        Variant("e09", "e = 0.9: the pericentre passage is 30 times faster", initial_state=pericentre_start(0.9)),
        Variant("e0999", "e = 0.999: steps must shrink 3e4 times", initial_state=pericentre_start(0.999)),
        Variant(
            "e0999999",
            "e = 0.999999: nearly a collision, steps shrink 1e9 times",
            initial_state=pericentre_start(0.999999),
        ),
        Variant("hyperbolic", "a flyby on a hyperbola", initial_state=(-20, 0.5, 1.5, 0), span=30),
        Variant("parabolic", "exactly the escape speed: no period, alpha = 0", {"mu": 2}, (1, 0, 0, 2), span=100),
        Variant(
            "near_parabolic_bound",
            "1e-12 below the escape speed: an ellipse for which formulas for e < 1 lose digits",
            {"mu": 2},
            (1, 0, 0, 2 * (1 - 1e-12)),
            span=100,
        ),
        Variant(
            "near_parabolic_unbound",
            "1e-12 above the escape speed: a hyperbola for which formulas for e > 1 lose digits",
            {"mu": 2},
            (1, 0, 0, 2 * (1 + 1e-12)),
            span=100,
        ),
        Variant(
            "throw",
            "a throw at the surface of the Earth: an orbit that is nearly a parabola",
            {"mu": "3.986004418e14"},
            (6371000, 0, 300, 400),
            span=61,
        ),
        Variant("plunge", "falls from rest until 0.07 % before the collision", initial_state=(1, 0, 0, 0), span="1.11"),
        # Spans whose 64 samples, rounded to 20 bits, fall on evenly spread phases.
        Variant("orbits_1e3", "1000 orbits: growth of the phase error", span="6285.5"),
        Variant("orbits_1e4", "1e4 orbits: growth of the phase error", span=62833.4375),
        Variant("orbits_1e6", "1e6 orbits: drift by round-off", span=6283192),
        Variant("orbits_1e6_e09", "1e6 orbits at e = 0.9", initial_state=pericentre_start(0.9), span=6283192),
        Variant("engines", "the parameters of the engine tables: 10 orbits at e = 0.6", span=10 * TURN),
        Variant("speed_e06", "the parameters of the timing tables: 100.37 periods at e = 0.6", span=100.37 * TURN),
        Variant(
            "speed_e099",
            "the parameters of the timing tables: 100.37 periods at e = 0.99",
            initial_state=pericentre_start(0.99),
            span=100.37 * TURN,
        ),
    )
    invariants = conserved(
        energy=kepler_energy, angular_momentum=angular_momentum, runge_lenz_x=runge_lenz_x, runge_lenz_y=runge_lenz_y
    )
    forms = (Separable(attraction, kepler_potential), NBody(masses, bodies, relative))
    scene = SCENE
    mirror = ("x", "y", "vx", "vy")
    alike = (("x", "vx"), ("y", "vy"))

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        collision = self.exact_motion.collision_time(20)
        if collision is not None and self.span >= Fraction(float(collision)):
            raise ValueError(
                f"{self.name}: span = {float(self.span):g} s reaches the collision at {float(collision):.10g} s; "
                "give a span that ends before it"
            )

    def scales(self) -> dict[str, float]:
        """Distance and speed are largest at the ends of the span or at an apsis in it."""
        motion = self.exact_motion
        end = float(self.times[-1])
        moments = [0.0, end]
        first = float(motion.pericentre_time())  # for a radial fall the collision, which is after the end
        if 0 < first < end:
            moments.append(first)
        if motion.conic > 0:
            half = float(motion.period()) / 2
            apocentre = first - half if first >= half else first + half
            if apocentre < end:
                moments.append(apocentre)
        states = np.array([[float(value) for value in motion.state(t)] for t in moments])
        return {
            "length": float(np.max(np.hypot(states[:, 0], states[:, 1]))),
            "velocity": float(np.max(np.hypot(states[:, 2], states[:, 3]))),
        }

    @property
    def time_scale(self) -> float:
        """The period over 2 pi; if the span holds no period, the time of one radian at pericentre."""
        motion = self.exact_motion
        if motion.conic > 0 and (motion.period() <= self.span or not motion.angular_momentum):
            return float(motion.period()) / TURN
        if motion.angular_momentum:
            return float(motion.pericentre() ** 2) / abs(float(motion.angular_momentum))
        return sqrt(hypot(*map(float, self.initial_state[:2])) ** 3 / float(self.mu))

    def natural_span(self) -> Number:
        """10.37 periods; an unbound orbit passes its pericentre; a radial fall ends close to the collision."""
        motion = self.exact_motion
        collision = motion.collision_time(20)
        if collision is not None:
            return float(collision) * (1 - 2.0**-10)
        if motion.conic > 0:
            return 10.37 * float(motion.period())
        radian = hypot(*map(float, self.initial_state[:2])) / hypot(*map(float, self.initial_state[2:]))
        return 20 * radian + 2 * abs(float(motion.pericentre_time()))

    @property
    def quantity_names(self) -> tuple[str, ...]:
        motion = self.exact_motion
        period = "collision_time" if motion.conic <= 0 or motion.collision_time() is not None else "period"
        axis = ("semi_major_axis",) if motion.conic else ()
        return ("eccentricity", "semi_latus_rectum", "pericentre", "areal_rate", *axis, period)

    @property
    def formulations(self) -> tuple[Formulation, ...]:
        """Sundman time, dt/ds = r: equal steps in s are short in time at the pericentre."""
        return (
            Formulation(
                "sundman", (FirstOrder(sundman_equations),), with_clock, without_clock, 4, self.exact_motion.sundman
            ),
        )

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Uniform gravity, for a throw from the x axis that is short compared with an orbit."""
        x, y, vx, vy = self.initial_state
        mu = self.mu
        if y != 0 or x <= 0 or self.span**2 * mu > x**3 / 10:
            return ()
        flat = ProjectileParabola(initial_state=(y, x, vy, vx), span=self.span, g=mu / x**2)
        return (Level(flat, upright, "uniform gravity: the parabola"),)
