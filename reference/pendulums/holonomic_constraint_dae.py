"""The pendulum in Cartesian coordinates, x right and y up from the pivot.

The radius and the initial angle follow from the given coordinates and are irrational. The simple pendulum starts from
them with enough guard digits for the growth of their rounding errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

from gnomon.reference.numerics.motion import Motion, decades
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.numerics.precision import exact, working
from gnomon.reference.pendulums.pendulum_simple import Pendulum

MOST_GROWTH = 60
"""Digits by which the saddle can magnify a rounding error, for starts no closer to it than 1e-30."""


@dataclass(frozen=True)
class CartesianPendulum(Motion):
    """State (x, y, x', y'), velocity along the circle: x x' + y y' = 0 at the start, exactly."""

    g: Fraction
    x0: Fraction
    y0: Fraction
    vx0: Fraction
    vy0: Fraction

    @property
    def radius_squared(self) -> Fraction:
        return self.x0**2 + self.y0**2

    @property
    def rate(self) -> Fraction:
        """Angular velocity at the start (rad/s)."""
        return (self.x0 * self.vy0 - self.y0 * self.vx0) / self.radius_squared

    @property
    def rests(self) -> bool:
        """Whether it is in equilibrium, at the top or at the bottom."""
        return self.x0 == 0 and self.rate == 0

    @property
    def on_separatrix(self) -> bool:
        """Whether the energy is exactly the energy of the upright position."""
        energy = (self.vx0**2 + self.vy0**2) / 2 + self.g * self.y0
        return energy > 0 and energy**2 == self.g**2 * self.radius_squared

    def pendulum(self, digits: int) -> Pendulum:
        """The equivalent simple pendulum, with length and angle rounded to `digits`."""
        return _pendulum(self, digits)

    def period(self, digits: int = 15) -> Any:
        """Period of the swing, or duration of a turn (s)."""
        return self.pendulum(digits + MOST_GROWTH).period(digits)

    def multiplier(self, digits: int = 15) -> Any:
        """The Lagrange multiplier at the start (1/s^2): the tension of the rod over mass and length."""
        top = self.vx0**2 + self.vy0**2 - self.g * self.y0
        return self._quantity(digits, lambda mp: mp.mpf(top / self.radius_squared))

    def _guard(self, t: Fraction) -> float:
        return 30 + MOST_GROWTH + decades(t * t * (self.g**2 / self.radius_squared + self.rate**2 + 1))

    def _cycle(self, mp: Any) -> Cycle | None:
        if self.rests or self.on_separatrix:
            return None
        return Cycle(mp.mpf(exact(self.period(mp.dps))), (mp.zero,) * 4)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        if self.rests:
            return mp.mpf(self.x0), mp.mpf(self.y0), mp.zero, mp.zero
        inner = self.pendulum(mp.dps)
        theta, omega = (mp.mpf(exact(v)) for v in inner.state(t, mp.dps - MOST_GROWTH // 2))
        length = mp.sqrt(mp.mpf(self.radius_squared))
        sine, cosine = mp.sin(theta), mp.cos(theta)
        return length * sine, -length * cosine, length * cosine * omega, length * sine * omega


@lru_cache(maxsize=64)
def _pendulum(motion: CartesianPendulum, digits: int) -> Pendulum:
    with working(digits + 10) as mp:
        length = exact(mp.sqrt(mp.mpf(motion.radius_squared)))
        theta = exact(mp.atan2(mp.mpf(motion.x0), -mp.mpf(motion.y0)))
    return Pendulum(motion.g, length, theta, motion.rate)
