"""Radial motion under an attracting point: Kepler's problem without angular momentum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.orbits.kepler_orbit import Kepler


@dataclass(frozen=True)
class RadialFall(Motion):
    """State (r, v), r'' = -mu/r^2, r0 > 0. A time at or beyond the collision raises ValueError."""

    mu: Fraction
    r0: Fraction
    v0: Fraction

    @cached_property
    def _orbit(self) -> Kepler:
        return Kepler(self.mu, self.r0, Fraction(0), self.v0, Fraction(0))

    @property
    def bound(self) -> bool:
        """Whether the speed is below the escape speed, decided exactly."""
        return self.v0**2 < 2 * self.mu / self.r0

    def collision_time(self, digits: int = 15) -> Any | None:
        """Time at which r = 0 (s); None if it escapes."""
        return self._orbit.collision_time(digits)

    def escape_speed(self, digits: int = 15) -> Any:
        """sqrt(2 mu/r0)."""
        return self._quantity(digits, lambda mp: mp.sqrt(mp.mpf(2 * self.mu / self.r0)))

    def farthest(self, digits: int = 15) -> Any:
        """The largest r of the whole motion; infinite if it escapes."""
        if not self.bound:
            return self._quantity(digits, lambda mp: mp.inf)
        height = 1 / (1 / self.r0 - self.v0**2 / (2 * self.mu))
        return self._quantity(digits, lambda mp: mp.mpf(height))

    def _guard(self, t: Fraction) -> float:
        return self._orbit._guard(t)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        r, _y, v, _w = self._orbit._state(mp, t)
        return r, v
