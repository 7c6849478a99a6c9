"""Attitudes as quaternions (x, y, z, w), body -> space."""

from math import hypot

from gnomon.cases.core.scene import Quaternion, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot


def scalar_first(attitude: Quaternion) -> tuple[float, float, float, float]:
    x, y, z, w = attitude
    return w, x, y, z


def upward_to(position: Vector) -> Quaternion:
    """An attitude that turns the third axis into the direction of a position."""
    x, y, z = position
    level, size = hypot(x, y), hypot(x, y, z)
    if not level:
        return (0.0, 0.0, 0.0, 1.0) if z > 0 else (1.0, 0.0, 0.0, 0.0)
    half = ((1 - z / size) / 2) ** 0.5 if z < 0 else level / size / (2 * (1 + z / size)) ** 0.5
    return -y / level * half, x / level * half, 0.0, (1 - half * half) ** 0.5 if z > 0 else level / size / (2 * half)


def frame_along(first: Vector, *others: Vector) -> tuple[Vector, Vector, Vector]:
    """The axes of a frame: this unit vector, one in its plane with the first of the others that is not parallel, the normal."""
    across = next(normal for each in others if dot(normal := cross(first, each), normal))
    third = along(ORIGIN, across, dot(across, across) ** -0.5)
    return first, cross(third, first), third
