"""Chains that slide over an edge: s'' = w^2 (s - c) until s reaches `end`, then free fall.

With x = s - c the motion is x = x0 cosh(wt) + (v0/w) sinh(wt). x0 and v0 are not negative, so that neither this nor the
end time has cancellation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion, decades


@dataclass(frozen=True)
class SlidingChain(Motion):
    """State (s, v); s0 >= c and v0 >= 0. `square` is w^2 > 0, `after` the acceleration beyond `end`."""

    square: Fraction
    centre: Fraction
    end: Fraction
    after: Fraction
    s0: Fraction
    v0: Fraction

    @property
    def rests(self) -> bool:
        """Whether it is in the unstable equilibrium."""
        return self.s0 == self.centre and self.v0 == 0

    def end_time(self, digits: int = 15) -> Any:
        """Time at which s reaches `end` (s); infinite in equilibrium."""
        return self._quantity(digits, self._end_time)

    def end_speed(self, digits: int = 15) -> Any:
        """The speed at `end`, sqrt(v0^2 + w^2 ((end - c)^2 - (s0 - c)^2))."""
        return self._quantity(digits, self._end_speed)

    def _end_speed(self, mp: Any) -> Any:
        ways = (self.end - self.centre) ** 2 - (self.s0 - self.centre) ** 2
        return mp.sqrt(mp.mpf(self.v0**2 + self.square * ways))

    def _end_time(self, mp: Any) -> Any:
        if self.rests:
            return mp.inf
        if self.s0 >= self.end:
            return mp.zero
        w, way = mp.sqrt(mp.mpf(self.square)), mp.mpf(self.end - self.centre)
        # e^(wt) = (way + w^-1 v_end) / (x0 + w^-1 v0), since v_end = w sqrt(way^2 - x0^2 + v0^2/w^2)
        grown = (way + self._end_speed(mp) / w) / (mp.mpf(self.s0 - self.centre) + mp.mpf(self.v0) / w)
        return mp.log(grown) / w

    def _guard(self, t: Fraction) -> float:
        return 15 + decades(t * t * self.square) / 2

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        time, w = mp.mpf(t), mp.sqrt(mp.mpf(self.square))
        if self.rests:
            return mp.mpf(self.s0), mp.zero
        end = self._end_time(mp)
        if time < end:
            cosh, sinh = mp.cosh(w * time), mp.sinh(w * time)
            x0, v0 = mp.mpf(self.s0 - self.centre), mp.mpf(self.v0)
            return mp.mpf(self.centre) + x0 * cosh + v0 / w * sinh, v0 * cosh + w * x0 * sinh
        since, speed, after = time - end, self._end_speed(mp), mp.mpf(self.after)
        return mp.mpf(self.end) + since * (speed + after * since / 2), speed + after * since
