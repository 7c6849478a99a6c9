"""Foucault's pendulum for small amplitudes, and a model with precession as the only effect of rotation.

Cases: foucault_pendulum_linear, foucault_precession.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from math import sin
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Level, Variant, same
from gnomon.cases.core.forms import SemiLinear, Values
from gnomon.cases.core.numbers import POINT_IN_A_PLANE, Domain, Parameter, Range, positive
from gnomon.cases.core.point_scene import free_point
from gnomon.cases.core.turning import Turning
from gnomon.cases.pendulums.foucault_pendulum_linear_scene import SCENE
from gnomon.reference.pendulums.foucault_pendulum_linear import Foucault

TURN = 2 * math.pi


def foucault_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Spring and Coriolis forces in the horizontal plane."""
    x, y, vx, vy = state
    g, length, rate, lat = parameters
    stiffness = g / length
    twice = 2 * rate * sin(lat)
    return vx, vy, twice * vy - stiffness * x, -twice * vx - stiffness * y


def precession_equations(t: Any, state: Values, parameters: Values) -> Values:
    """The same with an added term, with which precession of the plane is the only effect of rotation."""
    x, y, vx, vy = state
    g, length, rate, lat = parameters
    turn = rate * sin(lat)
    stiffness = g / length - turn * turn
    return vx, vy, 2 * turn * vy - stiffness * x, -2 * turn * vx - stiffness * y


def foucault_matrix(parameters: Values) -> Values:
    g, length, rate, lat = parameters
    stiffness, twice = g / length, 2 * rate * sin(lat)
    return 0, 0, 1, 0, 0, 0, 0, 1, -stiffness, 0, 0, twice, 0, -stiffness, -twice, 0


def precession_matrix(parameters: Values) -> Values:
    g, length, rate, lat = parameters
    turn = rate * sin(lat)
    stiffness = g / length - turn * turn
    return 0, 0, 1, 0, 0, 0, 0, 1, -stiffness, 0, 0, 2 * turn, 0, -stiffness, -2 * turn, 0


def no_load(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0, 0, 0


def foucault_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy per unit mass: the Coriolis force does no work."""
    x, y, vx, vy = state
    g, length, _rate, _lat = parameters
    return ((vx * vx + vy * vy + g / length * (x * x + y * y)) / 2,)


def precession_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    g, length, rate, lat = parameters
    turn = rate * sin(lat)
    return ((vx * vx + vy * vy + (g / length - turn * turn) * (x * x + y * y)) / 2,)


def foucault_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum per unit mass about the vertical in the inertial frame."""
    x, y, vx, vy = state
    _g, _length, rate, lat = parameters
    return (x * vy - y * vx + rate * sin(lat) * (x * x + y * y),)


PRECESSION_SCENE = free_point(precession_equations, (0, 1))


class FoucaultLinear(Case):
    name = "foucault_pendulum_linear"
    title = "Foucault pendulum, small amplitudes"
    section = "6.17.2-6.17.4"
    conventions = (
        "x east, y north; centrifugal terms are absorbed in g; for lat > 0 the plane of swing turns clockwise."
    )
    state = POINT_IN_A_PLANE
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "apparent gravity"),
        Parameter("L", "m", 67, "length of the pendulum"),
        Parameter("Om", "rad/s", "7.292115e-5", "rate of rotation of the Earth"),
        Parameter("lat", "rad", "0.8526", "latitude"),
    )
    default_state = (3, 0, 0, 0)
    turning = Turning((("x", "y"), ("vx", "vy")))
    default_span = 3600
    domain = Domain(
        {
            "g": positive(5.0, 15.0),
            "L": positive(0.5, 100.0),
            "Om": Range(typical=(-1.0, 1.0)),
            "lat": Range(low=-1.5707963267948966, high=1.5707963267948966, typical=(-1.5, 1.5)),
        }
    )
    variants: ClassVar[tuple[Variant, ...]] = (
        Variant("day", "24 h: the drift of the plane over 5e3 swings", span=86400),
        Variant(
            "two_days", "48 h on 1 m: the drift of the plane over 9e4 swings", {"L": 1}, ("0.1", 0, 0, 0), span=172800
        ),
        Variant("equator", "no precession: the other component stays exactly zero", {"lat": 0}),
        Variant(
            "turntable",
            "a fast turntable: the frame rotates six times faster than the pendulum swings",
            {"L": 1, "Om": 20, "lat": 1.5707963267948966},
            ("0.1", 0, 0, 0),
            span=21,
        ),
    )
    invariants: ClassVar[Mapping[str, Invariant]] = {
        "energy": Invariant(foucault_energy),
        "angular_momentum": Invariant(foucault_momentum),
    }
    forms = (SemiLinear(foucault_equations, linear=foucault_matrix, rest=no_load),)
    scene = SCENE
    reversal = ("vx", "vy", "Om")
    mirror = ("x", "y", "vx", "vy")

    def motion(self) -> Foucault:
        return self.foucault(larmor=False)

    def foucault(self, larmor: bool) -> Foucault:
        g, length, rate, lat = self.parameter_values()
        x, y, vx, vy = self.initial_state
        return Foucault(g, length, rate, lat, x, y, vx, vy, larmor)

    @property
    def time_scale(self) -> float:
        """One radian of the faster of the two circular motions."""
        return 1 / max(abs(float(rate)) for rate in self.motion().circles()[2:])

    def scales(self) -> dict[str, float]:
        """The sums of the radii and of the speeds of the two circular motions, which are reached within half a swing."""
        motion = self.motion()
        if float(self.times[-1]) < float(motion.swing_period()) / 2:
            return super().scales()
        p, q, faster, slower = (abs(float(value)) for value in motion.circles())
        sizes = {"length": p + q, "velocity": p * faster + q * slower}
        return {name: size if size > 0 else 1.0 for name, size in sizes.items()}

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`closest`: the least distance from the point of rest; |W/s| of the amplitude if released from rest."""
        motion = self.motion()
        return {
            "precession_rate": motion.precession_rate(digits),
            "swing_period": motion.swing_period(digits),
            "closest": motion.closest(digits),
        }

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        def level(**changed: Any) -> Case:
            return FoucaultPrecession(
                initial_state=self.initial_state, span=self.span, **(dict(self.parameters) | changed)
            )

        return (
            Level(level(Om=0), same, "swings in a fixed plane"),
            Level(level(), same, "the plane turns at -Om sin(lat)"),
        )


class FoucaultPrecession(FoucaultLinear):
    name = "foucault_precession"
    title = "Foucault pendulum, precession only"
    conventions = "As foucault_pendulum_linear, with a term Om^2 sin^2(lat) r: the swing is as on an Earth at rest."
    variants = ()
    invariants: ClassVar[Mapping[str, Invariant]] = {
        "energy": Invariant(precession_energy),
        "angular_momentum": Invariant(foucault_momentum),
    }
    forms = (SemiLinear(precession_equations, linear=precession_matrix, rest=no_load),)
    scene = PRECESSION_SCENE
    hierarchy = ()

    def motion(self) -> Foucault:
        return self.foucault(larmor=True)
