"""A ball that bounces on a vibrating or accelerated table; the motion is regular or chaotic."""

from gnomon.cases.core.impacts import ImpactCase
from gnomon.cases.declare import *
from gnomon.cases.scenes.impact import TABLE
from gnomon.reference.contact.bouncing_ball_table import VibratingTable
from mpmath import mpf


def over_the_table(t: Any, state: Values, parameters: Values) -> Values:
    """z'' = -g - b + A w^2 sin(w t)."""
    _, u = state
    g, _e, b, A, w = parameters
    return u, A * w * w * sin(w * t) - b - g


def height_over_table(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0],)


def off_the_table(t: Any, state: Values, parameters: Values) -> Values:
    """u -> -e u."""
    _, u = state
    return 0, -parameters[1] * u


def onto_the_table(t: Any, state: Values, parameters: Values) -> Values:
    """The state in which the flight through a given state meets the table, with the mean acceleration."""
    z, u = state
    g, _e, b, _A, _w = parameters
    return 0, -sqrt(u * u + 2 * (g + b) * z)


def ball_mode(t: Any, state: Values, parameters: Values) -> str:
    return "flight"


def _never_lifts(n: Mapping[str, Fraction]) -> bool:
    return n["A"] * n["w"] ** 2 < n["g"] + n["b"]


class BouncingBallTable(ImpactCase):
    name = "bouncing_ball_table"
    title = "Bouncing ball on a vibrating, accelerated table (impacts by certified root finding)"
    section = "8.13"
    conventions = (
        "z is the height above the table, u its rate; the table's position is b t^2/2 + A sin(w t), its acceleration never "
        "below -g, so that each flight ends in one impact. A = 0 is the bouncing ball in the gravity g + b. The motion ends "
        "before an accumulation of impacts."
    )
    z = Coordinate("m", "0.2", nonnegative(0.5, 1))
    u = Coordinate("m/s", 0, typical(-1, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 10))
    e = Parameter("1", "0.8", "coefficient of restitution", Range(0.0, 1.0, low_open=True, typical=(0.7, 1.0)))
    b = Parameter("m/s^2", 0, "constant acceleration of the table, upward", typical(-1, 3))
    A = Parameter("m", "0.01", "amplitude of the table", nonnegative(0, 0.1))
    w = Parameter("rad/s", 30, "frequency of the table", positive(1, 6))
    rules = (
        Rule("A w^2 < g + b (the table never falls faster than the ball)", _never_lifts),
        Rule("the ball is above the table or leaves it (z > 0 or u > 0)", lambda n: n["z"] > 0 or n["u"] > 0),
    )
    exact_motion = bind(lambda c: VibratingTable(c.g + c.b, c.e, c.A, c.w, *c.initial_state))
    default_span = "6.1"
    variants = (
        Variant(
            "accelerating", "a table that accelerates upward with 2 m/s^2: elastic, as in a gravity of 11.81 m/s^2",
            {"e": 1, "b": 2, "A": 0}, (1, 0), "8.3",
        ),
        Variant(
            "chaotic", "e = 1, A w^2 = 0.9 g: errors grow 2.3-fold at each of 34 impacts, 3e12-fold in all",
            {"e": 1, "A": "0.0098", "w": 30}, ("0.05", 0), "5.03",
        ),
        Variant(
            "chaotic_longer", "the same motion through 39 impacts: 14 digits are lost", {"e": 1, "A": "0.0098", "w": 30}, ("0.05", 0), "6.17",
        ),
        Variant("slow_table", "a table that moves at 1 Hz below many short flights", {"e": 1, "A": "0.2", "w": 6}, ("0.02", 0), "5.3"),
        Variant("fast_table", "1e4 rad/s: the table's phase at an impact depends on 1e-5 s", {"e": 1, "A": "5e-8", "w": 10**4}, span="4.1"),
    )  # fmt: skip
    autonomous = False
    scene = TABLE
    forms = (
        Hybrid(
            modes=(Mode("flight", over_the_table),),
            start=ball_mode,
            transitions=(
                Transition("bounce", "flight", height_over_table, -1, off_the_table, "flight", onto_the_table),
            ),
        ),
    )

    @property
    def time_scale(self) -> float:
        """The time of a fall from the start, or of a radian of the table's vibration if that is shorter."""
        (z, u), G = map(float, self.initial_state), float(self.exact_motion.pull)
        fall = sqrt(u * u + 2 * G * z) / G
        return min(fall, 1 / float(self.w)) if self.A else fall

    def natural_span(self) -> Number:
        """1.9 falls if the start is not the default or e < 0.8: then there are few impacts for any restitution."""
        if self.initial_state == tuple(map(Fraction, ("0.2", "0"))) and self.e >= Fraction("0.8"):
            return super().natural_span()
        (z, u), G = map(float, self.initial_state), float(self.exact_motion.pull)
        return 1.9 * (u + sqrt(u * u + 2 * G * z)) / G

    def list_events(self, digits: int) -> tuple[Event, ...]:
        zero = mpf(0)
        return tuple(
            Event(time, "bounce", (zero, before), (zero, after)) for time, before, after in self.impacts(digits)
        )

    def derived(self, digits: int) -> dict[str, Any]:
        """`bounces` within the span; the time of the first; the table's largest relative acceleration A w^2/(g + b)."""
        return {
            "bounces": self.count,
            "relative_push": self.A * self.w**2 / (self.g + self.b),
            "first_impact": self.exact_motion.impact(1, self.span, digits)[0] if self.count else None,
        }
