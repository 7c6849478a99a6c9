"""A rigid block that rocks about its two lower edges, linearised: hyperbolic between impacts, all impacts in closed form.

On either side w = alpha - |theta| obeys w'' = p^2 w, so w = A exp(p t) + B exp(-p t); an impact follows at the later
root of w = alpha. With c = |theta'|/(p alpha) after an impact the next flight takes 2 atanh(c)/p.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.contact.flights import Flight, ImpactMotion
from gnomon.reference.numerics.balls import ball


@dataclass(frozen=True)
class RockingBlock(ImpactMotion):
    """State (theta, theta'); |theta'| < p (alpha - |theta|), theta != 0; at theta = 0 the rate is multiplied by r."""

    p: Fraction
    alpha: Fraction
    r: Fraction
    z0: Fraction
    u0: Fraction

    @staticmethod
    def _side(flight: Flight) -> int:
        place = flight.z if flight.arriving.is_zero() else flight.u
        return 1 if place > 0 else -1

    def _following(self, flight: Flight, until: Any) -> Flight | None:
        side, p, alpha = self._side(flight), ball(self.p), ball(self.alpha)
        w, rate = alpha - side * flight.z, -side * flight.u / p
        # From an impact w = alpha exactly: the discriminant is that of the rate alone.
        fall = (alpha * alpha - w * w + rate * rate).sqrt() if flight.arriving.is_zero() else abs(rate)
        wait = ((alpha + fall) / (w + rate)).log() / p
        arriving = -side * p * fall
        return Flight(flight.begin + wait, ball(Fraction(0)), ball(self.r) * arriving, arriving)

    def _after(self, flight: Flight, since: Any) -> tuple[Any, Any]:
        side, p, alpha = self._side(flight), ball(self.p), ball(self.alpha)
        grown = (p * since).exp()
        sine, cosine = (grown - 1 / grown) / 2, (grown + 1 / grown) / 2
        place = flight.z - side * alpha
        return side * alpha + place * cosine + flight.u / p * sine, p * place * sine + flight.u * cosine
