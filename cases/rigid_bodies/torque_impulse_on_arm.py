"""A torque impulse on an arm: its rate jumps, its angle does not."""

from __future__ import annotations

from functools import cached_property
from math import sin, sqrt
from typing import Any

from gnomon.cases.core.case import Case, Event, Variant
from gnomon.cases.core.forms import Hybrid, Mode, Transition, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.pendulums.blow_scene import ARM
from gnomon.reference.numerics.precision import Number, publish, working
from gnomon.reference.pendulums.kicked_pendulum import KickedPendulum
from gnomon.reference.pendulums.pendulum_simple import Pendulum


def arm_swings(t: Any, state: Values, parameters: Values) -> Values:
    """theta'' = -(3 g/2 l) sin(theta), for a uniform rod hinged at its end."""
    theta, omega = state
    g, _m, length, _H, _blow = parameters
    return omega, -3 * g / (2 * length) * sin(theta)


def until_the_blow(t: Any, state: Values, parameters: Values) -> Values:
    return (t - parameters[4],)


def arm_is_struck(t: Any, state: Values, parameters: Values) -> Values:
    """I (omega' - omega) = H, I = m l^2/3."""
    theta, omega = state
    _g, m, length, H, _blow = parameters
    return theta, omega + 3 * H / (m * length * length)


def arm_mode(t: Any, state: Values, parameters: Values) -> str:
    return "before" if t < parameters[4] else "after"


class TorqueImpulseOnArm(Case):
    name = "torque_impulse_on_arm"
    title = "Torque impulse on a swinging arm"
    section = "7.3"
    conventions = (
        "A uniform rod hinged at one end in a vertical plane, theta from the downward vertical; at t1 a torque impulse H "
        "acts about the hinge, positive towards growing theta."
    )
    state = (Coordinate("theta", "rad", "angle"), Coordinate("omega", "rad/s", "angular velocity"))
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("m", "kg", 3, "mass of the arm"),
        Parameter("l", "m", 1, "length of the arm"),
        Parameter("H", "N m s", 3, "torque impulse"),
        Parameter("t1", "s", "1.3", "time of the impulse"),
    )
    default_state = ("0.8", 0)
    domain = Domain(
        {
            "g": positive(1.0, 10.0),
            "m": positive(0.5, 3.0),
            "l": positive(0.5, 3.0),
            "H": Range(typical=(-5.0, 5.0)),
            "t1": positive(0.1, 2.0),
            "theta": Range(typical=(-3.0, 3.0)),
            "omega": Range(typical=(-3.0, 3.0)),
        }
    )
    variants = (
        Variant("at_rest", "at rest until the impulse", {"H": 4}, (0, 0)),
        Variant("knocked_over", "swings before the impulse, turns over the top repeatedly after it", {"H": 12}),
        Variant(
            "to_the_top",
            "exactly the energy at the top: an error at the impulse decides on which side the arm ends",
            {"g": "9.8125", "m": 1, "l": "14.71875", "H": "144.427734375"},
            (0, 0),
        ),
        Variant(
            "stopped",
            "passes the bottom when the impulse takes all but 1e-9 of its rate: cancellation",
            {"g": 10, "m": 3, "l": "1.5", "H": "-4.4999999955", "t1": "2e-9"},
            (0, 2),
        ),
        Variant("huge", "the rate jumps by 1e6 rad/s", {"H": 10**6}, span="1.31"),
    )
    autonomous = False
    scene = ARM

    @cached_property
    def _exact(self) -> KickedPendulum:
        g, m, length, H, blow = self.parameter_values()
        return KickedPendulum(Pendulum(g, length * 2 / 3, *self.initial_state), blow, 3 * H / (m * length**2))

    def motion(self) -> KickedPendulum:
        return self._exact

    @property
    def forms(self) -> tuple[Hybrid, ...]:
        return (
            Hybrid(
                modes=(Mode("before", arm_swings), Mode("after", arm_swings)),
                start=arm_mode,
                transitions=(Transition("blow", "before", until_the_blow, 1, arm_is_struck, "after"),),
                settle=1e-9 * self.time_scale,
                terminal=frozenset({"after"}),
            ),
        )

    @property
    def time_scale(self) -> float:
        """sqrt(2 l/3 g), or the time of a radian at the largest rate after the impulse if that is shorter."""
        small = sqrt(float(self._exact.before.length / self._exact.before.g))
        fastest = float(self._exact.after().top_speed())
        return min(small, 1 / fastest) if fastest else small

    def natural_span(self) -> Number:
        """2.37 periods after the impulse; 4 times sqrt(2 l/3 g) if there is no period."""
        after = self._exact.after()
        small = sqrt(float(self._exact.before.length / self._exact.before.g))
        periodic = after.regime in (Pendulum.LIBRATION, Pendulum.ROTATION)
        return float(self._exact.blow) + (2.37 * float(after.period()) if periodic else 4 * small)

    def _listed(self, digits: int) -> tuple[Event, ...]:
        motion = self._exact
        if motion.blow > self.span:
            return ()
        with working(digits + 5) as mp:
            time = publish([mp.mpf(motion.blow)], digits)[0]
        theta, before, after = motion.at_the_blow(digits)
        return (Event(time, "blow", (theta, before), (theta, after)),)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`jump` of the rate, H/I (rad/s); `work` of the impulse, H times the mean of the rates before and after (J)."""
        motion = self._exact
        H, after = self.parameters["H"], motion.after(digits + 60)
        mean = after.omega0 - motion.jump / 2
        return {
            "jump": motion._rational(digits, motion.jump),
            "work": motion._rational(digits, H * mean),
            "amplitude_before": motion.before.amplitude(digits),
            "amplitude_after": after.amplitude(digits),
        }
