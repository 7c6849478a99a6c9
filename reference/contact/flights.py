"""Motions from impact to impact, each flight found from the one before it.

Errors grow from impact to impact, exponentially in chaotic motions: the precision is raised until the balls are narrow.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
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


UNKNOWN = Flight(*[flint.arb("nan")] * 4)
"""A flight of which the precision gives nothing."""


STEPS = 100_000
"""More steps than any search for an impact needs within the domain."""


def first_passage(
    ahead: Callable[[Any], tuple[Any, Any]], most: Any, start: tuple[Any, Any, Any], longest: Any
) -> Any | None:
    """The time to the first zero of a gap, from below; None if that is later than `longest`.

    `ahead` gives the gap and its rate at a time, `start` is a time with the gap and the rate there, and `most` bounds the
    bending of the gap: from a gap g that changes at the rate g', no zero follows within the positive root h of
    g + g' h - M h^2/2. Steps of that length never pass the first zero, and converge to it quadratically.
    """
    wait, gap, rate = start
    for _ in range(STEPS):
        step = ((rate + (rate * rate + 2 * most * gap).sqrt()) / most).mid()
        wait = (wait + step).mid()
        if step <= wait * flint.arb(2) ** (20 - ROUGH_BITS):
            return wait
        gap, rate = (x.mid() for x in ahead(wait))
        if gap <= 0:
            return wait
        if wait > longest:
            return None
    raise ArithmeticError("no impact within the steps of the search")


class ImpactMotion(BallMotion):
    """State (z, u), a place and its rate. A subclass is a frozen dataclass that states its start and its flights."""

    z0: Fraction
    u0: Fraction

    @abstractmethod
    def _following(self, flight: Flight, until: Any) -> Flight | None:
        """The flight after the next impact; None if there is none up to a time."""

    @abstractmethod
    def _after(self, flight: Flight, since: Any) -> tuple[Any, Any]:
        """Place and rate at `since` after the start of a flight, as if no impact followed."""

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
        """Flight n; unknown where the precision does not reach that far."""
        known = self._known(until)
        return known[n] if n < len(known) else UNKNOWN

    def _known(self, until: Fraction) -> list[Flight]:
        """The flights that begin up to a time, at the current precision."""
        flights, more = _flights(self, flint.ctx.prec), ball(until).mid()
        while flights[-1].begin.is_finite() and flights[-1].begin.mid() <= more:
            if len(flights) > MOST:
                raise ArithmeticError(f"more than {MOST} impacts")
            following = self._following(flights[-1], more)
            if following is None:
                break
            flights.append(following)
            if not flights[-1].begin.is_finite():
                break  # the balls are infinite: more precision is needed
            before, now = (flight.begin.mid() for flight in flights[-2:])
            if now - before < SHORTEST * now:
                raise ArithmeticError(f"impacts without end near t = {float(now):g} s")
        return [flight for flight in flights if not flight.begin.mid() > more]

    def _balls(self, t: Fraction) -> Sequence[Any]:
        flight = self._known(t)[-1]
        return self._after(flight, ball(t) - flight.begin)


@lru_cache(maxsize=32)
def _flights(motion: ImpactMotion, bits: int) -> list[Flight]:
    """The flights computed so far at a precision; callers append."""
    return [Flight(flint.arb(0), ball(motion.z0), ball(motion.u0), flint.arb(0))]
