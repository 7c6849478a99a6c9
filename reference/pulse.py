"""A mass under a short pulse of force, exact in rational numbers (Beatty, Dynamics, 7.2, 7.3).

The pulse is the parabola F = 6 J s (T - s)/T^3, 0 < s = t - t1 < T, of impulse J. As T goes to 0 the motion goes to that
of an instantaneous impulse, v -> v + J/m at t1, with an error of the place of J T/(2 m).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.motion import Motion


@dataclass(frozen=True)
class Pulse(Motion):
    """State (x, v)."""

    m: Fraction
    impulse: Fraction
    begin: Fraction
    length: Fraction
    x0: Fraction
    v0: Fraction

    def at(self, t: Fraction) -> tuple[Fraction, Fraction]:
        """The state, exactly."""
        x, v = self.x0 + self.v0 * t, self.v0
        if t <= self.begin:
            return x, v
        s, T = min(t - self.begin, self.length), self.length
        kick = self.impulse / self.m
        gained = kick * s**2 * (3 * T - 2 * s) / T**3
        way = kick * s**3 * (2 * T - s) / (2 * T**3)
        return x + way + gained * (t - self.begin - s), v + gained

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        return [mp.mpf(value) for value in self.at(t)]
