"""Systems that are simple pendulums with irrational parameters: theta'' = -W^2 sin(theta + shift).

W^2 and the shift are replaced by rational numbers that differ from them by less than the working precision resolves.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.numerics.precision import exact, working
from gnomon.reference.pendulums.pendulum_simple import Pendulum


@dataclass(frozen=True)
class EquivalentPendulum(Motion):
    """State (theta, omega). A subclass states W^2 and the shift."""

    theta0: Fraction
    omega0: Fraction

    @abstractmethod
    def _pull(self, mp: Any) -> Any:
        """W^2 > 0."""

    def _shift(self, mp: Any) -> Any:
        return mp.zero

    def pendulum(self, digits: int = 60) -> Pendulum:
        """The simple pendulum with the angle theta + shift; W^2 and the shift are correct to `digits`."""
        return _pendulum(self, digits)[0]

    def frequency(self, digits: int = 15) -> Any:
        """W, the angular frequency of small swings."""
        return self._quantity(digits, lambda mp: mp.sqrt(self._pull(mp)))

    def rest_angle(self, digits: int = 15) -> Any:
        """The stable equilibrium nearest to zero."""
        return self._quantity(digits, lambda mp: -self._shift(mp))

    def _near(self, mp: Any) -> tuple[Pendulum, Any]:
        """The pendulum with enough digits for the precision of `mp`, and the shift."""
        depth = self.pendulum()._depth
        pendulum, shift = _pendulum(self, int(mp.dps + 20 + 3 * depth))
        return pendulum, mp.mpf(shift)

    def _guard(self, t: Fraction) -> float:
        return self.pendulum()._guard(t) + 5

    def _cycle(self, mp: Any) -> Cycle | None:
        return self._near(mp)[0]._cycle(mp)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        pendulum, shift = self._near(mp)
        theta, omega = pendulum._state(mp, t)
        return theta - shift, omega


@lru_cache(maxsize=64)
def _pendulum(motion: EquivalentPendulum, digits: int) -> tuple[Pendulum, Fraction]:
    with working(digits + 10) as mp:
        shift = exact(motion._shift(mp))
        pull = exact(motion._pull(mp))
    return Pendulum(pull, Fraction(1), motion.theta0 + shift, motion.omega0), shift
