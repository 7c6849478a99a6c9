"""Two masses joined by a spring or by a rod, thrown together.

The centre of mass moves on a parabola; about it the pair vibrates harmonically (spring) or rotates uniformly (rod).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion, decades
from gnomon.reference.oscillators.harmonic_oscillator import HarmonicMotion


@dataclass(frozen=True)
class SpringPair(Motion):
    """m1 x1'' = k (x2 - x1 - rest) + m1 a, m2 x2'' = -k (x2 - x1 - rest) + m2 a along each of several axes.

    `places` and `velocities` hold a pair (body 1, body 2) for each axis, `rests` and `pulls` the rest length and the
    acceleration a. State: x of body 1, of body 2, then the velocities in the same sequence.
    """

    m1: Fraction
    m2: Fraction
    k: Fraction
    rests: tuple[Fraction, ...]
    pulls: tuple[Fraction, ...]
    places: tuple[tuple[Fraction, Fraction], ...]
    velocities: tuple[tuple[Fraction, Fraction], ...]

    @property
    def reduced(self) -> Fraction:
        """m1 m2/(m1 + m2)."""
        return self.m1 * self.m2 / (self.m1 + self.m2)

    def vibration(self, axis: int) -> HarmonicMotion:
        """The motion of x2 - x1 - rest along one axis."""
        (x1, x2), (v1, v2) = self.places[axis], self.velocities[axis]
        return HarmonicMotion(self.reduced, self.k, x2 - x1 - self.rests[axis], v2 - v1)

    def centre(self, axis: int, t: Fraction = Fraction(0)) -> tuple[Fraction, Fraction]:
        """Position and velocity of the centre of mass."""
        total = self.m1 + self.m2
        (x1, x2), (v1, v2) = self.places[axis], self.velocities[axis]
        x, v, a = (self.m1 * x1 + self.m2 * x2) / total, (self.m1 * v1 + self.m2 * v2) / total, self.pulls[axis]
        return x + t * (v + a * t / 2), v + a * t

    def _guard(self, t: Fraction) -> float:
        return 15 + decades(t * t * self.k / self.reduced) / 2

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        total = self.m1 + self.m2
        first, second = mp.mpf(self.m1 / total), mp.mpf(self.m2 / total)
        parts: list[list[Any]] = [[], [], [], []]
        for axis, rest in enumerate(self.rests):
            place, speed = self.centre(axis, t)
            stretch, rate = self.vibration(axis)._state(mp, t)
            for slot, centre, apart in ((0, place, stretch + mp.mpf(rest)), (2, speed, rate)):
                parts[slot].append(mp.mpf(centre) - second * apart)
                parts[slot + 1].append(mp.mpf(centre) + first * apart)
        return [x for part in parts for x in part]


@dataclass(frozen=True)
class RodPair(Motion):
    """Two masses on a massless rod of length l: state (x1, y1, theta, vx1, vy1, omega) of mass 1 and the rod.

    theta is the angle from the x axis to the rod, from mass 1 to mass 2.
    """

    m1: Fraction
    m2: Fraction
    length: Fraction
    g: Fraction
    x: Fraction
    y: Fraction
    theta: Fraction
    vx: Fraction
    vy: Fraction
    omega: Fraction

    def tension(self, digits: int = 15) -> Any:
        """Tension of the rod (N): the reduced mass times l omega^2."""
        force = self.m1 * self.m2 / (self.m1 + self.m2) * self.length * self.omega**2
        return self._quantity(digits, lambda mp: mp.mpf(force))

    def _guard(self, t: Fraction) -> float:
        return 15 + decades((self.omega * t) ** 2 + self.theta**2) / 2

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        """`arm` is the distance of the centre of mass from mass 1."""
        arm = mp.mpf(self.m2 / (self.m1 + self.m2) * self.length)
        angle = mp.mpf(self.theta + self.omega * t)
        c0, s0 = mp.cos_sin(mp.mpf(self.theta))
        c, s = mp.cos_sin(angle)
        time, omega = mp.mpf(t), mp.mpf(self.omega)
        x, y = (mp.mpf(p + v * t) for p, v in ((self.x, self.vx), (self.y, self.vy - self.g * t / 2)))
        turned = arm * omega
        return (
            x + arm * (c0 - c) - turned * s0 * time,
            y + arm * (s0 - s) + turned * c0 * time,
            angle,
            mp.mpf(self.vx) + turned * (s - s0),
            mp.mpf(self.vy - self.g * t) - turned * (c - c0),
            omega,
        )
