"""A flyball governor that spins freely: the azimuth is cyclic, the arms move in a well.

With J = I + 2 m L^2 sin^2(theta) and p = J phi' constant, M theta'^2/2 + V = E, M = 2 L^2 (m + 2 M_s sin^2(theta)) and
V = p^2/(2 J) - 2 (m + M_s) g L cos(theta). Fast spin lifts the arms off the spindle: V then has a maximum at theta = 0,
and the arms stay on one side of it or swing through it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

import flint
from gnomon.reference.numerics.phase import Balls
from gnomon.reference.numerics.precision import working
from gnomon.reference.numerics.well import WellMotion


@dataclass(frozen=True)
class Governor(WellMotion):
    """State (theta, phi, theta', phi'), theta from the spindle downward, |theta| < pi; m and L > 0, inertia > 0."""

    g: Fraction
    m: Fraction
    sleeve: Fraction
    length: Fraction
    inertia: Fraction
    theta: Fraction
    phi: Fraction
    rate: Fraction
    spin: Fraction

    @property
    def rests(self) -> bool:
        """Whether the arms hang along the spindle; other equilibria are at no rational angle."""
        return self.theta == 0 and self.rate == 0

    @cached_property
    def lifted(self) -> bool:
        """Whether the arms have an equilibrium off the spindle: p^2 m L > I^2 (m + M_s) g.

        Decided with 40 digits; equality needs a start at theta = 0.
        """
        with working(40) as mp:
            momentum = self._momentum(mp)
            square = mp.mpf(self.inertia**2 * (self.m + self.sleeve) * self.g / (self.m * self.length))
            return bool(momentum**2 > square)

    @cached_property
    def one_sided(self) -> bool:
        """Whether the arms stay on one side of the spindle."""
        with working(40) as mp:
            return self.lifted and bool(self._energy(mp) < self._potential(mp, mp.zero))

    @cached_property
    def swings(self) -> bool:
        """Whether the arms do not reach the upright position."""
        with working(40) as mp:
            return bool(self._energy(mp) < self._potential(mp, +mp.pi) * (1 - mp.mpf(10) ** -30))

    def steady_angle(self, digits: int = 15) -> Any:
        """The equilibrium angle at this momentum: L cos(theta) = (m + M_s) g/(m phi'^2) with the spin there."""
        return self._quantity(digits, lambda mp: abs(self._bottom(mp)), 30)

    def momentum(self, digits: int = 15) -> Any:
        """J phi', conjugate to the azimuth."""
        return self._quantity(digits, self._momentum)

    def azimuth(self, digits: int = 15) -> Any:
        """The growth of phi in a period of theta (rad)."""
        return self.carried_over_period(0, digits)

    def small_frequency(self, digits: int = 15) -> Any:
        """Angular frequency of small swings about the steady angle, sqrt(V''/M)."""

        def formula(mp: Any) -> Any:
            x = self._bottom(mp)
            sine, cosine = mp.sin(x), mp.cos(x)
            weight = 2 * mp.mpf((self.m + self.sleeve) * self.g * self.length)
            twice = 2 * mp.mpf(self.m * self.length**2)
            inertia = self._inertia(mp, x)
            turned = self._momentum(mp) ** 2 * twice
            curvature = weight * cosine - turned * (cosine**2 - sine**2) / inertia**2
            curvature += 4 * turned * twice * (sine * cosine) ** 2 / inertia**3
            return mp.sqrt(curvature / self._mass(mp, x))

        return self._quantity(digits, formula, 30)

    def spin_at(self, theta: float, digits: int = 15) -> Any:
        """phi' when the arms are at theta."""
        return self._quantity(digits, lambda mp: self._momentum(mp) / self._inertia(mp, mp.mpf(theta)))

    def fastest_spin(self, digits: int = 15) -> Any:
        """The largest |phi'|, where the arms are closest to the spindle."""
        if self.rests:
            return self._quantity(digits, lambda mp: abs(mp.mpf(self.spin)))
        low, high = (abs(float(x)) for x in self.turning_points())
        return abs(self.spin_at(min(low, high) if self.one_sided else 0.0, digits))

    def _inertia(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.inertia) + 2 * mp.mpf(self.m * self.length**2) * mp.sin(x) ** 2

    def _momentum(self, mp: Any) -> Any:
        return _kept_momentum(self, mp, flint.ctx.prec if mp is Balls else mp.prec)

    def _own_momentum(self, mp: Any) -> Any:
        return self._inertia(mp, mp.mpf(self.theta)) * mp.mpf(self.spin)

    def _begin(self) -> tuple[Fraction, Fraction]:
        return self.theta, self.rate

    def _bottom(self, mp: Any) -> Any:
        """The root of J^2 = c cos(theta) below the horizontal, c = p^2 m L/((m + M_s) g): bisection, then Newton."""
        if not self.lifted:
            return mp.zero
        size = self._momentum(mp) ** 2 * mp.mpf(self.m * self.length / ((self.m + self.sleeve) * self.g))
        twice = 2 * mp.mpf(self.m * self.length**2)
        low, high = mp.zero, mp.pi / 2
        for _ in range(60):
            middle = (low + high) / 2
            if self._inertia(mp, middle) ** 2 < size * mp.cos(middle):
                low = middle
            else:
                high = middle
        x = (low + high) / 2
        for _ in range(60):
            inertia, sine, cosine = self._inertia(mp, x), mp.sin(x), mp.cos(x)
            step = (inertia**2 - size * cosine) / (4 * inertia * twice * sine * cosine + size * sine)
            x -= step
            if abs(step) <= 8 * mp.eps * x:
                break
        return -x if self.theta < 0 or (self.theta == 0 and self.rate < 0) else x

    def _walls(self, mp: Any) -> tuple[Any, Any]:
        if not self.one_sided:
            return -mp.pi, +mp.pi
        return (mp.zero, +mp.pi) if self.theta > 0 else (-mp.pi, mp.zero)

    def _mass(self, mp: Any, x: Any) -> Any:
        square = 2 * mp.mpf(self.length**2)
        return square * (mp.mpf(self.m) + 2 * mp.mpf(self.sleeve) * mp.sin(x) ** 2)

    def _potential(self, mp: Any, x: Any) -> Any:
        """V - V(0), which resolves a small maximum."""
        half = mp.sin(x / 2) ** 2
        square, moment = 4 * half * (1 - half), mp.mpf(self.m * self.length**2)
        about = mp.mpf(self.inertia) * (mp.mpf(self.inertia) + 2 * moment * square)
        return 4 * mp.mpf((self.m + self.sleeve) * self.g * self.length) * half - (
            self._momentum(mp) ** 2 * moment * square / about
        )

    def _slope(self, mp: Any, x: Any) -> Any:
        weight = 2 * mp.mpf((self.m + self.sleeve) * self.g * self.length)
        turned = self._momentum(mp) ** 2 * 2 * mp.mpf(self.m * self.length**2) / self._inertia(mp, x) ** 2
        return mp.sin(x) * (weight - turned * mp.cos(x))

    def _carried(self, mp: Any, x: Any) -> tuple[Any, ...]:
        return (self._momentum(mp) / self._inertia(mp, x),)

    def _read(self, mp: Any, t: Fraction, x: Any, rate: Any, carried: Sequence[Any]) -> Sequence[Any]:
        return x, mp.mpf(self.phi) + carried[0], rate, self._momentum(mp) / self._inertia(mp, x)

    def _turned(self, mp: Any, carried: Sequence[Any], period: Any) -> Sequence[Any]:
        return mp.zero, carried[0], mp.zero, mp.zero


@lru_cache(maxsize=64)
def _kept_momentum(motion: Governor, mp: Any, bits: int) -> Any:
    """Cached by precision, because integrals need it thousands of times."""
    return motion._own_momentum(mp)
