"""A short pulse of force: what an impulse is the limit of."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from gnomon.cases.case import Case, Event, Variant
from gnomon.cases.forms import Hybrid, Mode, Transition, Values
from gnomon.cases.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.reference.precision import Number, publish, working
from gnomon.reference.pulse import Pulse


def coasting(t: Any, state: Values, parameters: Values) -> Values:
    return state[1], 0


def pushed(t: Any, state: Values, parameters: Values) -> Values:
    """m x'' = 6 J s (T - s)/T^3, s = t - t1."""
    m, impulse, begin, length = parameters
    s = (t - begin) / length
    return state[1], 6 * impulse * s * (1 - s) / (m * length)


def pulse_begin(t: Any, state: Values, parameters: Values) -> Values:
    return (t - parameters[2],)


def pulse_end(t: Any, state: Values, parameters: Values) -> Values:
    return (t - parameters[2] - parameters[3],)


def on_it_goes(t: Any, state: Values, parameters: Values) -> Values:
    return state[0], state[1]


def phase_of_pulse(t: Any, state: Values, parameters: Values) -> str:
    _, _, begin, length = parameters[:4]
    if t < begin:
        return "before"
    return "pulse" if t < begin + length else "after"


class ImpulseInstantaneous(Case):
    """A free mass that a short pulse of given impulse sets in motion."""

    name = "impulse_instantaneous"
    title = "Finite pulse that tends to an impulse"
    section = "7.2, 7.3"
    conventions = "The pulse is a parabola in time of impulse J, from t1 to t1 + T, given by its times; else no force."
    state = (Coordinate("x", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("m", "kg", 2, "mass"),
        Parameter("J", "N s", 3, "impulse"),
        Parameter("t1", "s", "0.7", "begin of the pulse"),
        Parameter("T", "s", "0.1", "length of the pulse"),
    )
    default_state = (0, "0.5")
    domain = Domain(
        {"m": positive(), "J": Range(typical=(-5.0, 5.0)), "t1": positive(0.1, 1.0), "T": positive(0.01, 1.0)}
        | {name: Range(typical=(-3.0, 3.0)) for name in ("x", "v")}
    )
    variants = (
        Variant("short_1e-3", "a pulse of 1 ms between coasts", {"T": "1e-3"}),
        Variant(
            "short_1e-9",
            "a pulse of 1 ns: step-size control that only looks at samples of the force steps over it",
            {"T": "1e-9"},
        ),
        Variant("kick_off", "starts at rest: nothing happens until the pulse", {"T": "1e-6"}, (0, 0)),
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
        return (
            Hybrid(
                modes=(Mode("before", coasting), Mode("pulse", pushed), Mode("after", coasting)),
                start=phase_of_pulse,
                transitions=(
                    Transition("begins", "before", pulse_begin, 1, on_it_goes, "pulse"),
                    Transition("ends", "pulse", pulse_end, 1, on_it_goes, "after"),
                ),
                settle=1e-9 * float(self.parameters["T"]),
                terminal=frozenset({"after"}),
            ),
        )

    @property
    def time_scale(self) -> float:
        """The time until the pulse is over."""
        return float(self.parameters["t1"] + self.parameters["T"])

    @property
    def fastest_time(self) -> float:
        return float(self.parameters["T"])

    def natural_span(self) -> Number:
        return 2.37 * self.time_scale

    def _listed(self, digits: int) -> tuple[Event, ...]:
        found = []
        begin, length = self.parameters["t1"], self.parameters["T"]
        for name, time in (("begins", begin), ("ends", begin + length)):
            if time <= self.span:
                with working(digits + 5) as mp:
                    state = publish(map(mp.mpf, self._exact.at(time)), digits)
                    found.append(Event(publish([mp.mpf(time)], digits)[0], name, state, state))
        return tuple(found)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`late`: by how much the place lags behind that after an instantaneous impulse at t1."""
        motion = self._exact
        lag = motion.impulse / motion.m * motion.length / 2
        return {
            "final_speed": motion._quantity(digits, lambda mp: mp.mpf(motion.v0 + motion.impulse / motion.m)),
            "late": motion._quantity(digits, lambda mp: mp.mpf(lag)),
        }
