"""A block on an incline with Coulomb friction: it stops, then holds or slides back."""

import math

from gnomon.cases.declare import *
from gnomon.cases.scenes.box import flat_box
from gnomon.reference.contact.block_incline_friction import BlockIncline, holds
from gnomon.reference.numerics.precision import exact
from mpmath import mpf


def sliding(t: Any, state: Values, parameters: Values) -> Values:
    """s' = v, v' = -g (sin(alpha) + sign mu_k cos(alpha)); the sign of v is a constant of the mode."""
    _, v = state
    g, alpha, mu_k, _, sign = parameters
    return v, -g * (sin(alpha) + sign * mu_k * cos(alpha))


def friction_bounds(t: Any, state: Values, parameters: Values) -> Values:
    g, alpha, mu_k, mu_s = parameters
    return g * mu_k * cos(alpha), g * mu_s * cos(alpha)


def sticking(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def speed(t: Any, state: Values, parameters: Values) -> Values:
    _, v = state
    return (v,)


def standstill(t: Any, state: Values, parameters: Values) -> Values:
    """At rest at the same position."""
    s, _ = state
    return s, 0


def energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    s, v = state
    g, alpha, _, _ = parameters
    return (g * s * sin(alpha) + v * v / 2,)


def mode_after_stop(t: Any, state: Values, parameters: Values) -> str:
    """The block sticks if tan(alpha) <= mu_s.

    Decided exactly for the given numbers: doubles next to tan(alpha) on either side give different motions, and
    `math.tan` is only accurate to an ulp.
    """
    _, alpha, _, mu_s, *_ = parameters
    return "stick" if holds(exact(alpha), exact(mu_s)) else "down"


def first_mode(t: Any, state: Values, parameters: Values) -> str:
    _, v = state
    if v > 0:
        return "up"
    return "down" if v < 0 else mode_after_stop(t, state, parameters)


def tilted_gravity(parameters: tuple[float, ...]) -> Vector:
    """The gravity of a horizontal plane that stands for the incline; the block is a flat box on it."""
    g, alpha, _mu_k, _mu_s = parameters
    return -g * sin(alpha), 0.0, -g * cos(alpha)


SCENE, TWO_COEFFICIENTS = (
    flat_box(tilted_gravity, lambda parameters: parameters[2], *more) for more in ((), ("static_friction",))
)


def scene_of(parameters: tuple[Fraction, ...]) -> SceneForm:
    """The scene needs a separate static coefficient only if that decides whether the block holds."""
    _g, alpha, mu_k, mu_s = parameters
    return TWO_COEFFICIENTS if holds(alpha, mu_s) and not holds(alpha, mu_k) else SCENE


class BlockInclineFriction(Case):
    """A block thrown up an incline, braked by Coulomb friction."""

    name = "block_incline_friction"
    title = "Block thrown up an incline with Coulomb friction: stop, hold or slide back"
    section = "5.11.3, 5.11.4, 7.4.2"
    conventions = "s up the slope; at v = 0 the block sticks if tan(alpha) <= mu_s. 0 <= alpha < pi/2, mu_k <= mu_s."
    s = Coordinate("m", 0, typical(-5, 5))
    v = Coordinate("m/s", 4, typical(-5, 5))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    alpha = Parameter("rad", "0.4", "angle of the incline", Range(0.0, math.pi / 2, typical=(0.0, 1.3)))
    mu_k = Parameter("1", "0.3", "coefficient of kinetic friction", nonnegative(0, 1))
    mu_s = Parameter("1", "0.4", "coefficient of static friction", nonnegative(0, 1.5))
    rules = (Rule("mu_k <= mu_s (friction does not grow when sliding begins)", lambda n: n["mu_k"] <= n["mu_s"]),)
    exact_motion = bind(BlockIncline)
    variants = (
        Variant("holds", "stops and stays: after the event nothing moves", {"mu_s": "0.5"}),
        Variant(
            "limit_above",
            "mu_s is the double just above tan(alpha): holds",
            {"alpha": 0.4, "mu_s": 0.42279321873816184},
        ),
        Variant(
            "limit_below",
            "mu_s is the double just below tan(alpha): slides back",
            {"alpha": 0.4, "mu_s": 0.4227932187381618},
        ),
        Variant(
            "gap",
            "mu_k < tan(alpha) < mu_s: holds, though kinetic friction could not stop a sliding block",
            {"mu_k": "0.1", "mu_s": "0.6"},
        ),
        Variant("rest_slides", "at rest on a slope that is too steep: slides from t = 0", initial_state=(0, 0)),
        Variant("rest_sticks", "at rest on a slope with enough friction: must not creep", {"mu_s": "0.5"}, (0, 0)),
        Variant("thrown_down", "thrown down a slope whose friction stops it", {"mu_k": "0.6", "mu_s": "0.7"}, (0, -4)),
        Variant(
            "end_stop",
            "horizontal, numbers exact in binary: comes to rest exactly at s = 0",
            {"g": 10, "alpha": 0, "mu_k": "0.5", "mu_s": "0.5"},
            (-10, 10),
        ),
        Variant(
            "engines_stop",
            "the parameters of engine tests: horizontal, v0 = 3, stops after v0^2/(2 mu g)",
            {"alpha": 0, "mu_k": "0.3", "mu_s": "0.3"},
            (0, 3),
            "1.28",
        ),
        Variant(
            "engines_slide",
            "the parameters of engine tests: slides down 30 degrees from rest",
            {"alpha": math.radians(30), "mu_k": "0.3", "mu_s": "0.3"},
            (0, 0),
            1,
        ),
        Variant(
            "engines_stick",
            "the parameters of engine tests: holds at 16 degrees, limit 16.7",
            {"alpha": math.radians(16), "mu_k": "0.3", "mu_s": "0.3"},
            (0, 0),
            10,
        ),
    )
    invariants = decaying(energy=energy)
    forms = (
        Friction(
            modes=(Mode("up", sliding, (1.0,)), Mode("down", sliding, (-1.0,)), Mode("stick", sticking)),
            start=first_mode,
            transitions=(
                Transition("stop_up", "up", speed, -1, standstill, mode_after_stop),
                Transition("stop_down", "down", speed, 1, standstill, "stick"),
            ),
            terminal=frozenset({"stick"}),
            sliding=sliding,
            bounds=friction_bounds,
        ),
    )

    @property
    def time_scale(self) -> float:
        """|v0|/g, the time in which gravity changes the velocity by the initial speed; from rest sqrt(1 m/g)."""
        g, v0 = float(self.g), abs(float(self.v))
        return v0 / g or math.sqrt(1 / g)

    def natural_span(self) -> Number:
        """Until after the return to the start, or well after the stop, or ten time scales."""
        motion = self.exact_motion
        if not motion.stops:
            return 10 * self.time_scale
        stop = float(motion.stop_time())
        return min(1.5 * float(motion.return_time()), 10 * stop) if motion.slides_back else 2.5 * stop

    @property
    def scene(self) -> SceneForm:
        return scene_of(self.parameter_values())

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """The stop: `stop_up` or `stop_down`, by the direction of the motion that ends."""
        motion, zero = self.exact_motion, mpf(0)
        if not motion.stops or motion.stop_time(20) > self.span:
            return ()
        there = (motion.stop_position(digits), zero)
        return (Event(motion.stop_time(digits), "stop_up" if motion.v0 > 0 else "stop_down", there, there),)

    def same_course(self, other: Case) -> bool:
        """Half an ulp can decide whether the block sticks or slides."""
        theirs = BlockIncline(*other.parameter_values(), *other.initial_state)
        return (theirs.holds, theirs.stops) == (self.exact_motion.holds, self.exact_motion.stops)

    def scales(self) -> dict[str, float]:
        """In closed form: the extremes are at the start, the stop and the end."""
        times = [
            Fraction(0),
            Fraction(float(self.times[-1])),
            *(Fraction(float(event.time)) for event in self.events()),
        ]
        states = [self.exact(t) for t in times]
        lengths, speeds = (float(max(abs(state[i]) for state in states)) for i in (0, 1))
        return {"length": lengths or 1.0, "velocity": speeds or 1.0}

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """`friction_work`: per unit mass, until the stop (J/kg); `friction_angle`: atan(mu_s) (rad)."""
        motion = self.exact_motion
        stop = ("stop_time", "stop_distance", "stop_position", "friction_work") if motion.stops else ()
        back = ("return_time", "return_speed") if motion.stops and motion.v0 > 0 and motion.slides_back else ()
        return ("friction_angle", *stop, *back)
