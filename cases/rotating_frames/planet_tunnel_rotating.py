"""Free fall inside a rotating planet: the fullest model in the hierarchy of the tunnel."""

from gnomon.cases.declare import *
from gnomon.cases.flight.projectile_parabola import ProjectileParabola
from gnomon.cases.scenes.point import free_point
from gnomon.reference.rotating_frames.planet_tunnel_rotating import TurningPlanet


def shaft_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = -(g/R) r - 2 Om x r' + Om^2 r."""
    x, y, vx, vy = state
    g, radius, rate = parameters
    pull = rate * rate - g / radius
    return vx, vy, pull * x + 2 * rate * vy, pull * y - 2 * rate * vx


def shaft_matrix(parameters: Values) -> Values:
    g, radius, rate = parameters
    pull, twice = rate * rate - g / radius, 2 * rate
    return 0, 0, 1, 0, 0, 0, 0, 1, pull, 0, 0, twice, 0, pull, -twice, 0


def shaft_load(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0, 0, 0


def shaft_jacobi(t: Any, state: Values, parameters: Values) -> Values:
    """v^2/2 + (g/R - Om^2) r^2/2."""
    x, y, vx, vy = state
    g, radius, rate = parameters
    return ((vx * vx + vy * vy + (g / radius - rate * rate) * (x * x + y * y)) / 2,)


def shaft_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Moment of momentum about the axis in the inertial frame, per unit mass."""
    x, y, vx, vy = state
    rate = parameters[2]
    return (x * vy - y * vx + rate * (x * x + y * y),)


SCENE = free_point(shaft_equations, (0, 1))


def _inside(n: Mapping[str, Fraction]) -> bool:
    return TurningPlanet(n["g"], n["R"], n["Om"], n["x"], n["y"], n["vx"], n["vy"]).inside


class PlanetTunnelRotating(Case):
    name = "planet_tunnel_rotating"
    title = "Free fall inside a rotating planet of uniform density"
    section = "5.8"
    conventions = (
        "x, y from the centre in the plane of the equator, rotating with the planet at Om; g is gravitation at the surface. "
        "No wall holds the body: the shaft is as wide as its path."
    )
    x = Coordinate("m", 6_371_000, typical(-2, 2))
    y = Coordinate("m", 0, typical(-2, 2))
    vx = Coordinate("m/s", 0, typical(-1, 1))
    vy = Coordinate("m/s", 0, typical(-1, 1))
    g = Parameter("m/s^2", "9.81", "gravitation at the surface", positive())
    R = Parameter("m", 6_371_000, "radius of the planet", positive(4, 8))
    Om = Parameter("rad/s", "7.292115e-5", "rate of the planet", typical(-0.3, 0.3))
    rules = (Rule("the body stays inside the planet", _inside),)
    exact_motion = bind(TurningPlanet)
    default_span = Span(10.37, lambda motion: motion.period())
    quantity_names = ("period", "farthest closest=half_axes")
    """`closest`: the least distance from the centre (m)."""
    variants = (
        Variant("day", "24 h: the path turns once", span=86400),
        Variant(
            "break_up",
            "the planet rotates at 0.999 of the rate at which it would fly apart: hardly any force is left",
            {"g": 1, "R": 1, "Om": "0.999"},
            (1, 0, 0, 0),
            2000,
        ),
        Variant("long_1e5", "100,000 periods: phase error", span="506364732"),
    )
    invariants = conserved(jacobi=shaft_jacobi, momentum=shaft_momentum)
    forms = (SemiLinear(shaft_equations, linear=shaft_matrix, rest=shaft_load),)
    scene = SCENE
    reversal = ("vx", "vy", "Om")

    @property
    def time_scale(self) -> float:
        """One radian of the faster of the two circular motions, sqrt(g/R) + |Om|."""
        return 1 / (sqrt(float(self.g) / float(self.R)) + abs(float(self.Om)))

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        x, y, vx, vy = self.initial_state
        still = self.with_numbers(self.initial_state, self.parameters | {"Om": Fraction(0)})
        flat = ProjectileParabola(initial_state=(y, x, vy, vx), span=self.span, g=self.g)

        def as_here(states: Floats) -> Floats:
            return states

        return (
            Level(flat, lambda states: states[:, [1, 0, 3, 2]], "uniform gravity along -x"),
            Level(still, as_here, "the force inside a planet at rest"),
        )
