"""A bead that slides on a smooth curve in a vertical plane: parabola, quartic, catenary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.well import WellMotion


@dataclass(frozen=True)
class Curve(WellMotion):
    """A bead on a smooth curve y(x) that is even and convex: state (q, q'), q = x or the arc length."""

    g: Fraction
    size: Fraction
    q0: Fraction
    v0: Fraction

    @property
    def rests(self) -> bool:
        return self.q0 == 0 and self.v0 == 0

    def _begin(self) -> tuple[Fraction, Fraction]:
        return self.q0, self.v0

    def _bottom(self, mp: Any) -> Any:
        return mp.zero

    def _read(self, mp: Any, t: Fraction, x: Any, rate: Any, carried: Sequence[Any]) -> Sequence[Any]:
        return x, rate

    def _turned(self, mp: Any, carried: Sequence[Any], period: Any) -> Sequence[Any]:
        return mp.zero, mp.zero


@dataclass(frozen=True)
class Parabola(Curve):
    """y = x^2/(4 p), p the focal length; q = x."""

    def _mass(self, mp: Any, x: Any) -> Any:
        return 1 + (x / (2 * mp.mpf(self.size))) ** 2

    def _potential(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.g) * x**2 / (4 * mp.mpf(self.size))

    def _slope(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.g) * x / (2 * mp.mpf(self.size))


@dataclass(frozen=True)
class Quartic(Curve):
    """y = x^4/a^3; q = x."""

    def _mass(self, mp: Any, x: Any) -> Any:
        return 1 + 16 * (x / mp.mpf(self.size)) ** 6

    def _potential(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.g) * x**4 / mp.mpf(self.size) ** 3

    def _slope(self, mp: Any, x: Any) -> Any:
        return 4 * mp.mpf(self.g) * x**3 / mp.mpf(self.size) ** 3


@dataclass(frozen=True)
class Catenary(Curve):
    """y = c cosh(x/c) = sqrt(c^2 + s^2); q = s, the arc length. V = g (y - c)."""

    def _potential(self, mp: Any, x: Any) -> Any:
        c = mp.mpf(self.size)
        return mp.mpf(self.g) * x**2 / (mp.hypot(c, x) + c)

    def _slope(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.g) * x / mp.hypot(mp.mpf(self.size), x)
