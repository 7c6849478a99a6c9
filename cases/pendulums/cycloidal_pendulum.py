"""Huygens' isochronous pendulum."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import cos, pi, sin, sqrt, tan
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core import accuracy
from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import FirstOrder, Separable, Values
from gnomon.cases.core.formulation import Formulation
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, Rule, positive
from gnomon.cases.pendulums.cycloidal_pendulum_scene import SCENE
from gnomon.reference.numerics.precision import Number
from gnomon.reference.pendulums.cycloidal_pendulum import CycloidalMotion
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def cycloid_equations(t: Any, state: Values, parameters: Values) -> Values:
    """phi'' = tan(phi/2) (phi'^2 - g/a) / 2."""
    phi, rate = state
    a, g = parameters
    return rate, tan(phi / 2) * (rate * rate - g / a) / 2


def arc_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """s'' = -(g/4a) s."""
    (s,) = q
    a, g = parameters
    return (-(g / (4 * a)) * s,)


def arc_potential(t: Any, q: Values, parameters: Values) -> Values:
    (s,) = q
    a, g = parameters
    return ((g / (8 * a)) * s * s,)


def cycloid_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero at the bottom: s'^2/2 + g y, s' = 2 a cos(phi/2) phi', y = 2 a sin^2(phi/2)."""
    phi, rate = state
    a, g = parameters
    square = sin(phi / 2) * sin(phi / 2)
    return (2 * a * a * (1 - square) * rate * rate + 2 * a * g * square,)


def arc_from_angle(mp: Any, state: Sequence[Any], parameters: Sequence[Any]) -> tuple[Any, Any]:
    phi, rate = state
    a, _ = parameters
    return 4 * a * mp.sin(phi / 2), 2 * a * mp.cos(phi / 2) * rate


def angle_from_arc(y: Floats, parameters: Sequence[float]) -> Floats:
    """The angle; nan beyond the cusp, where there is none."""
    a = parameters[0]
    sine = y[..., 0] / (4 * a)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = np.sqrt((1 - sine) * (1 + sine))
        return np.stack([2 * np.arctan2(sine, cosine), y[..., 1] / (2 * a * cosine)], axis=-1)


class CycloidalPendulum(Case):
    """A bead on a smooth cycloid, or a string of length 4 a between cycloidal jaws of the same size."""

    name = "cycloidal_pendulum"
    title = "Huygens' isochronous cycloidal pendulum"
    section = "7.11.3-7.11.5, 8.12"
    conventions = "x=a(phi+sin phi), y=a(1-cos phi), s=4a sin(phi/2) arc length from the bottom, s''=-(g/4a)s."
    state = (Coordinate("phi", "rad", "angle"), Coordinate("phidot", "rad/s", "angular velocity"))
    parameter_list = (
        Parameter("a", "m", "0.25", "radius of the rolling circle"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
    )
    default_state = (1, 0)
    domain = Domain(
        {
            "a": positive(),
            "g": positive(),
            # The double nearest to pi is below pi.
            "phi": Range(low=-pi, high=pi, typical=(-3.0, 3.0)),
            "phidot": Range(typical=(-5.0, 5.0)),
        },
        (Rule("phidot^2 < g/a (else the bead reaches the cusp)", lambda n: n["phidot"] ** 2 * n["a"] < n["g"]),),
    )
    variants = (
        Variant("small", "amplitude 0.01 rad: the period is that of every other amplitude", initial_state=("0.01", 0)),
        Variant("wide", "amplitude 3 rad: the period is that of every other amplitude", initial_state=(3, 0)),
        Variant("launched", "starts with speed and passes the bottom", initial_state=("0.5", 5)),
        Variant(
            "near_cusp",
            "released 1e-4 rad from the cusp: the angle turns sharply, the arc length does not",
            initial_state=("3.141492653589793", 0),
        ),
        Variant(
            "nearer_cusp",
            "released 1e-8 rad from the cusp: the angle turns within 1e-8 of a period; 2.5e-17 of the energy to reach the "
            "cusp is missing, less than binary64 resolves",
            initial_state=("3.141592643589793", 0),
        ),
        Variant(
            "cusp_to_cusp",
            "released at the last double before the cusp, s = 4a after rounding; ends just before the other cusp",
            initial_state=(pi, 0),
        ),
    )
    invariants: ClassVar = {"energy": Invariant(cycloid_energy)}
    forms = (FirstOrder(cycloid_equations),)
    scene = SCENE
    reversal = ("phidot",)
    mirror = ("phi", "phidot")
    formulations = (
        Formulation("arc length", (Separable(arc_acceleration, arc_potential),), arc_from_angle, angle_from_arc),
    )

    @cached_property
    def _exact(self) -> CycloidalMotion:
        return CycloidalMotion(*self.parameter_values(), *self.initial_state)

    def motion(self) -> CycloidalMotion:
        return self._exact

    @property
    def time_scale(self) -> float:
        """2 sqrt(a/g), the period over 2 pi."""
        a, g = map(float, self.parameter_values())
        return 2 * sqrt(a / g)

    @property
    def fastest_time(self) -> float:
        """The time in which the angle turns close to the cusp."""
        return self.time_scale * cos(float(self._exact.angle_amplitude()) / 2)

    def natural_span(self) -> Number:
        """10.37 periods; 0.47 periods between cusps, where the angle is not defined."""
        periods = 0.47 if self.variant == "cusp_to_cusp" else 10.37
        return periods * 2 * pi * self.time_scale

    def scales(self) -> dict[str, float]:
        """In closed form if the span holds a period: close to the cusp the peaks are narrow."""
        found = accuracy.grid_scales(self)
        motion = self._exact
        if self.span >= motion.period() and motion.energy() > 0:
            return {"angle": float(motion.angle_amplitude()), "angular velocity": float(motion.top_rate())}
        return found

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """Normal forces are over the mass (m/s^2): g cos(phi/2) + v^2/(4a cos(phi/2)), v = 2a cos(phi/2) phi'.

        As a string between jaws of the same shape, the evolute of the cycloid, the pendulum has length 4 a.
        """
        motion = self._exact
        a, g = self.parameter_values()
        phi, rate = self.initial_state
        start = motion._quantity(digits, lambda mp: mp.mpf(g + a * rate**2) * mp.cos(mp.mpf(phi) / 2))
        return {
            "period": motion.period(digits),
            "angle_amplitude": motion.angle_amplitude(digits),
            "arc_amplitude": motion.arc_amplitude(digits),
            "energy": motion.energy(digits),
            "normal_force_start": start,
            "normal_force_bottom": motion.normal_force_bottom(digits),
            "string_length": motion._rational(digits, 4 * a),
        }
