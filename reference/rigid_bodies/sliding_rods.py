"""A uniform rod that slides down between wall and floor, then on the floor alone.

theta is from the vertical. On wall and floor theta'' = (3g/2L) sin(theta), an inverted pendulum; the rod leaves the
wall where omega^2 = (3g/2L) cos(theta), after a time that is an elliptic integral of the first kind. On the smooth
floor alone the horizontal velocity of the centre and omega^2 (sin^2(theta) + 1/3) + 4 (g/L) cos(theta) are constant:
the time is a quadrature, inverted by Newton's method. The rod ends at rest at theta = pi/2.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
from gnomon.reference.guided.pendulum_on_hoop import Hoop
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.precision import publish, working

STEP = 0.02
"""In units of sqrt(L/6g): the step of the rough solution from which Newton's method starts."""


@dataclass(frozen=True)
class FloorFall:
    """The rod on the smooth floor alone, in balls: g/L, the initial angle and omega^2 (None from rest).

    Its coordinate is x: theta = start + x, or start + x^2 from rest, so that the initial rate is finite.
    """

    ratio: Any
    theta: Any
    square: Any | None

    def angle(self, x: Any) -> Any:
        return self.theta + (x if self.square is not None else x * x)

    def way(self, theta: Any) -> Any:
        return theta - self.theta if self.square is not None else (theta - self.theta).sqrt()

    def pace(self, x: Any, analytic: bool = False) -> Any:
        """dx/dt, for real and complex balls."""
        root = {"analytic": analytic} if isinstance(x, flint.acb) else {}
        theta = self.angle(x)
        half = (theta - self.theta) / 2
        if self.square is None:
            # 4 (g/L) (cos(start) - cos(theta)) over 4 x^2
            fallen = self.ratio * (self.theta + half).sin() * half.sinc()
        else:
            fallen = 8 * self.ratio * (self.theta + half).sin() * half.sin() + self.square * _inertia(self.theta)
        return (fallen / _inertia(theta)).sqrt(**root)

    def rate(self, x: Any) -> Any:
        """omega."""
        return self.pace(x) if self.square is not None else 2 * x * self.pace(x)

    def elapsed(self, first: Any, last: Any) -> Any:
        """The time between two values of x."""
        path = flint.acb(first), flint.acb(last)
        return flint.acb.integral(lambda z, analytic: 1 / self.pace(z, analytic), *path).real

    def at(self, time: Any) -> tuple[Any, Any]:
        """Angle and rate after a time."""
        x = flint.arb(self._rough(float(time.mid())))
        missing = time - self.elapsed(flint.arb(0), x)
        for _ in range(60):
            step = (missing * self.pace(x)).mid()
            if not abs(step) > abs(x) * flint.arb(2) ** (24 - flint.ctx.prec):
                break
            missing, x = missing - self.elapsed(x, x + step), (x + step).mid()
        # One step of the equations covers the remaining time: its square is below the last bit.
        theta, omega = self.angle(x), self.rate(x)
        s, c = theta.sin_cos()
        acceleration = s * (2 * self.ratio - c * omega * omega) / _inertia(theta)
        return theta + omega * missing, omega + acceleration * missing

    def _rough(self, time: float) -> float:
        """x by the classical Runge-Kutta method in doubles."""
        ratio, start = float(self.ratio.mid()), float(self.theta.mid())
        square = None if self.square is None else float(self.square.mid())

        def inertia(theta: float) -> float:
            return math.sin(theta) ** 2 + 1 / 3

        def pace(x: float) -> float:
            half = (x if square is not None else x * x) / 2
            if square is None:
                fallen = ratio * math.sin(start + half) * (math.sin(half) / half if half else 1.0)
            else:
                fallen = 8 * ratio * math.sin(start + half) * math.sin(half) + square * inertia(start)
            return math.sqrt(max(fallen, 0.0) / inertia(start + 2 * half))

        count = max(1, math.ceil(time * math.sqrt(6 * ratio) / STEP))
        h, x = time / count, 0.0
        for _ in range(count):
            a = pace(x)
            b = pace(x + h * a / 2)
            c = pace(x + h * b / 2)
            x += h * (a + 2 * b + 2 * c + pace(x + h * c)) / 6
        return x


def _inertia(theta: Any) -> Any:
    s = theta.sin()
    return s * s + flint.arb(1) / 3


class _Rod(BallMotion):
    """A rod that ends flat on the floor; a subclass states `_fall()` and the time `_begin()` at which it begins."""

    @abstractmethod
    def _fall(self) -> FloorFall: ...

    @abstractmethod
    def _begin(self) -> Any: ...

    @property
    @abstractmethod
    def stands(self) -> bool:
        """Whether the rod never moves."""

    def floor_time(self, digits: int = 15) -> Any:
        """Time at which the rod reaches the floor (s)."""
        return self._derived(digits, lambda: self._begin() + _flat(self, flint.ctx.prec))

    def flat_angle(self, digits: int = 15) -> Any:
        """pi/2."""
        return self._derived(digits, lambda: flint.arb.pi() / 2)

    def floor_rate(self, digits: int = 15) -> Any:
        """omega just before the rod reaches the floor (rad/s)."""

        def rate() -> Any:
            fall = _fall(self, flint.ctx.prec)
            return fall.rate(fall.way(flint.arb.pi() / 2))

        return self._derived(digits, rate)

    def _falling(self, t: Fraction) -> Sequence[Any]:
        fall, time = _fall(self, flint.ctx.prec), ball(t) - self._begin()
        if time > _flat(self, flint.ctx.prec):
            return [flint.arb.pi() / 2, flint.arb(0)]
        return list(fall.at(time))


@lru_cache(maxsize=32)
def _fall(motion: _Rod, bits: int) -> FloorFall:
    return motion._fall()


@lru_cache(maxsize=32)
def _flat(motion: _Rod, bits: int) -> Any:
    """Duration of the motion on the floor alone."""
    fall = _fall(motion, bits)
    return fall.elapsed(flint.arb(0), fall.way(flint.arb.pi() / 2))


@dataclass(frozen=True)
class FallingRod(_Rod):
    """Released from rest on a smooth floor, without a wall: state (theta, omega), 0 <= theta < pi/2."""

    g: Fraction
    L: Fraction
    theta: Fraction

    @property
    def stands(self) -> bool:
        return self.theta == 0

    def _fall(self) -> FloorFall:
        return FloorFall(ball(self.g / self.L), ball(self.theta), None)

    def _begin(self) -> Any:
        return flint.arb(0)

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if self.stands or t == 0:
            return [ball(self.theta), flint.arb(0)]
        if t < 0:
            theta, omega = self._falling(-t)
            return [theta, -omega]
        return self._falling(t)


@dataclass(frozen=True)
class SlidingLadder(_Rod):
    """State (theta, omega), started on the wall: 0 <= theta < pi/2, 0 <= omega^2 < (3g/2L) cos(theta)."""

    g: Fraction
    L: Fraction
    theta: Fraction
    omega: Fraction

    @property
    def stands(self) -> bool:
        return self.theta == 0 and self.omega == 0

    def centre_velocity(self, digits: int = 15) -> Any:
        """The constant horizontal velocity of the centre after the rod has left the wall (m/s)."""

        def velocity() -> Any:
            theta, omega = self._leaving()
            return ball(self.L) / 2 * theta.cos() * omega

        return self._derived(digits, velocity)

    def leaving_time(self, digits: int = 15) -> Any:
        """Time at which the rod leaves the wall (s)."""
        return self._derived(digits, self._begin)

    def leaving_state(self, digits: int = 15) -> tuple[Any, Any]:
        """Angle and rate at the leaving time."""

        with working(digits + 2) as mp:
            theta, omega = publish(refined(mp, self._leaving), digits)
        return theta, omega

    def _leaving(self) -> tuple[Any, Any]:
        fall = _fall(self, flint.ctx.prec)
        return fall.theta, fall.rate(flint.arb(0))

    def on_wall(self, t: Fraction) -> bool:
        """Whether the rod touches the wall at t; the leaving time, an elliptic integral, is not a rational number."""
        return self.stands or bool(self.leaving_time(40) > t)

    def _top(self) -> Any:
        """cos(theta) where omega would be zero."""
        return ball(self.theta).cos() + ball(self.omega**2 * self.L / (3 * self.g))

    def _begin(self) -> Any:
        """2 R_F of DLMF 19.29.4 between the cosines, over sqrt(3g/L)."""
        top = self._top()
        high, low = ball(self.theta).cos(), 2 * top / 3
        margin = ball(self.omega**2 * self.L / (3 * self.g)).sqrt()
        x1, x2, x3 = 2 ** flint.arb(0.5) * (ball(self.theta) / 2).sin(), (1 + high).sqrt(), margin
        y1, y2, y3 = (1 - low).sqrt(), (1 + low).sqrt(), (top / 3).sqrt()
        width = high - low
        u12 = (x1 * x2 * y3 + y1 * y2 * x3) / width
        u13 = (x1 * x3 * y2 + y1 * y3 * x2) / width
        u23 = (x2 * x3 * y1 + y2 * y3 * x1) / width
        integral = flint.acb.elliptic_rf(flint.acb(u12 * u12), flint.acb(u13 * u13), flint.acb(u23 * u23)).real
        return 2 * integral / ball(3 * self.g / self.L).sqrt()

    def _fall(self) -> FloorFall:
        """From the leaving time on."""
        cosine, ratio = 2 * self._top() / 3, ball(self.g / self.L)
        return FloorFall(ratio, cosine.acos(), 3 * ratio * cosine / 2)

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if self.on_wall(t):
            return Hoop(-3 * self.g / (2 * self.L), Fraction(0), self.theta, self.omega)._balls(t)
        return self._falling(t)
