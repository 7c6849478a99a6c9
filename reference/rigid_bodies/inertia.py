"""Inertia of special bodies about their principal axes, and the parallel-axis theorem (Beatty, Dynamics, 9, App. D).

Arguments are numbers of any type: balls, mpmath, floats. Density is uniform; the axis of a body of revolution is z;
moments are about the centre of mass unless the docstring says otherwise.
"""

from __future__ import annotations

from typing import Any

from gnomon.reference.numerics.vectors import Matrix, Vector, dot

Moments = tuple[Any, Any, Any]


def box(m: Any, a: Any, b: Any, c: Any) -> Moments:
    """Edges a, b, c along x, y, z."""
    return m * (b * b + c * c) / 12, m * (a * a + c * c) / 12, m * (a * a + b * b) / 12


def ellipsoid(m: Any, a: Any, b: Any, c: Any) -> Moments:
    """Semi-axes a, b, c; a = b = c is the sphere."""
    return m * (b * b + c * c) / 5, m * (a * a + c * c) / 5, m * (a * a + b * b) / 5


def spherical_shell(m: Any, r: Any) -> Moments:
    every = 2 * m * r * r / 3
    return every, every, every


def hemisphere(m: Any, r: Any) -> Moments:
    """About its own centre of mass, 3r/8 from the base."""
    transverse = 83 * m * r * r / 320
    return transverse, transverse, 2 * m * r * r / 5


def cylinder(m: Any, r: Any, h: Any) -> Moments:
    transverse = m * (3 * r * r + h * h) / 12
    return transverse, transverse, m * r * r / 2


def tube(m: Any, r: Any, inner: Any, h: Any) -> Moments:
    """A hollow cylinder, radii r and inner."""
    squares = r * r + inner * inner
    transverse = m * (3 * squares + h * h) / 12
    return transverse, transverse, m * squares / 2


def cone(m: Any, r: Any, h: Any) -> Moments:
    transverse = 3 * m * (4 * r * r + h * h) / 80
    return transverse, transverse, 3 * m * r * r / 10


def cone_apex(m: Any, r: Any, h: Any) -> Moments:
    """The cone about its apex."""
    transverse = 3 * m * (r * r + 4 * h * h) / 20
    return transverse, transverse, 3 * m * r * r / 10


def torus(m: Any, R: Any, r: Any) -> Moments:
    """A tube of radius r whose middle is a circle of radius R."""
    transverse = m * (4 * R * R + 5 * r * r) / 8
    return transverse, transverse, m * (4 * R * R + 3 * r * r) / 4


def ring(m: Any, r: Any) -> Moments:
    """A thin ring."""
    return m * r * r / 2, m * r * r / 2, m * r * r


def lamina(m: Any, a: Any, b: Any) -> Moments:
    """A thin rectangle: perpendicular axes, I_z = I_x + I_y."""
    return m * b * b / 12, m * a * a / 12, m * (a * a + b * b) / 12


def transferred(tensor: Matrix, m: Any, offset: Vector) -> Matrix:
    """The tensor about a point at -offset from the centre of mass: I + m (r.r 1 - r r)."""
    square = dot(offset, offset)
    return [
        [tensor[i][j] + m * ((square if i == j else 0) - offset[i] * offset[j]) for j in range(3)] for i in range(3)
    ]
