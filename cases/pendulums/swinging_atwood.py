"""The swinging Atwood machine: a hanging mass pulls the string of a pendulum over a pulley."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, sin, sqrt
from typing import Any, ClassVar

from gnomon.cases.core.case import Invariant, Variant
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.cases.core.integrated import IntegratedCase
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.core.rope_scene import SWINGING
from gnomon.reference.numerics.precision import Number


def swinging_atwood_equations(t: Any, state: Values, parameters: Values) -> Values:
    """The unit mass swings at (r, theta); the mass mu hangs."""
    r, theta, vr, w = state
    mu, g = parameters
    return vr, w, (r * w * w + g * (cos(theta) - mu)) / (1 + mu), -(2 * vr * w + g * sin(theta)) / r


def swinging_atwood_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the swinging mass."""
    r, theta, vr, w = state
    mu, g = parameters
    return ((1 + mu) * vr * vr / 2 + r * r * w * w / 2 + g * r * (mu - cos(theta)),)


def tufillaro_integral(t: Any, state: Values, parameters: Values) -> Values:
    """The second integral, constant only for mu = 3 (Tufillaro, J. Physique 46 (1985) 1495)."""
    r, theta, vr, w = state
    _mu, g = parameters
    half, c = sin(theta / 2), cos(theta / 2)
    return (r * r * w * (vr * c - r * w * half / 2) + g * r * r * half * c * c,)


class SwingingAtwood(IntegratedCase):
    name = "swinging_atwood"
    title = "Swinging Atwood machine (no closed form; certified Taylor)"
    section = "8.8-8.9"
    conventions = (
        "r from the pulley (a point) to the swinging mass, theta from the downward vertical; mu is the hanging mass "
        "over the swinging one. Integrable only at mu = 3."
    )
    state = (
        Coordinate("r", "m", "length"),
        Coordinate("theta", "rad", "angle"),
        Coordinate("vr", "m/s", "velocity"),
        Coordinate("w", "rad/s", "angular velocity"),
    )
    parameter_list = (
        Parameter("mu", "1", "2.5", "hanging mass over swinging mass"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
    )
    default_state = (1, "1.5", 0, 0)
    domain = Domain(
        {
            "mu": positive(1.0, 4.0),
            "g": positive(5.0, 12.0),
            "r": positive(1.0, 2.0),
            "theta": Range(typical=(-1.5, 1.5)),
            "vr": Range(typical=(-0.2, 0.2)),
            "w": Range(typical=(-1.0, 1.0)),
        }
    )
    variants = (
        Variant("integrable", "mu = 3: a second integral exists", {"mu": 3}, (1, "1.5", 0, "0.5")),
        Variant(
            "near_pulley",
            "passes the pulley at a tenth of the initial distance: a sharp turn",
            {"mu": "2.5"},
            (1, "0.3", 0, "0.5"),
        ),
    )
    forms = (FirstOrder(swinging_atwood_equations),)
    scene = SWINGING
    reversal = ("vr", "w")

    _ENERGY: ClassVar = {"energy": Invariant(swinging_atwood_energy)}

    @property
    def invariants(self) -> Mapping[str, Invariant]:  # type: ignore[override]
        """The energy; with mu = 3 a second one."""
        second = {"tufillaro": Invariant(tufillaro_integral)} if self.parameters["mu"] == 3 else {}
        return self._ENERGY | second

    @property
    def time_scale(self) -> float:
        """A third of sqrt(r/g): the string becomes short during the motion."""
        return sqrt(float(self.initial_state[0]) / float(self.parameters["g"])) / 3

    @property
    def fastest_time(self) -> float:
        """The time of a radian at r/sqrt(mu) from the pulley, which the mass passes if mu is large."""
        return self.time_scale / max(1.0, sqrt(float(self.parameters["mu"])) / 2)

    def natural_span(self) -> Number:
        return 14.3 * self.time_scale
