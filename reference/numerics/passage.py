"""Time along a passage as the integral of a positive analytic dt/dx in balls, and its inverse, the place at a time.

A motion with a first integral x'^2 = p(x) takes dt = dx/sqrt(p). Next to a turning point p = delta q(delta), and with
delta = sigma^2 it takes dt = 2 d sigma/sqrt(q(sigma^2)): analytic again. Integrals: Johansson, Numerical integration in
arbitrary-precision ball arithmetic, ICMS 2018.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable
from typing import Any

import flint
from gnomon.reference.numerics.balls import precision

Pace = Callable[[Any, bool], Any]
"""(x, analytic) -> dt/dx over complex balls; `analytic` as python-flint asks of square roots."""
ROUGH_BITS = 64
FEWEST_CELLS = 8
NARROWEST = 2.0**-60


class Track:
    """The times at places along a passage from 0 to `end`, at most about `longest` seconds apart.

    If the passage begins so slowly that these would be too many, `slow` is a place up to which the pace hardly changes:
    between it and the end each place is a quarter further than the one before. Valid at the precision at which it is made.
    """

    def __init__(self, pace: Pace, end: Any, longest: float, slow: float = 0.0) -> None:
        self.pace = pace
        self.places = [flint.arb(0)]
        self.times = [flint.arb(0)]
        for place in self._cells(end, longest, slow):
            self.times.append(self.times[-1] + self._duration(self.places[-1], place))
            self.places.append(place)
        self._middles = [float(time.mid()) for time in self.times]

    @property
    def duration(self) -> Any:
        """The time to the end."""
        return self.times[-1]

    def arrival(self, time: Any) -> Any:
        """The place after `time`: Newton's method, whose last step adds the ball of the remaining time."""
        cell = min(max(bisect.bisect_right(self._middles, float(time.mid())) - 1, 0), len(self.places) - 2)
        place, missing = self.places[cell].mid(), time - self.times[cell]
        with precision(ROUGH_BITS):
            place = self._rough(place, self.places[cell + 1].mid(), missing.mid())
        missing = missing - self._duration(self.places[cell], place)
        size = abs(self.places[-1].mid())
        for _ in range(60):
            step = (missing.mid() / self._at(place)).mid()
            if abs(step) <= size * flint.arb(2) ** (20 - flint.ctx.prec):
                break
            new = (place + step).mid()
            missing, place = missing - self._duration(place, new), new
        return place + missing / self._at(place)

    def _at(self, place: Any) -> Any:
        return self.pace(flint.acb(place), False).real

    def _duration(self, low: Any, high: Any) -> Any:
        return flint.acb.integral(self.pace, flint.acb(low), flint.acb(high)).real

    def _cells(self, end: Any, longest: float, slow: float) -> list[Any]:
        """The ends of cells, halved until each takes at most `longest` by Simpson's rule, or is short for its place."""
        last = end.mid()
        waiting = [(k * last / FEWEST_CELLS, (k + 1) * last / FEWEST_CELLS) for k in reversed(range(FEWEST_CELLS))]
        ends = []
        with precision(ROUGH_BITS):
            while waiting:
                low, high = waiting.pop()
                middle, width = ((low + high) / 2).mid(), high - low
                takes = width * (self._at(low) + 4 * self._at(middle) + self._at(high)) / 6
                short = width < max(float(low), slow) / 4
                if float(takes.mid()) > longest and not short and width > NARROWEST * abs(last):
                    waiting += [(middle, high), (low, middle)]
                else:
                    ends.append(high.mid())
        return [*ends[:-1], end]

    def _rough(self, low: Any, high: Any, time: Any) -> Any:
        """The place `time` after `low`, to ten digits of the cell: Newton's method, or bisection where it leaves it."""
        place, close = ((low + high) / 2).mid(), abs(high - low) * flint.arb(2) ** -34
        missing = time - self._duration(low, place)
        for _ in range(100):
            if missing.mid() > 0:
                low = place
            else:
                high = place
            new = (place + missing / self._at(place)).mid()
            if not low <= new <= high:
                new = ((low + high) / 2).mid()
            if abs(new - place) <= close:
                return new
            missing, place = missing - self._duration(place, new), new
        return place


def pace_from_rest(quotient: Callable[[Any], Any]) -> Pace:
    """dt/d sigma with delta = sigma^2, the distance from a rest, where the squared speed is delta quotient(delta)."""
    return lambda sigma, analytic: 2 * quotient(sigma * sigma).rsqrt(analytic=analytic)
