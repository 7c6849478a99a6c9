"""A block on an incline with Coulomb friction: it stops, and then stays or slides back.

Friction is mu_k g cos(alpha) against the motion; a block at rest stays where tan(alpha) <= mu_s. Each phase has constant
acceleration.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.precision import working


@lru_cache(maxsize=1024)
def holds(alpha: Fraction, mu_s: Fraction) -> bool:
    """Whether tan(alpha) <= mu_s, for 0 <= alpha < pi/2, decided exactly.

    The tangent of a rational number other than zero is irrational (Lambert 1761), so equality needs alpha = 0,
    and otherwise enough digits decide.
    """
    if alpha == 0:
        return mu_s >= 0
    digits = 40
    while True:
        with working(digits) as mp:
            excess = mp.tan(mp.mpf(alpha)) - mp.mpf(mu_s)
            if abs(excess) > mp.mpf(10) ** (10 - digits) * (1 + mp.mpf(mu_s)):
                return bool(excess < 0)
        digits *= 2


@dataclass(frozen=True)
class BlockIncline(Motion):
    """State (s, v), s up the slope: s'' = -g (sin(alpha) + mu_k sign(v) cos(alpha)); alpha < pi/2, mu_k <= mu_s."""

    g: Fraction
    alpha: Fraction
    mu_k: Fraction
    mu_s: Fraction
    s0: Fraction
    v0: Fraction

    @property
    def holds(self) -> bool:
        """Whether the block, once at rest, stays there."""
        return holds(self.alpha, self.mu_s)

    @property
    def stops(self) -> bool:
        """Whether a moving block stops: upward unless nothing slows it, downward if friction exceeds gravity."""
        if self.v0 == 0 or (self.alpha == 0 and self.mu_k == 0):
            return False
        return self.v0 > 0 or holds(self.alpha, self.mu_k)

    @property
    def slides_back(self) -> bool:
        """Whether the block slides down from rest, at the start or after its stop."""
        return not self.holds and (self.v0 == 0 or self.stops)

    def stop_time(self, digits: int = 15) -> Any:
        """Time at which the block comes to rest (s); infinite if it does not."""
        return self._quantity(digits, self._stop_time)

    def stop_distance(self, digits: int = 15) -> Any:
        """The distance covered until the block comes to rest."""
        return self._quantity(digits, lambda mp: abs(mp.mpf(self.v0)) * self._stop_time(mp) / 2)

    def stop_position(self, digits: int = 15) -> Any:
        """Where the block comes to rest."""
        return self._quantity(digits, self._stop_position, 20)

    def return_time(self, digits: int = 15) -> Any:
        """Time at which a block thrown upward slides back through its start (s); infinite if it does not."""
        return self._quantity(digits, self._return_time)

    def return_speed(self, digits: int = 15) -> Any:
        """The speed at the return, v0 sqrt((tan(alpha) - mu_k)/(tan(alpha) + mu_k))."""
        return self._quantity(
            digits,
            lambda mp: mp.mpf(self.v0) * mp.sqrt(self._sliding(mp) / self._rising(mp)) if self._returns else mp.nan,
        )

    def friction_work(self, digits: int = 15) -> Any:
        """Work of friction until the stop, per unit mass: -mu_k g cos(alpha) times the distance."""

        def work(mp: Any) -> Any:
            force = mp.mpf(self.mu_k) * mp.mpf(self.g) * mp.cos(mp.mpf(self.alpha))
            return -force * abs(mp.mpf(self.v0)) * self._stop_time(mp) / 2

        return self._quantity(digits, work)

    def friction_angle(self, digits: int = 15) -> Any:
        """atan(mu_s): the steepest slope on which the block stays."""
        return self._quantity(digits, lambda mp: mp.atan(mp.mpf(self.mu_s)))

    @property
    def _returns(self) -> bool:
        return self.v0 > 0 and self.slides_back

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        time, s0, v0 = mp.mpf(t), mp.mpf(self.s0), mp.mpf(self.v0)
        stop = mp.mpf(0) if self.v0 == 0 else self._stop_time(mp)
        if time < stop:
            rate = -self._rising(mp) if self.v0 > 0 else -self._sliding(mp)
            return s0 + time * (v0 + rate * time / 2), v0 + rate * time
        rest = s0 + v0 * stop / 2
        if self.holds:
            return rest, mp.mpf(0)
        since = time - stop
        return rest - self._sliding(mp) * since**2 / 2, -self._sliding(mp) * since

    def _rising(self, mp: Any) -> Any:
        """Deceleration while rising."""
        alpha = mp.mpf(self.alpha)
        return mp.mpf(self.g) * (mp.sin(alpha) + mp.mpf(self.mu_k) * mp.cos(alpha))

    def _sliding(self, mp: Any) -> Any:
        """Downward acceleration while sliding down, a difference that may cancel; negative if friction is larger."""

        def excess() -> Any:
            alpha = mp.mpf(self.alpha)
            return mp.sin(alpha) - mp.mpf(self.mu_k) * mp.cos(alpha)

        return mp.mpf(self.g) * _without_cancellation(mp, excess) if self.alpha or self.mu_k else mp.mpf(0)

    def _stop_time(self, mp: Any) -> Any:
        if not self.stops:
            return mp.inf if self.v0 or not self.holds else mp.mpf(0)
        return mp.mpf(self.v0) / (self._rising(mp) if self.v0 > 0 else self._sliding(mp))

    def _stop_position(self, mp: Any) -> Any:
        return mp.mpf(self.s0) + mp.mpf(self.v0) * self._stop_time(mp) / 2

    def _return_time(self, mp: Any) -> Any:
        if not self._returns:
            return mp.inf
        stop = self._stop_time(mp)
        return stop + stop * mp.sqrt(self._rising(mp) / self._sliding(mp))


def _without_cancellation(mp: Any, formula: Callable[[], Any]) -> Any:
    """A nonzero difference of terms of size about 1, to the relative precision of the context."""
    wanted, digits = mp.dps, mp.dps + 10
    while True:
        with mp.workdps(digits):
            value = formula()
            if abs(value) > mp.mpf(10) ** (wanted - digits + 3):
                return value
        digits *= 2
