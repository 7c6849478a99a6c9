"""A pendulum with drag proportional to the square of its speed.

theta'' = -w2 sin(theta) -+ c theta'^2, the drag against the motion. In each swing, with u = +-theta growing, p = u'^2
has the first integral p = K e^(-2 c u) + A (cos u - 2 c sin u), A = 2 w2/(1 + 4 c^2). The swing ends at the next zero
of p, and the time is a quadrature. The motion is a sequence of such swings.
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
from gnomon.reference.numerics.passage import Track, pace_from_rest

LONGEST = 0.7
"""In units of 1/sqrt(w2): the time between two places of a track."""
MOST_TURNS = 150
"""Most turns over the top before it swings: their time is one integral, in parts of `LONGEST`."""
WIDE = 1e-6
"""Balls with a larger radius are subintervals on which the integration bounds the integrand."""


class Swing(NamedTuple):
    """A swing from u = `begin`, where only the first swing may have a speed, to the turning point u = `end`.

    `side`: theta = side u. `since`, `until`: its times (s). `out`: the track from rest at `begin` to the middle; None for a
    swing that begins with a speed. `back`: the track from `end` backwards, to the middle or to `begin`.
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
    """State (theta, v), theta from the downward vertical (rad, unwrapped); t >= 0, w2 and c > 0, not in equilibrium."""

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
        """Number of turns over the top before it swings; negative if theta falls."""
        side, start = (1 if self.forward else -1), self.theta if self.forward else -self.theta
        return side * (self._last_bottom() - floor_of(lambda: ball(start) / (2 * flint.arb.pi()) + flint.arb(0.5)))

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if t == 0:
            return [ball(self.theta), ball(self.v)]
        swing = swing_sequence(self, flint.ctx.prec).at(t)
        since, left = ball(t) - swing.since, swing.until - ball(t)
        if swing.out is not None and since.mid() < swing.out.duration.mid():
            way, quotient = swing.out.arrival(since), self._quotient_after(swing.begin)
            u = swing.begin + way * way
        else:
            way, quotient = swing.back.arrival(left), self._quotient_before(swing.end)
            u = swing.end - way * way
        speed = abs(way) * quotient(flint.acb(way * way)).real.sqrt()
        return [swing.side * u, swing.side * speed]

    def turning_point(self, n: int, digits: int = 15) -> tuple[Any, Any]:
        """Time (s) and angle (rad) of the n-th turning point after the start, n = 1, 2, ..."""

        def swing() -> Swing:
            return swing_sequence(self, flint.ctx.prec).number(n - 1)

        return (
            self._derived(digits, lambda: swing().until),
            self._derived(digits, lambda: swing().side * swing().end),
        )

    def _coefficient(self) -> Any:
        """The coefficient A = 2 w2/(1 + 4 c^2) of the squared speed p, see the top of this file."""
        return ball(2 * self.w2 / (1 + 4 * self.c**2))

    def _shape(self, u: Any) -> Any:
        """cos u - 2 c sin u: the factor of A in p."""
        sine, cosine = u.sin_cos()
        return cosine - 2 * ball(self.c) * sine

    def _last_bottom(self) -> int:
        """j of the last bottom u = 2 pi j that the first swing passes: p is positive at all tops before this bottom."""
        start = self.theta if self.forward else -self.theta
        top = -floor_of(lambda: flint.arb(0.5) - ball(start) / (2 * flint.arb.pi()))
        # the first top after the start is (2 top + 1) pi
        for turns in range(MOST_TURNS + 1):
            if not self._passes(start, top + turns):
                return top + turns
        raise ArithmeticError(f"it turns over the top more than {MOST_TURNS} times before it swings")

    def _passes(self, start: Fraction, top: int) -> bool:
        """Whether p e^(2 c (u - u0)) is positive at u = (2 top + 1) pi."""

        def left() -> Any:
            rise = (2 * ball(self.c) * ((2 * top + 1) * flint.arb.pi() - ball(start))).exp()
            return ball(self.v**2) - self._coefficient() * (self._shape(ball(start)) + rise)

        return sign(left) > 0

    def _quotient_after(self, begin: Any) -> Any:
        """The function delta -> p(begin + delta)/delta, for a zero `begin` of p at which p begins to grow."""
        inner = self._quotient_before(begin)
        return lambda delta: -inner(-delta)

    def _quotient_before(self, end: Any) -> Any:
        """The function delta -> p(end - delta)/delta, for a zero `end` of p: the zero cancels in the formula."""
        coefficient, (sine, cosine), c = self._coefficient(), end.sin_cos(), ball(self.c)

        def plain(delta: Any) -> Any:
            half = delta / 2
            turned = half.sin() * half.sinc()
            decayed = 2 * c * (c * delta).exp() * (flint.acb(0, 1) * c * delta).sinc()
            straight, both = delta.sinc(), turned + decayed
            return coefficient * (cosine * (2 * c * straight - both) + sine * (straight + 2 * c * both))

        def quotient(delta: Any) -> Any:
            """The quotient, on wide balls by the mean value theorem: near a top the terms cancel, their radii add up."""
            direct = plain(delta)
            if delta.rad() < WIDE or delta.contains(0):
                return direct
            middle = delta.mid()
            slope = (2 * ball(self.w2) * (end - delta).sin() + (2 * c * delta - 1) * direct) / delta
            centred = plain(middle) + slope * (delta - middle)
            return centred if centred.rad() < direct.rad() else direct

        return quotient


class SwingSequence:
    """The swings of one motion, computed on demand, always at the same precision."""

    def __init__(self, motion: DampedPendulum) -> None:
        self.motion = motion
        self.swings: list[Swing] = []
        self.bottom = 0
        """j of the bottom 2 pi j that the last swing passes."""

    def at(self, t: Fraction) -> Swing:
        """The swing that contains t."""
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
            self.bottom = motion._last_bottom()
        else:
            last = self.swings[-1]
            side, begin, since, speed = -last.side, -last.end, last.until, flint.arb(0)
            self.bottom = -self.bottom
        end = self._find_rest(begin, speed, self.bottom)
        way, longest = end - begin, LONGEST / float(motion.w2) ** 0.5
        if speed.is_zero():
            middle = (way / 2).sqrt()
            out = Track(pace_from_rest(motion._quotient_after(begin)), middle, longest)
            back = Track(pace_from_rest(motion._quotient_before(end)), middle, longest)
            return Swing(side, begin, end, since, since + out.duration + back.duration, out, back)
        back = Track(pace_from_rest(motion._quotient_before(end)), way.sqrt(), longest)
        return Swing(side, begin, end, since, since + back.duration, None, back)

    def _find_rest(self, begin: Any, speed: Any, bottom: int) -> Any:
        """A ball with the zeros of p between the bottom 2 pi `bottom` and the next top, for all points of the ball `begin`.

        The derivative of a zero `end` by `begin`, e^(-2 c (end - begin)) sin(begin)/sin(end), is below 1, so the radii of
        balls do not grow from swing to swing.
        """
        end = self._find_rest_from(begin.mid(), speed, bottom)
        spread = flint.arb(0, begin.rad().upper())
        wide = end + 4 * spread
        share = (-2 * ball(self.motion.c) * (wide - begin)).exp() * abs(begin.sin()) / abs(wide.sin())
        return end + share * spread

    def _find_rest_from(self, begin: Any, speed: Any, bottom: int) -> Any:
        """The zero as `_find_rest`, from an exact `begin`: bisection, Newton's method, one step of interval Newton."""
        motion = self.motion
        coefficient, c = motion._coefficient(), ball(motion.c)
        share = speed - coefficient * motion._shape(begin)

        def left(u: Any) -> Any:
            return share * (-2 * c * (u - begin)).exp() + coefficient * motion._shape(u)

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
def swing_sequence(motion: DampedPendulum, bits: int) -> SwingSequence:
    return SwingSequence(motion)
