"""Two hinged rods, struck while they are at rest (Beatty, Dynamics, 11.10.5), in balls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gnomon.reference.numerics.vectors import square


def rates(
    masses: Sequence[Any], lengths: Sequence[Any], angles: Sequence[Any], impulse: Any, at: Any
) -> tuple[Any, Any]:
    """Rates of both rods after a horizontal impulse at distance `at` from the joint along the second: M(q) q' = Q.

    Uniform rods; angles from the downward vertical; the first hangs from a fixed point.
    """
    (m1, m2), (l1, l2), (th1, th2) = masses, lengths, angles
    a, b, d = (m1 / 3 + m2) * l1 * l1, m2 * l1 * l2 * (th1 - th2).cos() / 2, m2 * l2 * l2 / 3
    q1, q2 = impulse * l1 * th1.cos(), impulse * at * th2.cos()
    # a d - b^2 without cancellation where the rods are in line and m1 is small.
    determinant = l1 * l1 * l2 * l2 * m2 * (m1 / 9 + m2 / 12 + m2 * square((th1 - th2).sin()) / 4)
    return (d * q1 - b * q2) / determinant, (a * q2 - b * q1) / determinant
