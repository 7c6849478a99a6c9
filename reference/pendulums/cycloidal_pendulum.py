"""Huygens' pendulum: a bead on the cycloid x = a (phi + sin phi), y = a (1 - cos phi).

The arc length from the bottom, s = 4 a sin(phi/2), is a harmonic motion for every amplitude: s'' = -(g/4a) s. The angle
follows from it; it is singular at the cusp, phi = pi, where the motion in s is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.numerics.motion import Motion, decades
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.numerics.precision import Number, exact, publish, working


@dataclass(frozen=True)
class CycloidalMotion(Motion):
    """State (phi, phi'), started between the cusps with |phi'| < sqrt(g/a)."""

    a: Fraction
    g: Fraction
    phi0: Fraction
    rate0: Fraction

    def period(self, digits: int = 15) -> Any:
        """4 pi sqrt(a/g) for every amplitude."""
        return self._quantity(digits, lambda mp: 2 * mp.pi / self._frequency(mp))

    def arc_amplitude(self, digits: int = 15) -> Any:
        """The largest arc length from the bottom, below 4 a."""
        return self._quantity(digits, lambda mp: 4 * mp.mpf(self.a) * mp.sqrt(1 - self._clearance(mp)), 30)

    def angle_amplitude(self, digits: int = 15) -> Any:
        """The largest angle."""

        def formula(mp: Any) -> Any:
            left = self._clearance(mp)
            return 2 * mp.atan2(mp.sqrt(1 - left), mp.sqrt(left))

        return self._quantity(digits, formula, 30 + self._depth)

    def top_rate(self, digits: int = 15) -> Any:
        """The largest |phi'|, at the bottom: 2 w times the amplitude of sin(phi/2)."""
        return self._quantity(digits, lambda mp: 2 * self._frequency(mp) * mp.sqrt(1 - self._clearance(mp)), 30)

    def energy(self, digits: int = 15) -> Any:
        """Energy per unit mass above the bottom: w^2/2 times the square of the arc amplitude."""
        return self._quantity(digits, lambda mp: 2 * mp.mpf(self.a * self.g) * (1 - self._clearance(mp)), 30)

    @property
    def string_length(self) -> Fraction:
        """The length of a string between jaws of the same shape, 4 a."""
        return 4 * self.a

    def normal_force_start(self, digits: int = 15) -> Any:
        """Over the mass: g cos(phi/2) + v^2/(4a cos(phi/2)), v = 2a cos(phi/2) phi'."""
        pull = self.g + self.a * self.rate0**2
        return self._quantity(digits, lambda mp: mp.mpf(pull) * mp.cos(mp.mpf(self.phi0) / 2))

    def normal_force_bottom(self, digits: int = 15) -> Any:
        """Normal force per unit mass at the bottom: g cos(phi/2) + v^2/(4 a cos(phi/2)) at phi = 0."""
        return self._quantity(digits, lambda mp: mp.mpf(self.g) * (2 - self._clearance(mp)), 30)

    def arc(self, t: Number, digits: int = 15) -> tuple[Any, Any]:
        """Arc length from the bottom and its rate."""
        time = exact(t, "t")
        with working(digits + self._guard(time)) as mp:
            s, rate = self._sine(mp, time)
            size = 4 * mp.mpf(self.a)
            published = publish((size * s, size * rate), digits)
        return published[0], published[1]

    def _frequency(self, mp: Any) -> Any:
        return mp.sqrt(mp.mpf(self.g / (4 * self.a)))

    def _clearance(self, mp: Any) -> Any:
        """1 - (largest sin(phi/2))^2 = cos^2(phi0/2) (1 - phi0'^2 a/g): no difference of nearly equal numbers."""
        return mp.cos(mp.mpf(self.phi0) / 2) ** 2 * mp.mpf(1 - self.rate0**2 * self.a / self.g)

    def _sine(self, mp: Any, t: Fraction) -> tuple[Any, Any]:
        """sin(phi/2) and its rate: a harmonic motion."""
        w = self._frequency(mp)
        half = mp.mpf(self.phi0) / 2
        start, rate = mp.sin(half), mp.cos(half) * mp.mpf(self.rate0) / 2
        cosine, sine = mp.cos_sin(w * mp.mpf(t))
        return start * cosine + rate / w * sine, rate * cosine - w * start * sine

    @cached_property
    def _depth(self) -> float:
        """Digits that the angle loses next to the cusp, where it reverses in the time sqrt(clearance)/w."""
        with working(30) as mp:
            return max(0.0, -float(mp.log10(self._clearance(mp))))

    def _cycle(self, mp: Any) -> Cycle:
        return Cycle(2 * mp.pi / self._frequency(mp), (mp.zero, mp.zero))

    def _guard(self, t: Fraction) -> float:
        return 15 + 2 * self._depth + decades(t * t * self.g / self.a) / 2

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        sine, rate = self._sine(mp, t)
        # cos^2 = clearance + (rate/w)^2: 1 - sin^2 would cancel next to the cusp.
        cosine = mp.sqrt(self._clearance(mp) + (rate / self._frequency(mp)) ** 2)
        return 2 * mp.atan2(sine, cosine), 2 * rate / cosine
