"""A chilled, inverted can on an incline, lifted by the warming air inside (inferred).

The excess pressure of the air gives the lift P (1 - e^(-t/T)), P = p1 A, and N = m g cos(alpha) - lift. The can starts
to slide when m g sin(alpha) = mu_s N; then s'' = g sin(alpha) - mu_k N/m, a constant and an exponential. If the lift
reaches m g cos(alpha), N = 0, the can leaves the plane and s'' = g sin(alpha).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, sign
from gnomon.reference.numerics.motion import BallMotion


@dataclass(frozen=True)
class SlidingCan(BallMotion):
    """State (s, v), s down the incline, starting at rest; 0 < alpha < pi/2."""

    mass: Fraction
    g: Fraction
    alpha: Fraction
    mu_s: Fraction
    mu_k: Fraction
    lift: Fraction
    warming: Fraction
    s0: Fraction
    v0: Fraction

    def excess(self) -> int:
        """Sign of mu_s (m g cos(alpha) - P) - m g sin(alpha); negative if the can slides at some time.

        It is never zero: at a rational alpha no rational combination of sine, cosine and 1 vanishes (Lindemann).
        """
        return sign(lambda: ball(self.mu_s) * (self._pressing() - ball(self.lift)) - self._pulling())

    @property
    def slides_first(self) -> bool:
        """Whether it slides from the start."""
        return self.v0 > 0 or sign(lambda: ball(self.mu_s) * self._pressing() - self._pulling()) < 0

    @property
    def holds(self) -> bool:
        """Whether it never moves."""
        return not self.slides_first and self.excess() > 0

    def onset(self, digits: int = 15) -> Any:
        """Time at which sliding starts (s), -T ln(1 - (m g/P) (cos(alpha) - sin(alpha)/mu_s)), or 0."""
        return self._derived(digits, self._onset)

    @cached_property
    def lifts(self) -> bool:
        """Whether the can lifts off: P > m g cos(alpha); the two are never equal (Lindemann)."""
        return sign(lambda: ball(self.lift) - self._pressing()) > 0

    def lift_off(self, digits: int = 15) -> Any:
        """Time at which N = 0 (s), -T ln(1 - m g cos(alpha)/P), if it lifts off."""
        return self._derived(digits, self._lift_off)

    def state_at_lift_off(self, digits: int = 15) -> tuple[Any, Any]:
        return (
            self._derived(digits, lambda: self._sliding(self._lift_off())[0]),
            self._derived(digits, lambda: self._sliding(self._lift_off())[1]),
        )

    def holding_lift(self, digits: int = 15) -> Any:
        """The largest P at which it never slides, m g (cos(alpha) - sin(alpha)/mu_s); mu_s > 0."""
        return self._derived(digits, self._missing)

    def _missing(self) -> Any:
        return self._pressing() - self._pulling() / ball(self.mu_s)

    def _onset(self) -> Any:
        return flint.arb(0) if self.slides_first else self._time_of(self._missing())

    def _lift_off(self) -> Any:
        return self._time_of(self._pressing())

    def _time_of(self, lift: Any) -> Any:
        return -ball(self.warming) * (-lift / ball(self.lift)).log1p()

    def _pressing(self) -> Any:
        return ball(self.mass * self.g) * ball(self.alpha).cos()

    def _pulling(self) -> Any:
        return ball(self.mass * self.g) * ball(self.alpha).sin()

    def _balls(self, t: Fraction) -> Sequence[Any]:
        # The onset is at no rational time but 0: e^(-t/T) is transcendental over the field of sin and cos (Lindemann).
        if self.holds or (not self.slides_first and sign(lambda: self._onset() - ball(t)) > 0):
            return ball(self.s0), ball(self.v0)
        if not self.lifts or sign(lambda: self._lift_off() - ball(t)) > 0:
            return self._sliding(ball(t))
        s, v = self._sliding(self._lift_off())
        since, pull = ball(t) - self._lift_off(), self._pulling() / ball(self.mass)
        return s + v * since + pull * since * since / 2, v + pull * since

    def _sliding(self, time: Any) -> tuple[Any, Any]:
        """The state on the plane, after the onset."""
        begin = self._onset()
        since, scale = time - begin, ball(self.warming)
        mass, mu = ball(self.mass), ball(self.mu_k)
        # s'' = rest - fading e^(-since/T), integrated twice.
        rest = (self._pulling() - mu * (self._pressing() - ball(self.lift))) / mass
        fading = mu * ball(self.lift) * (-begin / scale).exp() / mass
        lost = -(-since / scale).expm1()
        v = ball(self.v0) + rest * since - fading * scale * lost
        s = ball(self.s0) + ball(self.v0) * since + rest * since * since / 2 - fading * scale * (since - scale * lost)
        return s, v
