"""A fall through a straight tunnel in a planet of uniform density, and above its surface."""

import math

from gnomon.cases.declare import *
from gnomon.cases.flight.projectile_parabola import ProjectileParabola
from gnomon.cases.oscillators.harmonic_oscillator import HarmonicOscillator
from gnomon.cases.scenes.point import railed_pull
from gnomon.reference.rotating_frames.planet_tunnel import PlanetTunnel
from mpmath import fneg


def tunnel_pull(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = -(g/R) x."""
    g, radius = parameters
    return (-g / radius * q[0],)


def tunnel_potential(t: Any, q: Values, parameters: Values) -> Values:
    g, radius = parameters
    return (g / radius * q[0] * q[0] / 2,)


def in_the_tunnel(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    g, radius = parameters
    return v, -g / radius * x


def above_the_planet(t: Any, state: Values, parameters: Values) -> Values:
    """x'' = -side g R^2/x^2; `side` is a constant of the mode."""
    x, v = state
    g, radius, side = parameters
    return v, -side * g * radius * radius / (x * x)


def upper_end(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - parameters[1],)


def lower_end(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] + parameters[1],)


def at_upper_end(t: Any, state: Values, parameters: Values) -> Values:
    return parameters[1], state[1]


def at_lower_end(t: Any, state: Values, parameters: Values) -> Values:
    return -parameters[1], state[1]


def tunnel_energy(t: Any, state: Values, parameters: Values) -> Values:
    """v^2/2 + g near^2/(2R) - g R^2/far; near and far are the smaller and the larger of |x| and R."""
    x, v = state
    g, radius = parameters
    distance = sqrt(x * x)
    above = sqrt((distance - radius) * (distance - radius))
    near, far = (distance + radius - above) / 2, (distance + radius + above) / 2
    return (v * v / 2 + g * near * near / (2 * radius) - g * radius * radius / far,)


def tunnel_and_outer_pull(t: float, q: Values, parameters: Values) -> Values:
    """The acceleration in all modes, for the force of a scene."""
    (x,), (g, radius) = q, parameters
    return (-g / radius * x,) if abs(x) <= radius else (-math.copysign(g * radius * radius / (x * x), x),)


SCENE = railed_pull(tunnel_and_outer_pull)


def tunnel_mode(t: Any, state: Values, parameters: Values) -> str:
    x, radius = state[0], parameters[1]
    return "above" if x > radius else "below" if x < -radius else "inside"


def below_escape_speed(n: Any) -> bool:
    """Below the escape speed."""
    x = abs(n["x"])
    if x <= n["R"]:
        return bool(n["v"] ** 2 + n["g"] / n["R"] * x**2 < 3 * n["g"] * n["R"])
    return bool(n["v"] ** 2 < 2 * n["g"] * n["R"] ** 2 / x)


class PlanetTunnelCase(Case):
    name = "planet_tunnel"
    title = "Through a planet of uniform density, and above its surface"
    section = "5.8"
    conventions = (
        "x from the centre along a straight tunnel through it; g at the surface; no rotation, no air. The default falls from "
        "1000 km above the surface. At the surface the force is continuous, its slope is not."
    )
    x = Coordinate("m", 7_371_000, typical(-8, 8))
    v = Coordinate("m/s", 0, typical(-3, 3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity at the surface", positive())
    R = Parameter("m", 6_371_000, "radius of the planet", positive(1, 5))
    rules = (
        Rule("the speed is below the escape speed", below_escape_speed),
        Rule(
            "a motion that starts at the surface stays inside (|x| = R only with v = 0)",
            lambda n: abs(n["x"]) != n["R"] or n["v"] == 0,
        ),
    )
    exact_motion = bind(PlanetTunnel)
    variants = (
        Variant("inside", "released at the surface: harmonic, no event", initial_state=(6_371_000, 0)),
        Variant("high", "released at ten radii: short passages between long falls", initial_state=(63_710_000, 0)),
        Variant("thrown_out", "leaves the planet from its centre", initial_state=(0, 10_000)),
        Variant("long_1e5", "100,000 periods inside: phase error", {}, (6_371_000, 0), "506364732"),
    )

    invariants = conserved(energy=tunnel_energy)
    scene = SCENE
    reversal = ("v",)

    @property
    def forms(self) -> tuple[Form, ...]:
        """Without modes if the motion stays inside."""
        if self.exact_motion.inside:
            return (Separable(tunnel_pull, tunnel_potential),)
        return (
            Hybrid(
                modes=(
                    Mode("inside", in_the_tunnel),
                    Mode("above", above_the_planet, (1.0,)),
                    Mode("below", above_the_planet, (-1.0,)),
                ),
                start=tunnel_mode,
                transitions=(
                    Transition("leaves_up", "inside", upper_end, 1, at_upper_end, "above"),
                    Transition("enters_down", "above", upper_end, -1, at_upper_end, "inside"),
                    Transition("leaves_down", "inside", lower_end, -1, at_lower_end, "below"),
                    Transition("enters_up", "below", lower_end, 1, at_lower_end, "inside"),
                ),
            ),
        )

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        x, v = self.initial_state
        g, radius = self.parameter_values()
        side = -1 if x < 0 else 1
        flat = ProjectileParabola(initial_state=(0, side * x, 0, side * v), span=self.span, g=g)
        linear = HarmonicOscillator(initial_state=(x, v), span=self.span, m=radius, k=g)
        uniform = Level(flat, lambda states: side * states[:, [1, 3]], "uniform gravity")
        if self.exact_motion.inside:
            return (uniform,)
        return (uniform, Level(linear, same, "the force inside the planet, used above the surface too"))

    @property
    def time_scale(self) -> float:
        """sqrt(R/g)."""
        return math.sqrt(float(self.R / self.g))

    def natural_span(self) -> Number:
        """10.37 periods; 3.37 if the surface is crossed."""
        return (10.37 if self.exact_motion.inside else 3.37) * float(self.exact_motion.period())

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion, events = self.exact_motion, list[Event]()
        if motion.inside:
            return ()
        self.limit_events(4 * float(self.span) / float(motion.period()))
        ends = {side: motion.number(side * motion.R, digits) for side in (1, -1)}
        speed = motion.surface_speed(digits)
        for time, enters, side in motion.crossings(self.span, digits):
            upward = (side > 0) != enters
            name = ("enters" if enters else "leaves") + ("_up" if upward else "_down")
            there = (ends[side], speed if upward else fneg(speed, exact=True))
            events.append(Event(time, name, there, there))
        return tuple(events)

    def same_course(self, other: Case) -> bool:
        theirs, mine = PlanetTunnel(*other.parameter_values(), *other.initial_state), self.exact_motion
        return theirs.inside == mine.inside and (mine.inside or len(other.events()) == len(self.events()))

    def derived(self, digits: int) -> dict[str, Any]:
        """The period, which inside the planet is 2 pi sqrt(R/g) for a tunnel along any chord, and others."""
        motion = self.exact_motion
        quantities = {"period": motion.period(digits)}
        if motion.inside:
            return quantities
        return quantities | {
            "surface_speed": motion.surface_speed(digits),
            "farthest": motion.number(motion.highest, digits),
        }
