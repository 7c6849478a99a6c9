"""A chain in a circular tube and a pendulum on an accelerated support: each moves exactly like a pendulum.

Cases: chain_in_circular_tube, moment_of_momentum_pendulum.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from math import cos, sin, tau
from typing import Any, ClassVar

from gnomon.cases.core import accuracy
from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import Separable, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, Rule, positive
from gnomon.cases.pendulums.equivalent_pendulum_scene import SCENE, TUBE
from gnomon.reference.numerics.precision import Number, quantity, working
from gnomon.reference.pendulums.equivalent_pendulum import CarriedPendulum, EquivalentPendulum, TubeChain
from gnomon.reference.pendulums.pendulum_simple import Pendulum


def tube_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """theta'' = -(2 g/L) sin(L/2R) sin(theta)."""
    (theta,) = q
    g, length, radius = parameters
    return (-(2 * g / length) * sin(length / (2 * radius)) * sin(theta),)


def tube_potential(t: Any, q: Values, parameters: Values) -> Values:
    (theta,) = q
    g, length, radius = parameters
    return (-(2 * g / length) * sin(length / (2 * radius)) * cos(theta),)


def tube_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over m R^2, zero at the rest position."""
    theta, omega = state
    g, length, radius = parameters
    height = 2 * sin(theta / 2) * sin(theta / 2)
    return (omega * omega / 2 + (2 * g / length) * sin(length / (2 * radius)) * height,)


def carried_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """theta'' = -((g + ay)/L) sin(theta) - (ax/L) cos(theta)."""
    (theta,) = q
    g, length, ax, ay = parameters
    return (-((g + ay) / length) * sin(theta) - (ax / length) * cos(theta),)


def carried_potential(t: Any, q: Values, parameters: Values) -> Values:
    (theta,) = q
    g, length, ax, ay = parameters
    return (-((g + ay) / length) * cos(theta) + (ax / length) * sin(theta),)


def carried_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over m L^2 relative to the support, in the apparent gravity."""
    theta, omega = state
    g, length, ax, ay = parameters
    return (omega * omega / 2 - ((g + ay) / length) * cos(theta) + (ax / length) * sin(theta),)


class _Pendulum(Case):
    state = (Coordinate("theta", "rad", "angle"), Coordinate("omega", "rad/s", "angular velocity"))
    reversal = ("omega",)

    _PERIODS: ClassVar[dict[str, float]] = {}

    @cached_property
    def _exact(self) -> EquivalentPendulum:
        raise NotImplementedError

    def motion(self) -> EquivalentPendulum:
        return self._exact

    @property
    def time_scale(self) -> float:
        """1/W, W the frequency of small swings; in fast rotation the time of a radian."""
        return min(1 / float(self._exact.frequency()), float(self._exact.pendulum().period()) / tau)

    def natural_span(self) -> Number:
        """10.37 periods."""
        return float(self._exact.pendulum().period(20)) * self._PERIODS.get(self.variant or "", 10.37)

    def scales(self) -> dict[str, float]:
        """In closed form if the span holds a period: close to the top the peaks are narrow."""
        found = accuracy.grid_scales(self)
        pendulum = self._exact.pendulum()
        if self.span >= pendulum.period() and pendulum.regime != Pendulum.REST:
            found["angular velocity"] = float(pendulum.top_speed())
        return found

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        pendulum = self._exact.pendulum(digits + 60)
        found = {
            "small_swing_frequency": self._exact.frequency(digits),
            "rest_angle": self._exact.rest_angle(digits),
            "modulus_squared": pendulum.modulus_squared(digits),
            "amplitude": pendulum.amplitude(digits),
        }
        name = "turn_time" if pendulum.regime == Pendulum.ROTATION else "period"
        return found | {name: pendulum.period(digits)}


def _shorter_than_the_tube(length: Fraction, radius: Fraction) -> bool:
    """Decided with enough digits: 2 pi R is not rational."""
    with working(60) as mp:
        return bool(mp.mpf(length / radius) < 2 * mp.pi)


class ChainInCircularTube(_Pendulum):
    """A uniform chain that slides in a smooth circular tube in a vertical plane."""

    name = "chain_in_circular_tube"
    title = "Uniform chain sliding in a smooth circular tube (exactly a pendulum)"
    section = "8.12"
    conventions = "theta=angle of chain mid-point from the bottom; chain length L<2 pi R."
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("L", "m", 2, "length of the chain"),
        Parameter("R", "m", 1, "radius of the tube"),
    )
    default_state = (2, 0)
    domain = Domain(
        {
            "g": positive(),
            "L": positive(0.1, 6.0),
            "R": positive(1.0, 5.0),
            "theta": Range(typical=(-6.0, 6.0)),
            "omega": Range(typical=(-5.0, 5.0)),
        },
        (Rule("L < 2 pi R (the chain fits into the tube)", lambda n: _shorter_than_the_tube(n["L"], n["R"])),),
    )
    variants = (
        Variant("short", "a chain of 1e-6 m: nearly a bead", {"L": "1e-6"}),
        Variant("rotation", "the chain runs around the tube without stopping", initial_state=(0, 6)),
        Variant(
            "neutral",
            "L is the double just below 2 pi R: hardly any restoring force, a period of 4e8 s",
            {"L": 6.283185307179586},
            (2, 0),
        ),
        Variant("long_1e4", "10,000 periods: phase error"),
    )
    invariants: ClassVar = {"energy": Invariant(tube_energy)}
    forms = (Separable(tube_acceleration, tube_potential),)
    scene = TUBE

    _PERIODS: ClassVar = {"long_1e4": 10000.37}

    @cached_property
    def _exact(self) -> TubeChain:
        return TubeChain(*self.initial_state, *self.parameter_values())

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`pendulum_length`: L/(2 sin(L/2R)), the length of the simple pendulum with the same motion (m)."""
        g = self.parameters["g"]
        rate = self._exact.frequency(digits + 5)
        length = quantity(digits, lambda mp: mp.mpf(g) / mp.mpf(rate) ** 2)
        return super().quantities(digits) | {"pendulum_length": length}


class MomentOfMomentumPendulum(_Pendulum):
    """A pendulum whose support has a constant acceleration; an example of moment of momentum about a moving point."""

    name = "moment_of_momentum_pendulum"
    title = "Pendulum on an accelerated support"
    section = "6.10"
    conventions = (
        "theta from the downward vertical, relative to the support; its constant acceleration is ax towards growing theta "
        "and ay upward."
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("L", "m", 1, "length of the pendulum"),
        Parameter("ax", "m/s^2", 3, "horizontal acceleration of the support"),
        Parameter("ay", "m/s^2", 1, "vertical acceleration of the support"),
    )
    default_state = (1, 0)
    domain = Domain(
        {
            "g": positive(),
            "L": positive(),
            "ax": Range(typical=(-10.0, 10.0)),
            "ay": Range(typical=(-5.0, 10.0)),
            "theta": Range(typical=(-6.0, 6.0)),
            "omega": Range(typical=(-8.0, 8.0)),
        },
        (
            Rule(
                "g + ay and ax are not both zero (else the pendulum is weightless)",
                lambda n: n["g"] + n["ay"] != 0 or n["ax"] != 0,
            ),
        ),
    )
    variants = (
        Variant("braked", "released at rest along the true vertical", initial_state=(0, 0)),
        Variant(
            "falling",
            "the support falls with 1.0001 g: apparent gravity of 1e-4 g upward",
            {"ax": 0, "ay": "-9.810981"},
        ),
        Variant("sideways", "10 g to the side", {"ax": "98.1", "ay": 0}),
        Variant("long_1e4", "10,000 periods: phase error"),
    )
    invariants: ClassVar = {"energy": Invariant(carried_energy)}
    forms = (Separable(carried_acceleration, carried_potential),)
    scene = SCENE

    _PERIODS: ClassVar = {"long_1e4": 10000.37}

    @cached_property
    def _exact(self) -> CarriedPendulum:
        return CarriedPendulum(*self.initial_state, *self.parameter_values())
