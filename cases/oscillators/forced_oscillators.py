"""Linear motion under loads that depend on time: forced vibration, the general equation, a force on a free mass.

Cases: forced_oscillator, second_order_linear_ode, time_varying_force.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cached_property
from math import cos, exp, sin
from typing import Any

from gnomon.cases.core.case import Case, Event, Variant
from gnomon.cases.core.forms import FirstOrder, Form, Hybrid, Mode, SemiLinear, Transition, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.core.point_scene import railed_point
from gnomon.reference.numerics.precision import Number, quantity
from gnomon.reference.oscillators.forced_oscillators import ForcedLinear, SwitchedOff

ZERO = Fraction(0)
LINE = (Coordinate("x", "m", "length"), Coordinate("v", "m/s", "velocity"))


def forced_equations(t: Any, state: Values, parameters: Values) -> Values:
    """x' = v, v' = -(c/m) v - (k/m) x + (F0/m) cos(w t)."""
    x, v = state
    m, c, k, f0, w = parameters
    return v, -(c / m) * v - (k / m) * x + f0 / m * cos(w * t)


def forced_matrix(parameters: Values) -> Values:
    m, c, k, _f0, _w = parameters
    return 0, 1, -k / m, -c / m


def harmonic_force(t: Any, state: Values, parameters: Values) -> Values:
    m, _c, _k, f0, w = parameters
    return 0, f0 / m * cos(w * t)


def linear_times(damping: float, stiffness: float) -> tuple[float, float]:
    """The characteristic and the shortest time of x'' + 2b x' + c x = 0 (s); infinite if b = c = 0."""
    square = damping**2 - stiffness
    if square <= 0:
        natural = 1 / math.sqrt(stiffness) if stiffness else math.inf
        return natural, min(natural, 1 / abs(damping) if damping else math.inf)
    fast = abs(damping) + math.sqrt(square)
    slow = abs(stiffness) / fast
    return 1 / slow if slow and damping > 0 and stiffness > 0 else 1 / fast, 1 / fast


FORCED_SCENE = railed_point(forced_equations, "time_force")


class ForcedOscillator(Case):
    """A mass on a spring with a damper under a harmonic force."""

    name = "forced_oscillator"
    title = "Harmonically forced oscillator: resonance, beats, damped steady state"
    section = "6.6, 6.12"
    conventions = (
        "x from the equilibrium; force F0 cos(w t). Unbalance: F0 = m_e e w^2. For a base that moves by Y cos(w t), x is "
        "relative to it and F0 = m Y w^2."
    )
    state = LINE
    parameter_list = (
        Parameter("m", "kg", 1, "mass"),
        Parameter("c", "N s/m", "0.4", "damping constant"),
        Parameter("k", "N/m", 20, "stiffness of the spring"),
        Parameter("F0", "N", 2, "amplitude of the force"),
        Parameter("w", "rad/s", 3, "frequency of the force"),
    )
    default_state = ("0.5", 0)
    domain = Domain(
        {
            "m": positive(),
            "c": Range(low=0.0, typical=(0.0, 5.0)),
            "k": positive(),
            "w": Range(low=0.0, typical=(0.1, 10.0)),
        }
    )
    autonomous = False
    variants = (
        Variant("resonance", "undamped, w = w0 exactly: the amplitude grows with t", {"c": 0, "k": 9}),
        Variant(
            "near_resonance",
            "w - w0 = 1e-10: a beat of 2000 years, the textbook formula divides by nearly zero",
            {"c": 0, "k": 9, "w": "3.0000000001"},
        ),
        Variant("beats", "w differs from w0 by 1 %: one whole beat", {"c": 0, "k": 9, "w": "3.03"}, (0, 0), "231.7"),
        Variant("long_1e5", "100,000 periods of weakly damped vibration", {"c": "1e-5"}, span="209440.3"),
        Variant("stiff", "rates 1e-3 and 1e6 beside w = 3", {"c": 10**6, "k": 10**3}),
        Variant("critical", "critically damped, exactly", {"c": 4, "k": 4}),
        Variant("engines", "the parameters of engine tests, 10 s", span=10),
        Variant(
            "speed",
            "the parameters of the speed tables: x'' + 0.04 x' + x = 0.5 cos(1.3 t)",
            {"c": "0.04", "k": 1, "F0": "0.5", "w": "1.3"},
            (1, 0),
            200,
        ),
    )
    forms = (SemiLinear(forced_equations, linear=forced_matrix, rest=harmonic_force),)
    scene = FORCED_SCENE
    mirror = ("x", "v", "F0")

    @cached_property
    def _exact(self) -> ForcedLinear:
        m, c, k, f0, w = self.parameter_values()
        return ForcedLinear(c / (2 * m), k / m, ZERO, f0 / m, ZERO, w, ZERO, *self.initial_state)

    def motion(self) -> ForcedLinear:
        return self._exact

    @property
    def _times(self) -> tuple[float, float]:
        m, c, k, _f0, w = map(float, self.parameter_values())
        slow, fast = linear_times(c / (2 * m), k / m)
        driven = 1 / w if w else math.inf
        return min(slow, driven), min(fast, driven)

    @property
    def time_scale(self) -> float:
        """One radian of the force or of the free vibration, whichever is shorter."""
        return self._times[0]

    @property
    def fastest_time(self) -> float:
        return self._times[1]

    def natural_span(self) -> Number:
        """10.37 periods of the force, or of the free vibration if there is no force."""
        w = float(self.parameters["w"])
        return 10.37 * 2 * math.pi * (1 / w if w else self.time_scale)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`transmissibility`: transmitted force over F0; with a moving base, motion over that of the base.

        `unbalance_ratio`: m X/(m_e e); with a moving base, relative motion over that of the base.
        """
        motion = self._exact
        found = {"natural_frequency": motion.natural_rate(digits)}
        if self.parameters["c"] == 0 and motion.stiffness == motion.frequency**2:
            return found
        return found | {
            "steady_amplitude": motion.steady_amplitude(digits),
            "magnification": motion.magnification(digits),
            "phase_lag": motion.phase_lag(digits),
            "transmissibility": motion.transmissibility(digits),
            "unbalance_ratio": motion.unbalance_ratio(digits),
        }


def second_order_linear(t: Any, state: Values, parameters: Values) -> Values:
    """x'' + 2b x' + c x = h0 + h1 e^(rt) cos(pt)."""
    x, v = state
    b, c, h0, h1, r, p = parameters
    return v, h0 + h1 * exp(r * t) * cos(p * t) - 2 * b * v - c * x


def second_order_matrix(parameters: Values) -> Values:
    b, c, _h0, _h1, _r, _p = parameters
    return 0, 1, -c, -2 * b


def second_order_load(t: Any, state: Values, parameters: Values) -> Values:
    _b, _c, h0, h1, r, p = parameters
    return 0, h0 + h1 * exp(r * t) * cos(p * t)


LINEAR_SCENE = railed_point(second_order_linear, "time_force")


class SecondOrderLinearOde(Case):
    name = "second_order_linear_ode"
    title = "The linear equation of second order with constant coefficients"
    section = "6.6"
    conventions = "x'' + 2b x' + c x = h0 + h1 e^(rt) cos(pt): a constant load plus a harmonic and exponential one."
    state = LINE
    parameter_list = (
        Parameter("b", "1/s", "0.3", "half the damping; negative: growth"),
        Parameter("c", "1/s^2", 4, "stiffness over mass; negative: repulsion"),
        Parameter("h0", "m/s^2", "0.5", "constant load over mass"),
        Parameter("h1", "m/s^2", 1, "amplitude of the load over mass"),
        Parameter("r", "1/s", "-0.1", "rate of growth of the load"),
        Parameter("p", "rad/s", 3, "frequency of the load"),
    )
    default_state = (1, 0)
    domain = Domain(
        {
            "b": Range(typical=(-0.2, 3.0)),
            "c": Range(typical=(-2.0, 10.0)),
            "r": Range(typical=(-2.0, 0.1)),
            "p": Range(typical=(-5.0, 5.0)),
        }
    )
    autonomous = False
    variants = (
        Variant("overdamped", "two real rates, 1 and 3", {"b": 2, "c": 3, "r": 0}),
        Variant("critical", "one double rate", {"b": 2, "c": 4, "r": 0}),
        Variant("repulsive", "c < 0: cosh and sinh", {"b": 0, "c": -1, "r": 0, "h1": 0}, (1, "-0.5"), 10),
        Variant(
            "exponential_resonance",
            "the load decays at a rate of the free motion: t e^(-t)",
            {"b": 2, "c": 3, "r": -1, "p": 0},
        ),
        Variant(
            "double_resonance",
            "the load decays at the double rate: t^2 e^(-2t)",
            {"b": 2, "c": 4, "r": -2, "p": 0, "h0": 0},
        ),
        Variant("harmonic_resonance", "undamped, p^2 = c: t sin(2t)", {"b": 0, "r": 0, "p": 2}),
        Variant(
            "damped_resonance",
            "the load is a free vibration of the system: t e^(-t) sin(2t)",
            {"b": 1, "c": 5, "r": -1, "p": 2},
        ),
    )
    forms = (SemiLinear(second_order_linear, linear=second_order_matrix, rest=second_order_load),)
    scene = LINEAR_SCENE

    @cached_property
    def _exact(self) -> ForcedLinear:
        b, c, h0, h1, r, p = self.parameter_values()
        return ForcedLinear(b, c, h0, h1, ZERO, p, r, *self.initial_state)

    def motion(self) -> ForcedLinear:
        return self._exact

    @property
    def time_scale(self) -> float:
        """The shortest time of the free motion and of the load."""
        b, c, _h0, h1, r, p = map(float, self.parameter_values())
        loads = [1 / abs(rate) for rate in (r, p) if rate and h1]
        shortest = min(linear_times(b, c)[1], *loads, math.inf)
        return shortest if shortest < math.inf else 1.0

    def natural_span(self) -> Number:
        """20.7 characteristic times; 5 if the motion or the load grows, so that it grows at most e^5 times."""
        b, c, _h0, _h1, r, _p = map(float, self.parameter_values())
        return (5 if b < 0 or c < 0 or r > 0 else 20.7) * self.time_scale


def driven_mass(t: Any, state: Values, parameters: Values) -> Values:
    """m x'' = e^(-d t) (S sin(w t) + C cos(w t))."""
    _x, v = state
    m, s, c, w, d, _off = parameters
    return v, exp(-d * t) * (s * sin(w * t) + c * cos(w * t)) / m


def coasting_mass(t: Any, state: Values, parameters: Values) -> Values:
    _x, v = state
    return v, 0


def switch_time(t: Any, state: Values, parameters: Values) -> Values:
    off = parameters[5]
    return (t - off,)


def as_before(t: Any, state: Values, parameters: Values) -> Values:
    return state


def switch_mode(t: Any, state: Values, parameters: Values) -> str:
    off = parameters[5]
    return "driven" if t < off else "coasting"


def force_until_off(t: float, state: Values, parameters: Values) -> Values:
    """The force in both modes, for a scene."""
    return (driven_mass if t < parameters[5] else coasting_mass)(t, state, parameters)


SWITCHED_SCENE = railed_point(force_until_off, token="time_force")


class TimeVaryingForce(Case):
    name = "time_varying_force"
    title = "A mass under a force that depends on time, switched off at a given time"
    section = "6.4.1"
    conventions = "m x'' = e^(-dt) (S sin wt + C cos wt) until the time `off`, an event; then uniform motion."
    state = LINE
    parameter_list = (
        Parameter("m", "kg", 1, "mass"),
        Parameter("S", "N", 2, "amplitude of the sine"),
        Parameter("C", "N", 0, "amplitude of the cosine; for w = 0 of the exponential"),
        Parameter("w", "rad/s", 3, "frequency"),
        Parameter("d", "1/s", 0, "rate of decay of the force"),
        Parameter("off", "s", "17.3", "time at which the force ends"),
    )
    default_state = (0, 0)
    domain = Domain(
        {
            "m": positive(),
            "w": Range(typical=(-10.0, 10.0)),
            "d": Range(typical=(0.0, 2.0)),
            "off": Range(low=0.0, low_open=True, typical=(0.5, 20.0)),
        }
    )
    autonomous = False
    variants = (
        Variant(
            "drift",
            "w = 1e6: a step that suits the slow drift F0/(m w) spans 1e5 cycles of the force",
            {"w": 10**6, "off": 10},
            span="0.6283",
        ),
        Variant(
            "exponential", "F0 e^(-t/T): a pulse without end", {"S": 0, "C": 2, "w": 0, "d": 2, "off": 100}, span=10
        ),
        Variant(
            "short_pulse",
            "a half sine of 1e-6 s in a span of 10 s: easily stepped over",
            {"S": 10**6, "w": "3141592.6", "off": "1e-6"},
            (0, 0),
            10,
        ),
        Variant("never_off", "no event within the span: the velocity's mean is not zero", {"off": 100}, span="21.7"),
    )
    scene = SWITCHED_SCENE

    @cached_property
    def _exact(self) -> SwitchedOff:
        m, s, c, w, d, off = self.parameter_values()
        return SwitchedOff(ForcedLinear(ZERO, ZERO, ZERO, c / m, s / m, w, -d, *self.initial_state), off)

    def motion(self) -> SwitchedOff:
        return self._exact

    @property
    def forms(self) -> tuple[Form, ...]:
        """Without modes if the force lasts beyond the span."""
        if self.parameters["off"] > self.span:
            return (FirstOrder(driven_mass),)
        return (
            Hybrid(
                modes=(Mode("driven", driven_mass), Mode("coasting", coasting_mass)),
                start=switch_mode,
                transitions=(Transition("off", "driven", switch_time, 1, as_before, "coasting"),),
                settle=1e-9 * self.time_scale,
                terminal=frozenset({"coasting"}),
            ),
        )

    @property
    def time_scale(self) -> float:
        """One radian of the force, its decay time or its duration, whichever is shortest."""
        w, d, off = (abs(float(self.parameters[name])) for name in ("w", "d", "off"))
        return min([1 / rate for rate in (w, d) if rate] + [off])

    def natural_span(self) -> Number:
        """1.25 times the duration of the force."""
        return 1.25 * float(self.parameters["off"])

    def _listed(self, digits: int) -> tuple[Event, ...]:
        off = self.parameters["off"]
        if off > self.span:
            return ()
        there = self.exact(off, digits)
        return (Event(self._exact.off_time(digits), "off", there, there),)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`impulse` of the force until it ends (N s). `drift`: the mean velocity v0 + S/(m w) under a steady oscillation."""
        found = {
            "final_velocity": self.exact(self.parameters["off"], digits)[1],
            "impulse": self._exact.impulse(self.parameters["m"], digits),
        }
        m, s, _c, w, d, _off = self.parameter_values()
        if d or not w:
            return found
        drift = self.initial_state[1] + s / (m * w)
        return found | {"drift": quantity(digits, lambda mp: mp.mpf(drift))}
