"""A uniform chain on a smooth cycloid: isochronous for every length."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from math import sqrt, tau
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import Separable, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, Rule, positive
from gnomon.cases.core.point_scene import railed
from gnomon.reference.numerics.precision import Number
from gnomon.reference.oscillators.harmonic_oscillator import HarmonicMotion


def chain_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """L s'' = -g (y(s + L/2) - y(s - L/2)) with the cycloid's y(s) = s^2/8a."""
    (s,) = q
    g, a, length = parameters
    front, rear = s + length / 2, s - length / 2
    return (-g * (front * front - rear * rear) / (8 * a * length),)


def chain_potential(t: Any, q: Values, parameters: Values) -> Values:
    (s,) = q
    g, a, _ = parameters
    return (g * s * s / (8 * a),)


def chain_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero at the lowest position."""
    s, v = state
    g, a, _ = parameters
    return (v * v / 2 + g * s * s / (8 * a),)


def _stays_between_cusps(n: Mapping[str, Fraction]) -> bool:
    room = 4 * n["a"] - n["L"] / 2
    return room > 0 and n["s"] ** 2 + 4 * n["a"] * n["v"] ** 2 / n["g"] <= room**2


SCENE = railed(lambda t, s, parameters: float(chain_acceleration(t, (s,), parameters)[0]))


class ChainSmoothCurve(Case):
    name = "chain_smooth_curve"
    title = "Chain on a smooth cycloid (isochronous for every length)"
    section = "8.12"
    conventions = "s: arc length of the chain's middle from the bottom; the cycloid y = s^2/8a has its cusps at s = 4a."
    state = (Coordinate("s", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("a", "m", "0.5", "radius of the rolling circle"),
        Parameter("L", "m", 2, "length of the chain"),
    )
    default_state = ("0.8", 0)
    domain = Domain(
        {
            "g": positive(),
            "a": positive(1.0, 5.0),
            "L": positive(0.1, 4.0),
            "s": Range(typical=(-1.0, 1.0)),
            "v": Range(typical=(-1.0, 1.0)),
        },
        (Rule("the ends of the chain stay between the cusps: amplitude + L/2 <= 4 a", _stays_between_cusps),),
    )
    variants = (
        Variant("cusp_to_cusp", "the ends of the chain just reach the cusps", initial_state=(1, 0)),
        Variant("short", "L = 1e-9 m: the difference of the heights of its ends cancels", {"L": "1e-9"}),
        Variant("long_1e5", "100,000 periods: phase error"),
    )
    invariants: ClassVar = {"energy": Invariant(chain_energy)}
    forms = (Separable(chain_acceleration, chain_potential),)
    scene = SCENE
    reversal = ("v",)

    @cached_property
    def _exact(self) -> HarmonicMotion:
        g, a, _ = self.parameter_values()
        return HarmonicMotion(4 * a, g, *self.initial_state)

    def motion(self) -> HarmonicMotion:
        return self._exact

    @property
    def time_scale(self) -> float:
        """2 sqrt(a/g)."""
        g, a, _ = map(float, self.parameter_values())
        return 2 * sqrt(a / g)

    def natural_span(self) -> Number:
        """10.37 periods."""
        return (100_000.37 if self.variant == "long_1e5" else 10.37) * tau * self.time_scale

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        return {"period": self._exact.period(digits), "amplitude": self._exact.amplitude(digits)}
