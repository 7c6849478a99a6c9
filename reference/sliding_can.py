"""A chilled can, inverted on an incline, that its warming air carries ever more (Beatty, Dynamics, 5.12.1; inferred).

The air's pressure beyond the atmosphere's lifts with P (1 - e^(-t/T)), P = p1 A: N = m g cos(alpha) - lift. It slides
from where m g sin(alpha) = mu_s N, and then s'' = g sin(alpha) - mu_k N/m, a constant and an exponential.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.balls import BallMotion, ball, sign


@dataclass(frozen=True)
class SlidingCan(BallMotion):
    """State (s, v), s down the incline, starting at rest; 0 < alpha < pi/2, no lift-off: P < m g cos(alpha)."""

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
        """Sign of mu_s (m g cos(alpha) - P) - m g sin(alpha): negative: the can slides some time.

        Never zero: of a rational alpha no rational combination of sine, cosine and 1 vanishes (Lindemann).
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
        """When it begins to slide, -T ln(1 - (m g/P) (cos(alpha) - sin(alpha)/mu_s)); 0 where it slides first."""
        return self._derived(digits, self._onset)

    def _onset(self) -> Any:
        if self.slides_first:
            return flint.arb(0)
        missing = self._pressing() - self._pulling() / ball(self.mu_s)
        return -ball(self.warming) * (-missing / ball(self.lift)).log1p()

    def _pressing(self) -> Any:
        return ball(self.mass * self.g) * ball(self.alpha).cos()

    def _pulling(self) -> Any:
        return ball(self.mass * self.g) * ball(self.alpha).sin()

    def _balls(self, t: Fraction) -> Sequence[Any]:
        # The onset is at no rational time but 0: e^(-t/T) is transcendental over the field of sin and cos (Lindemann).
        if self.holds or (not self.slides_first and sign(lambda: self._onset() - ball(t)) > 0):
            return ball(self.s0), ball(self.v0)
        begin = self._onset()
        since, scale = ball(t) - begin, ball(self.warming)
        mass, mu = ball(self.mass), ball(self.mu_k)
        # s'' = rest - fading e^(-since/T), integrated twice.
        rest = (self._pulling() - mu * (self._pressing() - ball(self.lift))) / mass
        fading = mu * ball(self.lift) * (-begin / scale).exp() / mass
        lost = -(-since / scale).expm1()
        v = ball(self.v0) + rest * since - fading * scale * lost
        s = ball(self.s0) + ball(self.v0) * since + rest * since * since / 2 - fading * scale * (since - scale * lost)
        return s, v
