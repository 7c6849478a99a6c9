"""A ball on a vibrating table: it chatters to rest, and leaves the table when this falls faster than the ball would.

Relative to the table z'' = -c(t), c = g - A w^2 sin(w t). Infinitely many bounces end in rest: over an interval in which
0 < c1 <= c <= c2, the speed after a bounce is at most q = e c2/c1 times the one before, so that from a speed u the ball
rests within 2 u/(c1 (1 - q)), if that ends within the interval. Bounces are followed until this time is below the last
bit. The ball then rests until c = 0, at a time known in closed form, and what was before is forgotten.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
from gnomon.reference.contact.bouncing_ball_table import VibratingTable
from gnomon.reference.contact.flights import ROUGH_BITS, UNKNOWN, Flight, first_passage
from gnomon.reference.numerics.balls import ball, precision

MOST_FLIGHTS = 20_000
"""Most bounces from a release to the next rest, or to the end of a span."""


@dataclass
class Bout:
    """The flights from a release (or 0) up to the rest that ends them; `rest` is its time, if they end in one."""

    flights: list[Flight] = field(default_factory=list)
    rest: Any = None


@dataclass(frozen=True)
class ChatteringBall(VibratingTable):
    """State (z, u), height over the table and its rate; z0 > 0, or z0 = 0 and u0 > 0; 0 < e < 1, A w^2 != g."""

    def bouts(self, until: Fraction) -> list[Bout]:
        """The bouts that begin up to a time, at the current precision; later flights may be among theirs."""
        bits, more = flint.ctx.prec, ball(until).mid()
        with precision(2 * bits):
            bouts = _bouts(self, bits)
            while self._continues(bouts, more, bits):
                pass
        return [bout for bout in bouts if not bout.flights[0].begin.mid() > more]

    def counts(self, until: Fraction, settle: Fraction) -> list[tuple[int, bool]]:
        """For each bout, the bounces up to a time or the first flight shorter than `settle`, and whether rest follows."""
        with precision(2 * ROUGH_BITS):
            counts = []
            for bout in self.bouts(until):
                begins = [flight.begin.mid() for flight in bout.flights]
                listed = [b for b in begins if not b > ball(until).mid()]
                short = (k for k in range(1, len(begins) - 1) if begins[k + 1] - begins[k] < ball(settle))
                count = min(len(listed) - 1, next(short, len(listed)))
                rests = bout.rest is not None and not bout.rest.mid() > ball(until).mid()
                counts.append((count, bool(rests)))
        return counts

    def bounce(self, bout: int, n: int, until: Fraction, digits: int = 15) -> tuple[Any, Any, Any]:
        """Time of bounce n = 1, 2, ... of a bout, and the relative velocity before and after it."""

        def part(name: str) -> Any:
            return self._derived(digits, lambda: getattr(self._bounced(bout, n, until), name))

        return part("begin"), part("arriving"), part("u")

    def rest_time(self, bout: int, until: Fraction, digits: int = 15) -> Any:
        """The time at which a bout ends in rest (s)."""
        return self._derived(digits, lambda: self._bout(bout, until).rest or UNKNOWN.begin)

    def release_time(self, bout: int, until: Fraction, digits: int = 15) -> Any:
        """The time at which a bout begins (s)."""
        return self._derived(digits, lambda: self._bout(bout, until).flights[0].begin)

    def _bout(self, bout: int, until: Fraction) -> Bout:
        known = self.bouts(until)
        return known[bout] if bout < len(known) else Bout([UNKNOWN])

    def _bounced(self, bout: int, n: int, until: Fraction) -> Flight:
        flights = self._bout(bout, until).flights
        return flights[n] if n < len(flights) else UNKNOWN

    def _continues(self, bouts: list[Bout], until: Any, bits: int) -> bool:
        """Adds a flight, a rest or a release; False if the next is later than `until`, or unknown."""
        bout = bouts[-1]
        if bout.rest is not None:
            begin = None if bout.rest.mid() > until else self._release(bout.rest)
            if begin is None or not begin.is_finite() or begin.mid() > until:
                return False
            bouts.append(Bout([Flight(begin, *[flint.arb(0)] * 3)]))
            return True
        flight = bout.flights[-1]
        if not flight.begin.is_finite() or flight.begin.mid() > until:
            return False
        limit = self._limit(flight)
        if limit is not None and limit < flint.arb(2) ** -bits * flight.begin:
            bout.rest = flight.begin + flint.arb(0).union(limit)
            return True
        following = self._bounce(flight, until) if limit is None else self._short(flight)
        if following is None:
            return False
        bout.flights.append(following)
        if len(bout.flights) > MOST_FLIGHTS:
            raise ArithmeticError(f"more than {MOST_FLIGHTS} bounces before t = {float(flight.begin.mid()):g} s")
        return bool(following.begin.is_finite())

    def _pull(self, t: Any) -> Any:
        """c, the relative acceleration downward."""
        return ball(self.pull) - ball(self.amplitude * self.frequency**2) * (ball(self.frequency) * t).sin()

    def _limit(self, flight: Flight) -> Any | None:
        """A bound of the time to rest after a bounce, if it is certain that no release comes before; else None."""
        here = self._pull(flight.begin)
        if not (here > 0 and flight.u > 0 and flight.arriving < 0):
            return None
        length = 4 * flight.u / (here * ball(1 - self.e))
        c = self._pull(flight.begin.union(flight.begin + length))
        if not c > 0:
            return None
        least, q = c.lower(), ball(self.e) * c.upper() / c.lower()
        if not q < 1:
            return None
        longest = (2 * flight.u / (least * (1 - q))).upper()
        return longest if longest < length else None

    def _release(self, rest: Any) -> Any | None:
        """The first time after a rest at which c falls through 0; None if it never does."""
        if self.amplitude * self.frequency**2 < self.pull:
            return None
        share, rate, turn = self.pull / (self.amplitude * self.frequency**2), ball(self.frequency), 2 * flint.arb.pi()
        first = ball(share).asin()
        turns = ((rate * rest - first) / turn).ceil().unique_fmpz()
        return UNKNOWN.begin if turns is None else (first + turn * int(turns)) / rate

    def _bounce(self, flight: Flight, until: Any) -> Flight | None:
        """The flight after the next bounce; None if that is later than `until`."""
        start = Flight(*(x.mid() for x in flight))
        with precision(ROUGH_BITS):
            begin, gap, rate = flint.arb(0), start.z, start.u
            if gap.is_zero() and rate.is_zero():  # a release: nothing bends the gap back before c > 0
                first = ball(self.pull / (self.amplitude * self.frequency**2)).asin()
                begin = ((flint.arb.pi() - 2 * first) / ball(self.frequency)).mid()
                gap, rate = (x.mid() for x in self._after(start, begin))
            most = (ball(self.pull + abs(self.amplitude) * self.frequency**2)).upper()
            wait = first_passage(lambda t: self._after(start, t), most, (begin, gap, rate), until - start.begin)
        return None if wait is None else self._landed(flight, self._root(start, wait))

    def _short(self, flight: Flight) -> Flight:
        """The flight after the next bounce of a chatter: its height is concave, Newton's method finds the bounce from above."""
        start = Flight(*(x.mid() for x in flight))
        length = 4 * start.u / (self._pull(start.begin) * ball(1 - self.e))
        least = self._pull(start.begin.union(start.begin + length)).lower()
        return self._landed(flight, self._root(start, (2 * start.u / least).mid()))

    def _root(self, flight: Flight, wait: Any) -> Any:
        """Newton's method until its steps no longer fall: short flights have fewer digits than the precision."""
        before = None
        while True:
            z, u = self._after(flight, wait)
            step = (z / u).mid()
            if not step.is_finite() or (before is not None and not abs(step) < before / 2):
                return wait
            wait, before = (wait - step).mid(), abs(step)

    def _landed(self, flight: Flight, wait: Any) -> Flight:
        """The flight after the bounce near `wait`, which is the root of the midpoints of a flight's begin and speed.

        The mean value theorem carries the balls from bounce to bounce: evaluated directly they would grow at each.
        """
        b, z, u = flight.begin, flight.z, flight.u
        middle = Flight(b.mid(), z.mid(), u.mid(), flight.arriving)
        here, arriving = self._after(middle, wait)
        centre = wait - here / arriving
        _, arriving = self._after(middle, centre)
        here, steep = self._after(flight, wait)
        since = wait - here / steep
        _, steep = self._after(flight, since)
        rate, swing = ball(self.frequency), ball(self.amplitude * self.frequency)
        before, after = rate * b, rate * (b + since)
        by_begin = -swing * (after.cos() - before.cos() + rate * since * before.sin())
        later, longer = -by_begin / steep, -since / steep
        c = self._pull(b + since)
        turned = swing * rate * (after.sin() - before.sin())
        off = b - b.mid(), u - u.mid(), z - z.mid()
        time = b.mid() + centre + (1 + later) * off[0] + longer * off[1] - off[2] / steep
        arriving = arriving + (turned - c * later) * off[0] + (1 - c * longer) * off[1] + c / steep * off[2]
        return Flight(time, flint.arb(0), -ball(self.e) * arriving, arriving) if arriving < 0 else UNKNOWN

    def _balls(self, t: Fraction) -> Sequence[Any]:
        now = ball(t)
        bout = self.bouts(t)[-1]
        if bout.rest is not None and not bout.rest.mid() > now.mid():
            return flint.arb(0), flint.arb(0)
        flight = [flight for flight in bout.flights if not flight.begin.mid() > now.mid()][-1]
        with precision(2 * flint.ctx.prec):
            return self._after(flight, ball(t) - flight.begin)


@lru_cache(maxsize=32)
def _bouts(motion: ChatteringBall, bits: int) -> list[Bout]:
    """The bouts computed so far at a precision; callers append."""
    return [Bout([Flight(flint.arb(0), ball(motion.z0), ball(motion.u0), flint.arb(0))])]
