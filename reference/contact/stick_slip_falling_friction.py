"""A block on a moving belt, held by a spring, whose kinetic friction falls in proportion to the speed of sliding.

While it slips, m v' = m g (mu_k - slope (V - v)) - k x: a linear oscillator of negative damping, in closed form about
xk = (mu_k - slope V) m g/k. A slip ends when v = V again. The peaks of v are in closed form too, and each is higher than
the one before by the factor exp(2 pi d/W), so that the turn on which v reaches V is known; on it v grows from a trough to
the peak, and the interval Newton method proves the only root.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
from gnomon.reference.contact.stick_slip_belt import StickSlip
from gnomon.reference.numerics.balls import ball, floor_of, sign

UNKNOWN = flint.arb("nan")
"""A root of which the precision gives nothing."""


@dataclass(frozen=True)
class FallingStickSlip(StickSlip):
    """State (x, v), v0 <= V; slope > 0, (slope g)^2 < 4 k/m; not at rest at xk, where a block slides for ever."""

    slope: Fraction

    @property
    def xk(self) -> Fraction:
        """The centre of the slip."""
        return (self.mu_k - self.slope * self.V) * self.mass * self.g / self.stiffness

    @property
    def slips_for_good(self) -> bool:
        return False

    @property
    def repeats(self) -> bool:
        """Every swing grows until it reaches the speed of the belt."""
        return True

    @property
    def turns(self) -> int:
        """Peaks of the speed that the initial slip has before the one on which it ends; 0 if the block sticks first."""
        return 0 if self.stuck_first or self.loose_first else self._missed(*self._first)

    @property
    def course(self) -> tuple[Any, ...]:
        return self.stuck_first, self.turns

    def slides_at_most(self, digits: int = 15) -> Any:
        """The largest speed of sliding after the first release (m/s)."""
        return self._derived(digits, lambda: ball(self.V) - self._slowest(*self._loose))

    def keeps_its_law(self) -> bool:
        """Whether friction stays positive through all slips, and the belt can hold the block where they end."""
        starts = [self._loose] if self.stuck_first or self.loose_first else [self._first, self._loose]
        least, reach = ball(self.V - self.mu_k / self.slope), ball(-self.xs)
        return all(
            sign(lambda start=start: self._slowest(*start) - least) > 0  # type: ignore[misc]
            and sign(lambda start=start: self._place(*start) - reach) > 0  # type: ignore[misc]
            for start in starts
        )

    @property
    def _growth(self) -> Fraction:
        return self.slope * self.g / 2

    def _rate(self) -> Any:
        """W = sqrt(k/m - d^2)."""
        return ball(self.stiffness / self.mass - self._growth**2).sqrt()

    def _swing(self, distance: Fraction, speed: Fraction, time: Any) -> tuple[Any, Any]:
        rate, growth = self._rate(), self._growth
        sine, cosine = (rate * time).sin_cos()
        grown = (ball(growth) * time).exp()
        along, across = ball(speed - growth * distance) / rate, ball(self._bend(distance, speed)) / rate
        place = grown * (ball(distance) * cosine + along * sine)
        return ball(self.xk) + place, grown * (ball(speed) * cosine + across * sine)

    def _bend(self, distance: Fraction, speed: Fraction) -> Fraction:
        return self._growth * speed - self.stiffness / self.mass * distance

    def _push(self, distance: Fraction, speed: Fraction) -> tuple[Fraction, Fraction]:
        """a and b of the acceleration exp(d t) (a cos W t + b/W sin W t)."""
        start = 2 * self._growth * speed - self.stiffness / self.mass * distance
        return start, self._growth * start - self.stiffness / self.mass * speed

    def _peak(self, distance: Fraction, speed: Fraction) -> Any:
        """W t of the first peak of the speed after the start."""
        a, b = self._push(distance, speed)
        if a == 0:
            return (2 if b < 0 else 1) * flint.arb.pi()
        phase = flint.arb.atan2(ball(b) / self._rate(), ball(a)) + flint.arb.pi() / 2
        return phase + 2 * flint.arb.pi() if a < 0 and b < 0 else phase

    def _missed(self, distance: Fraction, speed: Fraction) -> int:
        """The number of peaks that stay below V; none after a start at V, which is past a peak of V or more."""
        if speed == self.V:
            return 0

        def turns() -> Any:
            rate = self._rate()
            first = self._swing(distance, speed, self._peak(distance, speed) / rate)[1]
            return (ball(self.V) / first).log() * rate / (2 * flint.arb.pi() * ball(self._growth))

        return max(0, floor_of(turns) + 1)

    def _slowest(self, distance: Fraction, speed: Fraction) -> Any:
        """The least velocity of a slip: half a turn before its last peak, or at its start."""
        peak, missed = self._peak(distance, speed), self._missed(distance, speed)
        trough = peak + (2 * missed - 1) * flint.arb.pi()
        if missed == 0 and not trough > 0:
            return ball(speed)
        return self._swing(distance, speed, trough / self._rate())[1]

    def _slip(self, distance: Fraction, speed: Fraction) -> Any:
        return _slip(self, distance, speed, flint.ctx.prec)

    def _place(self, distance: Fraction, speed: Fraction) -> Any:
        return self._swing(distance, speed, self._slip(distance, speed))[0]

    def _ends(self, distance: Fraction, speed: Fraction) -> Any:
        """The time at which v grows through V, between a trough and the peak after it."""
        rate, pi = self._rate(), flint.arb.pi()
        peak = self._peak(distance, speed) + 2 * pi * self._missed(distance, speed)
        trough = peak - pi
        inside = ((trough if trough > 0 else flint.arb(0)) / rate).union(peak / rate)
        a, b = map(ball, self._push(distance, speed))
        while True:
            sine, cosine = (rate * inside).sin_cos()
            push = (ball(self._growth) * inside).exp() * (a * cosine + b / rate * sine)
            middle = inside.mid()
            gap = self._swing(distance, speed, middle)[1] - ball(self.V)
            if push > 0:
                closer = (middle - gap / push).intersection(inside)
            elif gap > 0:
                closer = inside.lower().union(middle)
            elif gap < 0:
                closer = middle.union(inside.upper())
            else:
                return UNKNOWN
            if not closer.rad() < inside.rad() * 0.9:
                return closer if push > 0 else UNKNOWN
            inside = closer


@lru_cache(maxsize=256)
def _slip(motion: FallingStickSlip, distance: Fraction, speed: Fraction, bits: int) -> Any:
    """Cached, because every sample needs it; `bits` is the current precision."""
    return motion._ends(distance, speed)
