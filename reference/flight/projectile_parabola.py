"""The projectile in uniform gravity: r = r0 + v0 t + g t^2 / 2."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.precision import Number, exact


@dataclass(frozen=True)
class Projectile(Motion):
    """A mass point thrown from (x, y) with velocity (vx, vy), y upward, gravity g downward (m, m/s, m/s^2).

    The motion is a polynomial with rational coefficients, and only the result is rounded.
    """

    g: Fraction
    x: Fraction
    y: Fraction
    vx: Fraction
    vy: Fraction

    def _state(self, mp: Any, t: Fraction) -> list[Any]:
        return [mp.mpf(value) for value in self.rational(t)]

    def rational(self, t: Number) -> tuple[Fraction, Fraction, Fraction, Fraction]:
        """The state at time t as exact fractions."""
        t = exact(t, "t")
        return self.x + self.vx * t, self.y + self.vy * t - self.g * t**2 / 2, self.vx, self.vy - self.g * t

    def apex(self, digits: int = 15) -> tuple[Any, Any]:
        """Time (s; negative where the throw points down) and height (m) of the highest point; g > 0."""
        self._need_gravity("apex")
        return (
            self._quantity(digits, lambda mp: mp.mpf(self.vy / self.g)),
            self._quantity(digits, lambda mp: mp.mpf(self.y + self.vy**2 / (2 * self.g))),
        )

    def landing(self, digits: int = 15) -> tuple[Any, Any] | None:
        """Time (s) and x (m) of the fall through y = 0, or None where the parabola stays below; g > 0."""
        self._need_gravity("landing")
        if self._fall_square < 0:
            return None
        return (
            self._quantity(digits, self._landing_time, guard=20),
            self._quantity(digits, lambda mp: mp.mpf(self.x) + mp.mpf(self.vx) * self._landing_time(mp), guard=20),
        )

    def range(self, digits: int = 15) -> Any | None:
        """Horizontal distance from the start to the fall through y = 0 (m), None if the parabola stays below; g > 0."""
        self._need_gravity("range")
        if self._fall_square < 0:
            return None
        return self._quantity(digits, lambda mp: mp.mpf(self.vx) * self._landing_time(mp), guard=20)

    @property
    def _fall_square(self) -> Fraction:
        """The square of the vertical speed at y = 0."""
        return self.vy**2 + 2 * self.g * self.y

    def _landing_time(self, mp: Any) -> Any:
        root = mp.sqrt(mp.mpf(self._fall_square))
        if self.vy >= 0:
            return (mp.mpf(self.vy) + root) / mp.mpf(self.g)
        # vy + root cancels for a throw downward from a low height.
        return mp.mpf(2 * self.y) / (root - mp.mpf(self.vy))

    def envelope(self, x: Number, digits: int = 15) -> Any:
        """Largest height (m) at x over all directions of the throw: v^2/2g - g d^2/2v^2 above y0, d = x - x0."""
        self._need_gravity("envelope")
        square = self.vx**2 + self.vy**2
        if square == 0:
            raise ValueError("the envelope needs a speed; vx = vy = 0")
        distance = exact(x, "x") - self.x
        height = self.y + square / (2 * self.g) - self.g * distance**2 / (2 * square)
        return self._quantity(digits, lambda mp: mp.mpf(height))

    def highest_apex(self, digits: int = 15) -> Any:
        """The height of the envelope above the start, its top (m); g > 0 and a speed."""
        return self.envelope(self.x, digits)

    def farthest_range(self, digits: int = 15) -> Any | None:
        """Where the envelope meets y = 0, v sqrt(v^2 + 2 g y0)/g (m); None where it stays below; g > 0."""
        self._need_gravity("farthest range")
        square = self.vx**2 + self.vy**2
        reach = square * (square + 2 * self.g * self.y) / self.g**2
        return None if reach < 0 else self._quantity(digits, lambda mp: mp.sqrt(mp.mpf(reach)))

    def _need_gravity(self, what: str) -> None:
        if self.g == 0:
            raise ValueError(f"without gravity the motion has no {what}; give g > 0")
