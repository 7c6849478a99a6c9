"""A particle that slides on a smooth circle and leaves it: from the top of a sphere, or inside a loop.

In contact the angle moves as a pendulum's (reference/guided/pendulum_on_hoop.py). Contact is lost where the normal
force vanishes; then the particle flies on a parabola, with r^2 - R^2 = tau^3 (v.g + g^2 tau/4) at the time tau after
the loss, because speed and curvature match the circle. This gives the distance from the circle without cancellation,
and the time of the next contact inside the loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

from gnomon.reference.guided.pendulum_on_hoop import Hoop
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.precision import exact, working


@dataclass(frozen=True)
class ContactLoss(Motion):
    """State (theta, h, omega, u): angle from the top of a sphere (`inside` False) or from the bottom of a loop (True).

    h is the distance from the circle, on the side where the particle is free, and u its rate. The start is in contact,
    with theta0 in [0, pi/2) and omega0 >= 0, moving or (inside) at rest, and a normal force that is not negative.
    """

    g: Fraction
    radius: Fraction
    theta0: Fraction
    omega0: Fraction
    inside: bool

    @cached_property
    def sliding(self) -> Hoop:
        """The motion in contact."""
        pull = self.g / self.radius
        return Hoop(pull if self.inside else -pull, Fraction(0), self.theta0, self.omega0)

    @cached_property
    def leaves(self) -> bool:
        """Whether contact is lost, decided with 40 digits."""
        if self.theta0 == 0 and self.omega0 == 0:
            return False
        if not self.inside:
            return True
        with working(40) as mp:
            cosine = self._leaving_cosine(mp)
            return bool(-1 < cosine < 0)

    def leaving_time(self, digits: int = 15) -> Any:
        """Time at which contact is lost (s); infinite if it is not."""
        return self._quantity(digits, self._leaving_time)

    def leaving_angle(self, digits: int = 15) -> Any:
        return self._quantity(digits, lambda mp: mp.acos(self._leaving_cosine(mp)))

    def leaving_rate(self, digits: int = 15) -> Any:
        return self._quantity(digits, self._leaving_rate)

    def flight_time(self, digits: int = 15) -> Any:
        """Time from leaving a loop to the next contact: 4 v_y/g; infinite for a sphere."""
        return self._quantity(digits, self._flight_time)

    def _leaving_cosine(self, mp: Any) -> Any:
        """cos(theta) where R omega^2 = +-g cos(theta)."""
        push, side = mp.mpf(self.radius * self.omega0**2 / self.g), -1 if self.inside else 1
        return (2 * mp.cos(mp.mpf(self.theta0)) + side * push) / 3

    def _leaving_rate(self, mp: Any) -> Any:
        return mp.sqrt(mp.mpf(self.g / self.radius) * abs(self._leaving_cosine(mp)))

    def _flight_time(self, mp: Any) -> Any:
        if not self.inside:
            return mp.inf
        sine = mp.sqrt(1 - self._leaving_cosine(mp) ** 2)
        return 4 * mp.mpf(self.radius / self.g) * self._leaving_rate(mp) * sine

    def _leaving_time(self, mp: Any) -> Any:
        return mp.mpf(_leaving_time(self, mp.dps + 5)) if self.leaves else mp.inf

    def _guard(self, t: Fraction) -> float:
        return 25

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        time, start = mp.mpf(t), self._leaving_time(mp)
        if time < start:
            theta, omega = self.sliding._state(mp, t)
            return theta, mp.zero, omega, mp.zero
        tau, g, radius = time - start, mp.mpf(self.g), mp.mpf(self.radius)
        cosine, rate = self._leaving_cosine(mp), self._leaving_rate(mp)
        sine, side = mp.sqrt(1 - cosine**2), -1 if self.inside else 1
        # y upward: (R sin, +-R cos), velocity R omega (cos, -+sin)
        vx, vy = radius * rate * cosine, -side * radius * rate * sine
        x, y = radius * sine + vx * tau, side * radius * cosine + vy * tau - g * tau**2 / 2
        fall, r = vy - g * tau, mp.hypot(x, y)
        theta = mp.atan2(x, side * y)
        if self.inside and theta < 0:  # past the top, not below the centre
            crossing = radius * sine / -vx
            theta += 2 * mp.pi if side * radius * cosine + vy * crossing - g * crossing**2 / 2 > 0 else 0
        h = side * tau**3 * (-g * vy + g**2 * tau / 4) / (r + radius)
        u = side * tau**2 * (-3 * g * vy + g**2 * tau) / (2 * r)
        return theta, h, side * (y * vx - x * fall) / r**2, u


@lru_cache(maxsize=32)
def _leaving_time(motion: ContactLoss, digits: int) -> Fraction:
    """A bracket and rough bisection, then Newton's method, each step with twice the digits."""
    step = Fraction(float(motion.radius / motion.g) ** 0.5 / 4)
    target = motion.leaving_angle(20)

    def past(t: Fraction) -> bool:
        theta, omega = motion.sliding.state(t, 15)
        return bool(theta >= target or (motion.inside and omega <= 0))

    low, high = Fraction(0), step
    while not past(high):
        low, high, step = high, high + step, step * Fraction(5, 4)
    for _ in range(14):
        middle = (low + high) / 2
        low, high = (low, middle) if past(middle) else (middle, high)
    time, known = high, 4
    for _ in range(60):
        known = min(2 * known, digits)
        with working(known + 20) as mp:
            theta, omega = motion.sliding._state(mp, time)
            step = (mp.acos(motion._leaving_cosine(mp)) - theta) / omega
            time = exact(mp.mpf(time) + step)
            if known == digits and abs(step) < mp.mpf(10) ** (-digits // 2 - 5) * mp.mpf(time):
                break  # the next error is the square of this one
    with working(digits + 20) as mp:
        return exact(mp.mpf(time) + 0)
