"""A chain in a circular tube and a pendulum on an accelerated support: each moves exactly like a pendulum.

Cases: chain_in_circular_tube, moment_of_momentum_pendulum.
"""

from fractions import Fraction
from math import cos, sin, tau
from typing import ClassVar

from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.cases.pendulums.equivalent_pendulum_scene import SCENE, TUBE
from gnomon.reference.numerics.precision import working
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
    exact_motion: ClassVar[ExactMotion[EquivalentPendulum]]
    default_span = Span(10.37, lambda motion: motion.pendulum().period(20))

    @property
    def time_scale(self) -> float:
        """1/W, W the frequency of small swings; in fast rotation the time of a radian."""
        return min(1 / float(self.exact_motion.frequency()), float(self.exact_motion.pendulum().period()) / tau)

    def scales(self) -> dict[str, float]:
        """In closed form if the span holds a period: close to the top the peaks are narrow."""
        found = accuracy.grid_scales(self)
        pendulum = self.exact_motion.pendulum()
        if self.span >= pendulum.period() and pendulum.regime != Pendulum.REST:
            found["angular velocity"] = float(pendulum.top_speed())
        return found

    def derived(self, digits: int) -> dict[str, Any]:
        motion, pendulum = self.exact_motion, self.exact_motion.pendulum(digits + 60)
        return {
            "small_swing_frequency": motion.frequency(digits),
            "rest_angle": motion.rest_angle(digits),
            "modulus_squared": pendulum.modulus_squared(digits),
            "amplitude": pendulum.amplitude(digits),
            "turn_time" if pendulum.regime == Pendulum.ROTATION else "period": pendulum.period(digits),
        }


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
    theta = Coordinate("rad", 2, typical(-6, 6))
    omega = Coordinate("rad/s", 0, typical(-5, 5))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    L = Parameter("m", 2, "length of the chain", positive(0.1, 6))
    R = Parameter("m", 1, "radius of the tube", positive(1, 5))
    rules = (Rule("L < 2 pi R (the chain fits into the tube)", lambda n: _shorter_than_the_tube(n["L"], n["R"])),)
    exact_motion = ExactMotion(TubeChain, length="L", radius="R")
    variants = (
        Variant("short", "a chain of 1e-6 m: nearly a bead", {"L": "1e-6"}),
        Variant("rotation", "the chain runs around the tube without stopping", initial_state=(0, 6)),
        Variant(
            "neutral",
            "L is the double just below 2 pi R: hardly any restoring force, a period of 4e8 s",
            {"L": 6.283185307179586},
            (2, 0),
        ),
        Variant("long_1e4", "10,000 periods: phase error", periods=10000.37),
    )
    invariants = conserved(energy=tube_energy)
    forms = (Separable(tube_acceleration, tube_potential),)
    scene = TUBE

    def derived(self, digits: int) -> dict[str, Any]:
        """`pendulum_length`: L/(2 sin(L/2R)), the length of the simple pendulum with the same motion (m)."""
        rate = self.exact_motion.frequency(digits + 5)
        return super().derived(digits) | {"pendulum_length": lambda mp: mp.mpf(self.g) / mp.mpf(rate) ** 2}


class MomentOfMomentumPendulum(_Pendulum):
    """A pendulum whose support has a constant acceleration; an example of moment of momentum about a moving point."""

    name = "moment_of_momentum_pendulum"
    title = "Pendulum on an accelerated support"
    section = "6.10"
    conventions = (
        "theta from the downward vertical, relative to the support; its constant acceleration is ax towards growing theta "
        "and ay upward."
    )
    theta = Coordinate("rad", 1, typical(-6, 6))
    omega = Coordinate("rad/s", 0, typical(-8, 8))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    L = Parameter("m", 1, "length of the pendulum", positive())
    ax = Parameter("m/s^2", 3, "horizontal acceleration of the support", typical(-10, 10))
    ay = Parameter("m/s^2", 1, "vertical acceleration of the support", typical(-5, 10))
    rules = (
        Rule(
            "g + ay and ax are not both zero (else the pendulum is weightless)",
            lambda n: n["g"] + n["ay"] != 0 or n["ax"] != 0,
        ),
    )
    exact_motion = ExactMotion(CarriedPendulum, length="L")
    variants = (
        Variant("braked", "released at rest along the true vertical", initial_state=(0, 0)),
        Variant(
            "falling",
            "the support falls with 1.0001 g: apparent gravity of 1e-4 g upward",
            {"ax": 0, "ay": "-9.810981"},
        ),
        Variant("sideways", "10 g to the side", {"ax": "98.1", "ay": 0}),
        Variant("long_1e4", "10,000 periods: phase error", periods=10000.37),
    )
    invariants = conserved(energy=carried_energy)
    forms = (Separable(carried_acceleration, carried_potential),)
    scene = SCENE
