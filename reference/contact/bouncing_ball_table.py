"""A ball that bounces on a vertically moving table: impacts by rigorous root finding.

Relative to the table, at b t^2/2 + A sin(w t), the ball falls with z'' = -G + A w^2 sin(w t), G = g + b. With A w^2 < G
the height over the table is concave in each flight: one impact ends it, and Newton's method from above finds it. Errors
grow from impact to impact, exponentially in chaotic motions: the precision is raised until the balls are narrow.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.contact.flights import ROUGH_BITS, Flight, ImpactMotion
from gnomon.reference.numerics.balls import ball, precision


@dataclass(frozen=True)
class VibratingTable(ImpactMotion):
    """State (z, u), height over the table and its rate; z0 > 0, or z0 = 0 and u0 > 0; 0 < e <= 1, A w^2 < G."""

    pull: Fraction
    e: Fraction
    amplitude: Fraction
    frequency: Fraction
    z0: Fraction
    u0: Fraction

    def _following(self, flight: Flight, until: Any) -> Flight:
        """The flight after the next impact: Newton's method, whose last step includes the balls of the start."""
        rest = Flight(*(x.mid() for x in flight))
        gravity, size = ball(self.pull), ball(self.amplitude)
        ball_speed = rest.u + size * ball(self.frequency) * (ball(self.frequency) * rest.begin).cos()
        wait = (ball_speed + (ball_speed * ball_speed + 2 * gravity * (rest.z + 2 * size)).sqrt()) / gravity
        for bits in (ROUGH_BITS, flint.ctx.prec):
            with precision(bits):
                wait = self._root(rest, wait.mid())
        z, u = self._after(flight, wait)
        wait = wait - z / u
        _, u = self._after(flight, wait)
        return Flight(flight.begin + wait, flint.arb(0), -ball(self.e) * u, u)

    def _root(self, flight: Flight, wait: Any) -> Any:
        for _ in range(200):
            z, u = self._after(flight, wait)
            step = (z / u).mid()
            wait = (wait - step).mid()
            if abs(step) <= abs(wait) * flint.arb(2) ** (12 - flint.ctx.prec):
                break
        return wait

    def _after(self, flight: Flight, since: Any) -> tuple[Any, Any]:
        """Height and relative velocity at `since` after the start of a flight, as if no impact followed."""
        rate, size, gravity = ball(self.frequency), ball(self.amplitude), ball(self.pull)
        half = rate * since / 2
        middle = rate * flight.begin + half
        # sin(x + 2h) - sin(x) = 2 cos(x + h) sin(h), and the same for the cosine: short flights do not cancel
        rise, turn = 2 * middle.cos() * half.sin(), -2 * middle.sin() * half.sin()
        drift = rate * since * (rate * flight.begin).cos()
        z = flight.z + since * (flight.u - gravity * since / 2) - size * (rise - drift)
        return z, flight.u - gravity * since - size * rate * turn
