"""A rigid body that falls and rotates in a Stokes medium.

The drag of every element, -nu v per unit mass, gives a force at the centre of mass and a torque -nu H about it:
translation and rotation are independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.flight.projectile_stokes_drag import StokesDrag
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.rigid_bodies.rigid_body_stokes_medium import StokesBody


@dataclass(frozen=True)
class FallingStokesBody(Motion):
    """State (x, y, z, vx, vy, vz, w1, w2, w3, R11..R33)."""

    centre: StokesDrag
    body: StokesBody

    def _guard(self, t: Fraction) -> float:
        return self.body._guard(t) + self.centre._guard(t)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        return [*self.centre._state(mp, t), *self.body._state(mp, t)]
