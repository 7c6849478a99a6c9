"""Three-vectors and matrices as plain tuples, for numbers of any kind: floats, balls, mpmath."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

Vector = Sequence[Any]
Matrix = Sequence[Sequence[Any]]
AXES = ("x", "y", "z")
PLANES = ("xx", "yy", "zz", "xy", "xz", "yz")


def components(p: Any, prefix: str, names: Sequence[str] = AXES) -> tuple[Any, ...]:
    """The attributes of p that are called prefix + name."""
    return tuple(getattr(p, prefix + name) for name in names)


def named(quantity: str, values: Sequence[Any], names: Sequence[str] = AXES) -> dict[str, Any]:
    """Components under the names quantity.x, quantity.y, ..."""
    return {f"{quantity}.{name}": value for name, value in zip(names, values, strict=True)}


def add(*vectors: Vector) -> tuple[Any, ...]:
    return tuple(sum(parts[1:], parts[0]) for parts in zip(*vectors, strict=True))


def subtract(a: Vector, b: Vector) -> tuple[Any, ...]:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def scale(factor: Any, a: Vector) -> tuple[Any, ...]:
    return tuple(factor * x for x in a)


def square(x: Any) -> Any:
    """x * x: the power `**` of a ball that holds 0 is NaN."""
    return x * x


def dot(a: Vector, b: Vector) -> Any:
    products = [x * y for x, y in zip(a, b, strict=True)]
    return sum(products[1:], products[0])


def cross(a: Vector, b: Vector) -> tuple[Any, ...]:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def apply(matrix: Matrix, a: Vector) -> tuple[Any, ...]:
    return tuple(dot(row, a) for row in matrix)


def multiply(a: Matrix, b: Matrix) -> tuple[tuple[Any, ...], ...]:
    columns = tuple(zip(*b, strict=True))
    return tuple(tuple(dot(row, column) for column in columns) for row in a)


def transpose(a: Matrix) -> tuple[tuple[Any, ...], ...]:
    return tuple(zip(*a, strict=True))


def symmetric(entries: Sequence[Any]) -> tuple[tuple[Any, ...], ...]:
    """The symmetric matrix with entries xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = entries
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def entries(matrix: Matrix) -> tuple[Any, ...]:
    """xx, yy, zz, xy, xz, yz of a symmetric matrix."""
    return (matrix[0][0], matrix[1][1], matrix[2][2], matrix[0][1], matrix[0][2], matrix[1][2])


def turn_x(cosine: Any, sine: Any) -> tuple[tuple[Any, ...], ...]:
    zero = cosine * 0
    return ((zero + 1, zero, zero), (zero, cosine, -sine), (zero, sine, cosine))


def turn_z(cosine: Any, sine: Any) -> tuple[tuple[Any, ...], ...]:
    zero = cosine * 0
    return ((cosine, -sine, zero), (sine, cosine, zero), (zero, zero, zero + 1))
