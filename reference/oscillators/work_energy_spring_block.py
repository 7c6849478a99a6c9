"""A block that falls on a massless upright spring and is thrown off again.

y is the height over the free end of the spring: y'' = -g for y > 0 and y'' = -g - w^2 y for y < 0, w^2 = k/m. Both
phases are elementary; the period is T = 2u/g + (2/w)(pi - atan(u w/g)), u the speed at y = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.numerics.precision import working


@dataclass(frozen=True)
class SpringBlock(Motion):
    """State (y, v)."""

    g: Fraction
    m: Fraction
    k: Fraction
    y0: Fraction
    v0: Fraction

    @property
    def square(self) -> Fraction:
        """w^2."""
        return self.k / self.m

    @property
    def speed_squared(self) -> Fraction:
        """u^2 at y = 0, from the energy; negative where the block never leaves the spring."""
        spring = self.square * self.y0**2 if self.y0 < 0 else 0
        return self.v0**2 + 2 * self.g * self.y0 + spring

    @property
    def leaves(self) -> bool:
        """Whether the block leaves the spring; False if it only reaches y = 0."""
        return self.speed_squared > 0

    def period(self, digits: int = 15) -> Any:
        return self._quantity(digits, self._period, 20)

    def compression(self, digits: int = 15) -> Any:
        """The largest compression -y: g/w^2 + sqrt((g/w^2)^2 + u^2/w^2)."""
        rest = self.g / self.square
        reach = rest**2 + self.speed_squared / self.square
        return self._quantity(digits, lambda mp: mp.mpf(rest) + mp.sqrt(mp.mpf(reach)), 20)

    def contact_time(self, digits: int = 15) -> Any:
        """Duration of each contact with the spring."""
        return self._quantity(digits, lambda mp: self._phases(mp)[1])

    def touch_time(self, n: int, digits: int = 15) -> Any:
        """Time at which the block meets the spring for the n-th time after the start, n = 1, 2, ..."""
        return self._quantity(digits, lambda mp: self._first_touch(mp) + (n - 1) * self._period(mp), 30)

    def lift_time(self, n: int, digits: int = 15) -> Any:
        """Time at which it leaves the spring for the n-th time, n = 1, 2, ..."""

        def formula(mp: Any) -> Any:
            first = self._first_touch(mp) + self._phases(mp)[1]
            if self._on_spring:
                first -= self._period(mp)
            return first + (n - 1) * self._period(mp)

        return self._quantity(digits, formula, 30)

    @property
    def _on_spring(self) -> bool:
        return self.y0 < 0 or (self.y0 == 0 and self.v0 < 0)

    def speed(self, digits: int = 15) -> Any:
        """u, the speed at which the block meets and leaves the spring."""
        return self._quantity(digits, lambda mp: mp.sqrt(mp.mpf(self.speed_squared)))

    def _phases(self, mp: Any) -> tuple[Any, Any]:
        """Duration of a flight and of a contact."""
        u, g, w = mp.sqrt(mp.mpf(self.speed_squared)), mp.mpf(self.g), mp.sqrt(mp.mpf(self.square))
        return 2 * u / g, 2 * (mp.pi - mp.atan(u * w / g)) / w

    def _period(self, mp: Any) -> Any:
        if not self.leaves:
            return 2 * mp.pi / mp.sqrt(mp.mpf(self.square))
        return sum(self._phases(mp))

    def _first_touch(self, mp: Any) -> Any:
        """Time of the first contact after the start; a start on the spring leaves it first."""
        u, g, w = mp.sqrt(mp.mpf(self.speed_squared)), mp.mpf(self.g), mp.sqrt(mp.mpf(self.square))
        v0 = mp.mpf(self.v0)
        if not self._on_spring:
            return (v0 + u) / g
        # phase of the vibration about -g/w^2: y + g/w^2 = A cos(p), v = -A w sin(p); lift-off at p in (pi, 2 pi)
        here = mp.atan2(-v0 / w, mp.mpf(self.y0) + g / w**2)
        lift = -mp.atan2(u / w, g / w**2)
        wait = lift - here
        while wait <= 0:
            wait += 2 * mp.pi
        return wait / w + 2 * u / g

    def _cycle(self, mp: Any) -> Cycle:
        return Cycle(self._period(mp), (mp.zero, mp.zero))

    def _guard(self, t: Fraction) -> float:
        with working(15) as mp:
            return 20 + 5 * round(float(mp.log10(1 + abs(mp.mpf(t)) / self._period(mp))) / 5)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        w, g, time = mp.sqrt(mp.mpf(self.square)), mp.mpf(self.g), mp.mpf(t)
        if not self.leaves:
            return self._vibrate(mp, w, mp.mpf(self.y0), mp.mpf(self.v0), time)
        period = self._period(mp)
        since = time - self._first_touch(mp)
        since -= period * mp.floor(since / period)  # since the last touch
        u, contact = mp.sqrt(mp.mpf(self.speed_squared)), self._phases(mp)[1]
        if since < contact:
            return self._vibrate(mp, w, mp.zero, -u, since)
        since -= contact
        return since * (u - g * since / 2), u - g * since

    def _vibrate(self, mp: Any, w: Any, y: Any, v: Any, t: Any) -> tuple[Any, Any]:
        rest = mp.mpf(self.g) / w**2
        cosine, sine = mp.cos_sin(w * t)
        return (y + rest) * cosine + v / w * sine - rest, v * cosine - w * (y + rest) * sine
