"""Two blocks on a rail before a wall, all impacts elastic: exact in rational numbers (Beatty, Dynamics, 8.13).

Between impacts both move uniformly. The number of impacts is finite: with the heavier block coming in on the lighter one
at rest it is ceil(pi/atan(sqrt(m1/m2))) - 1, the first digits of pi for m2/m1 = 100^n (Galperin, Regul. Chaotic Dyn. 8,
2003).
"""

from __future__ import annotations

import bisect
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

from gnomon.reference.motion import Motion

MOST = 20_000


class Leg(NamedTuple):
    """What begins at an impact (`name`), or at the start (no name): time, places, velocities after it."""

    time: Fraction
    name: str
    x1: Fraction
    x2: Fraction
    v1: Fraction
    v2: Fraction


@dataclass(frozen=True)
class TwoBlocks(Motion):
    """State (x1, x2, v1, v2), 0 < x1 < x2; the wall is at 0."""

    m1: Fraction
    m2: Fraction
    x1: Fraction
    x2: Fraction
    v1: Fraction
    v2: Fraction

    @cached_property
    def legs(self) -> tuple[Leg, ...]:
        """The start, and all impacts there ever are."""
        here = Leg(Fraction(0), "", self.x1, self.x2, self.v1, self.v2)
        found = [here]
        while len(found) <= MOST:
            here_ = self._next(here)
            if here_ is None:
                return tuple(found)
            here = here_
            found.append(here)
        raise ArithmeticError(f"more than {MOST} impacts")

    @property
    def impacts(self) -> int:
        return len(self.legs) - 1

    def leg(self, t: Fraction) -> Leg:
        """The one that t falls in; at an impact, the one that it begins."""
        return self.legs[max(0, bisect.bisect_right(self._times, t) - 1)]

    @cached_property
    def _times(self) -> list[Fraction]:
        return [leg.time for leg in self.legs]

    def _next(self, leg: Leg) -> Leg | None:
        closing, inward = leg.v1 - leg.v2, -leg.v1
        meet = (leg.x2 - leg.x1) / closing if closing > 0 else None
        hit = leg.x1 / inward if inward > 0 else None
        if meet is None and hit is None:
            return None
        if hit is None or (meet is not None and meet <= hit):
            assert meet is not None
            place, total = leg.x1 + leg.v1 * meet, self.m1 + self.m2
            mean = (self.m1 * leg.v1 + self.m2 * leg.v2) / total
            return Leg(leg.time + meet, "blocks", place, place, 2 * mean - leg.v1, 2 * mean - leg.v2)
        return Leg(leg.time + hit, "wall", Fraction(0), leg.x2 + leg.v2 * hit, -leg.v1, leg.v2)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        leg = self.leg(t)
        since = t - leg.time
        return [mp.mpf(x) for x in (leg.x1 + leg.v1 * since, leg.x2 + leg.v2 * since, leg.v1, leg.v2)]
