"""Belt drives and flywheels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.linear import LinearMotion, Row
from gnomon.reference.numerics.motion import BallMotion, Motion


@dataclass(frozen=True)
class BeltDrive(Motion):
    """State (w1, w2): the belt slips with the constant friction force F until r1 w1 = r2 w2, then it grips.

    A torque M acts on the first pulley. Every number is rational.
    """

    I1: Fraction
    I2: Fraction
    r1: Fraction
    r2: Fraction
    F: Fraction
    M: Fraction
    w1: Fraction
    w2: Fraction

    @property
    def slip(self) -> Fraction:
        """r1 w1 - r2 w2 at the start."""
        return self.r1 * self.w1 - self.r2 * self.w2

    @property
    def side(self) -> int:
        """+1 where the first pulley is ahead, -1 behind, 0 where the belt grips."""
        return (self.slip > 0) - (self.slip < 0)

    @property
    def grip_time(self) -> Fraction:
        """Time at which the slip ends."""
        first, second = self._slipping
        return -self.slip / (self.r1 * first - self.r2 * second) if self.side else Fraction(0)

    @property
    def gripped(self) -> tuple[Fraction, Fraction]:
        """The state at the grip time."""
        first = self.w1 + self._slipping[0] * self.grip_time
        return first, self.r1 * first / self.r2

    @property
    def belt_energy_loss(self) -> Fraction:
        """F times the distance that the belt slips."""
        return self.F * abs(self.slip) * self.grip_time / 2

    @property
    def _slipping(self) -> tuple[Fraction, Fraction]:
        return (self.M - self.side * self.F * self.r1) / self.I1, self.side * self.F * self.r2 / self.I2

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        if t < self.grip_time:
            first, second = self._slipping
            return mp.mpf(self.w1 + first * t), mp.mpf(self.w2 + second * t)
        ratio = self.r1 / self.r2
        first = self.gripped[0] + self.M / (self.I1 + self.I2 * ratio**2) * (t - self.grip_time)
        return mp.mpf(first), mp.mpf(ratio * first)


@dataclass(frozen=True)
class Flywheel(LinearMotion):
    """State (angle, w): I w' = M (1 + p cos(W t)) - c w."""

    inertia: Fraction
    c: Fraction
    M: Fraction
    p: Fraction
    W: Fraction
    angle: Fraction
    w: Fraction

    dimension: ClassVar[int] = 2

    def _system(self) -> tuple[Sequence[Row], Row]:
        """With the additional components 1, cos(W t) and sin(W t)."""
        load = self.M / self.inertia
        rows: list[Row] = [
            [0, 1, 0, 0, 0],
            [0, -self.c / self.inertia, load, load * self.p, 0],
            [0, 0, 0, 0, 0],
            [0, 0, 0, 0, -self.W],
            [0, 0, 0, self.W, 0],
        ]
        return rows, [self.angle, self.w, 1, 1, 0]

    def fluctuation(self, digits: int = 15) -> Any:
        """Amplitude of w in the steady state, M p/sqrt((I W)^2 + c^2)."""
        return self._derived(
            digits, lambda: ball(self.M * self.p) / ball((self.inertia * self.W) ** 2 + self.c**2).sqrt()
        )


@dataclass(frozen=True)
class CoastDown(BallMotion):
    """State (angle, w), w >= 0: I w' = -M - c w until the wheel stops; M > 0, c >= 0."""

    inertia: Fraction
    c: Fraction
    M: Fraction
    angle: Fraction
    w: Fraction

    def stop_time(self, digits: int = 15) -> Any:
        """(I/c) ln(1 + c w/M), I w/M without drag."""
        return self._derived(digits, self._stop)

    def stop_angle(self, digits: int = 15) -> Any:
        return self._derived(digits, lambda: self._turning(self._stop())[0])

    def stopped(self, t: Fraction) -> bool:
        """Whether the wheel rests at t; with drag the stop is at no rational time (Lindemann)."""
        if self.w == 0 or t <= 0:
            return self.w == 0
        if self.c == 0:
            return t >= self.inertia * self.w / self.M
        return bool(self.stop_time(40) <= t)

    def _stop(self) -> Any:
        if self.c == 0:
            return ball(self.inertia * self.w / self.M)
        return ball(self.c * self.w / self.M).log1p() * ball(self.inertia / self.c)

    def _turning(self, time: Any) -> Sequence[Any]:
        load = ball(self.M / self.inertia)
        if self.c == 0:
            return [ball(self.angle) + time * (ball(self.w) - load * time / 2), ball(self.w) - load * time]
        rate = ball(self.c / self.inertia)
        first = -(-rate * time).expm1() / rate  # the integral of e^(-rate t)
        second = (time - first) / rate
        return [
            ball(self.angle) + ball(self.w) * first - load * second,
            ball(self.w) * (-rate * time).exp() - load * first,
        ]

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if self.stopped(t):
            return [self._turning(self._stop())[0], ball(0)]
        return self._turning(ball(t))
