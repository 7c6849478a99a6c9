"""The bouncing ball: impacts, and the Zeno limit, the finite time at which infinitely many impacts end."""

from collections.abc import Sequence

from gnomon.cases.core.interface import Between
from gnomon.cases.declare import *
from gnomon.reference.contact.bouncing_ball import BouncingBall as Motion
from mpmath import fneg, mpf


def flight(t: Any, state: Values, parameters: Values) -> Values:
    """y' = v, v' = -g."""
    _, v = state
    g, _ = parameters
    return v, -g


def resting(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def height(t: Any, state: Values, parameters: Values) -> Values:
    y, _ = state
    return (y,)


def gap(t: Any, place: Values, parameters: Values) -> Values:
    return (place[0],)


def upward(t: Any, place: Values, parameters: Values) -> Values:
    return (1,)


def restitution(parameters: Values) -> Values:
    return (parameters[1],)


def rebound(t: Any, state: Values, parameters: Values) -> Values:
    """v -> -e v on the plane."""
    _, v = state
    _, e = parameters
    return 0, -e * v


def come_to_rest(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def impact_state(t: Any, state: Values, parameters: Values) -> Values:
    """The state in which the flight through a given state meets the plane, from its energy."""
    y, v = state
    g, _ = parameters
    return 0, -sqrt(v * v + 2 * g * y)


def energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    y, v = state
    g, _ = parameters
    return (g * y + v * v / 2,)


def first_mode(t: Any, state: Values, parameters: Values) -> str:
    y, v = state
    return "rest" if y == 0 and v == 0 else "flight"


RADIUS = 0.1


def bouncing_ball_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """A sphere of radius 0.1 m above a plane; y is the gap between them."""
    y, v = state
    g, e = parameters
    moment = 2 * RADIUS**2 / 5
    ball = Body("ball", 1.0, (moment, moment, moment), (0.0, 0.0, RADIUS + y), velocity=(0.0, 0.0, v), radius=RADIUS)
    return Scene((0.0, 0.0, -g), (ball,), contacts=(Contact("ball", (0.0, 0.0, 1.0), restitution=e),))


def bouncing_ball_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, _, velocity, _ = readings.bodies["ball"]
    return position[2] - RADIUS, velocity[2]


SCENE = SceneForm(bouncing_ball_scene, bouncing_ball_reading, frozenset({"rigid_impact"}), conservative=False)
"""Not conservative in the sense of SceneForm: at an impact the velocity jumps."""


class BouncingBall(Case):
    """A ball that falls on a horizontal plane and keeps the fraction e of its speed at each impact."""

    name = "bouncing_ball"
    title = "Bouncing ball with restitution, Zeno limit"
    section = "8.13, 7.2.1"
    conventions = "y is the height of the lowest point above the plane; from t_inf on the ball rests at (0, 0)."
    y = Coordinate("m", 1, nonnegative(0, 5))
    v = Coordinate("m/s", 0, typical(-5, 5))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    e = Parameter("1", "0.8", "coefficient of restitution", Range(0.0, 1.0, typical=(0.05, 0.95)))
    rules = (
        Rule(
            "on the plane (y = 0) the ball does not move down (v >= 0)",
            lambda numbers: numbers["y"] > 0 or numbers["v"] >= 0,
        ),
    )
    exact_motion = bind(Motion)
    default_span = Span(10.37, "flight")
    variants = (
        Variant("zeno", "e = 0.999: 20,000 impacts, closer and closer, before the ball rests", {"e": "0.999"}),
        Variant(
            "before_limit",
            "ends 8e-6 s before the Zeno limit; numbers exact in binary, impacts at rational times",
            {"g": 2, "e": "0.75"},
            (1, 0),
            Fraction(7 * 2**17 - 1, 2**17),
        ),
        Variant(
            "elastic", "e = 1: 10,000 impacts without loss; errors of impact times add up", {"e": 1}, periods=10000.37
        ),
        Variant("elastic_1e6", "e = 1: 1,000,000 impacts", {"e": 1}, periods=1000000.37),
        Variant("dead", "e = 0: the first impact is the limit", {"e": 0}),
        Variant("upward", "thrown upward, so that the first event is far away", initial_state=(1, 5)),
        Variant("from_plane", "starts on the plane: the guard is exactly zero at the start", initial_state=(0, 3)),
        Variant("engines_e1", "the parameters of engine tests: elastic, ten impacts", {"e": 1}, span=9),
        Variant("engines_e08", "the parameters of engine tests: e = 0.8, ten impacts", span="3.6"),
    )
    invariants = decaying(energy=energy)
    scene = SCENE
    reversal = ("v",)
    forms = (
        Impact(
            modes=(Mode("flight", flight), Mode("rest", resting)),
            start=first_mode,
            transitions=(Transition("bounce", "flight", height, -1, rebound, "flight", impact_state),),
            terminal=frozenset({"rest"}),
            limits=(("bounce", "rest", come_to_rest),),
            free=flight,
            gap=gap,
            normal=upward,
            restitution=restitution,
        ),
    )

    @property
    def time_scale(self) -> float:
        """The speed of the first impact over g, the time of a fall."""
        return float(self.exact_motion.impact_speed()) / float(self.g) or 1.0

    def natural_span(self) -> Number:
        """1.25 times the limit; for e close to 1 a fixed number of flights."""
        flights = self.periods * 2 * self.time_scale
        if self.exact_motion.rests or self.e == 1:
            return flights
        limit = 1.25 * float(self.exact_motion.limit_time())
        return limit if self.variant == "zeno" else min(limit, 8 * flights)

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """Impacts (`bounce`) up to the last sample or the first gap below `settle`, after which comes `limit`."""
        motion, zero, e = self.exact_motion, mpf(0), self.e
        end = Fraction(float(self.times[-1]))
        impacts = motion.impact_list(Fraction(1e-9 * self.time_scale), end, digits)
        events = []
        before = after = (zero, zero)
        for n, (time, speed) in enumerate(impacts, start=1):
            if n == 1 or e < 1:
                # fneg: a minus sign would round to the caller's precision
                before, after = (zero, fneg(speed, exact=True)), (zero, motion.speed_after(n, digits))
            events.append(Event(time, "bounce", before, after))
        if e < 1 and not motion.rests and motion.impacts(end) is None:
            events.append(Event(motion.limit_time(digits), "limit", (zero, zero), (zero, zero)))
        return tuple(events)

    def between(self, t: float) -> Between:
        """In closed form, also for events that are not listed."""
        motion = self.exact_motion
        if motion.rests:
            return Between(0, mpf(0), mpf("inf"), mpf("inf"))
        past = motion.impacts(Fraction(t))
        if past is None:
            limit = motion.limit_time(20)
            return Between(1, limit, mpf("inf"), limit)
        last, following = motion.impact_time(past, 20) if past else mpf(0), motion.impact_time(past + 1, 20)
        return Between(past, last, following, following - last)

    def event_time(self, n: int, digits: int = 15) -> Any:
        """Time of impact n (s), also of impacts that are not listed."""
        return self.exact_motion.impact_time(n, digits)

    def scales(self) -> dict[str, float]:
        """In closed form: the highest apex and the fastest impact."""
        motion, end = self.exact_motion, Fraction(float(self.times[-1]))
        if motion.rests:
            return {"length": 1.0, "velocity": 1.0}
        apexes = (self.v / self.g, Fraction(float(motion.apex_after(1))))
        times = (Fraction(0), end, *apexes)
        states = [self.exact(t) for t in times if 0 <= t <= end]
        speeds = [abs(v) for _, v in states] + [motion.impact_speed()] * (motion.impacts(end) != 0)
        return {"length": float(max(y for y, _ in states)) or 1.0, "velocity": float(max(speeds)) or 1.0}

    def derived(self, digits: int) -> dict[str, Any]:
        """`bounces`: the number of impacts within the span; infinite if it includes the limit."""
        motion = self.exact_motion
        count = motion.impacts(self.span)
        quantities = {"bounces": mpf(0 if motion.rests else "inf" if count is None else count)}
        if not motion.rests:
            quantities |= {"first_impact": motion.impact_time(1, digits), "impact_speed": motion.impact_speed(digits)}
        if self.e < 1:
            quantities |= {"t_inf": motion.limit_time(digits), "path_length": motion.path_length(digits)}
        elif not motion.rests:
            quantities["period"] = motion.flight_time(1, digits)
        return quantities

    def reversed(self, state: Sequence[Any]) -> tuple[tuple[Any, ...], dict[str, Fraction]] | None:
        return super().reversed(state) if self.e == 1 and state[0] > 0 else None
