"""A ball on a table: it slides with constant acceleration until it rolls.

The slip s = (vx - R wy, vy + R wx) keeps its direction, so the path is a parabola until
t1 = 2 |s0|/(7 mu g), and then a straight line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.precision import publish, working


@dataclass(frozen=True)
class Sphere:
    """State (x, y, vx, vy, wx, wy, wz), z upward, of a solid sphere of radius R, friction mu >= 0, gravity g."""

    R: Fraction
    mu: Fraction
    g: Fraction
    x: Fraction
    y: Fraction
    vx: Fraction
    vy: Fraction
    wx: Fraction
    wy: Fraction
    wz: Fraction

    @property
    def slip(self) -> tuple[Fraction, Fraction]:
        """Velocity of the lowest point at the start."""
        return self.vx - self.R * self.wy, self.vy + self.R * self.wx


@dataclass(frozen=True)
class BilliardBall(Sphere, BallMotion):
    """A sphere that slides and then rolls."""

    @property
    def slides(self) -> bool:
        return any(self.slip)

    @property
    def will_roll(self) -> bool:
        return self.mu > 0

    def rolling_time(self, digits: int = 15) -> Any:
        """Time at which sliding ends (s); mu > 0."""
        return self._derived(digits, self._rolling_time)

    def rolling_state(self, digits: int = 15) -> tuple[Any, ...]:
        """The state when sliding ends; mu > 0."""
        with working(digits + 2) as mp:
            return publish(refined(mp, lambda: self._rolled(flint.arb(0))), digits)

    def rolling_velocity(self, digits: int = 15) -> tuple[Any, Any]:
        """The velocity of the centre from the end of sliding on (m/s)."""
        _x, _y, vx, vy, *_ = self.rolling_state(digits)
        return vx, vy

    def energy_loss(self, digits: int = 15) -> Any:
        """Energy lost per unit mass, |s0|^2/7."""
        sx, sy = self.slip
        return self._derived(digits, lambda: ball((sx * sx + sy * sy) / 7))

    def spin_up(self) -> tuple[Any, Any, Any]:
        """The angular acceleration while the ball slides, in ball arithmetic."""
        sx, sy = map(ball, self.slip)
        push = ball(Fraction(5, 2) * self.mu * self.g / self.R) / self._slip_size()
        return -push * sy, push * sx, flint.arb(0)

    def _rolling_time(self) -> Any:
        return 2 * self._slip_size() / ball(7 * self.mu * self.g)

    def _slip_size(self) -> Any:
        sx, sy = self.slip
        return ball(sx * sx + sy * sy).sqrt()

    def rolls_at(self, t: Fraction) -> bool:
        """Whether sliding has ended at t, decided exactly: |s0| <= 7 mu g t/2."""
        sx, sy = self.slip
        return t >= 0 and sx * sx + sy * sy <= (7 * self.mu * self.g * t / 2) ** 2

    def _slid(self, time: Any) -> list[Any]:
        """The state after sliding for a time."""
        sx, sy = map(ball, self.slip)
        size = self._slip_size()
        push = ball(self.mu * self.g) * time
        dx, dy = (-push * sx / size, -push * sy / size) if self.slides else (flint.arb(0), flint.arb(0))
        x, y, vx, vy, wx, wy, wz = map(ball, (self.x, self.y, self.vx, self.vy, self.wx, self.wy, self.wz))
        turn = ball(Fraction(5, 2) / self.R)
        return [
            x + (vx + dx / 2) * time,
            y + (vy + dy / 2) * time,
            vx + dx,
            vy + dy,
            wx + turn * dy,
            wy - turn * dx,
            wz,
        ]

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if not self.slides or not self.rolls_at(t):
            return self._slid(ball(t))
        return self._rolled(ball(t) - self._rolling_time())

    def _rolled(self, rest: Any) -> list[Any]:
        """The state at `rest` after sliding ends; the rates are rational."""
        x, y, *_, wz = self._slid(self._rolling_time())
        px = ball(5 * self.vx / 7 + 2 * self.R * self.wy / 7)
        py = ball(5 * self.vy / 7 - 2 * self.R * self.wx / 7)
        radius = ball(self.R)
        return [x + px * rest, y + py * rest, px, py, -py / radius, px / radius, wz]
