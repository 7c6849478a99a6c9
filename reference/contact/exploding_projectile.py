"""A projectile that bursts in flight: the centre of mass stays on its parabola."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion

Four = tuple[Fraction, Fraction, Fraction, Fraction]


@dataclass(frozen=True)
class Fragments(Motion):
    """State (x1, y1, x2, y2, vx1, vy1, vx2, vy2), y upward; exact in rational numbers.

    At `burst` an internal impulse adds (wx, wy) to the velocity of part 2 as seen from part 1.
    """

    g: Fraction
    m1: Fraction
    m2: Fraction
    burst: Fraction
    wx: Fraction
    wy: Fraction
    places: Four
    velocities: Four

    @property
    def kicks(self) -> Four:
        """The change of each velocity at the burst; the total momentum does not change."""
        total = self.m1 + self.m2
        first, second = -self.m2 / total, self.m1 / total
        return first * self.wx, first * self.wy, second * self.wx, second * self.wy

    @property
    def energy_released(self) -> Fraction:
        """Energy released by the burst: the increase of the kinetic energy of the relative motion."""
        reduced = self.m1 * self.m2 / (self.m1 + self.m2)
        _, _, u2, w2 = self.velocities
        u1, w1 = self.velocities[:2]
        before = (u2 - u1) ** 2 + (w2 - w1) ** 2
        return reduced * ((u2 - u1 + self.wx) ** 2 + (w2 - w1 + self.wy) ** 2 - before) / 2

    def at(self, t: Fraction) -> tuple[Fraction, ...]:
        """The state in rational numbers; at the burst that after it."""
        since = max(t - self.burst, Fraction(0))
        falls = (0, 1, 0, 1)
        places = [
            x + v * t - fall * self.g * t**2 / 2 + kick * since
            for x, v, kick, fall in zip(self.places, self.velocities, self.kicks, falls, strict=True)
        ]
        return (*places, *self._speeds(t, t >= self.burst))

    def before_the_burst(self) -> tuple[Fraction, ...]:
        return (*self.at(self.burst)[:4], *self._speeds(self.burst, False))

    def _speeds(self, t: Fraction, burst: bool) -> list[Fraction]:
        kicks = self.kicks if burst else (Fraction(0),) * 4
        falls = (0, 1, 0, 1)
        return [v - fall * self.g * t + kick for v, kick, fall in zip(self.velocities, kicks, falls, strict=True)]

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        return [mp.mpf(value) for value in self.at(t)]
