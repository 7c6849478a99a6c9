"""Simpler models of the heavy top: the levels below `lagrange_top` in its hierarchy.

Cases: lagrange_top_fast, lagrange_top_small_nutation.
"""

from __future__ import annotations

import math
from functools import cached_property
from math import cos, sin
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Variant
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, Rule, positive
from gnomon.reference.numerics.precision import Number
from gnomon.reference.rigid_bodies.top_models import FastTop, SmallNutation

ANGLES = (
    Coordinate("theta", "rad", "angle", "tilt"),
    Coordinate("omega_theta", "rad/s", "angular velocity"),
    Coordinate("phi", "rad", "angle", "precession"),
    Coordinate("psi", "rad", "angle", "spin"),
)
MOMENTS = (
    Parameter("I1", "kg m^2", "0.02", "transverse moment about the point"),
    Parameter("I3", "kg m^2", "0.01", "axial moment"),
    Parameter("W", "N m", "0.5", "weight times distance of the centre of mass from the point"),
)
SPIN = Parameter("a", "kg m^2/s", "0.6", "p_psi, momentum of the spin, I3 w3")


def fast_top(t: Any, state: Values, parameters: Values) -> Values:
    axial, weight, a = parameters
    slow = weight / a
    return 0 * t, 0 * t, slow, a / axial - slow * cos(state[0])


def nutating_top(t: Any, state: Values, parameters: Values) -> Values:
    """theta'', phi' and psi' of the top to first order in theta - tilt."""
    theta, omega, _phi, _psi = state
    moment, axial, weight, a, b, tilt = parameters
    s, u, off = sin(tilt), cos(tilt), theta - tilt
    turn = (b - a * u) / (moment * s * s)
    slope = (a - 2 * moment * turn * u) / (moment * s)
    torque = turn * (moment * turn * u - a) + weight
    steeper = torque * u + slope * (2 * moment * turn * u - a) * s - moment * turn * turn * s * s
    return (
        omega,
        (torque * s + steeper * off) / moment,
        turn + slope * off,
        a / axial - turn * u + (turn * s - slope * u) * off,
    )


class LagrangeTopFast(Case):
    """A kinematic model without forces: it has no scene."""

    name = "lagrange_top_fast"
    title = "Fast top: steady slow precession at W/a"
    section = "11.12.4"
    conventions = "As lagrange_top; theta is constant, phi' = W/a, psi' = a/I3 - (W/a) cos(theta)."
    state = ANGLES
    parameter_list = (*MOMENTS[1:], SPIN)
    default_state = ("0.6", 0, 0, 0)
    domain = Domain(
        {
            "I3": positive(0.5, 2.0),
            "W": positive(0.2, 4.0),
            "a": Range(typical=(0.5, 4.0)),
            "theta": Range(0.0, math.pi, typical=(0.1, 3.0)),
            "omega_theta": Range(0.0, 0.0, typical=(0.0, 0.0)),
        },
        (Rule("the top spins (a is not 0)", lambda n: n["a"] != 0),),
    )
    forms = (FirstOrder(fast_top),)

    @cached_property
    def _exact(self) -> FastTop:
        axial, weight, a = self.parameter_values()
        return FastTop(axial, weight, a, self.initial_state)

    def motion(self) -> FastTop:
        return self._exact

    @property
    def time_scale(self) -> float:
        """The time of a radian of the spin."""
        axial, _weight, a = map(float, self.parameter_values())
        return axial / abs(a)

    def natural_span(self) -> Number:
        """65.3 radians of the spin."""
        return 65.3 * self.time_scale


class LagrangeTopSmallNutation(Case):
    """Linearised equations, which no bodies and forces obey exactly: no scene."""

    name = "lagrange_top_small_nutation"
    title = "Top with small nutation about a tilt"
    section = "11.12.4"
    conventions = "The equations of lagrange_top to first order in theta - tilt."
    state = ANGLES
    parameter_list = (
        *MOMENTS,
        SPIN,
        Parameter("b", "kg m^2/s", "0.52", "p_phi, momentum about the vertical"),
        Parameter("tilt", "rad", "0.6", "the angle about which the equations are linear"),
    )
    default_state = ("0.6", 0, 0, 0)
    domain = Domain(
        {
            "I1": positive(0.5, 2.0),
            "I3": positive(0.5, 2.0),
            "W": positive(0.2, 4.0),
            "a": Range(typical=(2.0, 4.0)),
            "b": Range(typical=(1.0, 2.0)),
            "tilt": Range(0.0, math.pi, low_open=True, typical=(0.5, 2.0)),
            "theta": Range(typical=(0.4, 2.1)),
            "omega_theta": Range(typical=(-0.5, 0.5)),
        }
    )
    variants = (
        Variant("fast", "a^2/(I1 W) = 1e6: a fast small nutation on the precession", {"a": 100, "b": 82}),
        Variant("long_1e4", "10,000 nutations: phase errors"),
    )
    forms = (FirstOrder(nutating_top),)

    _CYCLES: ClassVar[dict[str, float]] = {"long_1e4": 10000.37}

    @cached_property
    def _exact(self) -> SmallNutation:
        moment, axial, weight, a, b, tilt = self.parameter_values()
        return SmallNutation(moment, axial, weight, a, b, tilt, self.initial_state)

    def motion(self) -> SmallNutation:
        return self._exact

    @property
    def time_scale(self) -> float:
        """The shortest time of nutation, spin and weight."""
        moment, axial, weight, a = (float(self.parameters[name]) for name in ("I1", "I3", "W", "a"))
        return 1 / max(abs(a) / moment, abs(a) / axial, math.sqrt(weight / moment))

    def natural_span(self) -> Number:
        """10.37 nutations; ten time scales if the tilt is unstable."""
        rate = self._exact.nutation_rate()
        cycles = self._CYCLES.get(self.variant or "", 10.37)
        return 10 * self.time_scale if rate is None else cycles * 2 * math.pi / float(rate)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        rate = self._exact.nutation_rate(digits)
        return {} if rate is None else {"nutation_rate": rate}
