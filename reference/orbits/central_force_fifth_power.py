"""Attraction by k/r^5: whether the point falls into the centre, and when."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.precision import quantity


def collision_time(k: Fraction, state: Sequence[Fraction], digits: int = 15) -> Any | None:
    """The time (s) at which a point that starts in `state` (x, y, vx, vy; m, m/s) reaches the centre; None if it never does.

    With h the angular momentum, E the energy per unit mass and s = 1/r^2, (ds/dt)^2 = 2 k s^3 ((s - m)^2 - d) where
    m = h^2/k and d = m^2 - 4 E/k: the point turns round where s = m +- sqrt(d), and the time from s to the centre, without a
    turn, is (2/3) R_D(s - m - sqrt(d), s - m + sqrt(d), s)/sqrt(2 k), Carlson's integral (DLMF 19.16.5).
    """
    x, y, vx, vy = state
    start, outward = 1 / (x * x + y * y), x * vx + y * vy >= 0
    m = (x * vy - y * vx) ** 2 / k
    d = m * m - 2 * (vx * vx + vy * vy) / k + start * start
    # With turning points, a start at s <= m is beyond both; without two of them an outward motion never returns.
    if (d >= 0 and start <= m) or (d <= 0 and outward):
        return None

    def formula() -> Sequence[Any]:
        root = flint.acb(ball(d)).sqrt()
        far = ball(start - m) + root
        near = ball((start - m) ** 2 - d) / far  # start - m - root without cancellation
        time = flint.acb.elliptic_rd(near, far, ball(start)).real
        if outward:
            time = 2 * flint.acb.elliptic_rd(0, 2 * root, ball(m) + root).real - time
        return (2 * time / (3 * ball(2 * k).sqrt()),)

    return quantity(digits, lambda mp: refined(mp, formula)[0])
