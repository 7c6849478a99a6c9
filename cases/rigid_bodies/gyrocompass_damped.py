"""The gyrocompass with viscous damping, for small angles."""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from math import sqrt
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import SemiLinear, Values
from gnomon.cases.core.hinge_scene import hinged_point
from gnomon.cases.core.numbers import Domain, Parameter, Range, positive
from gnomon.cases.rigid_bodies.gyrocompass import Gyrocompass
from gnomon.reference.numerics.precision import Number
from gnomon.reference.oscillators.damped_oscillator import DampedMotion


def damped_compass(t: Any, state: Values, parameters: Values) -> Values:
    across, along, spin, earth, cosine, c = parameters
    return state[1], -(along * spin * earth * cosine * state[0] + c * state[1]) / across


def compass_matrix(parameters: Values) -> Values:
    across, along, spin, earth, cosine, c = parameters
    return 0, 1, -along * spin * earth * cosine / across, -c / across


def nothing_else(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


SCENE = hinged_point(damped_compass)


def damped_compass_energy(t: Any, state: Values, parameters: Values) -> Values:
    across, along, spin, earth, cosine, _c = parameters
    return ((across * state[1] * state[1] + along * spin * earth * cosine * state[0] * state[0]) / 2,)


class GyrocompassDamped(Case):
    name = "gyrocompass_damped"
    title = "Gyrocompass with viscous damping, small angles"
    section = "11.12.3"
    conventions = (
        "theta from true north in the horizontal plane, linearised, without the square of the Earth's rate: "
        "A theta'' = -C s Om coslat theta - c theta'."
    )
    state = Gyrocompass.state
    parameter_list = (*Gyrocompass.parameter_list, Parameter("c", "N m s", "0.004", "damping constant"))
    default_state = ("0.1", 0)
    domain = Domain(
        {
            "A": positive(0.1, 1.0),
            "C": positive(0.1, 1.0),
            "s": positive(1.0, 20.0),
            "Om": positive(0.1, 5.0),
            "coslat": Range(0.0, 1.0, low_open=True, typical=(0.1, 1.0)),
            "c": Range(low=0.0, typical=(0.0, 2.0)),
            "theta": Range(typical=(-0.3, 0.3)),
            "omega": Range(typical=(-0.3, 0.3)),
        }
    )
    variants = (
        Variant(
            "critical",
            "exactly critical, numbers exact in binary",
            {"A": 1, "C": 1, "s": 4, "Om": 1, "coslat": 1, "c": 4},
        ),
        Variant("overdamped", "approaches north slowly: rates differ by a factor 4e4", {"c": 4}),
        Variant("undamped", "c = 0: never settles", {"c": 0}),
    )
    invariants: ClassVar = {"energy": Invariant(damped_compass_energy, "decays")}
    forms = (SemiLinear(damped_compass, linear=compass_matrix, rest=nothing_else),)
    scene = SCENE

    @property
    def _stiffness(self) -> Fraction:
        n = self.parameters
        return n["C"] * n["s"] * n["Om"] * n["coslat"]

    @cached_property
    def _exact(self) -> DampedMotion:
        return DampedMotion(self.parameters["A"], self.parameters["c"], self._stiffness, *self.initial_state)

    def motion(self) -> DampedMotion:
        return self._exact

    @property
    def time_scale(self) -> float:
        return sqrt(float(self.parameters["A"] / self._stiffness))

    @property
    def fastest_time(self) -> float:
        return min(self.time_scale, 1 / float(self._exact.decay)) if self._exact.decay else self.time_scale

    def natural_span(self) -> Number:
        """10.37 damped periods, at most 10 decay times; 10 decay times of the slow mode if nothing oscillates."""
        if self._exact.regime != DampedMotion.UNDERDAMPED:
            return 10 / float(self._exact.rates()[0])
        cycles, decay = 10.37 * float(self._exact.period()), float(self._exact.decay)
        return cycles if decay * cycles <= 10 else 10 / decay

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        motion = self._exact
        found = {"damping_ratio": motion.damping_ratio(digits), "undamped_period": motion.undamped_period(digits)}
        if motion.regime == DampedMotion.UNDERDAMPED:
            found["period"] = motion.period(digits)
        return found
