"""Foucault's pendulum for small amplitudes with the centrifugal terms of the horizontal plane.

x'' = 2 W y' - (g/L - Om^2) x, y'' = -2 W x' - (g/L - W^2) y, W = Om sin(lat): no longer isotropic off the pole.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.linear import LinearMotion, Row


@dataclass(frozen=True)
class FoucaultCentrifugal(LinearMotion):
    """State (x, y, x', y'), east and north."""

    g: Fraction
    L: Fraction
    Om: Fraction
    lat: Fraction
    start: tuple[Fraction, ...]

    dimension = 4

    def _system(self) -> tuple[Sequence[Row], Row]:
        turn = ball(self.Om) * ball(self.lat).sin()
        east = self.Om**2 - self.g / self.L
        north = turn * turn - ball(self.g / self.L)
        rows: list[list[Any]] = [[0, 0, 1, 0], [0, 0, 0, 1], [east, 0, 0, 2 * turn], [0, north, -2 * turn, 0]]
        return rows, self.start

    def _rate(self) -> float:
        return math.sqrt(self.g / self.L)
