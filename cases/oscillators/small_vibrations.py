"""Small vibrations of three masses in a row, without damping.

Cases: small_vibrations_3dof_chain, small_vibrations_mdof.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from math import pi
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import SecondOrder, SemiLinear, Separable, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.core.row_scene import masses_in_a_row
from gnomon.reference.numerics.precision import Number
from gnomon.reference.oscillators.small_vibrations import Matrix, Vibrations, chain

STATE = tuple(
    [Coordinate(f"x{i}", "m", "length") for i in (1, 2, 3)]
    + [Coordinate(f"v{i}", "m/s", "velocity") for i in (1, 2, 3)]
)
STARTS = {c.name: Range(typical=(-2.0, 2.0)) for c in STATE}


def chain_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """Three equal masses between four equal springs."""
    x1, x2, x3 = q
    (k,) = parameters
    return k * (x2 - 2 * x1), k * (x1 + x3 - 2 * x2), k * (x2 - 2 * x3)


def chain_potential(t: Any, q: Values, parameters: Values) -> Values:
    x1, x2, x3 = q
    (k,) = parameters
    return (k * (x1 * x1 + (x2 - x1) * (x2 - x1) + (x3 - x2) * (x3 - x2) + x3 * x3) / 2,)


def chain_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    v1, v2, v3 = state[3:]
    return ((v1 * v1 + v2 * v2 + v3 * v3) / 2 + chain_potential(t, state[:3], parameters)[0],)


def row_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """Three masses, each on a spring to the ground, with springs between neighbours."""
    x1, x2, x3 = q
    m1, m2, m3, k1, k2, k3, k12, k23 = parameters
    first, second = k12 * (x2 - x1), k23 * (x3 - x2)
    return (first - k1 * x1) / m1, (second - first - k2 * x2) / m2, (-second - k3 * x3) / m3


def row_energy(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, v1, v2, v3 = state
    m1, m2, m3, k1, k2, k3, k12, k23 = parameters
    twice = m1 * v1 * v1 + m2 * v2 * v2 + m3 * v3 * v3 + k1 * x1 * x1 + k2 * x2 * x2 + k3 * x3 * x3
    return ((twice + k12 * (x2 - x1) * (x2 - x1) + k23 * (x3 - x2) * (x3 - x2)) / 2,)


def chain_equations(t: Any, state: Values, parameters: Values) -> Values:
    return (*state[3:], *chain_acceleration(t, state[:3], parameters))


def row_equations(t: Any, state: Values, parameters: Values) -> Values:
    return (*state[3:], *row_acceleration(t, state[:3], parameters))


def chain_matrix(parameters: Values) -> Values:
    (k,) = parameters
    return row_matrix((1, 1, 1, k, 0, k, k, k))


def row_matrix(parameters: Values) -> Values:
    """The matrix of the first-order equations, row by row; the first three rows are x' = v."""
    m1, m2, m3, k1, k2, k3, k12, k23 = parameters
    return (
        *(0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1),
        *(-(k1 + k12) / m1, k12 / m1, 0, 0, 0, 0),
        *(k12 / m2, -(k12 + k2 + k23) / m2, k23 / m2, 0, 0, 0),
        *(0, k23 / m3, -(k23 + k3) / m3, 0, 0, 0),
    )


def nothing_else(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0, 0, 0, 0, 0


def chain_as_row(parameters: Values) -> Values:
    (k,) = parameters
    return 1.0, 1.0, 1.0, k, 0.0, k, k, k


CHAIN_SCENE = masses_in_a_row(3, chain_as_row)
ROW_SCENE = masses_in_a_row(3, lambda parameters: parameters)


class _Vibrating(Case):
    """Base of the two cases: a motion of three modes."""

    section = "11.13"
    state = STATE
    reversal = ("v1", "v2", "v3")
    mirror = ("x1", "x2", "x3", "v1", "v2", "v3")

    _CYCLES: ClassVar[dict[str, float]] = {}
    """Spans by variant, in periods of the slowest mode with a frequency above zero; others last 10.37 periods."""

    @cached_property
    def _exact(self) -> Vibrations:
        raise NotImplementedError

    def motion(self) -> Vibrations:
        return self._exact

    @cached_property
    def _moving(self) -> list[float]:
        """The frequencies above zero (rad/s); 1 rad/s if there is none."""
        return [w for w in map(float, self._exact.frequencies()) if w > 0] or [1.0]

    @property
    def time_scale(self) -> float:
        """One radian of the slowest mode with a frequency above zero."""
        return 1 / self._moving[0]

    @property
    def fastest_time(self) -> float:
        return 1 / self._moving[-1]

    def natural_span(self) -> Number:
        return self._CYCLES.get(self.variant or "", 10.37) * 2 * pi * self.time_scale

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        return {f"frequency_{i}": w for i, w in enumerate(self._exact.frequencies(digits), start=1)}


class SmallVibrationsChain(_Vibrating):
    """Three equal masses and four equal springs between two walls."""

    name = "small_vibrations_3dof_chain"
    title = "Three equal masses, four equal springs, fixed ends: modal closed form"
    section = "11.13.2"
    conventions = "x1, x2, x3 from the equilibrium; k is stiffness over mass; frequencies 2 sqrt(k) sin(j pi/8)."
    parameter_list = (Parameter("k", "1/s^2", 1, "stiffness of each spring over each mass"),)
    default_state = (1, 0, "-0.5", 0, "0.25", 0)
    domain = Domain({"k": positive()} | STARTS)
    variants = (
        Variant(
            "slow_mode",
            "the slowest mode up to rounding: its shape is irrational, so both other modes have amplitudes of 1e-16",
            initial_state=(1, 1.4142135623730951, 1, 0, 0, 0),
        ),
        Variant("middle_mode", "the middle mass stays at rest", initial_state=(1, 0, -1, 0, 0, 0)),
        Variant("long_1e4", "10,000 periods of the slowest mode: three phase errors"),
    )
    _CYCLES: ClassVar = {"long_1e4": 10000.37}
    invariants: ClassVar = {"energy": Invariant(chain_energy)}
    forms = (
        Separable(chain_acceleration, chain_potential),
        SemiLinear(chain_equations, linear=chain_matrix, rest=nothing_else),
    )
    scene = CHAIN_SCENE
    alike = (("x1", "v1"), ("x3", "v3"))

    @cached_property
    def _exact(self) -> Vibrations:
        k = self.parameters["k"]
        one, none = Fraction(1), Fraction(0)
        springs = chain((k, none, k), (k, k))
        return Vibrations((one, one, one), springs, _zeros(), self.initial_state[:3], self.initial_state[3:])


class SmallVibrations(_Vibrating):
    """Three masses, each on its spring to the ground, with springs between neighbours."""

    name = "small_vibrations_mdof"
    title = "Small vibrations of three masses: beats, molecules, stiff couplings"
    conventions = (
        "x1, x2, x3 from the equilibrium; springs k1, k2, k3 join each mass to the ground, k12 and k23 join neighbours. "
        "A pendulum of mass m with small swings is like a spring m g/L to the ground."
    )
    parameter_list = (
        Parameter("m1", "kg", 1, "first mass"),
        Parameter("m2", "kg", 2, "second mass"),
        Parameter("m3", "kg", "1.5", "third mass"),
        Parameter("k1", "N/m", 10, "first mass to the ground"),
        Parameter("k2", "N/m", 0, "second mass to the ground"),
        Parameter("k3", "N/m", 5, "third mass to the ground"),
        Parameter("k12", "N/m", 8, "between first and second mass"),
        Parameter("k23", "N/m", 12, "between second and third mass"),
    )
    default_state = (1, 0, 0, 0, 0, "0.5")
    domain = Domain(
        {name: positive() for name in ("m1", "m2", "m3")}
        | {name: Range(low=0.0, typical=(0.0, 20.0)) for name in ("k1", "k2", "k3", "k12", "k23")}
        | STARTS
    )
    variants = (
        Variant(
            "beats",
            "equal pendulums, coupled at 1e-3: the motion passes to the next one and back in 2000 swings",
            {"m1": 1, "m2": 1, "m3": 1, "k1": 1, "k2": 1, "k3": 1, "k12": "0.001", "k23": "0.001"},
            (1, 0, 0, 0, 0, 0),
        ),
        Variant(
            "near_degenerate",
            "equal pendulums, coupled at 1e-10: three frequencies equal to ten digits, beats of 1e10 swings",
            {"m1": 1, "m2": 1, "m3": 1, "k1": 1, "k2": 1, "k3": 1, "k12": "1e-10", "k23": "1e-10"},
            (1, 0, 0, 0, 0, 0),
        ),
        Variant(
            "carbon_dioxide",
            "masses 16:12:16 on two springs: a mode of frequency zero, in which the molecule drifts",
            {"m1": 16, "m2": 12, "m3": 16, "k1": 0, "k2": 0, "k3": 0, "k12": 1400, "k23": 1400},
            ("0.1", 0, "-0.05", "0.5", 0, 0),
        ),
        Variant(
            "stiff_1e12",
            "a coupling 1e12 times stiffer than the others: frequencies 1e6 apart",
            {"m1": 1, "m2": 1, "m3": 1, "k1": 1, "k2": 1, "k3": 1, "k12": 10**12, "k23": 1},
            (1, 1, 0, 0, 0, 0),
        ),
        Variant(
            "free",
            "no springs: all three modes have frequency zero",
            dict.fromkeys(("k1", "k2", "k3", "k12", "k23"), 0),
            (1, 2, 3, 1, 0, -1),
        ),
    )
    _CYCLES: ClassVar = {"beats": 2100.37, "free": 2}
    invariants: ClassVar = {"energy": Invariant(row_energy)}
    forms = (SecondOrder(row_acceleration), SemiLinear(row_equations, linear=row_matrix, rest=nothing_else))
    scene = ROW_SCENE
    alike = (("x1", "v1", "m1", "k1", "k12"), ("x3", "v3", "m3", "k3", "k23"))

    @cached_property
    def _exact(self) -> Vibrations:
        m1, m2, m3, k1, k2, k3, k12, k23 = self.parameter_values()
        springs = chain((k1, k2, k3), (k12, k23))
        return Vibrations((m1, m2, m3), springs, _zeros(), self.initial_state[:3], self.initial_state[3:])


def _zeros() -> Matrix:
    return chain((Fraction(0),) * 3, (Fraction(0),) * 2)
