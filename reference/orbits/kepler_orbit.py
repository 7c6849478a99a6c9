"""The Kepler problem in a plane, any conic, in universal variables.

The formulas of `conic` are Goodyear's (Astron. J. 70, 1965).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from gnomon.reference.numerics.motion import MANY
from gnomon.reference.numerics.pointwise import Floats
from gnomon.reference.numerics.precision import Number, exact, publish, working
from gnomon.reference.orbits.conic import Conic
from gnomon.reference.orbits.universal import universal_functions


@dataclass(frozen=True)
class Kepler(Conic):
    """A point at (x, y) with velocity (vx, vy) attracted to the origin by mu / r^2 (m, m/s, m^3/s^2).

    With zero angular momentum the motion ends at the collision: a time at or beyond it raises ValueError.
    """

    mu: Fraction
    x: Fraction
    y: Fraction
    vx: Fraction
    vy: Fraction

    def __post_init__(self) -> None:
        if self.mu <= 0:
            raise ValueError(f"mu = {self.mu} is not positive")
        if self.x == 0 and self.y == 0:
            raise ValueError("x = y = 0 is the centre of attraction, where there is no motion; start elsewhere")

    # The exact numbers that decide which conic it is

    @cached_property
    def angular_momentum(self) -> Fraction:
        """x vy - y vx, twice the areal rate (m^2/s)."""
        return self.x * self.vy - self.y * self.vx

    @cached_property
    def _rr(self) -> Fraction:
        return self.x**2 + self.y**2

    @cached_property
    def _vv(self) -> Fraction:
        return self.vx**2 + self.vy**2

    @cached_property
    def _rv(self) -> Fraction:
        return self.x * self.vx + self.y * self.vy

    # The state

    def _state(self, mp: Any, t: Fraction) -> list[Any]:
        f, g, df, dg = self._lagrange(mp, t)
        x, y, vx, vy = (mp.mpf(value) for value in (self.x, self.y, self.vx, self.vy))
        return [f * x + g * vx, f * y + g * vy, df * x + dg * vx, df * y + dg * vy]

    def _guard(self, t: Fraction) -> float:
        """Digits lost to the subtraction of whole periods and, near a close pericentre, to cancellation in r."""
        with working(20) as mp:
            r0, alpha, _s0, _root = self._elements(mp)
            size = r0 + (1 / abs(alpha) if self.conic else 0)
            lost = mp.log10(1 + abs(mp.mpf(t)) / self._period(mp)) if self.conic > 0 else mp.mpf(0)
            if self.angular_momentum:
                return float(20 + lost + 2 * mp.log10(1 + size / self._pericentre(mp)))
        closeness = self._closeness(t)
        return float(20 + lost + 2 * closeness)

    def sample(self, times: Floats, span: float | None = None, breaks: Sequence[Any] = ()) -> Floats:
        """Doubles within 0.51 ulp of the state at each time (float64, s), shape (len(times), 4)."""
        if len(times) < MANY:
            return self.sample_each(times)
        if not self.angular_momentum:  # raises where a time is beyond the collision
            for extreme in (float(np.min(times)), float(np.max(times))):
                self._closeness(Fraction(extreme))
        if self.conic > 0:
            from gnomon.reference.orbits import ellipse  # compiles; not wanted before many times are asked for

            return ellipse.sample(self, times)
        return super().sample(times, span, breaks) if self.angular_momentum else self.sample_each(times)

    def sundman(self, t: Number, digits: int = 15) -> Any:
        """The integral of dt / r from 0 to t (s/m), the independent variable of Sundman's equations."""
        time = exact(t, "t")
        with working(digits + self._guard(time)) as mp:
            _r0, alpha, _s0, root = self._elements(mp)
            chi = self._solve(mp, time)[0]
            if self.conic > 0:
                chi += mp.nint(mp.mpf(time) / self._period(mp)) * 2 * mp.pi / mp.sqrt(alpha)
            return publish([chi / root], digits)[0]

    # Derived quantities

    def eccentricity(self, digits: int = 15) -> Any:
        return self._quantity(digits, self._eccentricity)

    def runge_lenz(self, digits: int = 15) -> tuple[Any, Any]:
        """The eccentricity vector, from the centre to the pericentre."""
        with working(digits + 20) as mp:
            along, across = self._eccentricity_parts(mp)
            r0 = mp.sqrt(mp.mpf(self._rr))
            x, y = mp.mpf(self.x) / r0, mp.mpf(self.y) / r0
            return publish((along * x + across * y, along * y - across * x), digits)  # type: ignore[return-value]

    def semi_major_axis(self, digits: int = 15) -> Any:
        """Negative for a hyperbola, infinite for a parabola (m)."""
        return self._quantity(digits, lambda mp: 1 / self._elements(mp)[1] if self.conic else mp.inf)

    def semi_latus_rectum(self, digits: int = 15) -> Any:
        return self._quantity(digits, lambda mp: mp.mpf(self.angular_momentum**2 / self.mu))

    def areal_rate(self, digits: int = 15) -> Any:
        """Area swept a second, h / 2 (m^2/s)."""
        return self._quantity(digits, lambda mp: mp.mpf(self.angular_momentum / 2))

    def pericentre(self, digits: int = 15) -> Any:
        """The smallest distance from the centre (m)."""
        return self._quantity(digits, self._pericentre)

    def collision_time(self, digits: int = 15, forward: bool = True) -> Any:
        """Time from the start to the next collision, or to it from the last one (s); None if there is none."""
        if self.angular_momentum:
            return None
        outward = self._rv >= 0 if forward else self._rv <= 0
        if outward and self.conic <= 0 and self._vv:
            return None

        def formula(mp: Any) -> Any:
            r0, alpha, s0, root = self._elements(mp)
            s0 = s0 if forward else -s0
            # sqrt(r) = sqrt(r0) cos(w) + (s0 / sqrt(r0 alpha)) sin(w), w = sqrt(alpha) chi / 2, vanishes at chi:
            if self.conic > 0:
                w = mp.sqrt(alpha)
                chi = 2 * mp.atan2(r0 * w, -s0) / w
            elif self.conic == 0:
                chi = -2 * r0 / s0
            else:
                w = mp.sqrt(-alpha)
                chi = 2 * mp.atanh(r0 * w / -s0) / w
            _u0, u1, u2, u3 = universal_functions(mp, alpha, chi)
            return (r0 * u1 + s0 * u2 + u3) / root

        return self._quantity(digits, formula, 30)

    def _eccentricity(self, mp: Any) -> Any:
        return mp.hypot(*self._eccentricity_parts(mp))

    def _eccentricity_parts(self, mp: Any) -> tuple[Any, Any]:
        """e cos f = h^2/(mu r) - 1, without cancellation, and e sin f = h r' / mu, f the true anomaly."""
        h, mu, r0 = self.angular_momentum, self.mu, mp.sqrt(mp.mpf(self._rr))
        along = mp.mpf(h**4 - mu**2 * self._rr) / (mp.mpf(mu) * r0 * (mp.mpf(h**2) + mp.mpf(mu) * r0))
        return along, mp.mpf(h * self._rv) / (mp.mpf(mu) * r0)

    def _pericentre(self, mp: Any) -> Any:
        return mp.mpf(self.angular_momentum**2 / self.mu) / (1 + self._eccentricity(mp))

    def _closeness(self, t: Fraction) -> float:
        """log10 of collision time over time left before it; ValueError at and beyond the collision."""
        collision = self.collision_time(forward=t >= 0)
        if collision is None:
            return 0.0
        for digits in (30, 100, 400):
            collision = self.collision_time(digits, forward=t >= 0)
            with working(digits) as mp:
                left = mp.mpf(collision) - abs(mp.mpf(t))
                if left > collision * mp.mpf(10) ** (5 - digits):
                    return float(mp.log10(mp.mpf(collision) / left))
                if left < -collision * mp.mpf(10) ** (5 - digits):
                    break
        raise ValueError(f"t = {float(t):.17g} is not before the collision at {float(collision):.17g} s")
