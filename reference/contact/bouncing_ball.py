"""A ball that bounces on a horizontal plane; each impact multiplies the speed by e.

With u the speed of the first impact, impact n is at

    t_n = t_1 + (2u/g) (e + e^2 + ... + e^(n-1)),

so for e < 1 infinitely many impacts accumulate at t_inf = t_1 + 2u e/(g (1 - e)), after which the ball rests.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

from gnomon.reference.numerics.motion import Motion, decades
from gnomon.reference.numerics.precision import publish, working


@dataclass(frozen=True)
class BouncingBall(Motion):
    """State (y, v): y'' = -g above the plane y = 0, v -> -e v at an impact; y0 >= 0, v0 positive upward.

    y0 = 0 requires v0 >= 0: a ball on the plane that moves down is within an impact.
    """

    g: Fraction
    e: Fraction
    y0: Fraction
    v0: Fraction

    @property
    def rests(self) -> bool:
        """Whether the ball lies on the plane from the start."""
        return self.y0 == 0 and self.v0 == 0

    def impacts(self, t: Fraction) -> int | None:
        """Number of impacts at or before t, decided exactly; None at and after the limit, or at rest."""
        return _impacts(self, t)

    def _impacts(self, t: Fraction) -> int | None:
        if self.rests or (self.e < 1 and self._reached(t, None)):
            return None
        if not self._reached(t, 1):
            return 0
        with working(30 + decades(self._phase(t))) as mp:
            count = 1 + self._flights_in(mp, (mp.mpf(t) - self._impact_time(mp, 1)) * self._rate(mp))
        while self._reached(t, count + 1):
            count += 1
        while count > 1 and not self._reached(t, count):
            count -= 1
        return count

    def impact_time(self, n: int, digits: int = 15) -> Any:
        """Time of impact n = 1, 2, ..."""
        return self._quantity(digits, lambda mp: self._impact_time(mp, n), 10 + math.log10(n))

    def impact_speed(self, digits: int = 15) -> Any:
        """Speed just before the first impact."""
        return self._quantity(digits, self._speed)

    def speed_after(self, n: int, digits: int = 15) -> Any:
        """Speed just after impact n."""
        return self._quantity(digits, lambda mp: self._leaving(mp, n), 10 + math.log10(n))

    def flight_time(self, n: int, digits: int = 15) -> Any:
        """Duration of the flight after impact n."""
        return self._quantity(digits, lambda mp: 2 * self._leaving(mp, n) / mp.mpf(self.g), 10 + math.log10(n))

    def apex_after(self, n: int, digits: int = 15) -> Any:
        """Time of the apex after impact n."""
        return self._quantity(digits, lambda mp: self._impact_time(mp, n) + self._leaving(mp, n) / mp.mpf(self.g))

    def limit_time(self, digits: int = 15) -> Any:
        """Time from which the ball rests; infinite for e = 1."""
        return self._quantity(digits, lambda mp: mp.mpf(0) if self.rests else self._impact_time(mp, None))

    def path_length(self, digits: int = 15) -> Any:
        """The distance covered until rest; infinite for e = 1, unless the ball never moves."""
        return self._quantity(digits, self._path_length)

    def impact_list(self, settle: Fraction, end: Fraction, digits: int = 15) -> list[tuple[Any, Any]]:
        """(time, speed before) of the impacts up to `end`, ending before the first flight shorter than `settle`."""
        if self.rests:
            return []
        count, impacts = self.impacts(end), list[tuple[Any, Any]]()
        with working(digits + 20) as mp:
            speed, time = self._speed(mp), self._impact_time(mp, 1)
            restitution, rate, shortest = mp.mpf(self.e), 2 / mp.mpf(self.g), mp.mpf(settle)
            arriving, gap = publish([speed], digits)[0], speed * rate
            while count is None or len(impacts) < count:
                impacts.append((publish([time], digits)[0], arriving))
                if self.e < 1:
                    speed = speed * restitution
                    arriving, gap = publish([speed], digits)[0], speed * rate
                if gap < shortest:
                    break
                time = time + gap
        return impacts

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        count, time, g = self.impacts(t), mp.mpf(t), mp.mpf(self.g)
        if count is None:
            return mp.mpf(0), mp.mpf(0)
        if count == 0:
            y0, v0 = mp.mpf(self.y0), mp.mpf(self.v0)
            return y0 + time * (v0 - g * time / 2), v0 - g * time
        since = time - self._impact_time(mp, count)
        speed = self._leaving(mp, count)
        return max(mp.mpf(0), since * (speed - g * since / 2)), speed - g * since

    def _guard(self, t: Fraction) -> float:
        """Digits of t over the duration of the flight, and digits of the small heights of late flights."""
        count = self.impacts(t)
        lost = 15 + decades(self._phase(t))
        return lost - 2 * count * math.log1p(float(self.e - 1)) / math.log(10) if count and self.e > 0 else lost

    def _phase(self, t: Fraction) -> Fraction:
        """A bound of g t/u, since 1 + 1/u^2 > 1/u."""
        return t * self.g * (1 + 1 / self._speed_squared) if self._speed_squared else t

    @cached_property
    def _speed_squared(self) -> Fraction:
        return self.v0**2 + 2 * self.g * self.y0

    def _speed(self, mp: Any) -> Any:
        return mp.sqrt(mp.mpf(self._speed_squared))

    def _leaving(self, mp: Any, n: int) -> Any:
        return self._speed(mp) * mp.mpf(self.e) ** n

    def _rate(self, mp: Any) -> Any:
        """g/(2u): flights per second at the initial speed."""
        return mp.mpf(self.g) / (2 * self._speed(mp))

    def _impact_time(self, mp: Any, n: int | None) -> Any:
        """Time of impact n, or of the limit (None)."""
        u, v0, g = self._speed(mp), mp.mpf(self.v0), mp.mpf(self.g)
        first = (v0 + u) / g if self.v0 > 0 else 2 * mp.mpf(self.y0) / (u - v0)  # neither form cancels
        return first if n == 1 else first + 2 * u / g * self._powers(mp, None if n is None else n - 1)

    def _powers(self, mp: Any, k: int | None) -> Any:
        """e + e^2 + ... + e^k, or all of them (None)."""
        if self.e == 1:
            return mp.inf if k is None else mp.mpf(k)
        total = mp.mpf(self.e / (1 - self.e))
        return total if k is None or self.e == 0 else -total * mp.expm1(k * mp.log1p(mp.mpf(self.e - 1)))

    def _flights_in(self, mp: Any, duration: Any) -> int:
        """Approximate number of flights after the first impact within `duration`, in units of 2u/g."""
        if self.e == 1:
            return int(mp.floor(duration))
        left = 1 - duration * mp.mpf(1 - self.e) / mp.mpf(self.e) if self.e > 0 else mp.mpf(0)
        return max(0, int(mp.floor(mp.log(left) / mp.log1p(mp.mpf(self.e - 1))))) if left > 0 else 0

    def _reached(self, t: Fraction, n: int | None) -> bool:
        """Whether t is at or after impact n or the limit (None), decided exactly.

        t_n is rational only if u is; then rational numbers decide. Otherwise t is never equal to t_n, and enough digits
        decide.
        """
        digits = 40 + decades(self._phase(t))
        while True:
            with working(digits) as mp:
                difference = mp.mpf(t) - self._impact_time(mp, n)
                if abs(difference) > mp.mpf(max(t, 1 / self.g)) * mp.mpf(10) ** (15 - digits):
                    return bool(difference > 0)
            rational = self._rational_speed
            if rational is not None:
                return t >= self._rational_time(rational, n)
            digits *= 2

    @cached_property
    def _rational_speed(self) -> Fraction | None:
        """u, if it is rational."""
        top, bottom = self._speed_squared.numerator, self._speed_squared.denominator
        root = Fraction(math.isqrt(top), math.isqrt(bottom))
        return root if root**2 == self._speed_squared else None

    def _rational_time(self, u: Fraction, n: int | None) -> Fraction:
        share = Fraction(0) if n is None else self.e ** (n - 1)
        flights = Fraction((n or 1) - 1) if self.e == 1 else self.e * (1 - share) / (1 - self.e)
        return (self.v0 + u * (1 + 2 * flights)) / self.g

    def _path_length(self, mp: Any) -> Any:
        """The distance to the plane, then u^2 e^(2n)/g up and down after each impact n."""
        g, u2 = mp.mpf(self.g), mp.mpf(self._speed_squared)
        rise = mp.mpf(self.v0) ** 2 / (2 * g) if self.v0 > 0 else mp.mpf(0)
        first = mp.mpf(self.y0) + 2 * rise
        if self.rests:
            return mp.mpf(0)
        return mp.inf if self.e == 1 else first + u2 / g * mp.mpf(self.e**2 / (1 - self.e**2))


@lru_cache(maxsize=1024)
def _impacts(motion: BouncingBall, t: Fraction) -> int | None:
    """Cached, because the guard digits, the state and the neighbouring events of one time all need it."""
    return motion._impacts(t)
