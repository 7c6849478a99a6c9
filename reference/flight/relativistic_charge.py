"""A relativistic charge in uniform fields.

In proper time the four-velocity (U0, u) = (gamma c, u) obeys a linear equation with constant coefficients,
U0' = (q/m) E.u/c, u' = (q/m) (E U0/c + u x B), in every regime (E < cB, E = cB, E > cB). The proper time tau of the
coordinate time t is the root of X0(tau) = c t, whose derivative is U0 >= c.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, precision
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.vectors import cross, dot

Vector = tuple[Fraction, Fraction, Fraction]
ROUGH_BITS = 128
LONGEST = 10**40


@dataclass(frozen=True)
class RelativisticCharge(BallMotion):
    """State (x, y, z, ux, uy, uz), u = gamma v the proper velocity (m, m/s)."""

    q_m: Fraction
    c: Fraction
    electric: Vector
    magnetic: Vector
    position: Vector
    proper: Vector

    def gamma(self, digits: int = 15) -> Any:
        """The Lorentz factor at the start."""
        return self._derived(digits, lambda: self._time_part() / ball(self.c))

    def proper_time(self, t: Fraction, digits: int = 15) -> Any:
        """Proper time of the charge at t (s)."""

        def formula() -> Any:
            tau = self._near(t)
            grown = self._grown(tau)
            return tau + (ball(self.c * t) - grown[0]) / grown[4]

        return self._derived(digits, formula)

    def largest_gamma(self, span: Fraction) -> float:
        """The largest Lorentz factor at the start, the middle and the end of a span."""
        squares = [1 + sum(float(u) ** 2 for u in self.state(t)[3:]) / float(self.c) ** 2 for t in (0, span / 2, span)]
        return float(max(squares) ** 0.5)

    def field_invariants(self) -> tuple[Fraction, Fraction]:
        """E^2 - c^2 B^2 and E.B, which are the same in every inertial frame."""
        return (
            dot(self.electric, self.electric) - self.c**2 * dot(self.magnetic, self.magnetic),
            dot(self.electric, self.magnetic),
        )

    def tangential_acceleration(self, digits: int = 15) -> Any:
        """Tangential acceleration F_t/(m gamma^3) at the start; the velocity must not be zero."""

        def formula() -> Any:
            along = ball(self.q_m * dot(self.electric, self.proper)) / ball(dot(self.proper, self.proper)).sqrt()
            return along / (self._time_part() / ball(self.c)) ** 3

        return self._derived(digits, formula)

    def curvature_radius(self, digits: int = 15) -> Any:
        """Radius of curvature gamma m v^2/F_n at the start, infinite for F_n = 0; the velocity must not be zero."""
        square = dot(self.proper, self.proper)
        # F_n in two parts: the part of E normal to u, and (u x B)/gamma
        share = dot(self.electric, self.proper) / square
        across = [e - share * u for e, u in zip(self.electric, self.proper, strict=True)]
        turned = cross(self.proper, self.magnetic)
        if self.q_m == 0 or (not any(across) and not any(turned)):
            return self._quantity(digits, lambda mp: mp.inf)

        def formula() -> Any:
            gamma = self._time_part() / ball(self.c)
            force = [ball(e) + ball(b) / gamma for e, b in zip(across, turned, strict=True)]
            size = sum((f * f for f in force), flint.arb(0)).sqrt()
            return ball(square / abs(self.q_m)) / (gamma * size)

        return self._derived(digits, formula)

    def _balls(self, t: Fraction) -> Sequence[Any]:
        x0, *place, u0, ux, uy, uz = self._grown(self._near(t))
        # Newton's method ends at the root up to round-off: one step of the equations covers the remaining time.
        rest = (ball(self.c * t) - x0) / u0
        rate, light = ball(self.q_m), ball(self.c)
        ex, ey, ez = map(ball, self.electric)
        bx, by, bz = map(ball, self.magnetic)
        force = (
            ex * u0 / light + uy * bz - uz * by,
            ey * u0 / light + uz * bx - ux * bz,
            ez * u0 / light + ux * by - uy * bx,
        )
        moved = [x + u * rest for x, u in zip(place, (ux, uy, uz), strict=True)]
        start = [ball(x) for x in self.position]
        return [
            *(a + b for a, b in zip(start, moved, strict=True)),
            *(u + rate * f * rest for u, f in zip((ux, uy, uz), force, strict=True)),
        ]

    def _time_part(self) -> Any:
        """U0 at the start."""
        return ball(self.c**2 + sum(u * u for u in self.proper)).sqrt()

    def _grown(self, tau: Any) -> list[Any]:
        """(X0, X, U0, U) after proper time tau, from X = 0."""
        rate = self.q_m
        ex, ey, ez = (rate * e / self.c for e in self.electric)
        bx, by, bz = (rate * b for b in self.magnetic)
        o = Fraction(0)
        field = ((o, ex, ey, ez), (ex, o, bz, -by), (ey, -bz, o, bx), (ez, by, -bx, o))
        # The last column is U(0), so that one exponential gives e^(F tau) and its integral applied to U(0). It is divided
        # by a power of two: the exponential takes as many squarings as its largest entry has bits.
        start = [self._time_part(), *map(ball, self.proper)]
        unit = _power_of_two(start[0] * tau)
        rows = [[*(ball(x) for x in row), u / unit] for row, u in zip(field, start, strict=True)]
        matrix = flint.arb_mat(5, 5, [x for row in rows for x in row] + [flint.arb(0)] * 5)
        grown = (matrix * tau).exp()
        way = [grown[i, 4] * unit for i in range(4)]
        return [*way, *(sum((grown[i, j] * start[j] for j in range(4)), flint.arb(0)) for i in range(4))]

    def _near(self, t: Fraction) -> Any:
        """A proper time close to that at time t, an exact number: Newton's method, first in a bracket."""
        largest = max(map(abs, (*(e / self.c for e in self.electric), *self.magnetic)))
        if abs(self.q_m * largest * t) > LONGEST:
            raise ArithmeticError(f"t = {float(t):g} s is more than 1e40 times the time scale of the fields")
        if max(map(abs, self.proper)) > LONGEST * self.c:
            raise ArithmeticError("its Lorentz factor is more than 1e40")
        with precision(ROUGH_BITS):
            goal = ball(self.c * t)
            low, high = min(flint.arb(0), ball(t)), max(flint.arb(0), ball(t))
            tau = self._newton(goal, (ball(t) * ball(self.c) / self._time_part()).mid(), low, high)
        return self._newton(ball(self.c * t), tau, low, high)

    def _newton(self, goal: Any, tau: Any, low: Any, high: Any) -> Any:
        """Newton's method; a bisection replaces steps that leave the bracket or exceed half the previous one."""
        before = high - low
        for _ in range(1000):
            grown = self._grown(tau)
            missing = (goal - grown[0]).mid()
            low, high = (tau, high) if missing > 0 else (low, tau)
            new = (tau + missing / grown[4]).mid()
            if not low <= new <= high or 2 * abs(new - tau) > before:
                new = ((low + high) / 2).mid()
            step = abs(new - tau)
            if step <= abs(new) * flint.arb(2) ** (24 - flint.ctx.prec):
                return new
            before, tau = step, new
        return tau


def _power_of_two(x: Any) -> Any:
    """The power of two next to a ball's midpoint, 1 where that is 0."""
    mantissa, exponent = abs(x.mid()).man_exp()
    return flint.arb(2) ** (int(exponent) + int(mantissa).bit_length()) if mantissa else flint.arb(1)
