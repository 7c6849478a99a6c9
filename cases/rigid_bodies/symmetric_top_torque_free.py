"""The torque-free axisymmetric body: regular precession."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import Equations, RigidBody, Values
from gnomon.cases.core.numbers import Domain, Parameter, Range, Rule, positive
from gnomon.cases.core.scene import Readings, Scene, SceneForm
from gnomon.cases.rigid_bodies.euler_top import (
    ORTHOGONAL,
    EulerTopCase,
    momentum_size,
    momentum_x,
    momentum_y,
    momentum_z,
    no_torque,
    spinning,
    twice_energy,
)
from gnomon.cases.rigid_bodies.euler_top_scene import euler_top_reading, euler_top_scene
from gnomon.reference.numerics.precision import Number
from gnomon.reference.rigid_bodies.euler_top import EulerTop


def axial_moments(parameters: Values) -> Values:
    across, along = parameters
    return across, across, along


def axial_spin(t: Any, state: Values, parameters: Values) -> Values:
    return (state[2],)


def of_three_moments(function: Equations) -> Equations:
    """A function of the general body for parameters (A, C)."""

    def with_axis(t: Any, state: Values, parameters: Values) -> Values:
        return function(t, state, axial_moments(parameters))

    return with_axis


def axial_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    return euler_top_scene(state, axial_moments(parameters))


def axial_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    return euler_top_reading(readings, axial_moments(parameters))


SCENE = SceneForm(axial_scene, axial_reading, frozenset({"gyroscopic"}), conservative=False)


class SymmetricTopTorqueFree(Case):
    name = "symmetric_top_torque_free"
    title = "Torque-free axisymmetric body: regular precession"
    section = "10.17"
    conventions = (
        "C is the moment about the third axis, A the transverse one. w are body components; R, row by row, maps them to space, "
        "R' = R hat(w). R(0) need not be orthogonal."
    )
    state = EulerTopCase.state
    parameter_list = (
        Parameter("A", "kg m^2", 2, "transverse moment of inertia"),
        Parameter("C", "kg m^2", 3, "axial moment of inertia"),
    )
    default_state = spinning("0.4", "0.3", 2)
    domain = Domain(
        {"A": positive(0.8, 1.5), "C": positive(0.5, 1.6)}
        | {name: Range(typical=(-2.0, 2.0)) for name in ("w1", "w2", "w3")}
        | {f"R{i}{j}": ORTHOGONAL for i in (1, 2, 3) for j in (1, 2, 3)},
        (Rule("the triangle inequality C <= 2 A", lambda n: n["C"] <= 2 * n["A"]),),
    )
    variants = (
        Variant("prolate", "a rod-like body: it precesses in the same sense as it spins", {"A": 3, "C": "0.3"}),
        Variant("disc", "a flat disc, C = 2 A: wobbles twice as fast as it spins", {"C": 4}, spinning("0.01", 0, 2)),
        Variant(
            "earth",
            "the Earth's free wobble of 305 days beside its daily rotation, three wobbles long",
            {"A": 1, "C": Fraction(306, 305)},
            spinning("1.458423e-10", 0, "7.292115e-5"),
            span="79100000",
        ),
        Variant("nearly_sphere", "C/A - 1 = 1e-9: the slow wobble is 1e-9 of the spin", {"A": 1, "C": "1.000000001"}),
        Variant("turns_1e5", "1e5 turns in space: drift by round-off", span=200000),
        Variant("engines", "the parameters of engine tests", initial_state=spinning("0.5", 0, 3), span=10),
    )
    invariants: ClassVar = {
        "twice_energy": Invariant(of_three_moments(twice_energy)),
        "momentum": Invariant(of_three_moments(momentum_size)),
        "momentum_x": Invariant(of_three_moments(momentum_x)),
        "momentum_y": Invariant(of_three_moments(momentum_y)),
        "momentum_z": Invariant(of_three_moments(momentum_z)),
        "axial_spin": Invariant(axial_spin),
    }
    forms = (RigidBody(axial_moments, no_torque),)
    scene = SCENE
    reversal = ("w1", "w2", "w3")

    @cached_property
    def _exact(self) -> EulerTop:
        w1, w2, w3, *attitude = self.initial_state
        across, along = self.parameter_values()
        return EulerTop((across, across, along), (w1, w2, w3), tuple(attitude))

    def motion(self) -> EulerTop:
        return self._exact

    @property
    def time_scale(self) -> float:
        """One radian at the initial rate."""
        rate = math.hypot(*map(float, self.initial_state[:3]))
        return 1 / rate if rate else 1.0

    def natural_span(self) -> Number:
        """10.37 turns about the angular momentum."""
        precession = float(self._exact.precession())
        return 10.37 * 2 * math.pi / precession if precession else 10.0

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        found = {"precession_rate": self._exact.precession(digits)}
        period = self._exact.body_period(digits)
        return found if period is None else found | {"body_period": period}
