"""Motions with a nonholonomic constraint: the Chaplygin sleigh, a skate on an incline."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.precision import Number, exact, publish, working


@dataclass(frozen=True)
class ChaplyginSleigh(BallMotion):
    """State (v, w, theta): v' = a w^2, w' = -v w a/q, theta' = w, q = (I + m a^2)/m; a > 0.

    v = V tanh s, sqrt(q) w = V sech s, s = s0 + (a V/q) t, V^2 = v^2 + q w^2; theta changes by
    sqrt(q)/a times gd(s) - gd(s0). The edge's path is a quadrature: dx + i dy = (q/a) tan(u) e^(i theta) du, u = gd(s).
    """

    m: Fraction
    inertia: Fraction
    a: Fraction
    v: Fraction
    w: Fraction
    theta: Fraction

    @property
    def _square(self) -> Fraction:
        return self.inertia / self.m + self.a**2

    def speed(self, digits: int = 15) -> Any:
        """V, the speed in the limit t -> infinity, where the sleigh moves straight ahead."""
        return self._derived(digits, self._speed)

    def whole_turn(self, digits: int = 15) -> Any:
        """Change of theta from t = -infinity to infinity, pi sqrt(q)/a."""
        return self._derived(digits, lambda: ball(self._square).sqrt() / ball(self.a) * ball(0).acos() * 2)

    def path(self, t: Number, digits: int = 15) -> tuple[Any, Any]:
        """Displacement (x, y) of the edge from its start at time t; x is along theta = 0."""
        time = exact(t, "t")
        with working(digits + 5) as mp:
            x, y = publish(refined(mp, lambda: self._way(time)), digits)
        return x, y

    def _way(self, t: Fraction) -> Sequence[Any]:
        if self.w == 0 or t == 0:
            sine, cosine = ball(self.theta).sin_cos()
            return [ball(self.v * t) * cosine, ball(self.v * t) * sine]
        first, s = self._place(t)
        begin, end = (2 * (x / 2).tanh().atan() for x in (first, s))
        ratio = (1 if self.w > 0 else -1) * ball(self._square).sqrt() / ball(self.a)
        scale, start = ball(self._square / self.a), ball(self.theta)

        def along(part: Callable[[Any], Any]) -> Any:
            way = flint.acb.integral(
                lambda u, _: u.tan() * part(start + ratio * (u - begin)), flint.acb(begin), flint.acb(end)
            )
            return scale * way.real

        return [along(lambda theta: theta.cos()), along(lambda theta: theta.sin())]

    def _place(self, t: Fraction) -> tuple[Any, Any]:
        """s at the start and at time t; w != 0."""
        first = (ball(self.v) / (ball(self._square).sqrt() * abs(ball(self.w)))).asinh()
        return first, first + ball(self.a / self._square * t) * self._speed()

    def _speed(self) -> Any:
        return ball(self.v**2 + self._square * self.w**2).sqrt()

    def _balls(self, t: Fraction) -> Sequence[Any]:
        v, w, theta = map(ball, (self.v, self.w, self.theta))
        if self.w == 0:
            return [v, w, theta]
        side = 1 if self.w > 0 else -1
        root, speed = ball(self._square).sqrt(), self._speed()
        first, s = self._place(t)
        turned = 2 * ((s / 2).tanh().atan() - (first / 2).tanh().atan())
        return [speed * s.tanh(), side * speed / root * s.sech(), theta + side * root / ball(self.a) * turned]


@dataclass(frozen=True)
class KnifeEdge(BallMotion):
    """State (x, y, th, v), x down the slope: x' = v cos th, y' = v sin th, th' = w, v' = gs cos th."""

    w: Fraction
    gs: Fraction
    x: Fraction
    y: Fraction
    th: Fraction
    v: Fraction

    def _balls(self, t: Fraction) -> Sequence[Any]:
        x, y, v, time = map(ball, (self.x, self.y, self.v, t))
        angle = ball(self.th + self.w * t)
        s0, c0 = ball(self.th).sin_cos()
        if self.w == 0:
            way = time * (v + ball(self.gs) * c0 * time / 2)
            return [x + c0 * way, y + s0 * way, angle, v + ball(self.gs) * c0 * time]
        s, c = angle.sin_cos()
        rate, amplitude = ball(self.w), ball(self.gs / self.w)
        rest = v - amplitude * s0
        across = time * rate / 2 - (s * c - s0 * c0) / 2
        return [
            x + (rest * (s - s0) + amplitude * (s * s - s0 * s0) / 2) / rate,
            y + (rest * (c0 - c) + amplitude * across) / rate,
            angle,
            rest + amplitude * s,
        ]

    def drift(self, digits: int = 15) -> Any | None:
        """Mean velocity across the slope, gs/(2 w), that down the slope is zero; None if the skate does not turn."""
        return self._derived(digits, lambda: ball(self.gs / (2 * self.w))) if self.w else None
