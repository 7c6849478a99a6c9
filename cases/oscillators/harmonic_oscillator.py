"""The harmonic oscillator."""

from __future__ import annotations

from functools import cached_property
from math import pi, sqrt
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import Separable, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.oscillators.harmonic_oscillator_scene import SCENE
from gnomon.reference.numerics.precision import Number
from gnomon.reference.oscillators.harmonic_oscillator import HarmonicMotion


def linear_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = -(k/m) x."""
    (x,) = q
    m, k = parameters
    return (-(k / m) * x,)


def linear_potential(t: Any, q: Values, parameters: Values) -> Values:
    (x,) = q
    m, k = parameters
    return ((k / m) * x * x / 2,)


def spring_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    m, k = parameters
    return ((m * v * v + k * x * x) / 2,)


class HarmonicOscillator(Case):
    """A mass m on a spring k."""

    name = "harmonic_oscillator"
    title = "Harmonic oscillator"
    section = "6.7"
    conventions = (
        "x from the equilibrium, which for a hanging spring is m g/k below its free end. "
        "Springs in parallel add k, springs in series add 1/k."
    )
    state = (Coordinate("x", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (Parameter("m", "kg", 1, "mass"), Parameter("k", "N/m", 4, "stiffness of the spring"))
    default_state = (1, "0.5")
    domain = Domain({"m": positive(), "k": positive()} | {name: Range(typical=(-5.0, 5.0)) for name in ("x", "v")})
    variants = (
        Variant("long_1e6", "1,000,000 periods: phase error", span="3141654.57"),
        Variant("fast", "w = 1e8 rad/s: times far below 1 s", {"k": 10**16}),
    )
    invariants: ClassVar = {"energy": Invariant(spring_energy)}
    forms = (Separable(linear_acceleration, linear_potential),)
    scene = SCENE
    reversal = ("v",)
    mirror = ("x", "v")

    @cached_property
    def _exact(self) -> HarmonicMotion:
        return HarmonicMotion(*self.parameter_values(), *self.initial_state)

    def motion(self) -> HarmonicMotion:
        return self._exact

    @property
    def time_scale(self) -> float:
        m, k = map(float, self.parameter_values())
        return sqrt(m / k)

    def natural_span(self) -> Number:
        """10.37 periods."""
        return 10.37 * 2 * pi * self.time_scale

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        return {
            "period": self._exact.period(digits),
            "amplitude": self._exact.amplitude(digits),
            "phase": self._exact.phase(digits),
            "energy": self._exact.energy(digits),
        }
