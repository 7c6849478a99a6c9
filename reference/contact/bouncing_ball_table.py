"""A ball that bounces on a vertically moving table: impacts by rigorous root finding.

Relative to the table, at b t^2/2 + A sin(w t), the ball falls with z'' = -G + A w^2 sin(w t), G = g + b. With A w^2 < G
the height over the table is concave in each flight: one impact ends it, and Newton's method from above finds it. Errors
grow from impact to impact, exponentially in chaotic motions: the precision is raised until the balls are narrow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

import flint
from gnomon.reference.numerics.balls import ball, precision
from gnomon.reference.numerics.motion import BallMotion

MOST = 500
"""Most impacts within a span; with e < 1 they may accumulate."""
SHORTEST = 2.0**-40
"""Fraction of the elapsed time: if flights are shorter, the ball comes to rest on the table."""
ROUGH_BITS = 64
CLOSE = 1e-12
"""Accuracy of the times of impacts (s) that are counted."""


class Flight(NamedTuple):
    """A flight from an impact (or 0) at `begin`: height z, relative velocity u, and the velocity before, `arriving`."""

    begin: Any
    z: Any
    u: Any
    arriving: Any


@dataclass(frozen=True)
class VibratingTable(BallMotion):
    """State (z, u), height over the table and its rate; z0 > 0, or z0 = 0 and u0 > 0; 0 < e <= 1, A w^2 < G."""

    pull: Fraction
    e: Fraction
    amplitude: Fraction
    frequency: Fraction
    z0: Fraction
    u0: Fraction

    def impacts(self, until: Fraction) -> int:
        """Number of impacts up to a time, at a precision that resolves them."""
        bits = 2 * ROUGH_BITS
        while True:
            with precision(bits):
                known = self._known(until)
            if all(flight.begin.rad() < CLOSE for flight in known):
                return len(known) - 1
            bits *= 2

    def impact(self, n: int, until: Fraction, digits: int = 15) -> tuple[Any, Any, Any]:
        """Time of impact n = 1, 2, ..., and the relative velocity before and after it."""
        return (
            self._derived(digits, lambda: self._flight(n, until).begin),
            self._derived(digits, lambda: self._flight(n, until).arriving),
            self._derived(digits, lambda: self._flight(n, until).u),
        )

    def _flight(self, n: int, until: Fraction) -> Flight:
        """The flight after impact n; not finite where the balls do not reach it, so that more precision is taken."""
        known = self._known(until)
        return known[n] if n < len(known) else Flight(*(flint.arb("nan") for _ in Flight._fields))

    def _known(self, until: Fraction) -> list[Flight]:
        """The flights that begin up to a time, at the current precision."""
        flights, more = _flights(self, flint.ctx.prec), ball(until).mid()
        while flights[-1].begin.mid() <= more:
            if len(flights) > MOST:
                raise ArithmeticError(f"more than {MOST} impacts")
            flights.append(self._following(flights[-1]))
            if not flights[-1].begin.is_finite():
                break  # the balls are infinite: more precision is needed
            before, now = (flight.begin.mid() for flight in flights[-2:])
            if now - before < SHORTEST * now:
                raise ArithmeticError(f"impacts without end near t = {float(now):g} s")
        return [flight for flight in flights if not flight.begin.mid() > more]

    def _following(self, flight: Flight) -> Flight:
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

    def _balls(self, t: Fraction) -> Sequence[Any]:
        flight = self._known(t)[-1]
        return self._after(flight, ball(t) - flight.begin)


@lru_cache(maxsize=32)
def _flights(motion: VibratingTable, bits: int) -> list[Flight]:
    """The flights computed so far at a precision; callers append."""
    return [Flight(flint.arb(0), ball(motion.z0), ball(motion.u0), flint.arb(0))]
