"""A round body on an incline, slipping or rolling: constant acceleration between events.

With k = I/(m R^2) the body can roll if tan(alpha) <= mu (1 + 1/k); otherwise it always slips.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.contact.block_incline_friction import holds
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.precision import publish, working


@dataclass(frozen=True)
class RollingBody(BallMotion):
    """State (s, v, w), s down the slope, 0 <= alpha < pi/2, mu >= 0; slip v - R w."""

    g: Fraction
    alpha: Fraction
    mu: Fraction
    k: Fraction
    R: Fraction
    s: Fraction
    v: Fraction
    w: Fraction

    @cached_property
    def can_roll(self) -> bool:
        return holds(self.alpha, self.mu * (1 + 1 / self.k))

    @property
    def slip(self) -> Fraction:
        return self.v - self.R * self.w

    @property
    def slip_ends(self) -> bool:
        """Whether a slip at the start passes through zero."""
        if self.slip > 0:
            return self.can_roll and self._pushed
        return self.slip < 0 and self._pushed

    @property
    def _pushed(self) -> bool:
        return self.alpha != 0 or self.mu != 0

    def slip_time(self, digits: int = 15) -> Any:
        """Time at which the slip ends (s)."""
        return self._derived(digits, self._slip_time)

    def slip_state(self, digits: int = 15) -> tuple[Any, ...]:
        """The state when the slip ends."""
        with working(digits + 2) as mp:
            return tuple(publish(refined(mp, self._end), digits))

    def rolling_acceleration(self, digits: int = 15) -> Any:
        """g sin(alpha)/(1 + k)."""
        return self._derived(digits, self._rolling)

    def _rolling(self) -> Any:
        return ball(self.g / (1 + self.k)) * ball(self.alpha).sin()

    def _slipping(self, side: int) -> tuple[Any, Any]:
        """v' and R w' while the slip has the sign `side`."""
        sine, cosine = ball(self.alpha).sin_cos()
        friction = side * ball(self.mu * self.g) * cosine
        return ball(self.g) * sine - friction, friction / ball(self.k)

    def _slip_time(self) -> Any:
        forward, turning = self._slipping(1 if self.slip > 0 else -1)
        return -ball(self.slip) / (forward - turning)

    def _end(self) -> Sequence[Any]:
        # Not (s, v, v/R): without friction w keeps its value exactly, also where that value is 0.
        s, _, w = self._slipped(self._slip_time(), 1 if self.slip > 0 else -1)
        return [s, ball(self.R) * w, w]

    def _slipped(self, time: Any, side: int) -> Sequence[Any]:
        forward, turning = self._slipping(side)
        s, v, w = ball(self.s), ball(self.v), ball(self.w)
        return [s + time * (v + forward * time / 2), v + forward * time, w + turning / ball(self.R) * time]

    def _past(self, t: Fraction) -> bool:
        """Whether the slip has ended; exact for alpha = 0, on a slope it ends at no rational time (Lindemann)."""
        if self.alpha == 0:
            return t >= abs(self.slip) / (self.mu * self.g * (1 + 1 / self.k))
        return bool(self.slip_time(40) <= t)

    def _balls(self, t: Fraction) -> Sequence[Any]:
        side = 1 if self.slip > 0 else -1
        if self.slip and not (self.slip_ends and self._past(t)):
            return self._slipped(ball(t), side)
        time = ball(t) - self._slip_time() if self.slip else ball(t)
        s, v, w = self._end() if self.slip else map(ball, (self.s, self.v, self.w))
        forward, turning = (self._rolling(), self._rolling()) if self.can_roll else self._slipping(1)
        return [s + time * (v + forward * time / 2), v + forward * time, w + turning / ball(self.R) * time]
