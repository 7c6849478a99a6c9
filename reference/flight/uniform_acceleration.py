"""Uniformly accelerated motions, q'' = a with constant a: in rational numbers where a is rational.

An Atwood machine, and a block on a wedge that is free to slide (Beatty, Dynamics, 8.8 to 8.11).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion


@dataclass(frozen=True)
class Uniform(Motion):
    """State (q..., q'...). A subclass states the accelerations."""

    places: tuple[Fraction, ...]
    velocities: tuple[Fraction, ...]

    @abstractmethod
    def _accelerations(self, mp: Any) -> Sequence[Any]: ...

    def acceleration(self, index: int = 0, digits: int = 15) -> Any:
        return self._quantity(digits, lambda mp: self._accelerations(mp)[index])

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        time, rates = mp.mpf(t), self._accelerations(mp)
        falls = [a * time**2 / 2 for a in rates]
        places = [mp.mpf(x + v * t) + fall for x, v, fall in zip(self.places, self.velocities, falls, strict=True)]
        return [*places, *(mp.mpf(v) + a * time for v, a in zip(self.velocities, rates, strict=True))]


@dataclass(frozen=True)
class Atwood(Uniform):
    """x, by which m1 has descended: x'' = g (m1 - m2)/(m1 + m2 + I/R^2)."""

    g: Fraction
    m1: Fraction
    m2: Fraction
    inertia: Fraction
    radius: Fraction

    @property
    def rate(self) -> Fraction:
        return self.g * (self.m1 - self.m2) / (self.m1 + self.m2 + self.inertia / self.radius**2)

    def tensions(self, digits: int = 15) -> tuple[Any, Any]:
        """Tensions of the rope on the sides of m1 and m2 (N)."""
        first, second = self.m1 * (self.g - self.rate), self.m2 * (self.g + self.rate)
        return self._quantity(digits, lambda mp: mp.mpf(first)), self._quantity(digits, lambda mp: mp.mpf(second))

    def _accelerations(self, mp: Any) -> Sequence[Any]:
        return (mp.mpf(self.rate),)


@dataclass(frozen=True)
class Wedge(Uniform):
    """X of the wedge and s of the block down its face, without friction."""

    g: Fraction
    m: Fraction
    M: Fraction
    alpha: Fraction

    def _accelerations(self, mp: Any) -> Sequence[Any]:
        g, m, M = mp.mpf(self.g), mp.mpf(self.m), mp.mpf(self.M)
        cosine, sine = mp.cos_sin(mp.mpf(self.alpha))
        common = g * sine / (M + m * sine**2)
        return -m * cosine * common, (M + m) * common

    def normal_force(self, digits: int = 15) -> Any:
        """Normal force between block and wedge (N): m M g cos(alpha)/(M + m sin^2(alpha))."""

        def formula(mp: Any) -> Any:
            cosine, sine = mp.cos_sin(mp.mpf(self.alpha))
            return mp.mpf(self.m * self.M * self.g) * cosine / (mp.mpf(self.M) + mp.mpf(self.m) * sine**2)

        return self._quantity(digits, formula)
