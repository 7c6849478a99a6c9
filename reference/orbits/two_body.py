"""Two bodies that attract each other: uniform motion of the centre of mass and a Kepler orbit about it.

r1 = R - (m2/M) r and r2 = R + (m1/M) r, where r is the motion of reference/orbits/kepler_orbit.py with
mu = G (m1 + m2) and R moves uniformly. The relative start and mu are exact rational numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.orbits.kepler_orbit import Kepler

Four = tuple[Fraction, Fraction, Fraction, Fraction]


@dataclass(frozen=True)
class TwoBody(Motion):
    """State (x1, y1, x2, y2, vx1, vy1, vx2, vy2); the angular momentum about the centre of mass is not zero."""

    G: Fraction
    m1: Fraction
    m2: Fraction
    places: Four
    velocities: Four

    @cached_property
    def relative(self) -> Kepler:
        """The motion of body 2 relative to body 1."""
        x1, y1, x2, y2 = self.places
        vx1, vy1, vx2, vy2 = self.velocities
        return Kepler(self.G * (self.m1 + self.m2), x2 - x1, y2 - y1, vx2 - vx1, vy2 - vy1)

    @cached_property
    def share(self) -> tuple[Fraction, Fraction]:
        """m1/M and m2/M."""
        total = self.m1 + self.m2
        return self.m1 / total, self.m2 / total

    def centre(self, pair: Four) -> tuple[Fraction, Fraction]:
        """The mean of (x1, y1, x2, y2), weighted by the masses."""
        first, second = self.share
        return first * pair[0] + second * pair[2], first * pair[1] + second * pair[3]

    def _guard(self, t: Fraction) -> float:
        return self.relative._guard(t) + 5

    def _cycle(self, mp: Any) -> Cycle | None:
        if self.relative.conic <= 0:
            return None
        period = self.relative._period(mp)
        drift = [mp.mpf(v) * period for v in self.centre(self.velocities)]
        return Cycle(period, (*drift, *drift, *[mp.zero] * 4))

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        relative = self.relative._state(mp, t)
        drift = self.centre(self.velocities)
        place = [mp.mpf(x + v * t) for x, v in zip(self.centre(self.places), drift, strict=True)]
        speed = [mp.mpf(v) for v in drift]
        first, second = (mp.mpf(share) for share in self.share)
        components = []
        for centre, part in ((place, relative[:2]), (speed, relative[2:])):
            components += [c - second * r for c, r in zip(centre, part, strict=True)]
            components += [c + first * r for c, r in zip(centre, part, strict=True)]
        return components
