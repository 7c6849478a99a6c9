"""A ball on a vibrating table that chatters to rest, and leaves the table again when this falls faster than g."""

from functools import cached_property

from gnomon.cases.declare import *
from gnomon.reference.contact.chattering_ball import ChatteringBall as Motion
from mpmath import mpf


def over_the_table(t: Any, state: Values, parameters: Values) -> Values:
    """z'' = A w^2 sin(w t) - g."""
    g, _e, A, w = parameters
    return state[1], A * w * w * sin(w * t) - g


def on_the_table(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def height(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0],)


def lift(t: Any, state: Values, parameters: Values) -> Values:
    """What the table's fall exceeds g by."""
    g, _e, A, w = parameters
    return (A * w * w * sin(w * t) - g,)


def off_the_table(t: Any, state: Values, parameters: Values) -> Values:
    """u -> -e u."""
    return 0, -parameters[1] * state[1]


def onto_the_table(t: Any, state: Values, parameters: Values) -> Values:
    return 0, state[1]


def at_rest(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def in_flight(t: Any, state: Values, parameters: Values) -> str:
    return "rest" if state[0] == 0 and state[1] == 0 else "flight"


class ChatteringBall(Case):
    name = "chattering_ball"
    title = "Ball on a vibrating table: chatters to rest and lifts off again"
    section = "8.13"
    conventions = (
        "[inferred] z is the height above the table, u its rate; the table is at A sin(w t). Each bounce multiplies u by -e; "
        "infinitely many end in rest on the table, from which the ball lifts off when A w^2 sin(w t) grows through g "
        "(Luck and Mehta, Phys. Rev. E 48 (1993) 3988, describe the motion). The numbers are ours."
    )
    z = Coordinate("m", "0.05", nonnegative(0.01, 0.1))
    u = Coordinate("m/s", 0, typical(-0.3, 0.3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(8, 11))
    e = Parameter("1", "0.5", "coefficient of restitution", Range(0.0, 0.9, low_open=True, typical=(0.2, 0.6)))
    A = Parameter("m", "0.03", "amplitude of the table", positive(0.025, 0.04))
    w = Parameter("rad/s", 20, "frequency of the table", positive(15, 22))
    rules = (
        Rule("the ball is above the table or leaves it (z > 0 or u > 0)", lambda n: n["z"] > 0 or n["u"] > 0),
        Rule("A w^2 != g (a table that reaches g exactly releases nothing)", lambda n: n["A"] * n["w"] ** 2 != n["g"]),
    )
    exact_motion = bind(Motion, pull="g", amplitude="A", frequency="w")
    default_span = "1.7"
    variants = (
        Variant(
            "hard_bounces", "e = 0.8, A w^2 = 1.02 g: 101 bounces down to flights of 5e-11 s, then 83 in each turn",
            {"e": "0.8", "A": "0.025"}, span="1.7",
        ),
        Variant("barely_lifts", "A w^2 = 1.0005 g: lifts off by 26 nanometres", {"A": "0.024537"}),
        Variant("held", "A w^2 = 0.98 g: rests for good", {"A": "0.024"}),
        Variant("many", "30 turns: 30 chatters and releases", span="9.7"),
    )  # fmt: skip
    autonomous = False
    forms = (
        Hybrid(
            modes=(Mode("flight", over_the_table), Mode("rest", on_the_table)),
            start=in_flight,
            transitions=(
                Transition("bounce", "flight", height, -1, off_the_table, "flight", onto_the_table),
                Transition("release", "rest", lift, 1, at_rest, "flight"),
            ),
            limits=(("bounce", "rest", at_rest),),
        ),
    )

    @property
    def time_scale(self) -> float:
        """The time of a fall from the start, or of a radian of the table's vibration if that is shorter."""
        z, u, g = float(self.z), float(self.u), float(self.g)
        return min(sqrt(u * u + 2 * g * z) / g, 1 / float(self.w))

    def natural_span(self) -> Number:
        """The fall, and 3.4 turns of the table."""
        z, u, g = float(self.z), float(self.u), float(self.g)
        return (u + sqrt(u * u + 2 * g * z)) / g + 3.4 * 2 * pi / float(self.w)

    @cached_property
    def counts(self) -> list[tuple[int, bool]]:
        """For each bout from a release to the next rest: the bounces that are listed, and whether it ends in rest."""
        return self.exact_motion.counts(self.span, Fraction(1e-9 * self.time_scale))

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """In each bout `bounce` up to the first flight shorter than `settle`, then `limit`; after it `release`."""
        zero, events, motion, end = mpf(0), list[Event](), self.exact_motion, self.span
        for bout, (count, rests) in enumerate(self.counts):
            if bout:
                events.append(Event(motion.release_time(bout, end, digits), "release", (zero, zero), (zero, zero)))
            for n in range(1, count + 1):
                time, before, after = motion.bounce(bout, n, end, digits)
                events.append(Event(time, "bounce", (zero, before), (zero, after)))
            if rests:
                events.append(Event(motion.rest_time(bout, end, digits), "limit", (zero, zero), (zero, zero)))
        return tuple(events)

    def scales(self) -> dict[str, float]:
        """The fastest bounce besides samples."""
        scales = super().scales()
        bounces = [abs(float(event.before[1])) for event in self.events(15)]
        return scales | {"velocity": max([scales["velocity"], *bounces])}

    def same_course(self, other: Case) -> bool:
        return isinstance(other, type(self)) and [c[1] for c in other.counts] == [c[1] for c in self.counts]

    def derived(self, digits: int) -> dict[str, Any]:
        """The first rest, the first release after it, and the table's largest relative acceleration A w^2/g."""
        motion, rests = self.exact_motion, self.counts[0][1]
        return {
            "relative_push": self.A * self.w**2 / self.g,
            "t_inf": motion.rest_time(0, self.span, digits) if rests else None,
            "first_release": motion.release_time(1, self.span, digits) if len(self.counts) > 1 else None,
        }
