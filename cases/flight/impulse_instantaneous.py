"""A short pulse of force, and its limit, an impulse."""

from __future__ import annotations

from functools import cached_property
from math import atan, pi, sin
from typing import Any

from gnomon.cases.core.case import Case, Event, Level, Variant, same
from gnomon.cases.core.forms import Hybrid, Mode, Transition, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.core.point_scene import railed
from gnomon.cases.core.scene import SceneForm
from gnomon.reference.flight.impulse_instantaneous import Pulse
from gnomon.reference.numerics.precision import Number


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
    state = (Coordinate("x", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("m", "kg", 2, "mass"),
        Parameter("J", "N s", 3, "impulse"),
        Parameter("t1", "s", "0.7", "start of the pulse"),
        Parameter("T", "s", "0.1", "length of the pulse"),
    )
    default_state = (0, "0.5")
    domain = Domain(
        {
            "m": positive(),
            "J": Range(typical=(-5.0, 5.0)),
            "t1": positive(0.1, 1.0),
            "T": Range(low=0.0, typical=(0.01, 1.0)),
        }
        | {name: Range(typical=(-3.0, 3.0)) for name in ("x", "v")}
    )
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

    @cached_property
    def _exact(self) -> Pulse:
        m, impulse, begin, length = self.parameter_values()
        x, v = self.initial_state
        return Pulse(m, impulse, begin, length, x, v)

    def motion(self) -> Pulse:
        return self._exact

    @property
    def forms(self) -> tuple[Hybrid, ...]:
        if not self.parameters["T"]:
            return (
                Hybrid(
                    modes=(Mode("before", coasting), Mode("after", coasting)),
                    start=pulse_mode,
                    transitions=(Transition("impulse", "before", pulse_begin, 1, struck, "after"),),
                    settle=1e-9 * self.time_scale,
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
                settle=1e-9 * float(self.parameters["T"]),
                terminal=frozenset({"after"}),
            ),
        )

    @property
    def scene(self) -> SceneForm:
        return PULSE if self.parameters["T"] else AT_ONCE

    @property
    def time_scale(self) -> float:
        """The time until the pulse ends."""
        return float(self.parameters["t1"] + self.parameters["T"])

    @property
    def fastest_time(self) -> float:
        return float(self.parameters["T"]) or self.time_scale

    def natural_span(self) -> Number:
        return 2.37 * self.time_scale

    def _listed(self, digits: int) -> tuple[Event, ...]:
        motion, begin, length = self._exact, self.parameters["t1"], self.parameters["T"]
        if not length:
            before, after = motion.before_the_impulse(digits), self.exact(begin, digits)
            time = motion._rational(digits, begin)
            return (Event(time, "impulse", before, after),) if begin <= self.span else ()  # type: ignore[arg-type]
        found = []
        for name, moment in (("begins", begin), ("ends", begin + length)):
            if moment <= self.span:
                state = self.exact(moment, digits)
                found.append(Event(motion._rational(digits, moment), name, state, state))
        return tuple(found)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`late`: how far the position lags behind that after an instantaneous impulse at t1 (m)."""
        motion = self._exact
        final = motion.v0 + motion.impulse / motion.m
        return {"final_speed": motion._rational(digits, final), "late": motion.lag(digits)}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The instantaneous impulse, whose error is proportional to T."""
        if not self.parameters["T"]:
            return ()
        numbers: dict[str, Any] = dict(self.parameters) | {"T": 0}
        at_once = ImpulseInstantaneous(initial_state=self.initial_state, span=self.span, **numbers)
        return (Level(at_once, same, "an instantaneous impulse"),)


def push(t: float, x: float, parameters: tuple[float, ...]) -> float:
    m, impulse, begin, length = parameters
    rate = pi / length
    return impulse * rate / (2 * m) * sin(rate * (t - begin)) if begin < t < begin + length else 0.0


PULSE = railed(push, "time_force")
AT_ONCE = railed(lambda t, x, parameters: 0.0, "impulse")
