"""Free fall inside a rotating planet of uniform density.

In the inertial frame it is the isotropic oscillator of frequency w = sqrt(g/R): an ellipse about the centre. Seen from
the planet the ellipse rotates at -Om (Larmor's theorem): r'' = -(g/R) r - 2 Om x r' + Om^2 r in the equatorial plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

import flint
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.linear import LinearMotion, Row
from gnomon.reference.numerics.pointwise import Cycle, Turn


@dataclass(frozen=True)
class TurningPlanet(LinearMotion):
    """State (x, y, vx, vy) in the frame of the planet, from its centre."""

    g: Fraction
    R: Fraction
    Om: Fraction
    x: Fraction
    y: Fraction
    vx: Fraction
    vy: Fraction

    dimension: ClassVar[int] = 4

    def _system(self) -> tuple[Sequence[Row], Row]:
        pull, twice = self.Om**2 - self.g / self.R, 2 * self.Om
        rows = ((0, 0, 1, 0), (0, 0, 0, 1), (pull, 0, 0, twice), (0, pull, -twice, 0))
        return rows, (self.x, self.y, self.vx, self.vy)

    def _cycle(self, mp: Any) -> Cycle:
        """Each revolution on the ellipse is the previous one, rotated."""

        def numbers() -> list[Any]:
            period = self._period()
            sine, cosine = (ball(self.Om) * period).sin_cos()
            return [period, sine, cosine]

        period, sine, cosine = refined(mp, numbers)
        return Cycle(period, (mp.zero,) * 4, [Turn([[cosine, sine], [-sine, cosine]], [[0, 1], [2, 3]])])

    def _period(self) -> Any:
        return 2 * flint.arb.pi() / ball(self.g / self.R).sqrt()

    def period(self, digits: int = 15) -> Any:
        """2 pi sqrt(R/g), as for every tunnel."""
        return self._derived(digits, self._period)

    @property
    def _sums(self) -> tuple[Fraction, Fraction]:
        """Sum and product of the squares of the half axes of the ellipse."""
        vx, vy = self.vx - self.Om * self.y, self.vy + self.Om * self.x
        square = self.R / self.g
        return (
            self.x**2 + self.y**2 + (vx**2 + vy**2) * square,
            (self.x * vy - self.y * vx) ** 2 * square,
        )

    @property
    def inside(self) -> bool:
        """Whether it stays inside the planet: the larger half axis is at most R, decided in rational numbers."""
        total, product = self._sums
        square = self.R**2
        return total <= 2 * square and square**2 - total * square + product >= 0

    def half_axes(self, digits: int = 15) -> tuple[Any, Any]:
        """Largest and smallest distance from the centre."""
        total, product = self._sums

        def larger() -> Any:
            return ((ball(total) + ball(total**2 - 4 * product).sqrt()) / 2).sqrt()

        if total == 0:
            return self._rational(digits, total), self._rational(digits, total)
        smaller = self._derived(digits, lambda: ball(product).sqrt() / larger())
        return self._derived(digits, larger), smaller
