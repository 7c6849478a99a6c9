"""A short pulse of force, and its limit, an impulse."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed
from gnomon.reference.flight.impulse_instantaneous import Pulse


def coasting(t: Any, state: Values, parameters: Values) -> Values:
    return state[1], 0


def pushed(t: Any, state: Values, parameters: Values) -> Values:
    """m x'' = (pi J/(2 T)) sin(pi (t - t1)/T)."""
    m, impulse, begin, length = parameters
    rate = 4 * atan(1) / length
    return state[1], impulse * rate / (2 * m) * sin(rate * (t - begin))


def pulse_begin(t: Any, state: Values, parameters: Values) -> Values:
    return (t - parameters[2],)


def pulse_end(t: Any, state: Values, parameters: Values) -> Values:
    return (t - parameters[2] - parameters[3],)


def on_it_goes(t: Any, state: Values, parameters: Values) -> Values:
    return state[0], state[1]


def struck(t: Any, state: Values, parameters: Values) -> Values:
    """v -> v + J/m."""
    x, v = state
    m, impulse, _begin, _length = parameters
    return x, v + impulse / m


def pulse_mode(t: Any, state: Values, parameters: Values) -> str:
    _, _, begin, length = parameters[:4]
    if t < begin:
        return "before"
    return "pulse" if t < begin + length else "after"


class ImpulseInstantaneous(Case):
    """A free mass and a short pulse of force with given impulse."""

    name = "impulse_instantaneous"
    title = "Finite pulse that tends to an impulse"
    section = "7.2, 7.3"
    conventions = (
        "The pulse is a half sine in time with impulse J, from t1 to t1 + T; else no force acts. T = 0 is an impulse."
    )
    x = Coordinate("m", 0, typical(-3, 3))
    v = Coordinate("m/s", "0.5", typical(-3, 3))
    m = Parameter("kg", 2, "mass", positive())
    J = Parameter("N s", 3, "impulse", typical(-5, 5))
    t1 = Parameter("s", "0.7", "start of the pulse", positive(0.1, 1))
    T = Parameter("s", "0.1", "length of the pulse", nonnegative(0.01, 1))
    exact_motion = bind(Pulse, impulse="J", begin="t1", length="T")
    default_span = Span(2.37, "time scale")
    quantity_names = ("final_speed", "late=lag")
    """`late`: the lag of the position behind the one after an instantaneous impulse at t1 (m)."""
    variants = (
        Variant("short_1e-3", "a pulse of 1 ms between uniform motions", {"T": "1e-3"}),
        Variant(
            "short_1e-9",
            "a pulse of 1 ns: step-size control can step over it; within it, time has only 7 digits",
            {"T": "1e-9"},
        ),
        Variant("kick_off", "starts at rest: nothing happens until the pulse", {"T": "1e-6"}, (0, 0)),
        Variant("at_once", "T = 0, an impulse: the velocity jumps", {"T": 0}),
    )
    autonomous = False

    @property
    def forms(self) -> tuple[Hybrid, ...]:
        if not self.T:
            return (
                Hybrid(
                    modes=(Mode("before", coasting), Mode("after", coasting)),
                    start=pulse_mode,
                    transitions=(Transition("impulse", "before", pulse_begin, 1, struck, "after"),),
                    terminal=frozenset({"after"}),
                ),
            )
        return (
            Hybrid(
                modes=(Mode("before", coasting), Mode("pulse", pushed), Mode("after", coasting)),
                start=pulse_mode,
                transitions=(
                    Transition("begins", "before", pulse_begin, 1, on_it_goes, "pulse"),
                    Transition("ends", "pulse", pulse_end, 1, on_it_goes, "after"),
                ),
                settle=1e-9 * float(self.T),
                terminal=frozenset({"after"}),
            ),
        )

    @property
    def scene(self) -> SceneForm:
        return PULSE if self.T else AT_ONCE

    @property
    def time_scale(self) -> float:
        """The time until the pulse ends."""
        return float(self.t1 + self.T)

    @property
    def fastest_time(self) -> float:
        return float(self.T) or self.time_scale

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion, begin, length = self.exact_motion, self.t1, self.T
        if not length:
            before, after = motion.before_the_impulse(digits), self.exact(begin, digits)
            time = motion._rational(digits, begin)
            return (Event(time, "impulse", before, after),) if begin <= self.span else ()  # type: ignore[arg-type]
        events = []
        for name, moment in (("begins", begin), ("ends", begin + length)):
            if moment <= self.span:
                state = self.exact(moment, digits)
                events.append(Event(motion._rational(digits, moment), name, state, state))
        return tuple(events)

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The instantaneous impulse, whose error is proportional to T."""
        if not self.T:
            return ()
        return (self.level(ImpulseInstantaneous, "an instantaneous impulse", T=0),)


def push(t: float, x: float, parameters: tuple[float, ...]) -> float:
    m, impulse, begin, length = parameters
    rate = pi / length
    return impulse * rate / (2 * m) * sin(rate * (t - begin)) if begin < t < begin + length else 0.0


PULSE = railed(push, "time_force")
AT_ONCE = railed(lambda t, x, parameters: 0.0, "impulse")
