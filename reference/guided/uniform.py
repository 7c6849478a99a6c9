"""Uniformly accelerated motions, q'' = a with constant a: in rational numbers where a is rational."""

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
