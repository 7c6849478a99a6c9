"""A flyball governor whose spindle spins freely."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from math import cos, pi, sin
from typing import Any, ClassVar

from gnomon.cases.core.case import Invariant, Variant
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.cases.core.numbers import Domain, Parameter, Range, Rule, positive
from gnomon.cases.guided.free_azimuth import FreeAzimuthCase
from gnomon.cases.guided.pendulum_on_hoop_scene import GOVERNOR
from gnomon.reference.guided.free_azimuth import Governor


def governor_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Lagrange's equations of arms (theta) and spindle (phi)."""
    theta, _phi, rate, spin = state
    g, m, sleeve, length, inertia = parameters
    sine, cosine = sin(theta), cos(theta)
    lift = m * spin * spin * cosine - 2 * sleeve * rate * rate * cosine - (m + sleeve) * g / length
    ball = 2 * m * length * length * sine
    return (
        rate,
        spin,
        sine * lift / (m + 2 * sleeve * sine * sine),
        -2 * ball * cosine * rate * spin / (inertia + ball * sine),
    )


def governor_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy, zero with the arms hanging straight down."""
    theta, _phi, rate, spin = state
    g, m, sleeve, length, inertia = parameters
    sine, half = sin(theta), sin(theta / 2)
    square = length * length
    arms = square * (m + 2 * sleeve * sine * sine) * rate * rate
    turning = (inertia / 2 + m * square * sine * sine) * spin * spin
    return (arms + turning + 4 * (m + sleeve) * g * length * half * half,)


def governor_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """(I + 2 m L^2 sin^2(theta)) phi', the momentum conjugate to the ignorable azimuth."""
    theta, _phi, _rate, spin = state
    _g, m, _sleeve, length, inertia = parameters
    sine = sin(theta)
    return ((inertia + 2 * m * length * length * sine * sine) * spin,)


def _motion(n: Mapping[str, Fraction]) -> Governor:
    names = ("g", "m", "M", "L", "I", "theta", "phi", "rate", "spin")
    return Governor(*(n[name] for name in names))


class EngineeringDesignAnalysis(FreeAzimuthCase):
    """Watt's governor (M = 0), or Porter's with a heavy sleeve, disconnected from the engine."""

    name = "engineering_design_analysis"
    title = "Flyball governor on a free spindle: ignorable azimuth"
    section = "11.12.1"
    conventions = (
        "[inferred] The book names a design analysis; the model is a governor with two arms L from a common pin on the "
        "spindle, a ball m on each, two links of the same length down to a sleeve M, and a spindle and rotor of moment "
        "I. theta from the spindle downward, phi the azimuth; no torque acts about the spindle."
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("m", "kg", 1, "mass of each ball"),
        Parameter("M", "kg", 2, "mass of the sleeve"),
        Parameter("L", "m", "0.25", "length of an arm"),
        Parameter("I", "kg m^2", "0.05", "moment of inertia of spindle and rotor"),
    )
    default_state = ("0.9", 0, 0, 16)
    domain = Domain(
        {
            "g": positive(9.0, 10.0),
            "m": positive(1.0, 2.0),
            "M": Range(low=0.0, typical=(0.0, 2.0)),
            "L": positive(0.25, 0.3),
            "I": positive(0.05, 0.1),
            "theta": Range(low=-pi, high=pi, typical=(0.8, 1.1)),
            "phi": Range(typical=(-3.0, 3.0)),
            "rate": Range(typical=(-0.3, 0.3)),
            "spin": Range(typical=(14.0, 16.0)),
        },
        (Rule("the energy is below that with the arms straight up (the arms swing)", lambda n: _motion(n).swings),),
    )
    variants = (
        Variant("watt", "no sleeve: Watt's governor", {"M": 0}, ("0.9", 0, 0, 9)),
        Variant(
            "steady",
            "the steady angle 1 rad up to rounding: spin^2 = (m + M) g/(m L cos 1)",
            {},
            (1, 0, 0, 14.760691931118897),
        ),
        Variant(
            "heavy_sleeve",
            "M = 1e4 m: lifted only at 800 rad/s, 90 turns in each slow swing of the arms",
            {"M": 10**4},
            ("0.9", 0, 0, 800),
        ),
        Variant(
            "light_spindle",
            "I = 1e-4 kg m^2: the rate doubles each time the arms come in",
            {"I": "1e-4"},
            ("0.9", 0, 0, 9),
        ),
        Variant("slow", "too slow to lift the arms from the spindle: a rotating pendulum", {}, ("0.5", 0, 0, 4)),
        Variant(
            "through",
            "released low with a large rate: swings through the spindle's axis to the other side and back",
            {},
            ("0.2", 0, "-1.5", 12),
        ),
        Variant("long_1e4", "10,000 swings and 16,000 turns: phase errors of both", {}),
    )
    invariants: ClassVar = {"energy": Invariant(governor_energy), "momentum": Invariant(governor_momentum)}
    forms = (FirstOrder(governor_equations),)
    scene = GOVERNOR

    _DRIVEN = "constant spin: a spindle that the arms do not slow"

    @cached_property
    def _exact(self) -> Governor:
        return _motion(self.numbers)
