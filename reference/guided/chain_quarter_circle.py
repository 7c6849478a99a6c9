"""A chain that slides from a table through a smooth quarter circle and off its end.

L s'' = g (drop(s) - drop(s - L)), s the distance of the front from the start of the quarter circle of radius R, along a
tube: drop(s) = R (1 - cos(s/R)) on it and R + s - h below, h = pi R/2 < L. While the front or the tail is on the
circle, energy gives s'^2, and a quadrature the time; between and after these stages the motion is elementary.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

import flint
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.passage import Pace, Track, pace_from_rest

LONGEST = 0.5
"""In units of sqrt(L/g): the time between two places of a track."""


class Stages(NamedTuple):
    """Tracks, and times and speeds at which the front and the tail pass the ends of the circle.

    `hangs`: the front leaves the circle; `enters`: the tail enters it; `leaves`: the tail leaves it.
    """

    front: Track
    hangs: Any
    hang_speed: Any
    enters: Any
    enter_speed: Any
    tail: Track
    leaves: Any
    leave_speed: Any


@dataclass(frozen=True)
class ChainQuarter(BallMotion):
    """State (s, v), 0 <= s < h and v >= 0 at the start, not both zero; pi R/2 < L."""

    g: Fraction
    length: Fraction
    radius: Fraction
    s: Fraction
    v: Fraction

    def event_times(self, digits: int = 15) -> tuple[Any, Any, Any]:
        """Times (s) at which the front leaves the circle, the tail enters it, and the tail leaves it."""
        return tuple(  # type: ignore[return-value]
            self._derived(digits, lambda i=i: getattr(self._stages(), ("hangs", "enters", "leaves")[i]))  # type: ignore[misc]
            for i in range(3)
        )

    def event_speeds(self, digits: int = 15) -> tuple[Any, Any, Any]:
        names = ("hang_speed", "enter_speed", "leave_speed")
        return tuple(self._derived(digits, lambda n=n: getattr(self._stages(), n)) for n in names)  # type: ignore[misc, return-value]

    def event_places(self, digits: int = 15) -> tuple[Any, Any, Any]:
        return (
            self._derived(digits, self.quarter),
            self._derived(digits, lambda: ball(self.length)),
            self._derived(digits, lambda: ball(self.length) + self.quarter()),
        )

    def quarter(self) -> Any:
        """h, the length of the quarter circle."""
        return flint.arb.pi() * ball(self.radius) / 2

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if t == 0:
            return [ball(self.s), ball(self.v)]
        stages, time = self._stages(), ball(t)
        if time.mid() < stages.hangs.mid():
            way = stages.front.arrival(time)
            if self.v == 0:
                square = way * way
                return [ball(self.s) + square, way * self._from_rest(flint.acb(square)).real.sqrt()]
            return [ball(self.s) + way, self._square(flint.acb(way)).real.sqrt()]
        if time.mid() < stages.enters.mid():
            return self._hanging(stages.hang_speed, time - stages.hangs)
        if time.mid() < stages.leaves.mid():
            way = stages.tail.arrival(time - stages.enters)
            return [ball(self.length) + way, self._tail_square(stages.enter_speed)(flint.acb(way)).real.sqrt()]
        since = time - stages.leaves
        fall = ball(self.g) * since
        return [ball(self.length) + self.quarter() + (stages.leave_speed + fall / 2) * since, stages.leave_speed + fall]

    def slow(self) -> float:
        """How far the front comes at about its first speed: until gravity has given it as much."""
        way = self.v**2 * self.length * self.radius / self.g
        third: float = float(way) ** (1 / 3)
        return min(third, float(way / self.s**2) if self.s else math.inf)

    def _stages(self) -> Stages:
        return _stages(self, flint.ctx.prec)

    def _square(self, delta: Any) -> Any:
        """v^2 when the front has moved by `delta`, on the circle."""
        return ball(self.v**2) + delta * self._from_rest(delta)

    def _from_rest(self, delta: Any) -> Any:
        """(v^2 - v0^2)/delta: (2 g R/L) (1 - cos((s0 + delta/2)/R) sin(delta/2R)/(delta/2R))."""
        half = delta / (2 * ball(self.radius))
        angle = ball(self.s / self.radius) + half
        versine = 2 * (angle / 2).sin() ** 2
        return ball(2 * self.g * self.radius / self.length) * (versine + angle.cos() * _sinc_below_one(half))

    def _tail_square(self, enter_speed: Any) -> Callable[[Any], Any]:
        """v^2 as a function of the distance of the tail from the start of the circle."""
        twice, radius = ball(2 * self.g / self.length), ball(self.radius)
        below = ball(self.length) - self.quarter()

        def square(way: Any) -> Any:
            return enter_speed * enter_speed + twice * (
                way * (below + way / 2) + radius * radius * (way / radius).sin()
            )

        return square

    def _hanging(self, speed: Any, time: Any) -> list[Any]:
        """s - h + R = R cosh(w t) + (v/w) sinh(w t), w^2 = g/L."""
        rate = ball(self.g / self.length).sqrt()
        sinh, cosh = (rate * time).sinh_cosh()
        radius = ball(self.radius)
        return [
            self.quarter() + radius * (cosh - 1) + speed / rate * sinh,
            radius * rate * sinh + speed * cosh,
        ]


@lru_cache(maxsize=32)
def _stages(motion: ChainQuarter, bits: int) -> Stages:
    longest = LONGEST * float(motion.length / motion.g) ** 0.5
    quarter, radius = motion.quarter(), ball(motion.radius)
    rest = quarter - ball(motion.s)
    if motion.v == 0:
        front = Track(pace_from_rest(motion._from_rest), rest.sqrt(), longest, float(motion.s) ** 0.5)
    else:
        front = Track(_pace(motion._square), rest, longest, motion.slow())
    hang_speed = motion._square(flint.acb(rest)).real.sqrt()
    # s - h + R = C e^(w t) - D e^(-w t): the time at which s = L
    rate, below = ball(motion.g / motion.length).sqrt(), ball(motion.length) - quarter + radius
    grow, fade = (radius + hang_speed / rate) / 2, (radius - hang_speed / rate) / 2
    enters = front.duration + ((below + (below * below - 4 * grow * fade).sqrt()) / (2 * grow)).log() / rate
    _, enter_speed = motion._hanging(hang_speed, enters - front.duration)
    square = motion._tail_square(enter_speed)
    tail = Track(_pace(square), quarter, longest)
    leave_speed = square(flint.acb(quarter)).real.sqrt()
    return Stages(front, front.duration, hang_speed, enters, enter_speed, tail, enters + tail.duration, leave_speed)


def _sinc_below_one(x: Any) -> Any:
    """1 - sin(x)/x, without cancellation where x is small: x^2/6 times 1F2(1; 2, 5/2; -x^2/4)."""
    if abs(x) < 0.25:
        square = x * x
        return square / 6 * (-square / 4).hypgeom([1], [2, flint.arb(5) / 2])
    return 1 - x.sinc()


def _pace(square: Callable[[Any], Any]) -> Pace:
    return lambda x, analytic: square(x).rsqrt(analytic=analytic)
