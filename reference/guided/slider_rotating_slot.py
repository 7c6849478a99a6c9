"""A slider on a spring in a radial slot of a uniformly rotating table, with wall friction.

The wall presses with the Coriolis force, so that friction is mu |2 m Om r'|: linear damping for either sign of r'.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

from gnomon.reference.numerics.linear import LinearMotion, Row


@dataclass(frozen=True)
class Slot(LinearMotion):
    """r'' = (Om^2 - k/m) r + (k/m) r0 - 2 mu |Om| r': state (r, v)."""

    mass: Fraction
    stiffness: Fraction
    natural: Fraction
    rate: Fraction
    friction: Fraction
    start: Fraction
    v0: Fraction

    dimension: ClassVar[int] = 2  # type: ignore[misc]

    @property
    def pull(self) -> Fraction:
        """Om^2 - k/m, positive above the critical speed."""
        return self.rate**2 - self.stiffness / self.mass

    @property
    def damping(self) -> Fraction:
        """2 mu |Om|."""
        return 2 * self.friction * abs(self.rate)

    @property
    def wall_force(self) -> Fraction:
        """The force of the wall at the start, 2 m Om v (N)."""
        return 2 * self.mass * self.rate * self.v0

    def balance(self, digits: int = 15) -> Any | None:
        """Equilibrium radius; None at the critical speed."""
        if self.pull == 0:
            return None
        return self._quantity(digits, lambda mp: mp.mpf(-self.stiffness / self.mass * self.natural / self.pull))

    def rates(self, digits: int = 15) -> tuple[Any, Any]:
        """Real parts of the two rates of r - balance, the larger first."""
        square = self.damping**2 / 4 + self.pull

        def rate(mp: Any, side: int) -> Any:
            root = mp.sqrt(mp.mpf(square)) if square > 0 else mp.zero
            if side > 0 and self.pull > 0:
                return mp.mpf(self.pull) / (mp.mpf(self.damping) / 2 + root)
            return side * root - mp.mpf(self.damping) / 2

        return self._quantity(digits, lambda mp: rate(mp, 1), 20), self._quantity(digits, lambda mp: rate(mp, -1), 20)

    def _system(self) -> tuple[Sequence[Row], Row]:
        pull = self.stiffness / self.mass * self.natural
        return ((0, 1, 0), (self.pull, -self.damping, pull), (0, 0, 0)), (self.start, self.v0, 1)
