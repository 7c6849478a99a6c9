"""Principal moments of an inertia tensor (Beatty, Dynamics, 9.8-9.10).

The trigonometric solution of the cubic, q + 2 p cos(acos(r)/3 + 2 pi k/3), in balls; multiplicity is decided on the
exact rational discriminant, because a ball of acos at +-1 cannot show that roots coincide.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball

Entries = tuple[Fraction, Fraction, Fraction, Fraction, Fraction, Fraction]
"""xx, yy, zz, xy, xz, yz."""


def determinant(entries: Entries) -> Fraction:
    xx, yy, zz, xy, xz, yz = entries
    return xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)


def deviator(entries: Entries) -> tuple[Fraction, Fraction, Fraction]:
    """q = tr/3, p^2 = |I - q 1|^2 / 6, det(I - q 1)/2."""
    xx, yy, zz, xy, xz, yz = entries
    q = (xx + yy + zz) / 3
    squares = ((xx - q) ** 2 + (yy - q) ** 2 + (zz - q) ** 2 + 2 * (xy * xy + xz * xz + yz * yz)) / 6
    return q, squares, determinant((xx - q, yy - q, zz - q, xy, xz, yz)) / 2


def multiplicity(entries: Entries) -> int:
    """How many of the principal moments coincide: 1 (none), 2 or 3."""
    _q, p2, half = deviator(entries)
    if p2 == 0:
        return 3
    return 2 if half * half == p2**3 else 1


def principal_moments(entries: Entries) -> tuple[Any, Any, Any]:
    """The three moments, ascending, in balls at the current precision."""
    q, p2, half = deviator(entries)
    several = multiplicity(entries)
    if several == 3:
        return ball(q), ball(q), ball(q)
    if several == 2:
        # p is rational here: p = half / p2 up to its sign, which determines the double moment.
        p = half / p2
        double, single = ball(q - p), ball(q + 2 * p)
        return (double, double, single) if p > 0 else (single, double, double)
    p = ball(p2).sqrt()
    angle = (ball(half) / (p * p * p)).acos() / 3
    third = 2 * flint.arb.pi() / 3
    largest, least, middle = (ball(q) + 2 * p * (angle + k * third).cos() for k in range(3))
    return least, middle, largest


def is_inertia(entries: Entries) -> bool:
    """Whether a body can have this tensor: tr/2 1 - I, the tensor of second moments, is positive semidefinite.

    That is the triangle inequality of the principal moments, I1 + I2 >= I3.
    """
    xx, yy, zz, xy, xz, yz = entries
    half = (xx + yy + zz) / 2
    a, b, c = half - xx, half - yy, half - zz
    return (
        min(a, b, c) >= 0
        and a * b >= xy * xy
        and a * c >= xz * xz
        and b * c >= yz * yz
        and determinant((a, b, c, -xy, -xz, -yz)) >= 0
    )
