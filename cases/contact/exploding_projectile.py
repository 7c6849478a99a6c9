"""A projectile that bursts in flight into two parts."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Event, Invariant, Variant
from gnomon.cases.core.forms import Hybrid, Mode, Transition, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.pendulums.blow_scene import FRAGMENTS
from gnomon.reference.contact.exploding_projectile import Fragments
from gnomon.reference.numerics.precision import Number, publish, working


def fragments_fall(t: Any, state: Values, parameters: Values) -> Values:
    _, _, _, _, vx1, vy1, vx2, vy2 = state
    g = parameters[0]
    return vx1, vy1, vx2, vy2, 0, -g, 0, -g


def until_the_burst(t: Any, state: Values, parameters: Values) -> Values:
    return (t - parameters[3],)


def bursts(t: Any, state: Values, parameters: Values) -> Values:
    """Each part gets a share of the relative velocity, inversely proportional to its mass."""
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    _g, m1, m2, _burst, wx, wy = parameters
    one, two = m2 / (m1 + m2), m1 / (m1 + m2)
    return x1, y1, x2, y2, vx1 - one * wx, vy1 - one * wy, vx2 + two * wx, vy2 + two * wy


def fragments_momentum_x(t: Any, state: Values, parameters: Values) -> Values:
    return (parameters[1] * state[4] + parameters[2] * state[6],)


def fragments_momentum_y(t: Any, state: Values, parameters: Values) -> Values:
    """P_y + (m1 + m2) g t."""
    g, m1, m2, *_ = parameters
    return (m1 * state[5] + m2 * state[7] + (m1 + m2) * g * t,)


def fragments_centre_x(t: Any, state: Values, parameters: Values) -> Values:
    """x_C - v_C t."""
    _g, m1, m2, *_ = parameters
    return ((m1 * (state[0] - state[4] * t) + m2 * (state[2] - state[6] * t)) / (m1 + m2),)


def fragments_centre_y(t: Any, state: Values, parameters: Values) -> Values:
    """y_C - v_C t - g t^2/2."""
    g, m1, m2, *_ = parameters
    return ((m1 * (state[1] - state[5] * t) + m2 * (state[3] - state[7] * t)) / (m1 + m2) - g * t * t / 2,)


def fragments_mode(t: Any, state: Values, parameters: Values) -> str:
    return "whole" if t < parameters[3] else "burst"


def _number(value: Fraction) -> Callable[[Any], Any]:
    return lambda mp: mp.mpf(value)


class ExplodingProjectile(Case):
    name = "exploding_projectile"
    title = "Projectile that bursts in flight: the centre of mass moves on unchanged"
    section = "8.2, 8.4"
    conventions = (
        "y upward; two parts fly together until the burst, at which their relative velocity jumps by (wx, wy)."
    )
    state = tuple(
        Coordinate(f"{letter}{axis}{n}", unit, kind)
        for letter, unit, kind in (("", "m", "length"), ("v", "m/s", "velocity"))
        for n in (1, 2)
        for axis in "xy"
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("m1", "kg", 2, "mass of part 1"),
        Parameter("m2", "kg", 1, "mass of part 2"),
        Parameter("t_burst", "s", "1.3", "time of the burst"),
        Parameter("wx", "m/s", 6, "relative velocity that the burst adds, x"),
        Parameter("wy", "m/s", 15, "relative velocity that the burst adds, y"),
    )
    default_state = (0, 0, 0, 0, 30, 20, 30, 20)
    domain = Domain(
        {
            "g": Range(low=0.0, typical=(0.0, 10.0)),
            "m1": positive(0.5, 5.0),
            "m2": positive(0.5, 5.0),
            "t_burst": positive(0.1, 2.0),
        }
        | {name: Range(typical=(-20.0, 20.0)) for name in ("wx", "wy", "vx1", "vy1", "vx2", "vy2")}
        | {name: Range(typical=(-3.0, 3.0)) for name in ("x1", "y1", "x2", "y2")}
    )
    variants = (
        Variant("splinter", "m2 = 1e-9 kg at 1e5 m/s: part 1 hardly changes its velocity", {"m2": "1e-9", "wx": 10**5}),
        Variant("at_rest", "at rest without gravity: all motion is due to the burst", {"g": 0}, (0,) * 8, span=3),
    )
    autonomous = False
    invariants: ClassVar = {
        "momentum_x": Invariant(fragments_momentum_x),
        "momentum_y_and_weight": Invariant(fragments_momentum_y),
        "centre_of_mass_start_x": Invariant(fragments_centre_x),
        "centre_of_mass_start_y": Invariant(fragments_centre_y),
    }
    scene = FRAGMENTS

    @cached_property
    def _exact(self) -> Fragments:
        g, m1, m2, burst, wx, wy = self.parameter_values()
        x1, y1, x2, y2, u1, w1, u2, w2 = self.initial_state
        return Fragments(g, m1, m2, burst, wx, wy, (x1, y1, x2, y2), (u1, w1, u2, w2))

    def motion(self) -> Fragments:
        return self._exact

    @property
    def forms(self) -> tuple[Hybrid, ...]:
        return (
            Hybrid(
                modes=(Mode("whole", fragments_fall), Mode("burst", fragments_fall)),
                start=fragments_mode,
                transitions=(Transition("burst", "whole", until_the_burst, 1, bursts, "burst"),),
                settle=1e-9 * self.time_scale,
                terminal=frozenset({"burst"}),
            ),
        )

    @property
    def time_scale(self) -> float:
        """The time until the burst."""
        return float(self.parameters["t_burst"])

    def natural_span(self) -> Number:
        """2.87 times the time until the burst."""
        return 2.87 * self.time_scale

    def _listed(self, digits: int) -> tuple[Event, ...]:
        motion = self._exact
        if motion.burst > self.span:
            return ()

        def published(values: tuple[Fraction, ...]) -> tuple[Any, ...]:
            with working(digits + 5) as mp:
                return publish(map(mp.mpf, values), digits)

        states = published(motion.before_the_burst()), published(motion.at(motion.burst))
        return (Event(published((motion.burst,))[0], "burst", *states),)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`apex`: height of the centre of mass above its start, which the burst does not change (m)."""
        motion, (_, vy1, _, vy2) = self._exact, self.initial_state[4:]
        found = {"energy_released": motion.energy_released}
        if motion.g:
            rise = (motion.m1 * vy1 + motion.m2 * vy2) / (motion.m1 + motion.m2)
            found["apex"] = max(rise, Fraction(0)) ** 2 / (2 * motion.g)
        return {name: motion._quantity(digits, _number(value)) for name, value in found.items()}
