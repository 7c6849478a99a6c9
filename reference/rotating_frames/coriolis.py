"""Projectile on a rotating planet, centrifugal acceleration included in g: exact and to first order in Om, in balls.

Beatty, Dynamics, 6.16 and 6.18; axes x east, y north, z up.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gnomon.reference.numerics.vectors import add, cross, dot, scale, subtract

Vector = Sequence[Any]


def first_order(turning: Vector, gravity: Vector, velocity: Vector, t: Any) -> Vector:
    """Displacement by the Coriolis acceleration to first order in Om: -Om x (v t^2 + g t^3/3)."""
    return scale(-1, cross(turning, add(scale(t * t, velocity), scale(t * t * t / 3, gravity))))


def displacement(turning: Vector, gravity: Vector, velocity: Vector, t: Any) -> Vector:
    """r(t) - r(0) of r'' = g - 2 Om x r'; Om is not zero."""
    rate = dot(turning, turning).sqrt()
    n = scale(1 / rate, turning)
    w = 2 * rate
    drift = scale(1 / w, cross(gravity, n))
    fall, along = dot(gravity, n), dot(velocity, n)
    across = subtract(subtract(velocity, scale(along, n)), drift)
    return add(
        scale(t, drift),
        scale(along * t + fall * t * t / 2, n),
        scale((w * t).sin() / w, across),
        scale((1 - (w * t).cos()) / w, cross(across, n)),
    )
