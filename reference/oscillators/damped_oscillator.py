"""Free vibration with viscous damping: m x'' = -c x' - k x.

With b = c/(2m), w^2 = k/m and D = b^2 - w^2 the motion is x = x0 C + (v0 + b x0) S, v = v0 C - (w^2 x0 + b v0) S, where
C and S are e^(-bt) times cos, sin over the damped frequency (D < 0), 1, t (D = 0) or cosh, sinh over sqrt(D) (D > 0).
The sign of D is the sign of an exact rational number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

from gnomon.reference.numerics.motion import Motion, decades
from gnomon.reference.numerics.pointwise import Cycle, Turn

LEAST_CYCLING = 20
"""Least ratio of decay rate and damped frequency without a cycle: the amplitude falls by e^(-40 pi) in a period."""


@dataclass(frozen=True)
class DampedMotion(Motion):
    """State (x, v)."""

    mass: Fraction
    damping: Fraction
    stiffness: Fraction
    x0: Fraction
    v0: Fraction

    UNDERDAMPED: ClassVar[str] = "underdamped"
    CRITICAL: ClassVar[str] = "critical"
    OVERDAMPED: ClassVar[str] = "overdamped"

    @property
    def decay(self) -> Fraction:
        """b = c/(2m)."""
        return self.damping / (2 * self.mass)

    @property
    def discriminant(self) -> Fraction:
        """D = b^2 - k/m."""
        return self.decay**2 - self.stiffness / self.mass

    @cached_property
    def regime(self) -> str:
        """underdamped, critical or overdamped."""
        if self.discriminant == 0:
            return self.CRITICAL
        return self.OVERDAMPED if self.discriminant > 0 else self.UNDERDAMPED

    def damping_ratio(self, digits: int = 15) -> Any:
        """zeta = c / (2 sqrt(k m))."""
        return self._quantity(digits, self._damping_ratio)

    def undamped_period(self, digits: int = 15) -> Any:
        """2 pi sqrt(m/k)."""
        return self._quantity(digits, lambda mp: 2 * mp.pi * mp.sqrt(mp.mpf(self.mass / self.stiffness)))

    def period(self, digits: int = 15) -> Any:
        """Time between maxima, 2 pi / sqrt(-D); underdamped only."""
        return self._quantity(digits, lambda mp: 2 * mp.pi / self._split(mp))

    def logarithmic_decrement(self, digits: int = 15) -> Any:
        """ln of the ratio of successive maxima, 2 pi b / sqrt(-D); underdamped only."""
        return self._quantity(digits, lambda mp: 2 * mp.pi * mp.mpf(self.decay) / self._split(mp))

    def rates(self, digits: int = 15) -> tuple[Any, Any]:
        """Decay rates of the slow and the fast mode (1/s); critical and overdamped."""
        return self._quantity(digits, lambda mp: self._modes(mp)[0]), self._quantity(
            digits, lambda mp: self._modes(mp)[1]
        )

    def overshoot_time(self, digits: int = 15) -> Any | None:
        """The first t > 0 at which x passes through zero; None where it never does."""
        if self._never_overshoots:
            return None
        return self._quantity(digits, self._overshoot_time, 10 + self._spread)

    @property
    def _never_overshoots(self) -> bool:
        """Without oscillation x crosses zero at most once, at t > 0 only if v0/x0 lies below minus the fast rate."""
        if self.x0 == 0:
            return self.v0 == 0 or self.regime != self.UNDERDAMPED
        if self.regime == self.UNDERDAMPED:
            return False
        # -v0/x0 > b + sqrt(D), in rational numbers.
        margin = -self.v0 / self.x0 - self.decay
        return not (margin > 0 and margin**2 > self.discriminant)

    def _overshoot_time(self, mp: Any) -> Any:
        x0, v0, b = mp.mpf(self.x0), mp.mpf(self.v0), mp.mpf(self.decay)
        slope = v0 + b * x0
        if self.regime == self.CRITICAL:
            return -x0 / slope
        root = self._split(mp)
        if self.regime == self.OVERDAMPED:
            return mp.atanh(-x0 * root / slope) / root
        angle = mp.atan2(-x0 * root, slope)
        return (angle if angle > 0 else angle + mp.pi) / root

    def _damping_ratio(self, mp: Any) -> Any:
        return mp.sqrt(mp.mpf(self.damping**2 / (4 * self.stiffness * self.mass)))

    def _split(self, mp: Any) -> Any:
        """sqrt(|D|): the damped frequency, or half the difference of the two rates."""
        return mp.sqrt(mp.mpf(abs(self.discriminant)))

    def _modes(self, mp: Any) -> tuple[Any, Any]:
        fast = mp.mpf(self.decay) + self._split(mp)
        return mp.mpf(self.stiffness / self.mass) / fast, fast  # b - sqrt(D) would cancel

    def _cycle(self, mp: Any) -> Cycle | None:
        if self.regime != self.UNDERDAMPED or self.decay**2 > -(LEAST_CYCLING**2) * self.discriminant:
            return None
        period = 2 * mp.pi / self._split(mp)
        lost = Turn([[mp.exp(-mp.mpf(self.decay) * period)]], [[0], [1]])
        return Cycle(period, (mp.zero, mp.zero), [lost])

    @property
    def _spread(self) -> float:
        """Digits of the ratio of fast and slow rate: the slow mode loses them to cancellation between C and S."""
        return decades(self.damping**2 / (self.mass * self.stiffness))

    def _guard(self, t: Fraction) -> float:
        return 15 + self._spread + decades(t * t * (self.stiffness / self.mass + self.decay**2)) / 2

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        x0, v0, b, time = mp.mpf(self.x0), mp.mpf(self.v0), mp.mpf(self.decay), mp.mpf(t)
        if self.regime == self.CRITICAL:
            c = mp.exp(-b * time)
            s = c * time
        elif self.regime == self.UNDERDAMPED:
            root = self._split(mp)
            cosine, sine = mp.cos_sin(root * time)
            envelope = mp.exp(-b * time)
            c, s = envelope * cosine, envelope * sine / root
        else:
            root = self._split(mp)
            slow, _ = self._modes(mp)
            envelope = mp.exp(-slow * time)
            fading = mp.expm1(-2 * root * time)
            c, s = envelope * (2 + fading) / 2, -envelope * fading / (2 * root)
        return x0 * c + (v0 + b * x0) * s, v0 * c - (mp.mpf(self.stiffness / self.mass) * x0 + b * v0) * s
