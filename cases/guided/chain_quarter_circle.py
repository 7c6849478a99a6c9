"""A chain that slides from a table over a smooth quarter circle to the vertical."""

import math

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed
from gnomon.reference.guided.chain_quarter_circle import ChainQuarter

BELOW, ABOVE = Fraction(math.pi), Fraction(math.nextafter(math.pi, 4))
"""Bounds of pi."""


def front_on_circle(t: Any, state: Values, parameters: Values) -> Values:
    """L s'' = g R (1 - cos(s/R)): the tail is on the table."""
    s, v = state
    g, length, radius = parameters
    return v, g * radius / length * (1 - cos(s / radius))


def front_hanging(t: Any, state: Values, parameters: Values) -> Values:
    """L s'' = g (R + s - pi R/2)."""
    s, v = state
    g, length, radius = parameters
    return v, g / length * (radius + s - 2 * atan(1) * radius)


def tail_on_circle(t: Any, state: Values, parameters: Values) -> Values:
    """L s'' = g (s - pi R/2 + R cos((s - L)/R))."""
    s, v = state
    g, length, radius = parameters
    return v, g / length * (s - 2 * atan(1) * radius + radius * cos((s - length) / radius))


def chain_falling(t: Any, state: Values, parameters: Values) -> Values:
    _s, v = state
    return v, parameters[0]


def above_zero(x: Any) -> Any:
    """max(x, 0) without a branch."""
    return (x + sqrt(x * x)) / 2


def depth_integral(s: Any, radius: Any) -> Any:
    """The integral of the depth below the table along the chain from the edge to s, on the circle and below it."""
    quarter = 2 * atan(1) * radius
    below = above_zero(s - quarter)
    around = above_zero(s) - below
    return radius * (around - radius * sin(around / radius)) + below * (radius + below / 2)


def quarter_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero if the whole chain is on the table."""
    s, v = state
    g, length, radius = parameters
    return (v * v / 2 - g / length * (depth_integral(s, radius) - depth_integral(s - length, radius)),)


def front_left(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - 2 * atan(1) * parameters[2],)


def table_left(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - parameters[1],)


def tail_left(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - parameters[1] - 2 * atan(1) * parameters[2],)


def slides_on(t: Any, state: Values, parameters: Values) -> Values:
    return state[0], state[1]


def quarter_mode(t: Any, state: Values, parameters: Values) -> str:
    return "front_on_circle"


STILL = Fraction(1, 10**30)


def _begins_on_circle(n: Mapping[str, Fraction]) -> bool:
    return n["s"] < BELOW * n["R"] / 2


def _longer_than_circle(n: Mapping[str, Fraction]) -> bool:
    return n["L"] > ABOVE * n["R"] / 2


def _slides(n: Mapping[str, Fraction]) -> bool:
    """Else it lies still, or for longer than 1e15 sqrt(L/g)."""
    return n["s"] >= STILL * n["R"] or n["v"] ** 2 >= STILL**2 * n["g"] * n["R"]


def chain_force(t: float, s: float, parameters: tuple[float, ...]) -> float:
    """The force over the mass, from the depths of front and tail."""
    g, length, radius = parameters
    return g / length * (_depth(s, radius) - _depth(s - length, radius))


SCENE = railed(chain_force)


class ChainQuarterCircle(Case):
    name = "chain_quarter_circle"
    title = "Chain over a smooth quarter circle to the vertical"
    section = "8.12"
    conventions = (
        "s is the distance of the chain's front from the edge of the table, along the curve; the chain is longer than the "
        "quarter circle and guided as in a smooth tube. When front or tail enter or leave the circle the acceleration is "
        "continuous, the third derivative of s is not: these are events."
    )
    s = Coordinate("m", "0.25", nonnegative(0.05, 0.2))
    v = Coordinate("m/s", 0, nonnegative(0, 2))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 10))
    L = Parameter("m", 2, "length of the chain", positive(2, 4))
    R = Parameter("m", "0.5", "radius of the quarter circle", positive(0.2, 1))
    rules = (
        Rule("the chain is longer than the quarter circle: L > pi R/2", _longer_than_circle),
        Rule("the front starts on the quarter circle: s < pi R/2", _begins_on_circle),
        Rule("the front is beyond the edge or moves: s >= 1e-30 R or v >= 1e-30 sqrt(g R)", _slides),
    )
    exact_motion = bind(ChainQuarter, length="L", radius="R")
    variants = (
        Variant("thrown", "starts at the edge with speed", initial_state=(0, 1)),
        Variant("crawls", "released 1e-3 m beyond the edge: the force grows with s^2 from 2e-6 g", {}, ("1e-3", 0)),
        Variant("sharp_edge", "R = 1e-6 m: the limit of the chain off a table's edge", {"R": "1e-6"}, ("1e-6", "0.5")),
        Variant(
            "just_longer",
            "L = 1.00004 pi R/2: almost no part hangs straight when the tail leaves the table",
            {"L": "0.78543"},
        ),
        Variant("long_chain", "L = 1000 m: hangs for a long time before the tail leaves the table", {"L": 1000}),
    )

    invariants = conserved(energy=quarter_energy)
    scene = SCENE
    forms = (
        Hybrid(
            modes=(
                Mode("front_on_circle", front_on_circle),
                Mode("hanging", front_hanging),
                Mode("tail_on_circle", tail_on_circle),
                Mode("falling", chain_falling),
            ),
            start=quarter_mode,
            transitions=(
                Transition("hangs", "front_on_circle", front_left, 1, slides_on, "hanging"),
                Transition("enters", "hanging", table_left, 1, slides_on, "tail_on_circle"),
                Transition("leaves", "tail_on_circle", tail_left, 1, slides_on, "falling"),
            ),
            terminal=frozenset({"falling"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """sqrt(L/g), or the time in which the front passes the circle at its initial speed."""
        g, length, radius = map(float, self.parameter_values())
        speed = float(self.v)
        return min(sqrt(length / g), radius / speed if speed else math.inf)

    def natural_span(self) -> Number:
        """Until the tail has left the circle, and 0.2 sqrt(L/g) more."""
        return float(self.exact_motion.event_times()[2]) + 0.2 * sqrt(float(self.L / self.g))

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """`hangs`, `enters`, `leaves`."""
        motion = self.exact_motion
        rows = zip(
            ("hangs", "enters", "leaves"),
            motion.event_times(digits),
            motion.event_places(digits),
            motion.event_speeds(digits),
            strict=True,
        )
        return tuple(Event(t, name, (s, v), (s, v)) for name, t, s, v in rows if t <= self.span)

    def derived(self, digits: int) -> dict[str, Any]:
        """The time at which the tail leaves the circle, and the speed then."""
        motion = self.exact_motion
        return {"leaving_time": motion.event_times(digits)[2], "leaving_speed": motion.event_speeds(digits)[2]}


def _depth(s: float, radius: float) -> float:
    """Depth of a point of the chain below the table (m)."""
    around = min(max(s, 0.0), math.pi * radius / 2)
    return radius * (1 - cos(around / radius)) + max(s - math.pi * radius / 2, 0.0)
