"""x'' = -w^2 (x - x^-3), x > 0: Ermakov's and Pinney's equation (Pinney, Proc. AMS 1, 1950).

x^2 = u^2 + s^2 with u = x0 cos(wt) + (v0/w) sin(wt), s = sin(wt)/x0: a sum of squares, without cancellation even
where x is close to zero. The period is pi/w at every amplitude.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion, decades
from gnomon.reference.numerics.pointwise import Cycle


@dataclass(frozen=True)
class Pinney(Motion):
    """State (x, v)."""

    w: Fraction
    x0: Fraction
    v0: Fraction

    @property
    def energy(self) -> Fraction:
        """v^2 + w^2 (x^2 + x^-2)."""
        return self.v0**2 + self.w**2 * (self.x0**2 + 1 / self.x0**2)

    def period(self, digits: int = 15) -> Any:
        return self._quantity(digits, lambda mp: mp.pi / mp.mpf(self.w))

    def least(self, digits: int = 15) -> Any:
        """The least x, the inverse of the largest."""
        return self._quantity(digits, lambda mp: 1 / self._largest(mp), 20)

    def largest(self, digits: int = 15) -> Any:
        return self._quantity(digits, self._largest, 20)

    def top_speed(self, digits: int = 15) -> Any:
        """The largest speed, at x = 1: v^2 = E - 2 w^2 = v0^2 + w^2 (x0 - 1/x0)^2."""
        square = self.v0**2 + self.w**2 * (self.x0 - 1 / self.x0) ** 2
        return self._quantity(digits, lambda mp: mp.sqrt(mp.mpf(square)))

    def _largest(self, mp: Any) -> Any:
        half = self.energy / (2 * self.w**2)
        return mp.sqrt(mp.mpf(half) + mp.sqrt(mp.mpf(half**2 - 1)))

    def _cycle(self, mp: Any) -> Cycle:
        return Cycle(mp.pi / mp.mpf(self.w), (mp.zero, mp.zero))

    def _guard(self, t: Fraction) -> float:
        return 20 + 2 * decades(self.energy / self.w**2) + decades((t * self.w) ** 2) / 2

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        w, x0, v0 = mp.mpf(self.w), mp.mpf(self.x0), mp.mpf(self.v0)
        cosine, sine = mp.cos_sin(mp.mpf(self.w * t))
        u, rate = x0 * cosine + v0 / w * sine, v0 * cosine - w * x0 * sine
        s, turn = sine / x0, w * cosine / x0
        x = mp.hypot(u, s)
        return x, (u * rate + s * turn) / x
