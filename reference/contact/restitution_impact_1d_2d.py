"""Two blocks on a rail before a wall, all impacts elastic.

In the plane of sqrt(m2) x2 + i sqrt(m1) x1 the motion is a ray of light between two mirrors with the angle
b = atan(sqrt(m1/m2)): contact of the blocks, and the wall. Unfolded, the path is a straight line, and impact k is where
it crosses the ray at angle k b: each impact is computed without those before. The number of impacts is finite; if the
heavier block hits the lighter one at rest it is ceil(pi/b) - 1, the first digits of pi for m2/m1 = 100^n (Galperin,
Regul. Chaotic Dyn. 8, 2003).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any, NamedTuple

import flint
from gnomon.reference.numerics.balls import ball, precision, refined
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.precision import publish, working

DECIDED_BITS = 256
"""Where these bits do not decide on which side of a ray a point lies, integers decide."""

Pair = tuple[Fraction, Fraction]


class Impact(NamedTuple):
    """Time, name (`blocks` or `wall`), positions (x1, x2), velocities (v1, v2) before and after."""

    time: Any
    name: str
    places: tuple[Any, Any]
    before: tuple[Any, Any]
    after: tuple[Any, Any]


@dataclass(frozen=True)
class TwoBlocks(BallMotion):
    """State (x1, x2, v1, v2), 0 < x1 < x2; the wall is at 0. The blocks must not reach the wall together."""

    m1: Fraction
    m2: Fraction
    x1: Fraction
    x2: Fraction
    v1: Fraction
    v2: Fraction

    @cached_property
    def turning(self) -> int:
        """1 if the angle in the plane grows, -1 if it falls, 0 if it is constant."""
        moment = self.x2 * self.v1 - self.x1 * self.v2
        return (moment > 0) - (moment < 0)

    @cached_property
    def impacts(self) -> int:
        """Number of all impacts: the rays between the initial direction and the direction of the velocity."""
        return self._crossed((self.v1, self.v2), True) if self.turning else 0

    def passed(self, t: Fraction) -> int:
        """Number of impacts up to and including t."""
        return self._crossed(self._unfolded(t), False) if self.turning else 0

    def impact_time(self, n: int, digits: int = 15) -> Any:
        """Time of impact n = 1, 2, ... (s)."""
        return self._derived(digits, lambda: self._impact(self._ray(n))[0])

    def impact(self, n: int, digits: int = 15) -> Impact:
        ray = self._ray(n)
        cells = (ray - 1, ray) if self.turning > 0 else (ray, ray - 1)
        with working(digits + 2) as mp:
            time, *places = publish(refined(mp, lambda: self._impact(ray)), digits)
            before, after = (
                publish(refined(mp, lambda c=c: self._folded(c, (self.v1, self.v2))), digits)  # type: ignore[misc]
                for c in cells
            )
        return Impact(time, "blocks" if ray % 2 else "wall", tuple(places), before, after)  # type: ignore[arg-type]

    def _balls(self, t: Fraction) -> Sequence[Any]:
        passed = self.passed(t)
        cell = passed if self.turning >= 0 else -passed
        return [*self._folded(cell, self._unfolded(t)), *self._folded(cell, (self.v1, self.v2))]

    def _unfolded(self, t: Fraction) -> Pair:
        return self.x1 + self.v1 * t, self.x2 + self.v2 * t

    def _ray(self, n: int) -> int:
        return n if self.turning > 0 else 1 - n

    def _point(self, pair: Pair) -> Any:
        first, second = pair
        return flint.acb(ball(self.m2).sqrt() * ball(second), ball(self.m1).sqrt() * ball(first))

    def _wedge(self) -> Any:
        return flint.arb.atan2(ball(self.m1).sqrt(), ball(self.m2).sqrt())

    def _folded(self, cell: int, pair: Pair) -> tuple[Any, Any]:
        """A pair of the unfolded plane mapped back between the mirrors, with a reflection in an odd cell."""
        turn, odd = self._wedge() * (cell + cell % 2), cell % 2 == 1
        point = self._point(pair) * flint.acb(turn.cos(), -turn.sin())
        height = -point.imag if odd else point.imag
        return height / ball(self.m1).sqrt(), point.real / ball(self.m2).sqrt()

    def _impact(self, ray: int) -> list[Any]:
        """Time and positions where the line crosses a ray."""
        angle = self._wedge() * ray
        direction = flint.acb(angle.cos(), angle.sin())
        start, speed = self._point((self.x1, self.x2)), self._point((self.v1, self.v2))
        along = _cross(direction, speed)
        time, far = -_cross(direction, start) / along, _cross(start, speed) / along
        if ray % 2:
            place = far / ball(self.m1 + self.m2).sqrt()
            return [time, place, place]
        return [time, flint.arb(0), far / ball(self.m2).sqrt()]

    def _crossed(self, pair: Pair, open_end: bool) -> int:
        """Number of rays from the start to a direction within half a turn, with one at the end unless `open_end`."""
        with precision(DECIDED_BITS):
            start = self._point((self.x1, self.x2))
            angle = start.arg() + (self._point(pair) / start).arg()
            ratio = angle / self._wedge()
            below = ratio.floor().unique_fmpz()
            if below is None:
                nearest = int((ratio + flint.arb(0.5)).floor().unique_fmpz())
                side = self._side(nearest, pair)
                below = nearest if side >= 0 else nearest - 1
                if side == 0:
                    return max(0, (nearest if self.turning > 0 else 1 - nearest) - int(open_end))
        return max(0, int(below) if self.turning > 0 else -int(below))

    def _side(self, ray: int, pair: Pair) -> int:
        """1 if a point lies beyond ray k, -1 before it, 0 on it, decided in integers.

        The ray's direction is z^k, z = sqrt(m2) + i sqrt(m1): P + i sqrt(m1 m2) Q for even k and
        sqrt(m2) P + i sqrt(m1) Q for odd k.
        """
        scale = lcm(self.m1.denominator, self.m2.denominator)
        m1, m2 = int(self.m1 * scale), int(self.m2 * scale)
        p, q = _power(m2 - m1, 2, m1 * m2, abs(ray) // 2)  # z^2 = m2 - m1 + 2 i sqrt(m1 m2)
        if ray % 2:
            p, q = p - m1 * q, p + m2 * q
        q = q if ray >= 0 else -q
        first, second = pair
        moment = first * p - second * q * (1 if ray % 2 else m2)
        return (moment > 0) - (moment < 0)


def _cross(a: Any, b: Any) -> Any:
    return a.real * b.imag - a.imag * b.real


def _power(p: int, q: int, square: int, n: int) -> tuple[int, int]:
    """(p + i sqrt(square) q)^n."""
    power = (1, 0)
    while n:
        if n % 2:
            power = (power[0] * p - square * power[1] * q, power[0] * q + power[1] * p)
        p, q, n = p * p - square * q * q, 2 * p * q, n // 2
    return power
