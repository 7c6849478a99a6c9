"""The harmonic oscillator: m x'' = -k x."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion, decades
from gnomon.reference.numerics.pointwise import Cycle


@dataclass(frozen=True)
class HarmonicMotion(Motion):
    """State (x, v): x = x0 cos(w t) + (v0/w) sin(w t), w^2 = k/m."""

    mass: Fraction
    stiffness: Fraction
    x0: Fraction
    v0: Fraction

    def period(self, digits: int = 15) -> Any:
        return self._quantity(digits, lambda mp: 2 * mp.pi / self._frequency(mp))

    def amplitude(self, digits: int = 15) -> Any:
        """hypot(x0, v0/w)."""
        return self._quantity(digits, lambda mp: mp.hypot(mp.mpf(self.x0), mp.mpf(self.v0) / self._frequency(mp)))

    def phase(self, digits: int = 15) -> Any:
        """The angle phi of x = A cos(w t - phi), atan2(v0/w, x0)."""
        return self._quantity(digits, lambda mp: mp.atan2(mp.mpf(self.v0) / self._frequency(mp), mp.mpf(self.x0)))

    def energy(self, digits: int = 15) -> Any:
        total = (self.mass * self.v0**2 + self.stiffness * self.x0**2) / 2
        return self._quantity(digits, lambda mp: mp.mpf(total))

    def _frequency(self, mp: Any) -> Any:
        return mp.sqrt(mp.mpf(self.stiffness / self.mass))

    def _cycle(self, mp: Any) -> Cycle:
        return Cycle(2 * mp.pi / self._frequency(mp), (mp.zero, mp.zero))

    def _guard(self, t: Fraction) -> float:
        return 10 + decades(t * t * self.stiffness / self.mass) / 2

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        w = self._frequency(mp)
        x0, v0 = mp.mpf(self.x0), mp.mpf(self.v0)
        cosine, sine = mp.cos_sin(w * mp.mpf(t))
        return x0 * cosine + v0 / w * sine, v0 * cosine - w * x0 * sine
