"""Vectors in space as tuples, which engines take and return; numpy is slower for three numbers."""

from collections.abc import Sequence
from math import cos, sin, sqrt

from gnomon.cases.core.scene import Quaternion, Vector
from gnomon.cases.scenes.attitude import quaternion

ORIGIN: Vector = (0.0, 0.0, 0.0)


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def along(start: Vector, direction: Vector, length: float) -> Vector:
    return (start[0] + length * direction[0], start[1] + length * direction[1], start[2] + length * direction[2])


def turn_arm(axis: Vector, arm: Vector, angle: float) -> tuple[Quaternion, Vector]:
    """The attitude after a rotation by `angle` about a unit `axis`, and the rotated arm (Rodrigues)."""
    x, y, z = along(ORIGIN, axis, sin(angle / 2))
    lever = along(along(ORIGIN, arm, cos(angle)), cross(axis, arm), sin(angle))
    return (x, y, z, cos(angle / 2)), along(lever, axis, dot(axis, arm) * (1 - cos(angle)))


def vector(values: Sequence[float]) -> Vector:
    """The first three of the values."""
    return values[0], values[1], values[2]


def times(p: Quaternion, q: Quaternion) -> Quaternion:
    """The rotation q, then p."""
    u, v = p[:3], q[:3]
    x, y, z = along(along(cross(u, v), v, p[3]), u, q[3])
    return x, y, z, p[3] * q[3] - dot(u, v)


def rotate(q: Quaternion, vector: Vector) -> Vector:
    """A vector after the rotation of a unit quaternion."""
    u = q[:3]
    twice = along(ORIGIN, cross(u, vector), 2.0)
    return along(along(vector, twice, q[3]), cross(u, twice), 1.0)


def inverse(q: Quaternion) -> Quaternion:
    """The opposite rotation of a unit quaternion."""
    return -q[0], -q[1], -q[2], q[3]


def unit(vector: Vector) -> Vector:
    """Raises ZeroDivisionError for the zero vector."""
    return along(ORIGIN, vector, 1 / sqrt(dot(vector, vector)))


def upright_to(x: Vector, z: Vector) -> Quaternion:
    """The attitude whose first axis is x and whose third is z, two unit vectors at a right angle."""
    y = cross(z, x)
    return quaternion((x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]))
