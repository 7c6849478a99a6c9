"""A pendulum with drag proportional to the square of its speed (Beatty, Dynamics, 6.13.1).

theta'' = -w2 sin(theta) -+ c theta'^2 against the motion. While it moves one way, u = +-theta growing, p = u'^2 has the
first integral p = K e^(-2 c u) + A (cos u - 2 c sin u), A = 2 w2/(1 + 4 c^2). A turning point is the next zero of p, and
the time is a quadrature; a chain of such passages is the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import flint
from gnomon.reference.numerics.balls import ball, floor_of, sign
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.passage import Pace, Track

LONGEST = 0.7
"""Of 1/sqrt(w2): the time between two places of a track."""
MOST_TURNS = 150
"""Over the top before it swings: their time is one integral, in parts of `LONGEST`."""
WIDE = 1e-6
"""Radius of a ball that integration bounds the integrand on, rather than evaluates it at."""


class Swing(NamedTuple):
    """A passage in u from `begin`, at rest there or (the first) not, to its rest at `end`; times `since` and `until`.

    `out` is the track from the rest at the beginning to the middle, None where there is none; `back` that from the end.
    """

    side: int
    begin: Any
    end: Any
    since: Any
    until: Any
    out: Track | None
    back: Track


@dataclass(frozen=True)
class DampedPendulum(BallMotion):
    """State (theta, v), theta from the downward vertical in rad, not wrapped; t >= 0, w2 and c > 0, not in balance."""

    w2: Fraction
    c: Fraction
    theta: Fraction
    v: Fraction

    @cached_property
    def forward(self) -> bool:
        """Whether theta grows at first."""
        if self.v:
            return self.v > 0
        return sign(lambda: ball(self.theta).sin()) < 0

    @cached_property
    def turns(self) -> int:
        """Over the top at first, before it swings; negative backwards."""
        side, start = (1 if self.forward else -1), self.theta if self.forward else -self.theta
        return side * (self._first_bottom() - floor_of(lambda: ball(start) / (2 * flint.arb.pi()) + flint.arb(0.5)))

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if t == 0:
            return [ball(self.theta), ball(self.v)]
        swing = course(self, flint.ctx.prec).at(t)
        since, left = ball(t) - swing.since, swing.until - ball(t)
        if swing.out is not None and since.mid() < swing.out.duration.mid():
            way, quotient = swing.out.arrival(since), self._begins(swing.begin)
            u = swing.begin + way * way
        else:
            way, quotient = swing.back.arrival(left), self._ends(swing.end)
            u = swing.end - way * way
        speed = abs(way) * quotient(flint.acb(way * way)).real.sqrt()
        return [swing.side * u, swing.side * speed]

    def turning_point(self, n: int, digits: int = 15) -> tuple[Any, Any]:
        """Time and angle of the n-th rest after the start, n = 1, 2, ..."""

        def swing() -> Swing:
            return course(self, flint.ctx.prec).number(n - 1)

        return (
            self._derived(digits, lambda: swing().until),
            self._derived(digits, lambda: swing().side * swing().end),
        )

    def _size(self) -> Any:
        """A."""
        return ball(2 * self.w2 / (1 + 4 * self.c**2))

    def _shape(self, u: Any) -> Any:
        sine, cosine = u.sin_cos()
        return cosine - 2 * ball(self.c) * sine

    def _first_bottom(self) -> int:
        """Which bottom u = 2 pi j the first passage is the last to cross or reach: p at the tops before is positive."""
        start = self.theta if self.forward else -self.theta
        top = -floor_of(lambda: flint.arb(0.5) - ball(start) / (2 * flint.arb.pi()))
        # the first top after the start is (2 top + 1) pi
        for turns in range(MOST_TURNS + 1):
            if not self._passes(start, top + turns):
                return top + turns
        raise ArithmeticError(f"it goes over the top more than {MOST_TURNS} times before it swings")

    def _passes(self, start: Fraction, top: int) -> bool:
        """Whether p e^(2 c (u - u0)) is positive at u = (2 top + 1) pi."""

        def left() -> Any:
            rise = (2 * ball(self.c) * ((2 * top + 1) * flint.arb.pi() - ball(start))).exp()
            return ball(self.v**2) - self._size() * (self._shape(ball(start)) + rise)

        return sign(left) > 0

    def _begins(self, begin: Any) -> Any:
        """p(begin + delta)/delta where p(begin) = 0."""
        inner = self._ends(begin)
        return lambda delta: -inner(-delta)

    def _ends(self, end: Any) -> Any:
        """p(end - delta)/delta where p(end) = 0, without cancellation."""
        size, (sine, cosine), c = self._size(), end.sin_cos(), ball(self.c)

        def plain(delta: Any) -> Any:
            half = delta / 2
            turned = half.sin() * half.sinc()
            decayed = 2 * c * (c * delta).exp() * (flint.acb(0, 1) * c * delta).sinc()
            straight, both = delta.sinc(), turned + decayed
            return size * (cosine * (2 * c * straight - both) + sine * (straight + 2 * c * both))

        def quotient(delta: Any) -> Any:
            """On wide balls by the mean value theorem: next to the top, p's terms cancel and their widths would not."""
            found = plain(delta)
            if delta.rad() < WIDE or delta.contains(0):
                return found
            middle = delta.mid()
            slope = (2 * ball(self.w2) * (end - delta).sin() + (2 * c * delta - 1) * found) / delta
            centred = plain(middle) + slope * (delta - middle)
            return centred if centred.rad() < found.rad() else found

        return quotient


def along(quotient: Any) -> Pace:
    """dt/d sigma, where delta = sigma^2 is the way from the rest and p = delta quotient(delta)."""
    return lambda sigma, analytic: 2 * quotient(sigma * sigma).rsqrt(analytic=analytic)


class Course:
    """The swings of one motion, at the precision in force when they were asked for."""

    def __init__(self, motion: DampedPendulum) -> None:
        self.motion = motion
        self.swings: list[Swing] = []
        self.bottom = 0
        """The bottom 2 pi j that the last of them ends after."""

    def at(self, t: Fraction) -> Swing:
        """The swing that t falls in."""
        n = 0
        while self.number(n).until.mid() < ball(t):
            n += 1
        return self.swings[n]

    def number(self, n: int) -> Swing:
        while len(self.swings) <= n:
            self.swings.append(self._next())
        return self.swings[n]

    def _next(self) -> Swing:
        motion = self.motion
        if not self.swings:
            side = 1 if motion.forward else -1
            begin, since, speed = side * ball(motion.theta), flint.arb(0), ball(motion.v**2)
            self.bottom = motion._first_bottom()
        else:
            last = self.swings[-1]
            side, begin, since, speed = -last.side, -last.end, last.until, flint.arb(0)
            self.bottom = -self.bottom
        end = self._rest(begin, speed, self.bottom)
        way, longest = end - begin, LONGEST / float(motion.w2) ** 0.5
        if speed.is_zero():
            middle = (way / 2).sqrt()
            out = Track(along(motion._begins(begin)), middle, longest)
            back = Track(along(motion._ends(end)), middle, longest)
            return Swing(side, begin, end, since, since + out.duration + back.duration, out, back)
        back = Track(along(motion._ends(end)), way.sqrt(), longest)
        return Swing(side, begin, end, since, since + back.duration, None, back)

    def _rest(self, begin: Any, speed: Any, bottom: int) -> Any:
        """The zero of p between the bottom and the top after it, whatever the beginning is within its ball.

        Its derivative by the beginning, e^(-2 c (end - begin)) sin(begin)/sin(end), is below 1: balls do not grow.
        """
        end = self._rest_after(begin.mid(), speed, bottom)
        spread = flint.arb(0, begin.rad().upper())
        wide = end + 4 * spread
        share = (-2 * ball(self.motion.c) * (wide - begin)).exp() * abs(begin.sin()) / abs(wide.sin())
        return end + share * spread

    def _rest_after(self, begin: Any, speed: Any, bottom: int) -> Any:
        """The same from a ball without radius: bisection, Newton's method, one interval step."""
        motion = self.motion
        size, c = motion._size(), ball(motion.c)
        share = speed - size * motion._shape(begin)

        def left(u: Any) -> Any:
            return share * (-2 * c * (u - begin)).exp() + size * motion._shape(u)

        def slope(u: Any) -> Any:
            return -2 * c * left(u) - 2 * ball(motion.w2) * u.sin()

        low = (2 * bottom * flint.arb.pi()).max(begin).mid()
        high = ((2 * bottom + 1) * flint.arb.pi()).mid()
        for _ in range(60):
            middle = ((low + high) / 2).mid()
            low, high = (middle, high) if left(middle).mid() > 0 else (low, middle)
        u = ((low + high) / 2).mid()
        for _ in range(60):
            step = (left(u) / slope(u)).mid()
            u = (u - step).mid()
            if abs(step) <= (1 + abs(u)) * flint.arb(2) ** (10 - flint.ctx.prec):
                break
        width = 4 * (abs(left(u)) / abs(slope(u))).upper()
        return u - left(u) / slope(flint.arb(u, width))


@lru_cache(maxsize=16)
def course(motion: DampedPendulum, bits: int) -> Course:
    return Course(motion)
