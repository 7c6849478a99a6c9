"""Gravity and drag proportional to the square of the speed.

In the plane the hodograph is Bernoulli's: with q = vy/vx = sinh s and u = |vx|,
1/u^2 = 1/u0^2 + (k/g) (F(s0) - F(s)), F = sinh s cosh s + s. Time and position are quadratures in s of analytic
integrands; t(s) is inverted by Newton's method. The motion on a vertical line is elementary.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, precision, sign
from gnomon.reference.numerics.motion import BallMotion

STEP = 0.05
"""Step of s in the rough inversion of t(s) from which Newton's method starts."""
CACHE_STEP = 0.5
"""Step of s: integrals up to its multiples are cached."""
MOST_CACHED = 500
STEEPEST = -300.0
"""Beyond this s the fall is vertical to 1e-260 and t(s) is linear."""


@dataclass(frozen=True)
class QuadraticDragPlane(BallMotion):
    """r'' = (0, -g) - k |r'| r', state (x, y, vx, vy), vx not zero, k > 0."""

    g: Fraction
    k: Fraction
    x: Fraction
    y: Fraction
    vx: Fraction
    vy: Fraction

    def _balls(self, t: Fraction) -> Sequence[Any]:
        slope, time, across, height = self._at(t)
        horizontal, side = self._horizontal(slope), 1 if self.vx > 0 else -1
        vx, vy = side * horizontal, horizontal * slope.sinh()
        # Newton's method ends at the root up to round-off: one step of the equations covers the remaining time.
        rest = ball(t) - time
        drag = ball(self.k) * horizontal * slope.cosh()
        x, y = ball(self.x) + side * across, ball(self.y) + height
        return [x + vx * rest, y + vy * rest, vx - drag * vx * rest, vy - (ball(self.g) + drag * vy) * rest]

    def apex(self, digits: int = 15) -> tuple[Any, Any] | None:
        """Time (s) and height (m) of the highest point; None for a downward throw."""
        if self.vy < 0:
            return None
        top = Fraction(0)
        return (
            self._derived(digits, lambda: self._integrals(ball(top), self._start())[0]),
            self._derived(digits, lambda: ball(self.y) + self._integrals(ball(top), self._start())[2]),
        )

    def terminal_speed(self, digits: int = 15) -> Any:
        return self._derived(digits, lambda: ball(self.g / self.k).sqrt())

    def _start(self) -> Any:
        return ball(self.vy / abs(self.vx)).asinh()

    def _level(self) -> Any:
        """1/u^2 + (k/g) F(s), which is constant."""
        return ball(1 / self.vx**2) + ball(self.k / self.g) * _arc(self._start())

    def _horizontal(self, slope: Any) -> Any:
        """u as a function of s."""
        return (self._level() - ball(self.k / self.g) * _arc(slope)).rsqrt()

    def _integrals(self, low: Any, high: Any) -> tuple[Any, Any, Any]:
        """The time, the horizontal distance and the rise from s = `high` down to s = `low`."""
        return (
            self._integral(lambda u, _, c: u * c, low, high),
            self._integral(lambda u, _, c: u * u * c, low, high),
            self._integral(lambda u, s, c: u * u * s * c, low, high),
        )

    def _integral(self, integrand: Callable[[Any, Any, Any], Any], low: Any, high: Any) -> Any:
        """(1/g) times the integral of `integrand(u, sinh s, cosh s)` over s."""
        level, ratio = self._level(), ball(self.k / self.g)

        def function(z: Any, analytic: bool) -> Any:
            s, c = z.sinh_cosh()
            return integrand((level - ratio * (s * c + z)).rsqrt(analytic=analytic), s, c)

        return flint.acb.integral(function, flint.acb(low), flint.acb(high)).real / ball(self.g)

    def _at(self, t: Fraction) -> tuple[Any, Any, Any, Any]:
        """An exact number s close to that at t, and the time, the horizontal distance and the rise up to s."""
        with precision(64):
            rough = self._newton(ball(t), flint.arb(self._rough_slope(float(t))))
        if not rough > float(self._start().mid()) - CACHE_STEP * MOST_CACHED:
            raise ArithmeticError("the fall is vertical to the last digit computed; give a shorter span")
        past = max(0, int(float(self._start().mid() - rough) / CACHE_STEP))
        slope, *until = _cached_integrals(self, past, flint.ctx.prec)
        near = self._newton(ball(t) - until[0], rough, slope)
        return near, *(a + b for a, b in zip(until, self._integrals(near, slope), strict=True))

    def _newton(self, time: Any, slope: Any, high: Any = None) -> Any:
        """s at `time` after s = `high` (by default the start); each step integrates only from the previous one."""
        missing = time - self._integral(lambda u, _, c: u * c, slope, self._start() if high is None else high)
        for _ in range(60):
            step = -missing.mid() * ball(self.g) / (self._horizontal(slope) * slope.cosh())
            new = (slope + step).mid()
            if abs(new - slope) <= (1 + abs(slope)) * flint.arb(2) ** (20 - flint.ctx.prec):
                return new
            missing, slope = missing - self._integral(lambda u, _, c: u * c, new, slope), new
        return slope

    def _rough_slope(self, t: float) -> float:
        """s at t by Simpson's rule on dt/ds = -u cosh(s)/g from the start on, then along the last secant."""
        start = math.asinh(float(self.vy / abs(self.vx)))
        ratio, first, g = float(self.k / self.g), float(1 / self.vx**2), float(self.g)

        def pace(s: float) -> float:
            lost = math.sinh(s) * math.cosh(s) + s
            return math.cosh(s) / (g * math.sqrt(first + ratio * (math.sinh(start) * math.cosh(start) + start - lost)))

        now, slope, rate = 0.0, start, pace(start)
        while now < t and slope > STEEPEST:
            rate = (pace(slope) + 4 * pace(slope - STEP / 2) + pace(slope - STEP)) / 6
            now, slope = now + rate * STEP, slope - STEP
        return slope + (now - t) / rate


@lru_cache(maxsize=1024)
def _cached_integrals(motion: QuadraticDragPlane, number: int, bits: int) -> tuple[Any, Any, Any, Any]:
    """s at `number` CACHE_STEPs below the start, and the time, horizontal distance and rise up to it, with `bits`."""
    start = motion._start()
    if number == 0:
        return start, flint.arb(0), flint.arb(0), flint.arb(0)
    slope, *until = _cached_integrals(motion, number - 1, bits)
    low = start - number * flint.arb(CACHE_STEP)
    return low, *(a + b for a, b in zip(until, motion._integrals(low, slope), strict=True))


def _arc(s: Any) -> Any:
    return s.sinh() * s.cosh() + s


@dataclass(frozen=True)
class QuadraticDragVertical(BallMotion):
    """y'' = -g - k v |v|, state (y, v), y upward, k > 0. With vt = sqrt(g/k) and z = g t/vt:

    rising   v = vt (u cos z - sin z)/(cos z + u sin z),        y = y0 + ln(cos z + u sin z)/k,    u = v0/vt;
    falling  v = -vt (u cosh z + sinh z)/(cosh z + u sinh z),   y = y0 - ln(cosh z + u sinh z)/k,  u = -v0/vt.
    """

    g: Fraction
    k: Fraction
    y: Fraction
    v: Fraction

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if self.v <= 0:
            return self._falling(ball(t), ball(self.y), -ball(self.v) / self._limit())
        # The apex is at no rational time: the arctangent of an algebraic number is transcendental.
        if sign(lambda: self._apex_time() - ball(t)) < 0:
            return self._falling(ball(t) - self._apex_time(), self._apex_height(), flint.arb(0))
        limit, u = self._limit(), ball(self.v) / self._limit()
        sine, cosine = (ball(self.g) * ball(t) / limit).sin_cos()
        below = cosine + u * sine
        return [ball(self.y) + below.log() / ball(self.k), limit * (u * cosine - sine) / below]

    def apex_time(self, digits: int = 15) -> Any:
        """Time at which an upward throw comes to rest (s); 0 from rest."""
        return self._derived(digits, self._apex_time)

    def apex_height(self, digits: int = 15) -> Any:
        return self._derived(digits, self._apex_height)

    def terminal_speed(self, digits: int = 15) -> Any:
        return self._derived(digits, self._limit)

    def return_time(self, digits: int = 15) -> Any:
        """Time at which an upward throw is back at its start; the fall takes acosh(sqrt(1 + u^2)) vt/g."""

        def formula() -> Any:
            u = ball(self.v) / self._limit()
            return self._apex_time() + u.asinh() * self._limit() / ball(self.g)

        return self._derived(digits, formula)

    def return_speed(self, digits: int = 15) -> Any:
        """The speed at the return, v0/sqrt(1 + v0^2/vt^2)."""
        return self._derived(digits, lambda: ball(self.v) / ball(1 + self.v**2 * self.k / self.g).sqrt())

    def _limit(self) -> Any:
        return ball(self.g / self.k).sqrt()

    def _apex_time(self) -> Any:
        return (ball(self.v) / self._limit()).atan() * self._limit() / ball(self.g)

    def _apex_height(self) -> Any:
        return ball(self.y) + ball(self.v**2 * self.k / self.g).log1p() / (2 * ball(self.k))

    def _falling(self, time: Any, y: Any, u: Any) -> Sequence[Any]:
        sinh, cosh = (ball(self.g) * time / self._limit()).sinh_cosh()
        below = cosh + u * sinh
        return [y - below.log() / ball(self.k), -self._limit() * (u * cosh + sinh) / below]
