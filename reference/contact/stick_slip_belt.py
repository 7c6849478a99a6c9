"""A block on a moving belt, held by a spring: it sticks, is released, slips and sticks again.

With xs = mu_s m g/k, xk = mu_k m g/k: a sticking block moves at V up to xs; a slipping block swings about xk,
x = xk - R cos psi and v = w R sin psi, psi growing at w, until v = V again. After the first release the motion is
periodic, with slips of (2/w) (pi - atan(w (xs - xk)/V)) and sticks of 2 (xs - xk)/V.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, floor_of, sign
from gnomon.reference.numerics.motion import BallMotion


@dataclass(frozen=True)
class StickSlip(BallMotion):
    """State (x, v), V > 0, v0 <= V; slips end in sticking: (x0 - xk)^2 + (v0^2 - V^2) m/k <= (xk + xs)^2."""

    mass: Fraction
    stiffness: Fraction
    g: Fraction
    mu_s: Fraction
    mu_k: Fraction
    V: Fraction
    x0: Fraction
    v0: Fraction

    @property
    def xs(self) -> Fraction:
        """The position of release."""
        return self.mu_s * self.mass * self.g / self.stiffness

    @property
    def xk(self) -> Fraction:
        """The centre of the slip."""
        return self.mu_k * self.mass * self.g / self.stiffness

    @property
    def stuck_first(self) -> bool:
        return self.v0 == self.V and self.x0 < self.xs

    @property
    def loose_first(self) -> bool:
        """Whether the motion starts with a release."""
        return self.v0 == self.V and self.x0 == self.xs

    @property
    def slips_for_good(self) -> bool:
        """Whether the initial slip never sticks: it does not reach V, or reaches it only at xk = xs."""
        return not self.stuck_first and self._catch(self._first) is None

    @property
    def repeats(self) -> bool:
        """Whether slips after a release end in sticking; for mu_s = mu_k the block slips for ever."""
        return self.xs > self.xk and not self.slips_for_good

    @property
    def course(self) -> tuple[Any, ...]:
        """What two motions of the same sequence of phases have in common."""
        return self.stuck_first, self.slips_for_good, self.repeats

    @property
    def _first(self) -> tuple[Fraction, Fraction]:
        return self.x0 - self.xk, self.v0

    @property
    def _loose(self) -> tuple[Fraction, Fraction]:
        """Distance from the centre and speed at a release."""
        return self.xs - self.xk, self.V

    def release_time(self, digits: int = 15) -> Any:
        """Time of the first release (s), which may be the start."""
        return self._derived(digits, self._release)

    def slip_time(self, digits: int = 15) -> Any:
        """Duration of a slip after a release (s)."""
        return self._derived(digits, lambda: self._slip(*self._loose))

    def stick_time(self, digits: int = 15) -> Any:
        """Duration of sticking between two slips (s)."""
        return self._derived(digits, self._stick)

    def period(self, digits: int = 15) -> Any:
        """Period of the limit cycle, or of the swing if the block never sticks again (s)."""
        return self._derived(digits, self._period if self.repeats else lambda: 2 * flint.arb.pi() / self._rate())

    def cycle_time(self, cycle: int, caught: bool, digits: int = 15) -> Any:
        """Time of release number `cycle` = 0, 1, ..., or (`caught`) of the end of the slip after it (s)."""
        return self._derived(
            digits,
            lambda: (
                self._release() + (cycle * self._period() if cycle else 0) + (self._slip(*self._loose) if caught else 0)
            ),
        )

    def place_caught(self, digits: int = 15) -> Any:
        """Position where the belt catches the block after a release (m)."""
        return self._derived(digits, lambda: self._place(*self._loose))

    def number(self, value: Fraction, digits: int = 15) -> Any:
        """A rational number to `digits`."""
        return self._derived(digits, lambda: ball(value))

    def first_catch(self, digits: int = 15) -> tuple[Any, Any] | None:
        """Time and position of the end of the initial slip; None if there is none, or if it never ends in sticking."""
        if self.stuck_first or self.slips_for_good or self.loose_first:
            return None
        return self._derived(digits, lambda: self._slip(*self._first)), self._derived(
            digits, lambda: self._place(*self._first)
        )

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if self.stuck_first:
            if t <= (self.xs - self.x0) / self.V:
                return ball(self.x0 + self.V * t), ball(self.V)
        elif self.slips_for_good or sign(lambda: self._slip(*self._first) - ball(t)) > 0:
            return self._swing(*self._first, ball(t))
        elif sign(lambda: self._release() - ball(t)) > 0:
            return self._place(*self._first) + ball(self.V) * (ball(t) - self._slip(*self._first)), ball(self.V)
        if not self.repeats:
            return self._swing(*self._loose, ball(t) - self._release())
        cycles = floor_of(lambda: (ball(t) - self._release()) / self._period()) if t else 0

        def since() -> Any:
            return ball(t) - self._release() - cycles * self._period()

        if sign(lambda: self._slip(*self._loose) - since()) > 0:
            return self._swing(*self._loose, since())
        return self._place(*self._loose) + ball(self.V) * (since() - self._slip(*self._loose)), ball(self.V)

    def _rate(self) -> Any:
        return ball(self.stiffness / self.mass).sqrt()

    def _swing(self, distance: Fraction, speed: Fraction, time: Any) -> Sequence[Any]:
        rate = self._rate()
        sine, cosine = (rate * time).sin_cos()
        from_centre, v = ball(distance), ball(speed)
        return ball(self.xk) + from_centre * cosine + v / rate * sine, v * cosine - rate * from_centre * sine

    def _catch(self, start: tuple[Fraction, Fraction]) -> Fraction | None:
        """The square of the distance from the centre at which a slip has the speed V; None if it never has."""
        square = start[0] ** 2 + (start[1] ** 2 - self.V**2) * self.mass / self.stiffness
        return None if square < 0 or (square == 0 and self.xs == self.xk) else square

    def _slip(self, distance: Fraction, speed: Fraction) -> Any:
        """Duration of a slip: psi from its start to the next psi with w R sin psi = V, cos psi >= 0."""
        rate = self._rate()
        square = self._catch((distance, speed))
        assert square is not None
        if speed == self.V:
            # From pi - psi1, beyond the centre, to 2 pi + psi1.
            return (flint.arb.pi() + 2 * flint.arb.atan2(ball(self.V), rate * ball(distance))) / rate
        here = flint.arb.atan2(ball(speed), -rate * ball(distance))
        there = flint.arb.atan2(ball(self.V), rate * ball(square).sqrt())
        angle = there - here
        return (angle + 2 * flint.arb.pi() if angle < 0 else angle) / rate

    def _place(self, distance: Fraction, speed: Fraction) -> Any:
        """Position at the end of a slip."""
        square = self._catch((distance, speed))
        assert square is not None
        return ball(self.xk) - ball(square).sqrt()

    def _stick(self) -> Any:
        return (ball(self.xs) - self._place(*self._loose)) / ball(self.V)

    def _release(self) -> Any:
        if self.stuck_first:
            return ball((self.xs - self.x0) / self.V)
        if self.slips_for_good or self.loose_first:
            return flint.arb(0)
        return self._slip(*self._first) + (ball(self.xs) - self._place(*self._first)) / ball(self.V)

    def _period(self) -> Any:
        return self._slip(*self._loose) + self._stick()
