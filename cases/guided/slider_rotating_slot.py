"""A slider in a radial slot of a rotating table."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property
from math import sqrt, tau
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import Form, SemiLinear, Separable, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.core.point_scene import railed_point, railed_pull
from gnomon.cases.core.scene import SceneForm
from gnomon.reference.guided.slider_rotating_slot import Slot
from gnomon.reference.numerics.precision import Number


def slot_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = Om^2 r - (k/m) (r - r0) - 2 mu Om r'."""
    r, v = state
    m, k, r0, Om, mu = parameters
    return v, Om * Om * r - (k / m) * (r - r0) - 2 * mu * Om * v


def slot_matrix(parameters: Values) -> Values:
    m, k, _, Om, mu = parameters
    return 0, 1, Om * Om - k / m, -2 * mu * Om


def spring_offset(t: Any, state: Values, parameters: Values) -> Values:
    m, k, r0, _, _ = parameters
    return 0, k / m * r0


def smooth_slot(t: Any, q: Values, parameters: Values) -> Values:
    """r'' = Om^2 r - (k/m) (r - r0)."""
    (r,) = q
    m, k, r0, Om, _ = parameters
    return (Om * Om * r - (k / m) * (r - r0),)


def smooth_slot_potential(t: Any, q: Values, parameters: Values) -> Values:
    (r,) = q
    m, k, r0, Om, _ = parameters
    return (((k / m) * (r - r0) * (r - r0) - Om * Om * r * r) / 2,)


def jacobi_integral(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass in the rotating frame, the centrifugal potential included; friction makes it decay."""
    r, v = state
    m, k, r0, Om, _ = parameters
    return ((v * v - Om * Om * r * r + (k / m) * (r - r0) * (r - r0)) / 2,)


ROUGH_SCENE, SMOOTH_SCENE = railed_point(slot_equations), railed_pull(smooth_slot)
"""In the frame of the table: a fixed rail with the centrifugal force and the friction due to the Coriolis force."""


class SliderRotatingSlot(Case):
    name = "slider_rotating_slot"
    title = "Slider block in a radial slot of a steadily rotating table: free, spring controlled, wall friction"
    section = "6.9.1, 6.9.2"
    conventions = (
        "The spring is unstretched at r0. Friction follows from the Coriolis force on the wall: linear damping for either "
        "sign of v. Om >= 0. The slot passes through the axis: r may change its sign."
    )
    state = (Coordinate("r", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("m", "kg", 1, "mass of the slider"),
        Parameter("k", "N/m", 20, "stiffness of the spring"),
        Parameter("r0", "m", "0.2", "position at which the spring is unstretched"),
        Parameter("Om", "rad/s", 3, "rate of the table"),
        Parameter("mu", "1", "0.1", "coefficient of friction on the wall"),
    )
    default_state = ("0.3", "0.4")
    domain = Domain(
        {"m": positive(0.5, 5.0), "k": Range(low=0.0, typical=(0.0, 30.0)), "r0": Range(typical=(0.0, 1.0))}
        | {"Om": Range(low=0.0, typical=(0.5, 5.0)), "mu": Range(low=0.0, typical=(0.0, 0.5))}
        | {"r": Range(typical=(-1.0, 1.0)), "v": Range(typical=(-2.0, 2.0))}
    )
    variants = (
        Variant("free", "no spring: moves outward as e^(Om t)", {"k": 0, "mu": 0}),
        Variant("smooth", "no friction: harmonic about a shifted centre", {"mu": 0}),
        Variant("critical", "k/m = Om^2: uniformly accelerated", {"k": 9, "mu": 0}),
        Variant("below_critical", "k/m - Om^2 = 1e-12: a period of 73 days", {"k": "9.000000000001", "mu": 0}),
        Variant("above_critical", "k/m - Om^2 = -1e-12: grows by e in 12 days", {"k": "8.999999999999", "mu": 0}),
        Variant("growth", "moves outward by a factor e^50", {"k": 0, "mu": 0}, span="16.67"),
        Variant("rough", "mu = 2: overdamped by the wall", {"mu": 2}),
    )
    invariants: ClassVar = {"jacobi": Invariant(jacobi_integral, "decays")}
    reversal = ("v",)

    @cached_property
    def _exact(self) -> Slot:
        return Slot(*self.parameter_values(), *self.initial_state)

    def motion(self) -> Slot:
        return self._exact

    @property
    def forms(self) -> tuple[Form, ...]:
        """Separable without friction."""
        linear = SemiLinear(slot_equations, linear=slot_matrix, rest=spring_offset)
        return (linear,) if self.parameters["mu"] else (Separable(smooth_slot, smooth_slot_potential), linear)

    @property
    def scene(self) -> SceneForm:
        return ROUGH_SCENE if self.parameters["mu"] else SMOOTH_SCENE

    @property
    def time_scale(self) -> float:
        """The shortest time of table, spring and friction; 1 s without any."""
        m, k, _, Om, mu = map(float, self.parameter_values())
        return 1 / (sqrt(max(Om * Om, k / m)) + 2 * mu * Om or 1.0)

    def natural_span(self) -> Number:
        """10.37 periods or decay times; a growth by e^10; 10 radians of the table at or near the critical speed."""
        motion = self._exact
        growth, pull = float(motion.rates()[0]), float(motion.pull)
        Om = float(motion.rate)
        if abs(pull) < 1e-6 * Om * Om or Om == 0 == pull:
            return 10 / (Om or 1.0)
        if growth > 0:
            return 10 / growth
        turning = -pull - float(motion.damping) ** 2 / 4
        return 10.37 * (tau / sqrt(turning) if turning > 0.01 else min(1 / max(-growth, 0.01), 10.0))

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`wall_force` at the start, 2 m Om v (N)."""
        motion = self._exact
        fast, slow = motion.rates(digits)
        force = 2 * motion.mass * motion.rate * motion.v0
        found = {"larger_rate": fast, "smaller_rate": slow}
        found["wall_force"] = motion._quantity(digits, lambda mp: mp.mpf(force))
        balance = motion.balance(digits)
        return found if balance is None else found | {"balance": balance}

    def reversed(self, state: Sequence[Any]) -> tuple[tuple[Any, ...], dict[str, Fraction]] | None:
        """Only without friction."""
        return super().reversed(state) if self.parameters["mu"] == 0 else None
