"""Central motions in a plane: a mass on a string through a hole, the attraction k/r, two masses on a spring."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.numerics.well import WellMotion


@dataclass(frozen=True)
class Central(WellMotion):
    """r'' = r theta'^2 - U'(r), theta'' = -2 r' theta'/r; state (r, theta, r', theta'), r > 0, theta' not zero.

    V = h^2/(2 r^2) b + U with h = r^2 theta'; a subclass states U, its slope, and b, the rotating fraction of the mass.
    """

    r: Fraction
    theta: Fraction
    vr: Fraction
    omega: Fraction

    def _turning(self) -> Fraction:
        return Fraction(1)

    def _pull(self, mp: Any, r: Any) -> Any:
        raise NotImplementedError

    def _pull_slope(self, mp: Any, r: Any) -> Any:
        raise NotImplementedError

    @cached_property
    def spin(self) -> Fraction:
        """h = r^2 theta'."""
        return self.r**2 * self.omega

    @cached_property
    def _barrier(self) -> Fraction:
        return self._turning() * self.spin**2

    def _begin(self) -> tuple[Fraction, Fraction]:
        return self.r, self.vr

    def _walls(self, mp: Any) -> tuple[Any, Any]:
        return mp.zero, mp.inf

    def _potential(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self._barrier) / (2 * x**2) + self._pull(mp, x)

    def _slope(self, mp: Any, x: Any) -> Any:
        return self._pull_slope(mp, x) - mp.mpf(self._barrier) / x**3

    def _carried(self, mp: Any, x: Any) -> tuple[Any, ...]:
        return (mp.mpf(self.spin) / x**2,)

    def _read(self, mp: Any, t: Fraction, x: Any, rate: Any, carried: Sequence[Any]) -> Sequence[Any]:
        return x, mp.mpf(self.theta) + carried[0], rate, mp.mpf(self.spin) / x**2

    def _turned(self, mp: Any, carried: Sequence[Any], period: Any) -> Sequence[Any]:
        return mp.zero, carried[0], mp.zero, mp.zero


@dataclass(frozen=True)
class HangingMass(Central):
    """m1 on a smooth table, on a string through a hole to m2: (m1 + m2) r'' = m1 r theta'^2 - m2 g."""

    g: Fraction
    m1: Fraction
    m2: Fraction

    @cached_property
    def weight(self) -> Fraction:
        return self.m2 * self.g / (self.m1 + self.m2)

    @property
    def rests(self) -> bool:
        """Whether the motion is a circle."""
        return self.vr == 0 and self.m1 * self.r * self.omega**2 == self.m2 * self.g

    def _turning(self) -> Fraction:
        return self.m1 / (self.m1 + self.m2)

    def _bottom(self, mp: Any) -> Any:
        return mp.cbrt(mp.mpf(self._turning() * self.spin**2 / self.weight))

    def _pull(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.weight) * r

    def _pull_slope(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.weight)


@dataclass(frozen=True)
class Logarithmic(Central):
    """The attraction k/r: U = k ln(r)."""

    k: Fraction

    @property
    def rests(self) -> bool:
        return self.vr == 0 and (self.r * self.omega) ** 2 == self.k

    def _bottom(self, mp: Any) -> Any:
        return abs(mp.mpf(self.spin)) / mp.sqrt(mp.mpf(self.k))

    def _pull(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.k) * mp.log(r)

    def _pull_slope(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.k) / r


@dataclass(frozen=True)
class SpringDumbbell(Central):
    """Two masses on a spring of natural length l, relative to one: r'' = r theta'^2 - (k/mu)(r - l)."""

    stiffness: Fraction
    length: Fraction

    @property
    def rests(self) -> bool:
        return self.vr == 0 and self.r * self.omega**2 == self.stiffness * (self.r - self.length)

    def _bottom(self, mp: Any) -> Any:
        """r^3 (r - l) = h^2/(k/mu): Newton's method from above, where it is convex."""
        size, length = mp.mpf(self.spin**2 / self.stiffness), mp.mpf(self.length)
        r = length + mp.root(size, 4)
        for _ in range(200):
            step = (r**3 * (r - length) - size) / (4 * r**3 - 3 * length * r**2)
            r -= step
            if abs(step) <= 8 * mp.eps * r:
                break
        return r

    def _pull(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.stiffness) * (r - mp.mpf(self.length)) ** 2 / 2

    def _pull_slope(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.stiffness) * (r - mp.mpf(self.length))
