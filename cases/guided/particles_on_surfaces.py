"""A particle on a smooth surface of revolution with a vertical axis: the azimuth is ignorable.

Cases: ignorable_coordinates (cone), particle_on_paraboloid, particle_on_torus.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from math import asin, atan2, cos, hypot, inf, pi, sin, tau
from typing import Any, ClassVar

from gnomon.cases.core.case import Invariant, Variant
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, Rule, positive
from gnomon.cases.guided.surface_scene import on_surface
from gnomon.cases.oscillators.well import WellCase
from gnomon.reference.guided.particles_on_surfaces import OnCone, OnParaboloid, OnSurface, OnTorus
from gnomon.reference.numerics.precision import Number, publish, working


def cone_equations(t: Any, state: Values, parameters: Values) -> Values:
    """On a cone of half angle alpha; unrolled, it is a plane with a constant force towards the tip."""
    s, _phi, vs, w = state
    alpha, g = parameters
    flat = sin(alpha) * w
    return vs, w, s * flat * flat - g * cos(alpha), -2 * vs * w / s


def cone_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero at the tip."""
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


def torus_equations(t: Any, state: Values, parameters: Values) -> Values:
    """theta around the tube: 0 on the outer side, -pi/2 at the bottom."""
    theta, _phi, rate, w = state
    ring, tube, g = parameters
    sine, cosine = sin(theta), cos(theta)
    radius = ring + tube * cosine
    return rate, w, -(radius * sine * w * w + g * cosine) / tube, 2 * tube * sine * rate * w / radius


def torus_energy(t: Any, state: Values, parameters: Values) -> Values:
    theta, _phi, rate, w = state
    ring, tube, g = parameters
    radius = ring + tube * cos(theta)
    return ((tube * tube * rate * rate + radius * radius * w * w) / 2 + g * tube * sin(theta),)


def torus_momentum(t: Any, state: Values, parameters: Values) -> Values:
    theta, _phi, _rate, w = state
    ring, tube, _g = parameters
    radius = ring + tube * cos(theta)
    return (radius * radius * w,)


def cone_place(s: float, parameters: Values) -> tuple[float, float, float, float]:
    alpha, _g = parameters
    return s * sin(alpha), s * cos(alpha), sin(alpha), cos(alpha)


def paraboloid_place(r: float, parameters: Values) -> tuple[float, float, float, float]:
    p, _g = parameters
    return r, r * r / (2 * p), 1.0, r / p


def torus_place(theta: float, parameters: Values) -> tuple[float, float, float, float]:
    ring, tube, _g = parameters
    sine, cosine = tube * sin(theta), tube * cos(theta)
    return ring + cosine, sine, -sine, cosine


def torus_angle(radius: float, height: float, parameters: Values) -> float:
    """From the height where that determines it best: in a thin tube the distance from the axis has few digits of it."""
    ring, tube, _g = parameters
    if tube * tube > 2 * height * height:
        return asin(height / tube) if radius > ring else -pi - asin(height / tube)
    return atan2(height, radius - ring)


CONE_SCENE = on_surface(cone_place, lambda radius, height, parameters: hypot(radius, height))
PARABOLOID_SCENE = on_surface(paraboloid_place, lambda radius, height, parameters: radius)
TORUS_SCENE = on_surface(torus_place, torus_angle)
ROUND = Rule("the particle moves round the axis (w is not 0, else it meets the tip or the axis)", lambda n: n["w"] != 0)


class _OnSurface(WellCase):
    """One coordinate along the meridian, the azimuth phi, and their rates."""

    section = "11.10.1-11.10.2"

    @cached_property
    def _exact(self) -> OnSurface:
        raise NotImplementedError

    @cached_property
    def time_scale(self) -> float:  # type: ignore[override]
        """The period over 2 pi, or the time of a radian of the azimuth closest to the axis if that is shorter."""
        fastest = float(self._exact.fastest_turn())
        turn = 1 / fastest if fastest else inf
        return turn if self._exact.rests else min(turn, float(self._exact.period()) / tau)

    def natural_span(self) -> Number:
        """5.37 periods; on a parallel circle 5.37 turns."""
        periods = self._PERIODS.get(self.variant or "", 5.37)
        return periods * (tau * self.time_scale if self._exact.rests else float(self._exact.period()))

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`apsidal_angle`: by how much phi grows from the least to the largest distance (rad)."""
        found = super().quantities(digits) | {"momentum": self._exact.momentum(digits)}
        if self._exact.rests:
            return found
        angle = self._exact.carried_over_period(0, digits + 5)
        with working(digits + 5) as mp:
            return found | {"apsidal_angle": publish([mp.mpf(angle) / 2], digits)[0]}


class ParticleOnCone(_OnSurface):
    name = "ignorable_coordinates"
    title = "Particle in a smooth cone: the azimuth is ignorable"
    conventions = "s from the tip along the wall, phi about the vertical axis, alpha between axis and wall."
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
            "alpha": Range(0.0, pi / 2, True, True, (0.3, 1.2)),
            "g": positive(5.0, 12.0),
            "s": positive(1.0, 2.0),
            "phi": Range(typical=(-3.0, 3.0)),
            "vs": Range(typical=(-0.5, 0.5)),
            "w": Range(typical=(2.0, 5.0)),
        },
        (ROUND,),
    )
    variants = (
        Variant(
            "near_tip",
            "comes within a few per cent of the tip: the azimuth changes fast",
            initial_state=(1, 0, 0, "0.5"),
        ),
        Variant("parallel", "close to a parallel circle: a small radial vibration", initial_state=(1, 0, 0, "6.1201")),
        Variant("flat", "a cone that is almost a plane: the force towards the tip is weak", {"alpha": "1.5607963"}),
        Variant("long_1e4", "10,000 periods: phase errors of both coordinates"),
    )
    _PERIODS: ClassVar = {"long_1e4": 10000.37}
    invariants: ClassVar = {"energy": Invariant(cone_energy), "angular_momentum": Invariant(cone_momentum)}
    forms = (FirstOrder(cone_equations),)
    scene = CONE_SCENE
    reversal = ("vs", "w")

    @cached_property
    def _exact(self) -> OnCone:
        alpha, g = self.parameter_values()
        s, phi, vs, w = self.initial_state
        return OnCone(g, s, phi, vs, w, alpha)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """The rate of the parallel circle at the start's height, and the frequency of radial vibrations about it (rad/s)."""
        with working(digits + 10) as mp:
            alpha, g, s = mp.mpf(self.parameters["alpha"]), mp.mpf(self.parameters["g"]), mp.mpf(self.initial_state[0])
            rate = mp.sqrt(g * mp.cos(alpha) / s) / mp.sin(alpha)
            found = publish((rate, mp.sqrt(3) * mp.sin(alpha) * rate), digits)
        return super().quantities(digits) | dict(zip(("circle_rate", "circle_vibration"), found, strict=True))


class ParticleOnParaboloid(_OnSurface):
    name = "particle_on_paraboloid"
    title = "Particle in a smooth paraboloid: the azimuth is ignorable"
    conventions = "r from the vertical axis, phi about it; the surface is z = r^2/(2 p)."
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
        },
        (ROUND,),
    )
    variants = (
        Variant(
            "near_axis",
            "passes the bottom at a few per cent of its largest radius: the azimuth changes fast",
            initial_state=(1, 0, 0, "0.2"),
        ),
        Variant("circle", "exactly a parallel circle, whose rate is sqrt(g/p) at any height", {"g": 9}, (2, 0, 0, 3)),
        Variant("long_1e4", "10,000 periods: phase errors of both coordinates"),
    )
    _PERIODS: ClassVar = {"long_1e4": 10000.37}
    invariants: ClassVar = {"energy": Invariant(paraboloid_energy), "angular_momentum": Invariant(paraboloid_momentum)}
    forms = (FirstOrder(paraboloid_equations),)
    scene = PARABOLOID_SCENE
    reversal = ("vr", "w")

    @cached_property
    def _exact(self) -> OnParaboloid:
        p, g = self.parameter_values()
        r, phi, vr, w = self.initial_state
        return OnParaboloid(g, r, phi, vr, w, p)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        with working(digits + 10) as mp:
            rate = publish([mp.sqrt(mp.mpf(self.parameters["g"] / self.parameters["p"]))], digits)[0]
        return super().quantities(digits) | {"circle_rate": rate}


def _on_torus(n: Mapping[str, Fraction]) -> OnTorus:
    return OnTorus(*(n[name] for name in ("g", "theta", "phi", "rate", "w", "R", "a")))


class ParticleOnTorus(_OnSurface):
    name = "particle_on_torus"
    title = "Particle in a smooth ring tube: the azimuth is ignorable"
    conventions = (
        "theta around the tube, 0 on the outer side, -pi/2 at the bottom; phi about the vertical axis; R the radius of "
        "the ring's middle circle, a of the tube. The surface holds the particle on both sides."
    )
    state = (
        Coordinate("theta", "rad", "angle", "angle around the tube"),
        Coordinate("phi", "rad", "angle"),
        Coordinate("rate", "rad/s", "angular velocity"),
        Coordinate("w", "rad/s", "angular velocity"),
    )
    parameter_list = (
        Parameter("R", "m", 2, "radius of the ring's middle circle"),
        Parameter("a", "m", "0.5", "radius of the tube"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
    )
    default_state = ("-0.6", 0, "1.5", "1.2")
    domain = Domain(
        {
            "R": positive(1.5, 3.0),
            "a": positive(0.3, 0.8),
            "g": positive(5.0, 12.0),
            "theta": Range(-pi, pi / 2, True, True, (-1.2, -0.2)),
            "phi": Range(typical=(-3.0, 3.0)),
            "rate": Range(typical=(-1.0, 1.0)),
            "w": Range(typical=(0.5, 2.5)),
        },
        (
            Rule("the ring has a hole, a < R", lambda n: n["a"] < n["R"]),
            Rule(
                "the particle swings: it is too slow to pass the top or the innermost circle",
                lambda n: _on_torus(n).swings,
            ),
        ),
    )
    variants = (
        Variant("inner", "climbs to the inner side, where the azimuth turns fastest", initial_state=("-2.4", 0, 0, 2)),
        Variant("plane", "no motion about the axis: a pendulum in the tube", initial_state=("-0.1", 0, 0, 0)),
        Variant(
            "fast", "fast about the axis: a small vibration about the outer side", initial_state=("-0.1", 0, 0, 30)
        ),
        Variant("thin", "a thin tube, a = 1e-4 R: 420 swings in a turn", {"a": "2e-4"}, ("-0.6", 0, 0, "0.5")),
        Variant("long_1e4", "10,000 periods: phase errors of both coordinates"),
    )
    _PERIODS: ClassVar = {"long_1e4": 10000.37}
    invariants: ClassVar = {"energy": Invariant(torus_energy), "angular_momentum": Invariant(torus_momentum)}
    forms = (FirstOrder(torus_equations),)
    scene = TORUS_SCENE
    reversal = ("rate", "w")

    @cached_property
    def _exact(self) -> OnTorus:
        return _on_torus(self.numbers)
