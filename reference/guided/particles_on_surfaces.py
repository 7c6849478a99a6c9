"""A particle on a smooth surface of revolution with a vertical axis: a motion in a well.

The azimuth is cyclic: with h = rho^2 phi' constant, M(x) x'^2/2 + h^2/(2 rho(x)^2) + g z(x) = E for the coordinate x
along the meridian (rho, z).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
from gnomon.reference.numerics.phase import Balls
from gnomon.reference.numerics.precision import working
from gnomon.reference.numerics.well import EXTRA, WellMotion


@dataclass(frozen=True)
class OnSurface(WellMotion):
    """State (x, phi, x', phi'); a subclass states the meridian, its slopes, M, and the bottom of the well."""

    g: Fraction
    x: Fraction
    phi: Fraction
    rate: Fraction
    spin: Fraction

    @abstractmethod
    def _radius(self, mp: Any, x: Any) -> Any:
        """Distance from the axis."""

    @abstractmethod
    def _height(self, mp: Any, x: Any) -> Any: ...

    @abstractmethod
    def _slopes(self, mp: Any, x: Any) -> tuple[Any, Any]:
        """d rho/dx and dz/dx."""

    def momentum(self, digits: int = 15) -> Any:
        """h = rho^2 phi', conjugate to the azimuth, over the mass."""
        return self._quantity(digits, self._momentum)

    def fastest_turn(self, digits: int = 15) -> Any:
        """The largest |phi'|, at the turning point closest to the axis."""

        def largest(mp: Any) -> Any:
            edges = (mp.mpf(self.x),) if self.rests else self._edges(mp)
            return abs(self._momentum(mp)) / min(self._radius(mp, x) for x in edges) ** 2

        return self._quantity(digits, largest, EXTRA)

    @property
    def rests(self) -> bool:
        """Whether it moves on a parallel circle; never at rational angles, whose cosine is irrational (Lindemann)."""
        return False

    def _begin(self) -> tuple[Fraction, Fraction]:
        return self.x, self.rate

    def _momentum(self, mp: Any) -> Any:
        return _kept_momentum(self, mp, flint.ctx.prec if mp is Balls else mp.prec)

    def _potential(self, mp: Any, x: Any) -> Any:
        return (self._momentum(mp) / self._radius(mp, x)) ** 2 / 2 + mp.mpf(self.g) * self._height(mp, x)

    def _slope(self, mp: Any, x: Any) -> Any:
        out, up = self._slopes(mp, x)
        return mp.mpf(self.g) * up - self._momentum(mp) ** 2 * out / self._radius(mp, x) ** 3

    def _carried(self, mp: Any, x: Any) -> tuple[Any, ...]:
        return (self._momentum(mp) / self._radius(mp, x) ** 2,)

    def _read(self, mp: Any, t: Fraction, x: Any, rate: Any, carried: Sequence[Any]) -> Sequence[Any]:
        return x, mp.mpf(self.phi) + carried[0], rate, self._momentum(mp) / self._radius(mp, x) ** 2

    def _turned(self, mp: Any, carried: Sequence[Any], period: Any) -> Sequence[Any]:
        return mp.zero, carried[0], mp.zero, mp.zero


@lru_cache(maxsize=64)
def _kept_momentum(motion: OnSurface, mp: Any, bits: int) -> Any:
    """Cached by precision, because integrals need it thousands of times."""
    return motion._radius(mp, mp.mpf(motion.x)) ** 2 * mp.mpf(motion.spin)


@dataclass(frozen=True)
class OnCone(OnSurface):
    """A cone: x from the tip along the wall, alpha between axis and wall; phi' != 0."""

    alpha: Fraction

    def _radius(self, mp: Any, x: Any) -> Any:
        return x * mp.sin(mp.mpf(self.alpha))

    def _height(self, mp: Any, x: Any) -> Any:
        return x * mp.cos(mp.mpf(self.alpha))

    def _slopes(self, mp: Any, x: Any) -> tuple[Any, Any]:
        return mp.sin(mp.mpf(self.alpha)), mp.cos(mp.mpf(self.alpha))

    def _bottom(self, mp: Any) -> Any:
        sine, cosine = mp.sin(mp.mpf(self.alpha)), mp.cos(mp.mpf(self.alpha))
        return mp.cbrt((self._momentum(mp) / sine) ** 2 / (mp.mpf(self.g) * cosine))

    def _walls(self, mp: Any) -> tuple[Any, Any]:
        return mp.zero, mp.inf


@dataclass(frozen=True)
class OnParaboloid(OnSurface):
    """A paraboloid: z = x^2/(2 p), x from the axis; phi' != 0."""

    p: Fraction

    @property
    def rests(self) -> bool:
        return self.rate == 0 and self.spin**2 * self.p == self.g

    def _mass(self, mp: Any, x: Any) -> Any:
        return 1 + (x / mp.mpf(self.p)) ** 2

    def _radius(self, mp: Any, x: Any) -> Any:
        return x

    def _height(self, mp: Any, x: Any) -> Any:
        return x**2 / (2 * mp.mpf(self.p))

    def _slopes(self, mp: Any, x: Any) -> tuple[Any, Any]:
        return mp.one, x / mp.mpf(self.p)

    def _bottom(self, mp: Any) -> Any:
        return mp.sqrt(abs(self._momentum(mp)) * mp.sqrt(mp.mpf(self.p / self.g)))

    def _walls(self, mp: Any) -> tuple[Any, Any]:
        return mp.zero, mp.inf


@dataclass(frozen=True)
class OnTorus(OnSurface):
    """A torus: rho = R + a cos(x), z = a sin(x), a < R; V bounds the motion between x = -pi and pi/2."""

    R: Fraction
    a: Fraction

    @property
    def swings(self) -> bool:
        """Whether the energy is below V at x = -pi and at x = pi/2, decided with 40 digits."""
        with working(40) as mp:
            if not -mp.pi < mp.mpf(self.x) < mp.pi / 2:
                return False
            edges = (self._potential(mp, edge) for edge in self._walls(mp))
            return bool(self._energy(mp) < min(edges) - mp.mpf(10) ** -30 * mp.mpf(self.g * self.R))

    def _mass(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.a**2) + 0 * x

    def _radius(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.R) + mp.mpf(self.a) * mp.cos(x)

    def _height(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.a) * mp.sin(x)

    def _slopes(self, mp: Any, x: Any) -> tuple[Any, Any]:
        return -mp.mpf(self.a) * mp.sin(x), mp.mpf(self.a) * mp.cos(x)

    def _bottom(self, mp: Any) -> Any:
        """The root of V' between -pi/2 and 0, where g cos(x) grows and h^2 (-sin(x))/rho^3 falls; by bisection."""
        low, high = -mp.pi / 2, mp.zero
        for _ in range(mp.prec + 10):
            middle = (low + high) / 2
            low, high = (middle, high) if self._slope(mp, middle) < 0 else (low, middle)
        return (low + high) / 2

    def _walls(self, mp: Any) -> tuple[Any, Any]:
        return -mp.pi, mp.pi / 2
