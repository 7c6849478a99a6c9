"""The planar double pendulum."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import cos, sin
from typing import Any, ClassVar

from gnomon.cases.case import Invariant, Variant
from gnomon.cases.forms import FirstOrder, Values
from gnomon.cases.integrated import IntegratedCase
from gnomon.cases.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.reference.precision import Number, publish, working


def double_pendulum_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Lagrange's equations, solved for the accelerations."""
    th1, th2, w1, w2 = state
    m1, m2, l1, l2, g = parameters
    sine, cosine = sin(th1 - th2), cos(th1 - th2)
    weight1, weight2 = g * sin(th1), g * sin(th2)
    first, second = l1 * w1 * w1, l2 * w2 * w2
    inertia = m1 + m2 * sine * sine
    total = m1 + m2
    a1 = m2 * (weight2 * cosine - sine * (first * cosine + second)) - total * weight1
    a2 = total * (weight1 * cosine - weight2 + sine * first) + m2 * sine * cosine * second
    return w1, w2, a1 / (l1 * inertia), a2 / (l2 * inertia)


def double_pendulum_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy, from the pivot."""
    th1, th2, w1, w2 = state
    m1, m2, l1, l2, g = parameters
    first, second = l1 * w1, l2 * w2
    kinetic = (m1 + m2) * first * first / 2 + m2 * second * (second / 2 + first * cos(th1 - th2))
    return (kinetic - (m1 + m2) * g * l1 * cos(th1) - m2 * g * l2 * cos(th2),)


class DoublePendulum(IntegratedCase):
    """Two point masses on two rigid massless rods, the second hanging from the first."""

    name = "double_pendulum"
    title = "Planar double pendulum (no closed form; certified Taylor)"
    section = "11.9, 11.13"
    conventions = "th1, th2 from the downward vertical, rad, continuous (not wrapped); absolute angles."
    state = (
        Coordinate("th1", "rad", "angle"),
        Coordinate("th2", "rad", "angle"),
        Coordinate("w1", "rad/s", "angular velocity"),
        Coordinate("w2", "rad/s", "angular velocity"),
    )
    parameter_list = (
        Parameter("m1", "kg", 1, "upper mass"),
        Parameter("m2", "kg", 1, "lower mass"),
        Parameter("l1", "m", 1, "upper rod"),
        Parameter("l2", "m", 1, "lower rod"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
    )
    default_state = (2, 1, 0, 0)
    domain = Domain(
        {name: positive(0.5, 2.0) for name in ("m1", "m2", "l1", "l2")}
        | {"g": positive(5.0, 15.0)}
        | {name: Range(typical=(-2.0, 2.0)) for name in ("th1", "th2", "w1", "w2")}
    )
    variants = (
        Variant("small", "small swings: two modes, as good as linear", initial_state=("1e-3", "-1e-3", 0, 0)),
        Variant(
            "upright",
            "released 1e-8 off the top: a long exponential phase first",
            initial_state=("3.14159264", "3.1415926", 0, 0),
        ),
        Variant("light_below", "a lower mass of 1e-6: hardly moves the upper, whips itself", {"m2": "1e-6"}),
        Variant(
            "light_above",
            "an upper mass of 0.01: whirls twenty times faster than the lower swings",
            {"m1": "0.01"},
            (1, "1.1", 0, 0),
        ),
    )
    invariants: ClassVar = {"energy": Invariant(double_pendulum_energy)}

    _SCALES: ClassVar = {"light_above": 1.87}

    @property
    def forms(self) -> tuple[FirstOrder, ...]:
        return (FirstOrder(double_pendulum_equations),)

    def _frequencies(self, digits: int = 15) -> tuple[Any, ...]:
        """Of small swings: roots of m1 w^4 - (m1 + m2) g (1/l1 + 1/l2) w^2 + (m1 + m2) g^2/(l1 l2) = 0."""
        with working(digits + 10) as mp:
            m1, m2, l1, l2, g = map(mp.mpf, self.parameter_values())
            total = (m1 + m2) / m1
            half, product = total * g * (1 / l1 + 1 / l2) / 2, total * g * g / (l1 * l2)
            upper = half + mp.sqrt(half * half - product)
            return publish((mp.sqrt(product / upper), mp.sqrt(upper)), digits)

    @property
    def time_scale(self) -> float:
        """One radian of the slow mode of small swings."""
        return 1 / float(self._frequencies()[0])

    @property
    def fastest_time(self) -> float:
        return 1 / float(self._frequencies()[1])

    def natural_span(self) -> Number:
        """10.37 radians of the slow small swing: chaos has not set in yet."""
        return self._SCALES.get(self.variant or "", 10.37) * self.time_scale

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """Angular frequencies of the two modes of small swings."""
        slow, fast = self._frequencies(digits)
        return {"slow_frequency": slow, "fast_frequency": fast}

    def reversed(self, state: Sequence[Any]) -> tuple[tuple[Any, ...], dict[str, Fraction]]:
        th1, th2, w1, w2 = state
        return (th1, th2, -w1, -w2), self.parameters
