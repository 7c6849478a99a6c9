"""A man who walks back and forth on a cart or in a boat: the centre of mass moves uniformly."""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from math import cos, sin, tau
from typing import Any, ClassVar

from gnomon.cases.core.cart_scene import MAN
from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import SecondOrder, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.reference.numerics.precision import Number
from gnomon.reference.oscillators.forced_oscillators import ForcedLinear

ZERO = Fraction(0)


def cart_recoils(t: Any, q: Values, parameters: Values) -> Values:
    """(m + M) x'' = -m xi'', with xi = (d/2) (1 - cos(w t)) the man's position on the cart."""
    m, M, d, w = parameters
    return (-m * d * w * w * cos(w * t) / (2 * (m + M)),)


def cart_and_man_momentum(t: Any, state: Values, parameters: Values) -> Values:
    _, v = state
    m, M, d, w = parameters
    return ((m + M) * v + m * d * w * sin(w * t) / 2,)


def cart_and_man_centre(t: Any, state: Values, parameters: Values) -> Values:
    """x_C - v_C t, constant; the cart's centre of mass is at x."""
    x, v = state
    m, M, d, w = parameters
    share, half = m / (m + M), sin(w * t / 2)
    return (x + share * d * half * half - t * (v + share * d * w * sin(w * t) / 2),)


class ManOnCart(Case):
    name = "man_on_cart"
    title = "Man walking back and forth on a cart (or in a boat): the centre of mass moves uniformly"
    section = "8.2, 8.4"
    conventions = (
        "x of the cart, on a smooth floor (of the boat, on water without resistance). The man walks from one end to the "
        "other and back: he is at x + xi, with xi = (d/2) (1 - cos(w t)) prescribed."
    )
    state = (Coordinate("x", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("m", "kg", 75, "mass of the man"),
        Parameter("M", "kg", 150, "mass of the cart"),
        Parameter("d", "m", 3, "length of the walk"),
        Parameter("w", "rad/s", "0.5", "frequency of the walk"),
    )
    default_state = (0, "0.01")
    domain = Domain(
        {"m": positive(), "M": positive(), "d": Range(typical=(-3.0, 3.0)), "w": positive(0.1, 5.0)}
        | {name: Range(typical=(-3.0, 3.0)) for name in ("x", "v")}
    )
    variants = (
        Variant(
            "light_cart", "M = 1e-9 m: the man stays in place, the cart moves back and forth below him", {"M": "75e-9"}
        ),
        Variant(
            "heavy_cart",
            "M = 1e9 m: the cart moves by 1e-9 of the walk, below a larger absolute tolerance",
            {"M": 75 * 10**9},
            (0, 0),
        ),
        Variant(
            "drifting", "drifts at 1e6 m/s: few digits of the state are left for the walk", initial_state=(0, 10**6)
        ),
        Variant("long_1e5", "100,000 walks: phase error"),
    )
    invariants: ClassVar = {
        "momentum": Invariant(cart_and_man_momentum),
        "centre_of_mass_start": Invariant(cart_and_man_centre),
    }
    autonomous = False
    forms = (SecondOrder(cart_recoils),)
    scene = MAN

    @cached_property
    def _exact(self) -> ForcedLinear:
        _, _, _, w = self.parameter_values()
        return ForcedLinear(ZERO, ZERO, ZERO, -self._half_way * w * w, ZERO, w, ZERO, *self.initial_state)

    @property
    def _half_way(self) -> Fraction:
        """m d/(2 (m + M)), half the distance that the cart moves."""
        m, M, d, _ = self.parameter_values()
        return m * d / (2 * (m + M))

    def motion(self) -> ForcedLinear:
        return self._exact

    @property
    def time_scale(self) -> float:
        """1/w."""
        return 1 / float(self.parameters["w"])

    def natural_span(self) -> Number:
        """10.37 walks, each to the other end and back."""
        return (100_000.37 if self.variant == "long_1e5" else 10.37) * tau * self.time_scale

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """The distance that the cart moves, m d/(m + M) (m); the largest force (N); the speed of the centre of mass (m/s)."""
        motion, (_, M, _, w) = self._exact, self.parameter_values()
        exact = {
            "cart_way": 2 * abs(self._half_way),
            "largest_force": M * abs(self._half_way) * w * w,
            "centre_speed": self.initial_state[1],
        }
        return {name: motion._rational(digits, value) for name, value in exact.items()}
