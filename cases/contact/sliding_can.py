"""A chilled can that starts to slide when the air in it has warmed."""

from dataclasses import replace

from gnomon.cases.declare import *
from gnomon.cases.scenes.box import flat_box
from gnomon.reference.contact.sliding_can import SlidingCan
from gnomon.reference.numerics.precision import exact
from mpmath import mpf


def can_slides(t: Any, state: Values, parameters: Values) -> Values:
    """v' = g sin(alpha) - mu_k N/m, N = m g cos(alpha) - P (1 - e^(-t/T))."""
    _s, v = state
    m, g, alpha, _mu_s, mu_k, lift, warming = parameters
    return v, g * sin(alpha) - mu_k * (g * cos(alpha) - lift / m * (1 - exp(-t / warming)))


def can_floats(t: Any, state: Values, parameters: Values) -> Values:
    """v' = g sin(alpha): the air carries the whole weight."""
    _s, v = state
    _m, g, alpha, _mu_s, _mu_k, _lift, _warming = parameters
    return v, g * sin(alpha)


def can_stands(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def grip(t: Any, state: Values, parameters: Values) -> Values:
    """The weight along the slope less the largest static friction."""
    m, g, alpha, mu_s, _mu_k, lift, warming = parameters
    return (m * g * sin(alpha) - mu_s * (m * g * cos(alpha) - lift * (1 - exp(-t / warming))),)


def pressure(t: Any, state: Values, parameters: Values) -> Values:
    """N."""
    m, g, alpha, _mu_s, _mu_k, lift, warming = parameters
    return (m * g * cos(alpha) - lift * (1 - exp(-t / warming)),)


def set_off(t: Any, state: Values, parameters: Values) -> Values:
    return state


def can_mode(t: Any, state: Values, parameters: Values) -> str:
    numbers = [exact(value) for value in (*parameters[:7], *state)]
    return "slide" if SlidingCan(*numbers).slides_first else "stick"


def tilted_gravity(parameters: tuple[float, ...]) -> Vector:
    _m, g, alpha, *_ = parameters
    return g * sin(alpha), 0.0, -g * cos(alpha)


def air_cushion(t: float, s: float, parameters: tuple[float, ...]) -> Vector:
    *_, lift, warming = parameters
    return 0.0, 0.0, lift * (1 - exp(-t / warming))


ONE_FRICTION, TWO_FRICTIONS = (
    flat_box(
        tilted_gravity,
        lambda parameters: parameters[4],
        *more,
        mass=lambda parameters: parameters[0],
        push=air_cushion,
        token="time_force",
    )
    for more in ((), ("static_friction",))
)

LIMIT_BELOW, LIMIT_ABOVE = 0.12992876274052303, 0.12992876274052306
"""The doubles next to m g (cos(alpha) - sin(alpha)/mu_s) on either side, for the default parameters in binary64."""


class SlidingCanCase(Case):
    name = "sliding_can"
    title = "A chilled can, inverted on an incline, slides when its air has warmed"
    section = "5.12.1 (model inferred from the section's title)"
    conventions = (
        "[inferred] s down the slope; the enclosed air, which warms from t = 0, reduces the normal force N by "
        "P (1 - e^(-t/T)). The can slides when m g sin(alpha) = mu_s N; when N = 0 it lifts off, and then "
        "s'' = g sin(alpha)."
    )
    s = Coordinate("m", 0, typical(-1, 1))
    v = Coordinate("m/s", 0, Range(low=0.0, high=0.0, typical=(0.0, 0.0)))
    m = Parameter("kg", "0.02", "mass of the can", positive(0.5, 2))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 15))
    alpha = Parameter("rad", "0.1", "angle of the incline", Range(0.0, pi / 2, low_open=True, typical=(0.05, 0.6)))
    mu_s = Parameter("1", "0.3", "coefficient of static friction", nonnegative(0.1, 0.8))
    mu_k = Parameter("1", "0.25", "coefficient of kinetic friction", nonnegative(0, 0.5))
    P = Parameter("N", "0.17", "final lift of the air, p1 A", positive(0.1, 30))
    T = Parameter("s", 5, "time constant of the warming", positive(0.5, 5))
    rules = (
        Rule("mu_k <= mu_s (friction does not grow when sliding begins)", lambda n: n["mu_k"] <= n["mu_s"]),
        Rule("the can starts at rest (v = 0)", lambda n: n["v"] == 0),
    )
    exact_motion = bind(SlidingCan, mass="m", lift="P", warming="T")
    variants = (
        Variant(
            "late", "P is 1e-5 above the holding limit: slides after 11.6 time constants", {"P": "0.12993"}, span=100
        ),
        Variant("never", "P is just below the holding limit: must not creep", {"P": "0.1299"}, span=60),
        Variant("at_once", "too steep: slides from the start", {"alpha": "0.4"}, span=3),
        Variant("lifts_off", "the air carries the whole weight in the end: two events", {"P": "0.25"}),
        Variant(
            "limit_above",
            "P is the double just above the holding limit: slides after 36 time constants",
            {"m": 0.02, "g": 9.81, "alpha": 0.1, "mu_s": 0.3, "P": LIMIT_ABOVE},
        ),
        Variant(
            "limit_below",
            "P is the double just below the holding limit: must never slide",
            {"m": 0.02, "g": 9.81, "alpha": 0.1, "mu_s": 0.3, "P": LIMIT_BELOW},
            span=200,
        ),
    )
    autonomous = False
    forms = (
        Hybrid(
            modes=(Mode("stick", can_stands), Mode("slide", can_slides), Mode("float", can_floats)),
            start=can_mode,
            transitions=(
                Transition("sets_off", "stick", grip, 1, set_off, "slide"),
                Transition("lifts_off", "slide", pressure, -1, set_off, "float"),
            ),
            terminal=frozenset({"float"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """The time constant of the warming."""
        return float(self.T)

    def natural_span(self) -> Number:
        """0.97 time constants after sliding begins, or half of one after lift-off; 5.1 time constants if it holds."""
        motion = self.exact_motion
        if motion.lifts:
            return float(motion.lift_off()) + 0.47 * self.time_scale
        return 5.1 * self.time_scale if motion.holds else float(motion.onset()) + 0.97 * self.time_scale

    @property
    def scene(self) -> SceneForm:
        """It needs a separate static coefficient only if that decides when sliding begins."""
        motion = self.exact_motion
        slippery = replace(motion, mu_s=motion.mu_k)
        alike = motion.mu_s == motion.mu_k or motion.slides_first or slippery.holds
        return ONE_FRICTION if alike else TWO_FRICTIONS

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion, events = self.exact_motion, list[Event]()
        if not motion.holds and not motion.slides_first and motion.onset(20) <= self.span:
            there = (self.exact(0, digits)[0], mpf(0))
            events.append(Event(motion.onset(digits), "sets_off", there, there))
        if motion.lifts and motion.lift_off(20) <= self.span:
            there = motion.state_at_lift_off(digits)
            events.append(Event(motion.lift_off(digits), "lifts_off", there, there))
        return tuple(events)

    def same_course(self, other: Case) -> bool:
        theirs, mine = SlidingCan(*other.parameter_values(), *other.initial_state), self.exact_motion
        return (theirs.holds, theirs.slides_first, theirs.lifts) == (mine.holds, mine.slides_first, mine.lifts)

    def derived(self, digits: int) -> dict[str, Any]:
        """`holding_lift`: the largest P with which it never slides (N); negative if it slides without any."""
        motion = self.exact_motion
        return {
            "onset": mpf("inf") if motion.holds else motion.onset(digits),
            "holding_lift": motion.holding_lift(digits) if self.mu_s > 0 else None,
            "lift_off": motion.lift_off(digits) if motion.lifts else None,
            "lift_off_speed": motion.state_at_lift_off(digits)[1] if motion.lifts else None,
        }
