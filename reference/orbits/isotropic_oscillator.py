"""The isotropic oscillator in a plane, m r'' = -k r: two harmonic motions of the same frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.oscillators.harmonic_oscillator import HarmonicMotion


@dataclass(frozen=True)
class IsotropicOscillator(Motion):
    """State (x, y, vx, vy)."""

    mass: Fraction
    stiffness: Fraction
    x: Fraction
    y: Fraction
    vx: Fraction
    vy: Fraction

    @property
    def _parts(self) -> tuple[HarmonicMotion, HarmonicMotion]:
        return (
            HarmonicMotion(self.mass, self.stiffness, self.x, self.vx),
            HarmonicMotion(self.mass, self.stiffness, self.y, self.vy),
        )

    def period(self, digits: int = 15) -> Any:
        return self._parts[0].period(digits)

    def semi_axes(self, digits: int = 15) -> tuple[Any, Any]:
        """Semi-axes a >= b of the ellipse, without cancellation: a^2 + b^2 = r^2 + v^2/w^2 and a b = |r x v|/w."""
        return self._quantity(digits, lambda mp: self._axes(mp)[0], 30), self._quantity(
            digits, lambda mp: self._axes(mp)[1], 30
        )

    def _axes(self, mp: Any) -> tuple[Any, Any]:
        ratio = self.mass / self.stiffness
        squares = mp.mpf(self.x**2 + self.y**2 + (self.vx**2 + self.vy**2) * ratio)
        area = abs(mp.mpf(self.x * self.vy - self.y * self.vx)) * mp.sqrt(mp.mpf(ratio))
        large = (mp.sqrt(squares + 2 * area) + mp.sqrt(max(squares - 2 * area, mp.zero))) / 2
        return large, area / large if large else mp.zero

    def _cycle(self, mp: Any) -> Cycle:
        return Cycle(self._parts[0]._cycle(mp).period, (mp.zero,) * 4)

    def _guard(self, t: Fraction) -> float:
        return self._parts[0]._guard(t)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        (x, vx), (y, vy) = (part._state(mp, t) for part in self._parts)
        return x, y, vx, vy
