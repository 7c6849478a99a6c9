"""Vectors in space as tuples, which engines take and return; numpy is slower for three numbers."""

from collections.abc import Sequence
from math import cos, sin

from gnomon.cases.core.scene import Quaternion, Vector

ORIGIN: Vector = (0.0, 0.0, 0.0)


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def along(start: Vector, direction: Vector, length: float) -> Vector:
    return (start[0] + length * direction[0], start[1] + length * direction[1], start[2] + length * direction[2])


def turned(axis: Vector, arm: Vector, angle: float) -> tuple[Quaternion, Vector]:
    """The attitude after a rotation by `angle` about a unit `axis`, and the rotated arm (Rodrigues)."""
    x, y, z = along(ORIGIN, axis, sin(angle / 2))
    lever = along(along(ORIGIN, arm, cos(angle)), cross(axis, arm), sin(angle))
    return (x, y, z, cos(angle / 2)), along(lever, axis, dot(axis, arm) * (1 - cos(angle)))


def vector(values: Sequence[float]) -> Vector:
    """The first three of the values."""
    return values[0], values[1], values[2]


def rotated(q: Quaternion, arm: Vector) -> Vector:
    """The arm after the rotation by a unit quaternion."""
    axis = vector(q)
    twice = along(ORIGIN, cross(axis, arm), 2.0)
    return along(along(arm, twice, q[3]), cross(axis, twice), 1.0)
