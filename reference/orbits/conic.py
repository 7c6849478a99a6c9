"""The part of a Kepler motion that depends on r0^2, v0^2 and r0.v0 alone, in any number of dimensions.

r(t) = f r0 + g v0 with Lagrange's coefficients in universal variables (Goodyear, Astron. J. 70, 1965). alpha = 1/a is
formed from exact numbers, so that orbits near the parabola lose no digits.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.precision import working
from gnomon.reference.orbits.universal import laguerre_step, rough_root, universal_functions


class Conic(Motion):
    """Attraction to a point by mu/r^2; a subclass states r0^2, v0^2 and r0.v0 as exact numbers."""

    mu: Fraction

    @property
    def _rr(self) -> Fraction:
        raise NotImplementedError

    @property
    def _vv(self) -> Fraction:
        raise NotImplementedError

    @property
    def _rv(self) -> Fraction:
        raise NotImplementedError

    @cached_property
    def conic(self) -> int:
        """1 for an ellipse, 0 for a parabola, -1 for a hyperbola (degenerate ones included), decided exactly."""
        return (self._gap > 0) - (self._gap < 0)

    @cached_property
    def _gap(self) -> Fraction:
        """4 mu^2 - r^2 v^4, which has the sign of 2 mu / r - v^2 and is rational."""
        return 4 * self.mu**2 - self._rr * self._vv**2

    def period(self, digits: int = 15) -> Any:
        """Period of an ellipse (s); ValueError for other conics."""
        if self.conic <= 0:
            raise ValueError("only an ellipse has a period; this orbit is not bound")
        return self._quantity(digits, self._period)

    def pericentre_time(self, digits: int = 15) -> Any:
        """Time of pericentre (s): on an ellipse the first at t >= 0, on other conics the only one, of either sign."""

        def formula(mp: Any) -> Any:
            time = self._pericentre_time(mp)
            return time + self._period(mp) if time < 0 and self.conic > 0 else time

        with working(20) as mp:
            guard = 20 + 2 * float(mp.log10(1 + abs(self._elements(mp)[1]) * mp.sqrt(mp.mpf(self._rr))))
        return self._quantity(digits, formula, guard + 20)

    def _lagrange(self, mp: Any, t: Fraction) -> tuple[Any, Any, Any, Any]:
        """f, g, f', g': r(t) = f r0 + g v0, v(t) = f' r0 + g' v0."""
        r0, _alpha, s0, root = self._elements(mp)
        _, (_u0, u1, u2, _u3), r = self._solve(mp, t)
        return 1 - u2 / r0, (r0 * u1 + s0 * u2) / root, -root * u1 / (r * r0), 1 - u2 / r

    def _elements(self, mp: Any) -> tuple[Any, Any, Any, Any]:
        """r0, alpha = 1/a, s0 = r.v / sqrt(mu), sqrt(mu)."""
        r0, mu = mp.sqrt(mp.mpf(self._rr)), mp.mpf(self.mu)
        alpha = mp.mpf(self._gap) / (r0 * mu * (2 * mu + r0 * mp.mpf(self._vv)))
        root = mp.sqrt(mu)
        return r0, alpha, mp.mpf(self._rv) / root, root

    def _solve(self, mp: Any, t: Fraction) -> tuple[Any, tuple[Any, Any, Any, Any], Any]:
        """chi with r0 U1 + s0 U2 + U3 = sqrt(mu) t, without whole periods; U0..U3 there; r."""
        r0, alpha, s0, root = self._elements(mp)
        time = mp.mpf(t)
        if self.conic > 0:
            period = self._period(mp)
            time -= mp.nint(time / period) * period
        if not time:
            return time, (mp.mpf(1), time, time, time), r0  # Newton's method has no relative accuracy at 0
        sign = -1 if time < 0 else 1  # backwards: the motion from the reversed velocity
        target, s0 = root * abs(time), sign * s0
        dps, lost = mp.dps, 0 if self.conic > 0 or s0 >= 0 else 2 * mp.log10(1 - alpha * r0)
        with working(20 + lost):  # towards the pericentre of a hyperbola F cancels
            chi = rough_root(mp, r0, alpha, s0, target)
        for _ in range(60):
            u = universal_functions(mp, alpha, chi)
            step = laguerre_step(mp, r0, alpha, s0, target, u)
            chi -= step
            if abs(step) <= abs(chi) * mp.mpf(10) ** (-0.6 * dps):
                break
        u0, u1, u2, u3 = universal_functions(mp, alpha, chi)
        return sign * chi, (u0, sign * u1, u2, sign * u3), r0 * u0 + s0 * u1 + u2

    def _period(self, mp: Any) -> Any:
        _r0, alpha, _s0, root = self._elements(mp)
        return 2 * mp.pi / (root * alpha * mp.sqrt(alpha))

    def _pericentre_time(self, mp: Any) -> Any:
        """Time of the pericentre nearest in eccentric anomaly."""
        r0, alpha, s0, root = self._elements(mp)
        along = 1 - alpha * r0
        if self.conic > 0:
            w = mp.sqrt(alpha)
            chi = -mp.atan2(s0 * w, along) / w
        elif self.conic == 0:
            chi = -s0
        else:
            w = mp.sqrt(-alpha)
            chi = -mp.atanh(s0 * w / along) / w
        _u0, u1, u2, u3 = universal_functions(mp, alpha, chi)
        return (r0 * u1 + s0 * u2 + u3) / root
