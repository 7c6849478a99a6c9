"""A pendulum under a torque impulse at a given time: two pendulum motions, one after the other.

The state at the impulse is irrational: the second motion starts from rational numbers that differ from it by less than
the working precision resolves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.precision import exact, publish, working
from gnomon.reference.pendulums.pendulum_simple import Pendulum


@dataclass(frozen=True)
class KickedPendulum(Motion):
    """State (theta, omega); at the time `blow` (s) omega jumps by `jump` (rad/s)."""

    before: Pendulum
    blow: Fraction
    jump: Fraction

    def after(self, digits: int = 60) -> Pendulum:
        """The motion after the impulse, timed from it, with the start correct to `digits`."""
        return _after(self, digits)

    def at_the_blow(self, digits: int = 15) -> tuple[Any, Any, Any]:
        """The angle at the impulse, and the rate before and after it."""
        start = self.after(digits + 20)
        with working(digits + 10) as mp:
            numbers = (start.theta0, start.omega0 - self.jump, start.omega0)
            return publish(map(mp.mpf, numbers), digits)  # type: ignore[return-value]

    def _guard(self, t: Fraction) -> float:
        return self.before._guard(t) if t < self.blow else self.after()._guard(t - self.blow) + 5

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        if t < self.blow:
            return self.before._state(mp, t)
        depth = self.after()._depth
        return self.after(int(mp.dps + 20 + 3 * depth))._state(mp, t - self.blow)


@lru_cache(maxsize=64)
def _after(motion: KickedPendulum, digits: int) -> Pendulum:
    first = motion.before
    theta, omega = map(exact, first.state(motion.blow, digits))
    return Pendulum(first.g, first.length, theta, omega + motion.jump)
