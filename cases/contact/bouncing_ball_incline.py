"""The bouncing ball on a smooth incline: infinitely many impacts, after which it slides."""

from functools import cached_property

from gnomon.cases.contact.bouncing_ball import BouncingBall
from gnomon.cases.core.interface import Between
from gnomon.cases.declare import *
from gnomon.cases.scenes.impact import INCLINE
from gnomon.reference.contact.bouncing_ball_incline import BouncingIncline


def incline_flight(t: Any, state: Values, parameters: Values) -> Values:
    _x, _y, vx, vy = state
    along, normal, _e = parameters
    return vx, vy, along, -normal


def incline_slide(t: Any, state: Values, parameters: Values) -> Values:
    _x, _y, vx, _vy = state
    along, _normal, _e = parameters
    return vx, 0, along, 0


def incline_height(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1],)


def incline_gap(t: Any, place: Values, parameters: Values) -> Values:
    return (place[1],)


def incline_normal(t: Any, place: Values, parameters: Values) -> Values:
    return 0, 1


def incline_restitution(parameters: Values) -> Values:
    return (parameters[2],)


def incline_rebound(t: Any, state: Values, parameters: Values) -> Values:
    """v_y -> -e v_y; a smooth incline does not change v_x."""
    x, _y, vx, vy = state
    _along, _normal, e = parameters
    return x, 0, vx, -e * vy


def keep_sliding(t: Any, state: Values, parameters: Values) -> Values:
    x, _y, vx, _vy = state
    return x, 0, vx, 0


def incline_impact(t: Any, state: Values, parameters: Values) -> Values:
    """The state in which the flight through a given state meets the incline."""
    x, y, vx, vy = state
    along, normal, _e = parameters
    speed = sqrt(vy * vy + 2 * normal * y)
    wait = (vy + speed) / normal
    return x + wait * (vx + along * wait / 2), 0, vx + along * wait, -speed


def incline_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    x, y, vx, vy = state
    along, normal, _e = parameters
    return ((vx * vx + vy * vy) / 2 + normal * y - along * x,)


def along_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """vx^2/2 - a x, constant: smooth impacts do not change it."""
    x, _y, vx, _vy = state
    along, _normal, _e = parameters
    return (vx * vx / 2 - along * x,)


def first_incline_mode(t: Any, state: Values, parameters: Values) -> str:
    return "slide" if state[1] == 0 and state[3] == 0 else "flight"


class BouncingBallIncline(Case):
    name = "bouncing_ball_incline"
    title = "Bouncing ball on a smooth incline: Zeno limit, then sliding"
    section = "8.13"
    conventions = (
        "x down the incline, y normal to it; gravity is given by its components g sin(a) along and g cos(a) normal to the "
        "incline, which are exact numbers here. From t_inf on the ball slides."
    )
    x = Coordinate("m", 0)
    y = Coordinate("m", 1, nonnegative(0, 5))
    vx = Coordinate("m/s", 0, typical(-5, 5))
    vy = Coordinate("m/s", 0, typical(-5, 5))
    g_along = Parameter("m/s^2", "4.905", "gravity down the incline (30 degrees)", nonnegative())
    g_across = Parameter("m/s^2", "8.496", "gravity into the incline", positive())
    e = Parameter("1", "0.7", "coefficient of restitution", Range(0.0, 1.0, typical=(0.05, 0.95)))
    rules = (
        Rule("on the incline (y = 0) the ball does not move into it (vy >= 0)", lambda n: n["y"] > 0 or n["vy"] >= 0),
    )
    exact_motion = bind(lambda c: BouncingIncline(c._ball.exact_motion, c.g_along, c.x, c.vx))
    variants = (
        Variant("uphill", "thrown uphill: turns back while it bounces", initial_state=(0, 1, -6, 2)),
        Variant("elastic", "e = 1: ever longer hops, no limit", {"e": 1}),
        Variant("dead", "e = 0: slides from the first impact on", {"e": 0}),
    )
    invariants = decaying(energy=incline_energy) | conserved(along=along_momentum)
    scene = INCLINE
    forms = (
        Impact(
            modes=(Mode("flight", incline_flight), Mode("slide", incline_slide)),
            start=first_incline_mode,
            transitions=(
                Transition("bounce", "flight", incline_height, -1, incline_rebound, "flight", incline_impact),
            ),
            terminal=frozenset({"slide"}),
            limits=(("bounce", "slide", keep_sliding),),
            free=incline_flight,
            gap=incline_gap,
            normal=incline_normal,
            restitution=incline_restitution,
        ),
    )

    @cached_property
    def _ball(self) -> BouncingBall:
        """The motion normal to the incline: a bouncing_ball with the same events."""
        _, y, _, vy = self.initial_state
        return BouncingBall(initial_state=(y, vy), span=self.span, g=self.g_across, e=self.e)

    @property
    def time_scale(self) -> float:
        """The speed of the first impact over gravity normal to the incline, the time of a fall."""
        y, vy = float(self.y), float(self.vy)
        normal = float(self.g_across)
        return sqrt(vy * vy + 2 * normal * y) / normal or 1.0

    def natural_span(self) -> Number:
        """1.25 times the limit, at most 83 falls; 10.37 flights for e = 1."""
        e = float(self.e)
        falls = 20.74 if e == 1 else min(83.0, 1.25 * (2 + 2 * e / (1 - e)))
        return falls * self.time_scale

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """Impacts, and the `limit` after which the ball slides."""
        events = []
        for event in self._ball.events(digits):
            x, vx = self.exact_motion.place(event.time, digits)
            (y, vy), (later, after) = event.before, event.after
            events.append(Event(event.time, event.name, (x, y, vx, vy), (x, later, vx, after)))
        return tuple(events)

    def between(self, t: float) -> Between:
        return self._ball.between(t)

    def event_time(self, n: int, digits: int = 15) -> Any:
        return self._ball.event_time(n, digits)

    def derived(self, digits: int) -> dict[str, Any]:
        """Quantities of the motion normal to the incline; position and speed at which sliding begins."""
        quantities = {k: v for k, v in self._ball.quantities(digits).items() if k != "path_length"}
        if "t_inf" in quantities:
            x, vx = self.exact_motion.place(self._ball.exact_motion.limit_time(2 * digits), digits)
            quantities |= {"slide_x": x, "slide_speed": vx}
        return quantities
