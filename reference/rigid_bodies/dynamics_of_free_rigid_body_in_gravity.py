"""A rigid body thrown in uniform gravity: its centre moves on a parabola, its rotation is torque-free."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.rigid_bodies.euler_top import EulerTop

Vector = tuple[Fraction, Fraction, Fraction]


@dataclass(frozen=True)
class FreeBody(Motion):
    """State (x, y, z, vx, vy, vz, w1, w2, w3, R11..R33), z up."""

    g: Fraction
    position: Vector
    velocity: Vector
    body: EulerTop

    def _guard(self, t: Fraction) -> float:
        return self.body._guard(t)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        x, y, z = (p + v * t for p, v in zip(self.position, self.velocity, strict=True))
        vx, vy, vz = self.velocity
        centre = (x, y, z - self.g * t * t / 2, vx, vy, vz - self.g * t)
        return [*map(mp.mpf, centre), *self.body._state(mp, t)]
