"""Impacts with a coefficient of restitution: balls on one line, and two smooth discs in a plane."""

from __future__ import annotations

import bisect
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.motion import BallMotion, Motion

MOST = 500
"""Most impacts on a line; with a small coefficient of restitution there may be infinitely many."""


class Leg(NamedTuple):
    """The free motion after the impact of balls `pair` and `pair` + 1 (None at the start), from `time` on."""

    time: Fraction
    pair: int | None
    places: tuple[Fraction, ...]
    velocities: tuple[Fraction, ...]


@dataclass(frozen=True)
class BallLine(Motion):
    """Balls on a line, with positions shifted so that neighbours touch where these are equal; in rational numbers.

    State (x1, ..., xn, v1, ..., vn), x1 < x2 < ...; 0 < e <= 1. Raises ValueError if three meet at the same time.
    """

    masses: tuple[Fraction, ...]
    e: Fraction
    places: tuple[Fraction, ...]
    velocities: tuple[Fraction, ...]

    @cached_property
    def legs(self) -> tuple[Leg, ...]:
        """The motion from the start and after each impact."""
        legs = [Leg(Fraction(0), None, self.places, self.velocities)]
        while len(legs) <= MOST:
            following = self._next(legs[-1])
            if following is None:
                return tuple(legs)
            legs.append(following)
        raise ArithmeticError(f"more than {MOST} impacts")

    @cached_property
    def _times(self) -> list[Fraction]:
        return [leg.time for leg in self.legs]

    def energy_lost(self, leg: int) -> Fraction:
        """Energy lost in the impact before this leg: (1 - e^2)/2 times reduced mass times squared speed of approach."""
        pair = self.legs[leg].pair
        assert pair is not None
        m1, m2 = self.masses[pair : pair + 2]
        before = self.legs[leg - 1].velocities
        return (1 - self.e**2) * m1 * m2 / (m1 + m2) * (before[pair] - before[pair + 1]) ** 2 / 2

    def _next(self, leg: Leg) -> Leg | None:
        x, v = leg.places, leg.velocities
        waits = {i: (x[i + 1] - x[i]) / (v[i] - v[i + 1]) for i in range(len(x) - 1) if v[i] > v[i + 1]}
        if not waits:
            return None
        wait = min(waits.values())
        pair = min(i for i, w in waits.items() if w == wait)
        if waits.get(pair + 1) == wait:
            raise ValueError(
                f"balls {pair + 1}, {pair + 2} and {pair + 3} meet at the same time; the outcome is undefined"
            )
        places = tuple(a + b * wait for a, b in zip(x, v, strict=True))
        m1, m2 = self.masses[pair : pair + 2]
        mean, apart = (m1 * v[pair] + m2 * v[pair + 1]) / (m1 + m2), self.e * (v[pair] - v[pair + 1]) / (m1 + m2)
        after = (*v[:pair], mean - m2 * apart, mean + m1 * apart, *v[pair + 2 :])
        return Leg(leg.time + wait, pair, places, after)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        leg = self.legs[max(0, bisect.bisect_right(self._times, t) - 1)]
        since = t - leg.time
        places = [x + v * since for x, v in zip(leg.places, leg.velocities, strict=True)]
        return [mp.mpf(value) for value in (*places, *leg.velocities)]


@dataclass(frozen=True)
class DiscImpact(BallMotion):
    """Two smooth discs that touch at the distance R, apart at the start: state (x1, y1, x2, y2, vx1, vy1, vx2, vy2).

    Along the line of centres n the relative velocity is reversed and multiplied by e; across it nothing changes.
    """

    m1: Fraction
    m2: Fraction
    R: Fraction
    e: Fraction
    places: tuple[Fraction, Fraction, Fraction, Fraction]
    velocities: tuple[Fraction, Fraction, Fraction, Fraction]

    @cached_property
    def _relative(self) -> tuple[Fraction, Fraction, Fraction, Fraction]:
        """Position and velocity of disc 2 relative to disc 1."""
        (x1, y1, x2, y2), (u1, w1, u2, w2) = self.places, self.velocities
        return x2 - x1, y2 - y1, u2 - u1, w2 - w1

    @cached_property
    def _squares(self) -> tuple[Fraction, Fraction]:
        """d.u, and the square of R times the normal speed of approach, negative if they miss each other."""
        x, y, u, w = self._relative
        along = x * u + y * w
        return along, along**2 - (u * u + w * w) * (x * x + y * y - self.R**2)

    @property
    def touches(self) -> bool:
        """Whether they collide; discs that touch at zero normal speed do not."""
        along, square = self._squares
        return along < 0 and square > 0

    def impact_time(self, digits: int = 15) -> Any:
        return self._derived(digits, self._time)

    def impact(self, digits: int = 15) -> tuple[Any, tuple[Any, ...], tuple[Any, ...]]:
        """Time of the impact, and the states before and after it."""
        count = range(8)
        before = [self._derived(digits, lambda i=i: self._moved(self._time(), False)[i]) for i in count]  # type: ignore[misc]
        after = [self._derived(digits, lambda i=i: self._moved(self._time(), True)[i]) for i in count]  # type: ignore[misc]
        return self.impact_time(digits), tuple(before), tuple(after)

    @cached_property
    def energy_lost(self) -> Fraction:
        """(1 - e^2)/2 times the reduced mass times the squared normal speed of approach."""
        if not self.touches:
            return Fraction(0)
        reduced = self.m1 * self.m2 / (self.m1 + self.m2)
        return (1 - self.e**2) * reduced * self._squares[1] / self.R**2 / 2

    def _time(self) -> Any:
        """The smaller root of |d + u t| = R, without cancellation."""
        (x, y, _, _), (along, square) = self._relative, self._squares
        return ball(x * x + y * y - self.R**2) / (ball(-along) + ball(square).sqrt())

    def _kicks(self) -> list[Any]:
        """Changes of the four velocities."""
        x, y, u, w = self._relative
        time, total = self._time(), self.m1 + self.m2
        push = ball((1 + self.e) / total / self.R**2) * ball(self._squares[1]).sqrt()
        kick = push * (ball(x) + ball(u) * time), push * (ball(y) + ball(w) * time)
        m1, m2 = ball(self.m1), ball(self.m2)
        return [-m2 * kick[0], -m2 * kick[1], m1 * kick[0], m1 * kick[1]]

    def _moved(self, t: Any, after: bool) -> list[Any]:
        places = [ball(x) + ball(v) * t for x, v in zip(self.places, self.velocities, strict=True)]
        speeds = [ball(v) for v in self.velocities]
        if after:
            kicks, since = self._kicks(), t - self._time()
            places = [x + k * since for x, k in zip(places, kicks, strict=True)]
            speeds = [v + k for v, k in zip(speeds, kicks, strict=True)]
        return places + speeds

    def is_past(self, t: Fraction) -> bool:
        """Whether the impact is at t or before, decided in rational numbers."""
        if not self.touches:
            return False
        x, y, u, w = self._relative
        # at t they would overlap, or be past the nearest approach
        (far_x, far_y), (along, _) = (x + u * t, y + w * t), self._squares
        return far_x**2 + far_y**2 <= self.R**2 or along + (u * u + w * w) * t > 0

    def _balls(self, t: Fraction) -> Sequence[Any]:
        return self._moved(ball(t), self.is_past(t))
