"""The conservative cubic oscillator."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from math import pi, sqrt
from typing import Any, ClassVar

from gnomon.cases.core import accuracy
from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import Separable, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, Rule
from gnomon.cases.core.point_scene import railed_pull
from gnomon.reference.numerics.precision import Number, publish, working
from gnomon.reference.oscillators.duffing_unforced import DuffingMotion


def cubic_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = -alpha x - beta x^3."""
    (x,) = q
    alpha, beta = parameters
    return (-alpha * x - beta * x * x * x,)


def quartic_potential(t: Any, q: Values, parameters: Values) -> Values:
    (x,) = q
    alpha, beta = parameters
    return (alpha * x * x / 2 + beta * x * x * x * x / 4,)


def quartic_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    x, v = state
    alpha, beta = parameters
    return (v * v / 2 + alpha * x * x / 2 + beta * x * x * x * x / 4,)


def _bounded(numbers: Mapping[str, Fraction]) -> bool:
    return DuffingMotion(numbers["alpha"], numbers["beta"], numbers["x"], numbers["v"]).bounded


SCENE = railed_pull(cubic_acceleration)


class DuffingUnforced(Case):
    """A spring that hardens (beta > 0) or softens (beta < 0), or two wells (alpha < 0), without damping or force."""

    name = "duffing_unforced"
    title = "Conservative cubic (Duffing) oscillator, Biermann-Weierstrass / cn, dn, sech"
    section = "6.13, 7.11.2 (quartic pendulum: alpha=w0^2, beta=-w0^2/6)"
    conventions = "x from the middle; forces over the mass."
    state = (Coordinate("x", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("alpha", "1/s^2", 1, "linear stiffness over the mass"),
        Parameter("beta", "1/(m^2 s^2)", 1, "cubic stiffness over the mass"),
    )
    default_state = (1, "0.5")
    domain = Domain(
        {name: Range(typical=(-2.0, 2.0)) for name in ("alpha", "beta", "x", "v")},
        (Rule("the motion is bounded (with beta < 0 it does not escape; alpha < 0 needs beta > 0)", _bounded),),
    )
    variants = (
        Variant("soft", "sn: softening spring", {"beta": "-0.25"}, ("1.2", "0.3")),
        Variant("one_well", "dn: stays in one of two wells", {"alpha": -1}, ("1.2", "0.1")),
        Variant("across_wells", "cn: swings across both wells", {"alpha": -1}, ("1.6", 0)),
        Variant("homoclinic", "sech: exactly the energy at the saddle", {"alpha": -1, "beta": 2}, (1, 0)),
        Variant("heteroclinic", "tanh: exactly the energy for escape", {"beta": "-0.5"}, (0, 1)),
        Variant("near_escape", "1e-12 below the escape speed", {"beta": "-0.5"}, (0, "0.999999999999")),
        Variant("saddle_1e_8", "released 1e-8 m from the saddle", {"alpha": -1}, ("1e-8", 0)),
        Variant("saddle_1e_12", "released 1e-12 m from the saddle", {"alpha": -1}, ("1e-12", 0)),
        Variant("long_1e4", "10,000 periods: phase error"),
    )
    invariants: ClassVar = {"energy": Invariant(quartic_energy)}
    forms = (Separable(cubic_acceleration, quartic_potential),)
    scene = SCENE
    reversal = ("v",)
    mirror = ("x", "v")

    _PERIODS: ClassVar = {
        "long_1e4": 10000.37,
        "near_escape": 2.37,
        "saddle_1e_8": 0.9,
        "saddle_1e_12": 0.9,
    }
    """Spans in periods; close to a saddle as long as binary64 can follow the motion."""

    @cached_property
    def _exact(self) -> DuffingMotion:
        return DuffingMotion(*self.parameter_values(), *self.initial_state)

    def motion(self) -> DuffingMotion:
        return self._exact

    @property
    def time_scale(self) -> float:
        """One over the root of the largest stiffness |alpha| + 3 |beta| x^2 of the motion; 1 s if that is zero."""
        alpha, beta = map(float, self.parameter_values())
        reach = max(abs(float(x)) for x in self._exact.turning_points())
        stiffness = abs(alpha) + 3 * abs(beta) * reach**2
        return 1 / sqrt(stiffness) if stiffness > 0 else 1.0

    def natural_span(self) -> Number:
        """10.37 periods; 9 times 1/sqrt|alpha| on a separatrix; 10.37 turns of the time scale at rest."""
        if self._exact.periodic:
            return float(self._exact.period(20)) * self._PERIODS.get(self.variant or "", 10.37)
        if self._exact.regime == DuffingMotion.REST:
            return 10.37 * 2 * pi * self.time_scale
        return 9 / sqrt(abs(float(self.parameters["alpha"])))

    def scales(self) -> dict[str, float]:
        """That of x in closed form if the span holds a period: close to a separatrix the peaks are narrow."""
        found = accuracy.grid_scales(self)
        if self._exact.periodic and self.span >= self._exact.period():
            found["length"] = max(abs(float(x)) for x in self._exact.turning_points())
        return found

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        motion = self._exact
        least, largest = motion.turning_points(digits)
        found = {"least_x": least, "largest_x": largest, "energy": motion.energy(digits)}
        alpha, beta = self.parameters["alpha"], self.parameters["beta"]
        if alpha > 0 > beta:  # with a softening spring the motion escapes over the maxima at x^2 = alpha/|beta|
            with working(digits + 10) as mp:
                found["escape_energy"] = publish([mp.mpf(-(alpha**2) / (4 * beta))], digits)[0]
        if motion.periodic:
            found |= {"period": motion.period(digits), "modulus_squared": motion.modulus_squared(digits)}
        return found
