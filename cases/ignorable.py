"""A particle inside a smooth surface of revolution, its axis upright: the azimuth is ignorable."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import cos, sin, sqrt
from typing import Any, ClassVar

from gnomon.cases.case import Invariant, Variant
from gnomon.cases.forms import FirstOrder, Values
from gnomon.cases.integrated import IntegratedCase
from gnomon.cases.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.reference.precision import Number, publish, working


def cone_equations(t: Any, state: Values, parameters: Values) -> Values:
    """On a cone of half angle alpha: unrolled, a plane with a constant pull towards the tip."""
    s, _phi, vs, w = state
    alpha, g = parameters
    flat = sin(alpha) * w
    return vs, w, s * flat * flat - g * cos(alpha), -2 * vs * w / s


def cone_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, from the tip."""
    s, _phi, vs, w = state
    alpha, g = parameters
    across = s * sin(alpha) * w
    return ((vs * vs + across * across) / 2 + g * s * cos(alpha),)


def cone_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the axis over the mass: conjugate to the ignorable azimuth."""
    s, _phi, _vs, w = state
    alpha, _g = parameters
    radius = s * sin(alpha)
    return (radius * radius * w,)


def paraboloid_equations(t: Any, state: Values, parameters: Values) -> Values:
    """On z = r^2/(2 p)."""
    r, _phi, vr, w = state
    p, g = parameters
    slope = r / p
    return vr, w, (r * w * w - g * slope - slope * vr * vr / p) / (1 + slope * slope), -2 * vr * w / r


def paraboloid_energy(t: Any, state: Values, parameters: Values) -> Values:
    r, _phi, vr, w = state
    p, g = parameters
    slope = r / p
    return ((1 + slope * slope) * vr * vr / 2 + r * r * w * w / 2 + g * r * slope / 2,)


def paraboloid_momentum(t: Any, state: Values, parameters: Values) -> Values:
    r, _phi, _vr, w = state
    return (r * r * w,)


class _OnSurface(IntegratedCase):
    section = "11.10.1-11.10.2"

    _CLOSE: ClassVar[frozenset[str]] = frozenset({"near_tip", "near_axis"})

    @property
    def time_scale(self) -> float:
        """A radian of the azimuth, or the time of a fall over the distance, whichever is shorter."""
        distance, _, _, w = map(float, self.initial_state)
        fall = sqrt(distance / float(self.parameters["g"]))
        return min(fall, 1 / abs(w)) if w else fall

    def natural_span(self) -> Number:
        return (8.3 if self.variant in self._CLOSE else 20.3) * self.time_scale

    def reversed(self, state: Sequence[Any]) -> tuple[tuple[Any, ...], dict[str, Fraction]]:
        distance, phi, speed, w = state
        return (distance, phi, -speed, -w), self.parameters


class ParticleOnCone(_OnSurface):
    name = "ignorable_coordinates"
    title = "Particle in a smooth cone: the azimuth is ignorable"
    conventions = "s from the tip along the wall, phi about the upright axis, alpha between axis and wall."
    state = (
        Coordinate("s", "m", "length"),
        Coordinate("phi", "rad", "angle"),
        Coordinate("vs", "m/s", "velocity"),
        Coordinate("w", "rad/s", "angular velocity"),
    )
    parameter_list = (
        Parameter("alpha", "rad", "0.5", "half angle of the cone"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
    )
    default_state = (1, 0, 0, 5)
    domain = Domain(
        {
            "alpha": Range(0.0, 1.5707963267948966, True, True, (0.3, 1.2)),
            "g": positive(5.0, 12.0),
            "s": positive(1.0, 2.0),
            "phi": Range(typical=(-3.0, 3.0)),
            "vs": Range(typical=(-0.5, 0.5)),
            "w": Range(typical=(2.0, 5.0)),
        }
    )
    variants = (
        Variant(
            "near_tip", "comes within a few per cent of the tip: the azimuth jumps", initial_state=(1, 0, 0, "0.5")
        ),
        Variant("parallel", "next to the parallel circle: a small radial vibration", initial_state=(1, 0, 0, "6.1201")),
    )
    invariants: ClassVar = {"energy": Invariant(cone_energy), "angular_momentum": Invariant(cone_momentum)}

    @property
    def forms(self) -> tuple[FirstOrder, ...]:
        return (FirstOrder(cone_equations),)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """The rate at which the start's height is a parallel circle; that of its radial vibration."""
        with working(digits + 10) as mp:
            alpha, g, s = mp.mpf(self.parameters["alpha"]), mp.mpf(self.parameters["g"]), mp.mpf(self.initial_state[0])
            rate = mp.sqrt(g * mp.cos(alpha) / s) / mp.sin(alpha)
            found = publish((rate, mp.sqrt(3) * mp.sin(alpha) * rate), digits)
        return dict(zip(("circle_rate", "circle_vibration"), found, strict=True))


class ParticleOnParaboloid(_OnSurface):
    name = "particle_on_paraboloid"
    title = "Particle in a smooth paraboloid: the azimuth is ignorable"
    conventions = "r from the upright axis, phi about it; the surface is z = r^2/(2 p)."
    state = (
        Coordinate("r", "m", "length"),
        Coordinate("phi", "rad", "angle"),
        Coordinate("vr", "m/s", "velocity"),
        Coordinate("w", "rad/s", "angular velocity"),
    )
    parameter_list = (
        Parameter("p", "m", 1, "radius of curvature at the bottom"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
    )
    default_state = (1, 0, "0.5", 2)
    domain = Domain(
        {
            "p": positive(0.5, 2.0),
            "g": positive(5.0, 12.0),
            "r": positive(1.0, 2.0),
            "phi": Range(typical=(-3.0, 3.0)),
            "vr": Range(typical=(-0.5, 0.5)),
            "w": Range(typical=(2.0, 5.0)),
        }
    )
    variants = (
        Variant(
            "near_axis",
            "passes the bottom at a few per cent of its radius: the azimuth jumps",
            initial_state=(1, 0, 0, "0.2"),
        ),
        Variant("circle", "on any parallel circle the rate is sqrt(g/p): exactly so here", {"g": 9}, (2, 0, 0, 3)),
    )
    invariants: ClassVar = {"energy": Invariant(paraboloid_energy), "angular_momentum": Invariant(paraboloid_momentum)}

    @property
    def forms(self) -> tuple[FirstOrder, ...]:
        return (FirstOrder(paraboloid_equations),)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        with working(digits + 10) as mp:
            return {"circle_rate": publish([mp.sqrt(mp.mpf(self.parameters["g"] / self.parameters["p"]))], digits)[0]}
