"""A particle on a smooth surface of revolution with a vertical axis: the azimuth is ignorable.

Cases: ignorable_coordinates (cone), particle_on_paraboloid, particle_on_torus.
"""

from collections.abc import Callable
from functools import cached_property
from math import asin

from gnomon.cases.declare import *
from gnomon.cases.oscillators.well import WellCase
from gnomon.reference.guided.particles_on_surfaces import OnCone, OnParaboloid, OnSurface, OnTorus


def cone_equations(t: Any, state: Values, parameters: Values) -> Values:
    """On a cone of half angle alpha; unrolled, it is a plane with a constant force towards the tip."""
    s, _phi, vs, w = state
    alpha, g = parameters
    flat = sin(alpha) * w
    return vs, w, s * flat * flat - g * cos(alpha), -2 * vs * w / s


def cone_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero at the tip."""
    s, _phi, vs, w = state
    alpha, g = parameters
    across = s * sin(alpha) * w
    return ((vs * vs + across * across) / 2 + g * s * cos(alpha),)


def cone_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the axis over the mass: conjugate to the ignorable azimuth."""
    s, _phi, _vs, w = state
    alpha, _g = parameters
    radius = s * sin(alpha)
    return (radius * radius * w,)


def paraboloid_equations(t: Any, state: Values, parameters: Values) -> Values:
    """On z = r^2/(2 p)."""
    r, _phi, vr, w = state
    p, g = parameters
    slope = r / p
    return vr, w, (r * w * w - g * slope - slope * vr * vr / p) / (1 + slope * slope), -2 * vr * w / r


def paraboloid_energy(t: Any, state: Values, parameters: Values) -> Values:
    r, _phi, vr, w = state
    p, g = parameters
    slope = r / p
    return ((1 + slope * slope) * vr * vr / 2 + r * r * w * w / 2 + g * r * slope / 2,)


def paraboloid_momentum(t: Any, state: Values, parameters: Values) -> Values:
    r, _phi, _vr, w = state
    return (r * r * w,)


def torus_equations(t: Any, state: Values, parameters: Values) -> Values:
    """theta around the tube: 0 on the outer side, -pi/2 at the bottom."""
    theta, _phi, rate, w = state
    ring, tube, g = parameters
    sine, cosine = sin(theta), cos(theta)
    radius = ring + tube * cosine
    return rate, w, -(radius * sine * w * w + g * cosine) / tube, 2 * tube * sine * rate * w / radius


def torus_energy(t: Any, state: Values, parameters: Values) -> Values:
    theta, _phi, rate, w = state
    ring, tube, g = parameters
    radius = ring + tube * cos(theta)
    return ((tube * tube * rate * rate + radius * radius * w * w) / 2 + g * tube * sin(theta),)


def torus_momentum(t: Any, state: Values, parameters: Values) -> Values:
    theta, _phi, _rate, w = state
    ring, tube, _g = parameters
    radius = ring + tube * cos(theta)
    return (radius * radius * w,)


def cone_place(s: float, parameters: Values) -> tuple[float, float, float, float]:
    alpha, _g = parameters
    return s * sin(alpha), s * cos(alpha), sin(alpha), cos(alpha)


def paraboloid_place(r: float, parameters: Values) -> tuple[float, float, float, float]:
    p, _g = parameters
    return r, r * r / (2 * p), 1.0, r / p


def torus_place(theta: float, parameters: Values) -> tuple[float, float, float, float]:
    ring, tube, _g = parameters
    sine, cosine = tube * sin(theta), tube * cos(theta)
    return ring + cosine, sine, -sine, cosine


def torus_angle(radius: float, height: float, parameters: Values) -> float:
    """From the height where that determines it best: in a thin tube the distance from the axis has few digits of it."""
    ring, tube, _g = parameters
    if tube * tube > 2 * height * height:
        return asin(height / tube) if radius > ring else -pi - asin(height / tube)
    return atan2(height, radius - ring)


Place = Callable[[float, Values], tuple[float, float, float, float]]
"""(x, parameters) -> distance from the axis and height on the meridian, and their derivatives by x."""


def on_surface(place: Place, coordinate: Callable[[float, float, Values], float]) -> SceneForm:
    """A particle on a smooth surface of revolution. Most engines have only planes (token `curved_surface`).

    State (x, phi, x', phi'); `coordinate` gives x from distance and height; g is the last parameter.
    """

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        x, phi, rate, w = state
        radius, height, out, up = place(x, parameters)
        c, s = cos(phi), sin(phi)
        velocity = (out * rate * c - radius * w * s, out * rate * s + radius * w * c, up * rate)
        particle = Body("particle", 1.0, (0.0, 0.0, 0.0), (radius * c, radius * s, height), velocity=velocity)
        return Scene((0.0, 0.0, -parameters[-1]), (particle,))

    def observe(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
        (px, py, pz), _, (vx, vy, vz), _ = readings.bodies["particle"]
        radius = hypot(px, py)
        x = coordinate(radius, pz, parameters)
        _, _, out, up = place(x, parameters)
        outward = (px * vx + py * vy) / radius
        rate = (out * outward + up * vz) / (out * out + up * up)
        return x, atan2(py, px), rate, (px * vy - py * vx) / radius**2

    return SceneForm(build, observe, frozenset({"curved_surface"}), conservative=False)


CONE_SCENE = on_surface(cone_place, lambda radius, height, parameters: hypot(radius, height))
PARABOLOID_SCENE = on_surface(paraboloid_place, lambda radius, height, parameters: radius)
TORUS_SCENE = on_surface(torus_place, torus_angle)
ROUND = Rule("the particle moves round the axis (w is not 0, else it meets the tip or the axis)", lambda n: n["w"] != 0)


class _OnSurface(WellCase):
    """One coordinate along the meridian, the azimuth phi, and their rates."""

    exact_motion: OnSurface
    section = "11.10.1-11.10.2"

    @cached_property
    def time_scale(self) -> float:  # type: ignore[override]
        """The period over 2 pi, or the time of a radian of the azimuth closest to the axis if that is shorter."""
        fastest = float(self.exact_motion.fastest_turn())
        turn = 1 / fastest if fastest else inf
        return turn if self.exact_motion.rests else min(turn, float(self.exact_motion.period()) / tau)

    def natural_span(self) -> Number:
        """5.37 periods; on a parallel circle 5.37 turns."""
        return self.periods * (tau * self.time_scale if self.exact_motion.rests else float(self.exact_motion.period()))

    def derived(self, digits: int) -> dict[str, Any]:
        """`apsidal_angle`: the growth of phi from the least to the largest distance (rad)."""
        named = {"momentum": self.exact_motion.momentum(digits)}
        return named if self.exact_motion.rests else named | {"apsidal_angle": self.exact_motion.apsidal_angle(digits)}


class ParticleOnCone(_OnSurface):
    name = "ignorable_coordinates"
    title = "Particle in a smooth cone: the azimuth is ignorable"
    conventions = "s from the tip along the wall, phi about the vertical axis, alpha between axis and wall."
    s = Coordinate("m", 1, positive(1, 2))
    phi = Coordinate("rad", 0, typical(-3, 3))
    vs = Coordinate("m/s", 0, typical(-0.5, 0.5))
    w = Coordinate("rad/s", 5, typical(2, 5))
    alpha = Parameter("rad", "0.5", "half angle of the cone", Range(0.0, pi / 2, True, True, (0.3, 1.2)))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 12))
    rules = (ROUND,)
    exact_motion = bind(OnCone, x="s", rate="vs", spin="w")
    variants = (
        Variant(
            "near_tip",
            "comes within a few per cent of the tip: the azimuth changes fast",
            initial_state=(1, 0, 0, "0.5"),
        ),
        Variant("parallel", "close to a parallel circle: a small radial vibration", initial_state=(1, 0, 0, "6.1201")),
        Variant("flat", "a cone that is almost a plane: the force towards the tip is weak", {"alpha": "1.5607963"}),
        Variant("long_1e4", "10,000 periods: phase errors of both coordinates", periods=10000.37),
    )
    invariants = conserved(energy=cone_energy, angular_momentum=cone_momentum)
    forms = (FirstOrder(cone_equations),)
    scene = CONE_SCENE
    reversal = ("vs", "w")

    def derived(self, digits: int) -> dict[str, Any]:
        """The rate of the parallel circle at the start's height, and the frequency of radial vibrations about it (rad/s)."""

        def rate(mp: Any) -> Any:
            alpha = mp.mpf(self.alpha)
            return mp.sqrt(mp.mpf(self.g) * mp.cos(alpha) / mp.mpf(self.s)) / mp.sin(alpha)

        def vibration(mp: Any) -> Any:
            return mp.sqrt(3) * mp.sin(mp.mpf(self.alpha)) * rate(mp)

        return super().derived(digits) | {"circle_rate": rate, "circle_vibration": vibration}


class ParticleOnParaboloid(_OnSurface):
    name = "particle_on_paraboloid"
    title = "Particle in a smooth paraboloid: the azimuth is ignorable"
    conventions = "r from the vertical axis, phi about it; the surface is z = r^2/(2 p)."
    r = Coordinate("m", 1, positive(1, 2))
    phi = Coordinate("rad", 0, typical(-3, 3))
    vr = Coordinate("m/s", "0.5", typical(-0.5, 0.5))
    w = Coordinate("rad/s", 2, typical(2, 5))
    p = Parameter("m", 1, "radius of curvature at the bottom", positive(0.5, 2))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 12))
    rules = (ROUND,)
    exact_motion = bind(OnParaboloid, x="r", rate="vr", spin="w")
    variants = (
        Variant(
            "near_axis",
            "passes the bottom at a few per cent of its largest radius: the azimuth changes fast",
            initial_state=(1, 0, 0, "0.2"),
        ),
        Variant("circle", "exactly a parallel circle, whose rate is sqrt(g/p) at any height", {"g": 9}, (2, 0, 0, 3)),
        Variant("long_1e4", "10,000 periods: phase errors of both coordinates", periods=10000.37),
    )
    invariants = conserved(energy=paraboloid_energy, angular_momentum=paraboloid_momentum)
    forms = (FirstOrder(paraboloid_equations),)
    scene = PARABOLOID_SCENE
    reversal = ("vr", "w")

    def derived(self, digits: int) -> dict[str, Any]:
        return super().derived(digits) | {"circle_rate": lambda mp: mp.sqrt(mp.mpf(self.g / self.p))}


def _swings(n: Mapping[str, Fraction]) -> bool:
    return bool(ParticleOnTorus.motion_of(n).swings)


class ParticleOnTorus(_OnSurface):
    name = "particle_on_torus"
    title = "Particle in a smooth ring tube: the azimuth is ignorable"
    conventions = (
        "theta around the tube, 0 on the outer side, -pi/2 at the bottom; phi about the vertical axis; R the radius of "
        "the ring's middle circle, a of the tube. The surface holds the particle on both sides."
    )
    theta = Coordinate("rad", "-0.6", Range(-pi, pi / 2, True, True, (-1.2, -0.2)), group="angle around the tube")
    phi = Coordinate("rad", 0, typical(-3, 3))
    rate = Coordinate("rad/s", "1.5", typical(-1, 1))
    w = Coordinate("rad/s", "1.2", typical(0.5, 2.5))
    R = Parameter("m", 2, "radius of the ring's middle circle", positive(1.5, 3))
    a = Parameter("m", "0.5", "radius of the tube", positive(0.3, 0.8))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 12))
    rules = (
        Rule("the ring has a hole, a < R", lambda n: n["a"] < n["R"]),
        Rule("the particle swings: it is too slow to pass the top or the innermost circle", _swings),
    )
    exact_motion = bind(OnTorus, x="theta", spin="w")
    variants = (
        Variant("inner", "climbs to the inner side, where the azimuth turns fastest", initial_state=("-2.4", 0, 0, 2)),
        Variant("plane", "no motion about the axis: a pendulum in the tube", initial_state=("-0.1", 0, 0, 0)),
        Variant(
            "fast", "fast about the axis: a small vibration about the outer side", initial_state=("-0.1", 0, 0, 30)
        ),
        Variant("thin", "a thin tube, a = 1e-4 R: 420 swings in a turn", {"a": "2e-4"}, ("-0.6", 0, 0, "0.5")),
        Variant("long_1e3", "1000 periods: phase errors of both coordinates", periods=1000.37),
        Variant("long_1e4", "10,000 periods: phase errors of both coordinates", periods=10000.37),
    )
    invariants = conserved(energy=torus_energy, angular_momentum=torus_momentum)
    forms = (FirstOrder(torus_equations),)
    scene = TORUS_SCENE
    reversal = ("rate", "w")
