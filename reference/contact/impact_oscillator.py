"""A forced oscillator before a rigid stop: closed form between impacts, impacts by certified root finding.

The gap to the stop bends by no more than a bound M on the acceleration: steps that no gap of that bending can close find
the first impact (`first_passage`), and a grazing arc that misses the stop is passed in the same way.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.contact.flights import ROUGH_BITS, UNKNOWN, Flight, ImpactMotion, first_passage
from gnomon.reference.numerics.balls import ball, precision


@dataclass(frozen=True)
class StoppedOscillator(ImpactMotion):
    """State (x, v); m x'' + c x' + k x = F cos(w t) for x < stop, v -> -e v at the stop; c^2 < 4 m k."""

    mass: Fraction
    damping: Fraction
    stiffness: Fraction
    force: Fraction
    frequency: Fraction
    stop: Fraction
    e: Fraction
    z0: Fraction
    u0: Fraction

    def _forced(self, t: Any) -> tuple[Any, Any]:
        """The periodic answer to the force, and its rate."""
        w = ball(self.frequency)
        soft, lag = self.stiffness - self.mass * self.frequency**2, self.damping * self.frequency
        size = ball(self.force / (soft**2 + lag**2))
        sine, cosine = (w * t).sin(), (w * t).cos()
        return size * (ball(soft) * cosine + ball(lag) * sine), size * w * (ball(lag) * cosine - ball(soft) * sine)

    def _rates(self) -> tuple[Any, Any]:
        decay = self.damping / (2 * self.mass)
        return ball(decay), ball(self.stiffness / self.mass - decay**2).sqrt()

    def _free(self, flight: Flight) -> tuple[Any, Any]:
        """Coefficients of cosine and sine of the free vibration of a flight."""
        decay, turn = self._rates()
        x, v = self._forced(flight.begin)
        return flight.z - x, (flight.u - v + decay * (flight.z - x)) / turn

    def _after(self, flight: Flight, since: Any) -> tuple[Any, Any]:
        decay, turn = self._rates()
        a, b = self._free(flight)
        sine, cosine, fade = (turn * since).sin(), (turn * since).cos(), (-decay * since).exp()
        x, v = self._forced(flight.begin + since)
        free = fade * (a * cosine + b * sine)
        return x + free, v - decay * free + fade * turn * (b * cosine - a * sine)

    def _most(self, flight: Flight) -> Any:
        """A bound of the acceleration: of the forced part, and of the free part, w0^2 + 2 decay (decay + turn) per size."""
        decay, turn = self._rates()
        a, b = self._free(flight)
        size = (a * a + b * b).sqrt()
        soft, lag = self.stiffness - self.mass * self.frequency**2, self.damping * self.frequency
        forced = ball(self.force).abs_upper() * ball(self.frequency**2) / ball(soft**2 + lag**2).sqrt()
        return (forced + size * (decay + turn) ** 2).upper()

    def _following(self, flight: Flight, until: Any) -> Flight | None:
        rest = Flight(*(x.mid() for x in flight))
        with precision(ROUGH_BITS):
            wait = self._first(rest, until - rest.begin)
        if wait is None:
            return None
        wait = self._root(rest, wait)
        x, v = self._after(flight, wait)
        wait = wait - (x - ball(self.stop)) / v
        _, v = self._after(flight, wait)
        if not v > 0:
            return UNKNOWN
        return Flight(flight.begin + wait, ball(self.stop), -ball(self.e) * v, v)

    def _first(self, rest: Flight, longest: Any) -> Any:
        """The time to the first impact, from below, or None if that is later than `longest`; after an impact the gap starts at exactly zero and opens."""
        gap = flint.arb(0) if rest.arriving.mid() != 0 else (ball(self.stop) - rest.z).mid()

        def ahead(wait: Any) -> tuple[Any, Any]:
            x, v = self._after(rest, wait)
            return ball(self.stop) - x, -v

        return first_passage(ahead, self._most(rest), (flint.arb(0), gap, -rest.u), longest)

    def _root(self, rest: Flight, wait: Any) -> Any:
        for _ in range(60):
            x, v = self._after(rest, wait)
            step = ((x - ball(self.stop)) / v).mid()
            wait = (wait - step).mid()
            if abs(step) <= abs(wait) * flint.arb(2) ** (12 - flint.ctx.prec):
                break
        return wait
