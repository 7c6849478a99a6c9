"""Foucault's pendulum for small amplitudes with the centrifugal terms of the horizontal plane."""

from __future__ import annotations

from functools import cached_property
from math import sin, sqrt
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Level, Variant, same
from gnomon.cases.core.forms import SemiLinear, Values
from gnomon.cases.core.numbers import Domain, Parameter, Range, Rule, positive
from gnomon.cases.core.point_scene import free_point
from gnomon.cases.pendulums.foucault_pendulum_linear import FoucaultLinear, FoucaultPrecession, no_load
from gnomon.reference.numerics.precision import publish, working
from gnomon.reference.pendulums.foucault_pendulum_centrifugal import FoucaultCentrifugal


def centrifugal_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Spring, Coriolis and in-plane centrifugal forces."""
    x, y, vx, vy = state
    g, length, rate, lat = parameters
    stiffness, turn = g / length, rate * sin(lat)
    return vx, vy, 2 * turn * vy - (stiffness - rate * rate) * x, -2 * turn * vx - (stiffness - turn * turn) * y


def centrifugal_matrix(parameters: Values) -> Values:
    g, length, rate, lat = parameters
    stiffness, turn = g / length, rate * sin(lat)
    east, north = stiffness - rate * rate, stiffness - turn * turn
    return 0, 0, 1, 0, 0, 0, 0, 1, -east, 0, 0, 2 * turn, 0, -north, -2 * turn, 0


def centrifugal_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Jacobi's integral per unit mass."""
    x, y, vx, vy = state
    g, length, rate, lat = parameters
    stiffness, turn = g / length, rate * sin(lat)
    return ((vx * vx + vy * vy + (stiffness - rate * rate) * x * x + (stiffness - turn * turn) * y * y) / 2,)


SCENE = free_point(centrifugal_equations, (0, 1))


class FoucaultInPlaneCentrifugal(Case):
    name = "foucault_pendulum_centrifugal"
    title = "Foucault pendulum, small amplitudes, with the centrifugal terms of the horizontal plane"
    section = "6.17.2-6.17.4"
    conventions = (
        "As foucault_pendulum_linear, with the terms Om^2 x east and Om^2 sin^2(lat) y north; g is the apparent gravity at "
        "the point of rest. Except at the poles the two axes differ."
    )
    state = FoucaultLinear.state
    parameter_list: ClassVar[tuple[Parameter, ...]] = FoucaultLinear.parameter_list
    default_state = FoucaultLinear.default_state
    default_span = 3600
    domain = Domain(
        dict(FoucaultLinear.domain.ranges) | {"g": positive(5.0, 15.0), "Om": Range(typical=(-0.2, 0.2))},
        (Rule("the pendulum is bound (Om^2 < g/L)", lambda n: n["Om"] ** 2 * n["L"] < n["g"]),),
    )
    variants = (
        Variant("day", "24 h: the axes differ by 1e-8 of the stiffness, whose effect accumulates", span=86400),
        Variant("equator", "no precession, two frequencies", {"lat": 0}, (2, 2, 0, 0)),
        Variant(
            "turntable",
            "a fast turntable at mid latitude: strongly anisotropic",
            {"L": 1, "Om": 2},
            ("0.1", 0, 0, 0),
            span=31,
        ),
    )
    invariants: ClassVar = {"energy": Invariant(centrifugal_energy)}
    forms = (SemiLinear(centrifugal_equations, linear=centrifugal_matrix, rest=no_load),)
    scene = SCENE
    reversal = ("vx", "vy", "Om")

    @cached_property
    def _exact(self) -> FoucaultCentrifugal:
        g, length, rate, lat = self.parameter_values()
        return FoucaultCentrifugal(g, length, rate, lat, self.initial_state)

    def motion(self) -> FoucaultCentrifugal:
        return self._exact

    @property
    def time_scale(self) -> float:
        """One radian of a swing."""
        g, length, rate, _ = map(float, self.parameter_values())
        return 1 / (sqrt(g / length) + abs(rate))

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """Rate of the plane of swing (rad/s), and the difference of stiffness of north and east over the stiffness."""
        with working(digits + 10) as mp:
            g, length, rate, lat = map(mp.mpf, self.parameter_values())
            found = publish((-rate * mp.sin(lat), (rate * mp.cos(lat)) ** 2 * length / g), digits)
        return {"precession_rate": found[0], "anisotropy": found[1], "swing_period": self._swing(digits)}

    def _swing(self, digits: int) -> Any:
        with working(digits + 10) as mp:
            return publish([2 * mp.pi * mp.sqrt(mp.mpf(self.parameters["L"] / self.parameters["g"]))], digits)[0]

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        numbers: dict[str, Any] = dict(self.parameters)
        rest: dict[str, Any] = numbers | {"Om": 0}
        start, span = self.initial_state, self.span
        return (
            Level(FoucaultPrecession(initial_state=start, span=span, **rest), same, "a fixed plane"),
            Level(
                FoucaultPrecession(initial_state=start, span=span, **numbers),
                same,
                "the plane turns at -Om sin(lat)",
            ),
            Level(FoucaultLinear(initial_state=start, span=span, **numbers), same, "Coriolis force in full"),
        )
