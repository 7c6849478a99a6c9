"""Motion along a tunnel through a planet of uniform density, and above its ends.

Inside x'' = -(g/R) x, outside x'' = -+g R^2/x^2: the force is continuous at the surface, its derivative is not. A motion
that leaves the planet and returns has three parts between its farthest points on both sides: a fall along the cycloid
x = h cos^2 e, t = sqrt(h^3/(2 g R^2)) (e + sin e cos e), a harmonic passage A sin(w t), and the fall reversed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, floor_of, refined, sign
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.pointwise import Cycle


@dataclass(frozen=True)
class PlanetTunnel(BallMotion):
    """State (x, v), x from the centre; bound; |x0| is not R unless the motion stays inside."""

    g: Fraction
    R: Fraction
    x0: Fraction
    v0: Fraction

    @cached_property
    def surface_square(self) -> Fraction:
        """The square of the speed at the surface; negative or zero if the motion stays inside."""
        if abs(self.x0) <= self.R:
            return self.v0**2 + self.g / self.R * (self.x0**2 - self.R**2)
        return self.v0**2 + 2 * self.g * self.R - 2 * self.g * self.R**2 / abs(self.x0)

    @property
    def inside(self) -> bool:
        """Whether the motion never leaves the planet."""
        return self.surface_square <= 0 and abs(self.x0) <= self.R

    @property
    def highest(self) -> Fraction:
        """The farthest point of a motion that leaves the planet."""
        return 1 / (1 / self.R - self.surface_square / (2 * self.g * self.R**2))

    def period(self, digits: int = 15) -> Any:
        return self._derived(digits, lambda: 2 * flint.arb.pi() / self._rate() if self.inside else 2 * self._half())

    def surface_speed(self, digits: int = 15) -> Any:
        return self._derived(digits, lambda: ball(self.surface_square).sqrt())

    def number(self, value: Fraction, digits: int = 15) -> Any:
        return self._derived(digits, lambda: ball(value))

    def crossings(self, until: Fraction, digits: int = 15) -> list[tuple[Any, bool, int]]:
        """(time, whether it enters, the side: 1 or -1) of each passage through the surface up to `until`."""
        if self.inside:
            return []
        passages = []
        for n in range(-1, 2 + floor_of(lambda: (ball(until) + self._phase()) / self._half())):
            for enters in (True, False):

                def time(n: int = n, enters: bool = enters) -> Any:
                    return n * self._half() + self._fall() + (0 if enters else self._passage()) - self._phase()

                if sign(time) > 0 and sign(lambda t=time: ball(until) - t()) > 0:  # type: ignore[misc]
                    side = self._first * (-1) ** (n % 2) * (1 if enters else -1)
                    passages.append((self._derived(digits, time), enters, side))
        return passages

    def _cycle(self, mp: Any) -> Cycle:
        (period,) = refined(mp, lambda: [2 * flint.arb.pi() / self._rate() if self.inside else 2 * self._half()])
        return Cycle(period, (mp.zero, mp.zero))

    def _balls(self, t: Fraction) -> Sequence[Any]:
        rate = self._rate()
        if self.inside:
            sine, cosine = (rate * ball(t)).sin_cos()
            return ball(self.x0) * cosine + ball(self.v0) / rate * sine, ball(self.v0) * cosine - rate * ball(
                self.x0
            ) * sine
        past = floor_of(lambda: (ball(t) + self._phase()) / self._half())
        side = self._first * (-1) ** (past % 2)

        def since() -> Any:
            return ball(t) + self._phase() - past * self._half()

        if past == 0 and self._phase().is_zero() and t == 0:
            return ball(self.x0), ball(self.v0)
        if sign(lambda: self._fall() - since()) > 0:
            x, v = self._outside(since())
            return side * x, side * v
        if sign(lambda: self._fall() + self._passage() - since()) > 0:
            sine, cosine = (rate * (since() - self._fall() - self._passage() / 2)).sin_cos()
            return -side * self._amplitude() * sine, -side * rate * self._amplitude() * cosine
        x, v = self._outside(self._half() - since())
        return -side * x, side * v

    @property
    def _first(self) -> int:
        """The side (1 or -1) of the farthest point where the phase is zero."""
        if abs(self.x0) > self.R:
            return 1 if self.x0 > 0 else -1
        return -1 if self.v0 > 0 else 1

    def _phase(self) -> Any:
        """Time from that farthest point to the start."""
        if abs(self.x0) > self.R:
            angle = ball(abs(self.x0) / self.highest).sqrt().acos()
            time = self._cycloid(angle)
            return -time if self.x0 * self.v0 > 0 else time
        angle = flint.arb.atan2(-self._first * ball(self.x0) * self._rate(), ball(abs(self.v0)))
        return self._fall() + self._passage() / 2 + angle / self._rate()

    def _rate(self) -> Any:
        return ball(self.g / self.R).sqrt()

    def _amplitude(self) -> Any:
        return ball(self.R**2 + self.surface_square * self.R / self.g).sqrt()

    def _fall(self) -> Any:
        """Time from the farthest point to the surface."""
        return self._cycloid(ball(self.R / self.highest).sqrt().acos())

    def _passage(self) -> Any:
        """Time from one surface to the other, through the planet."""
        return 2 * flint.arb.atan2(self._rate() * ball(self.R), ball(self.surface_square).sqrt()) / self._rate()

    def _half(self) -> Any:
        return 2 * self._fall() + self._passage()

    def _slowness(self) -> Any:
        return ball(self.highest**3 / (2 * self.g * self.R**2)).sqrt()

    def _cycloid(self, angle: Any) -> Any:
        sine, cosine = angle.sin_cos()
        return self._slowness() * (angle + sine * cosine)

    def _outside(self, time: Any) -> Sequence[Any]:
        """Distance and velocity at a time after the farthest point."""
        angle = flint.arb(self._rough(float(time / self._slowness())))
        for _ in range(math.ceil(math.log2(flint.ctx.prec))):
            angle = (angle + (time.mid() - self._cycloid(angle)) / (2 * self._slowness() * angle.cos() ** 2)).mid()
        x, v = ball(self.highest) * angle.cos() ** 2, -ball(self.highest) * angle.cos() * angle.sin()
        v = v / (self._slowness() * angle.cos() ** 2)
        # Newton's method ends at the root up to round-off: one step of the equations covers the remaining time.
        rest = time - self._cycloid(angle)
        return x + v * rest, v - ball(self.g * self.R**2) / (x * x) * rest

    @staticmethod
    def _rough(phase: float) -> float:
        """The root of e + sin e cos e = phase in [0, pi/2], by bisection."""
        low, high = 0.0, math.pi / 2
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (middle, high) if middle + math.sin(middle) * math.cos(middle) < phase else (low, middle)
        return (low + high) / 2
