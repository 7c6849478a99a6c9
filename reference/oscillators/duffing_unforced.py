"""The undamped Duffing oscillator, x'' = -alpha x - beta x^3, in every bounded regime.

x'^2 = h - alpha x^2 - (beta/2) x^4 with h = 2E. Weierstrass's P gives the motion (Biermann), Legendre's K its period.
In Jacobi's functions: cn across the middle, dn inside one well of two, sn in the well of a softening spring; sech and
tanh on the separatrices. The discriminant alpha^2 + 2 beta h and h are rational, so that the regime is decided exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

from gnomon.reference.numerics.elliptic import complete_first
from gnomon.reference.numerics.motion import Motion, decades
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.numerics.precision import working
from gnomon.reference.numerics.weierstrass import Quartic, solve_quartic


@dataclass(frozen=True)
class DuffingMotion(Motion):
    """State (x, v) of a bounded motion (see `bounded`)."""

    alpha: Fraction
    beta: Fraction
    x0: Fraction
    v0: Fraction

    REST: ClassVar[str] = "rest"
    HARMONIC: ClassVar[str] = "harmonic"
    ACROSS: ClassVar[str] = "cn: across the middle"
    ONE_WELL: ClassVar[str] = "dn: in one of two wells"
    SOFT_WELL: ClassVar[str] = "sn: in the well of a softening spring"
    HOMOCLINIC: ClassVar[str] = "sech: from the saddle and back"
    HETEROCLINIC: ClassVar[str] = "tanh: from saddle to saddle"

    @property
    def doubled_energy(self) -> Fraction:
        """h = v^2 + alpha x^2 + (beta/2) x^4."""
        return self.v0**2 + self.alpha * self.x0**2 + self.beta * self.x0**4 / 2

    @property
    def discriminant(self) -> Fraction:
        return self.alpha**2 + 2 * self.beta * self.doubled_energy

    @property
    def bounded(self) -> bool:
        """Whether x stays finite for all time."""
        if self._rests or self.beta > 0:
            return True
        if self.beta == 0:
            return self.alpha > 0
        inside = self.alpha > 0 and -self.beta * self.x0**2 <= self.alpha
        return inside and self.discriminant >= 0

    @property
    def _rests(self) -> bool:
        return self.v0 == 0 and self.x0 * (self.alpha + self.beta * self.x0**2) == 0

    @cached_property
    def regime(self) -> str:
        if self._rests:
            return self.REST
        if self.beta == 0:
            return self.HARMONIC
        if self.beta < 0:
            return self.SOFT_WELL if self.discriminant > 0 else self.HETEROCLINIC
        if self.doubled_energy > 0:
            return self.ACROSS
        return self.ONE_WELL if self.doubled_energy < 0 else self.HOMOCLINIC

    @property
    def periodic(self) -> bool:
        return self.regime not in (self.REST, self.HOMOCLINIC, self.HETEROCLINIC)

    def period(self, digits: int = 15) -> Any:
        """Time after which the state repeats; infinite on a separatrix."""
        return self._quantity(digits, self._period, 20 + self._depth)

    def modulus_squared(self, digits: int = 15) -> Any:
        """m of the elliptic functions of the regime."""
        return self._quantity(digits, lambda mp: 1 - self._shape(mp)[1], 20 + self._depth)

    def energy(self, digits: int = 15) -> Any:
        """Energy over the mass."""
        return self._quantity(digits, lambda mp: mp.mpf(self.doubled_energy / 2))

    @property
    def escape_energy(self) -> Fraction | None:
        """The energy, over the mass, at the maxima x^2 = alpha/|beta| over which a softening spring lets the mass escape."""
        return -(self.alpha**2) / (4 * self.beta) if self.alpha > 0 > self.beta else None

    def turning_points(self, digits: int = 15) -> tuple[Any, Any]:
        """The least and the largest x of the motion (on a separatrix: the limits)."""
        return (
            self._quantity(digits, lambda mp: self._turning_points(mp)[0], 20 + self._depth),
            self._quantity(digits, lambda mp: self._turning_points(mp)[1], 20 + self._depth),
        )

    def _squares(self, mp: Any) -> tuple[Any, Any]:
        """The roots y = x^2 of h - alpha y - (beta/2) y^2, by size, without cancellation."""
        root = mp.sqrt(mp.mpf(self.discriminant))
        alpha, beta, h = (mp.mpf(x) for x in (self.alpha, self.beta, self.doubled_energy))
        # The product of the roots is -2h/beta.
        large = (-alpha - root) / beta if alpha >= 0 else (-alpha + root) / beta
        small = -2 * h / (beta * large) if large else mp.zero
        return small, large

    def _shape(self, mp: Any) -> tuple[Any, Any, int]:
        """Frequency of the elliptic argument, mc = 1 - m, and the period in units of K."""
        if self.regime in (self.HARMONIC, self.REST):
            return mp.sqrt(mp.mpf(abs(self.alpha + 3 * self.beta * self.x0**2))), mp.one, 4
        small, large = self._squares(mp)
        root = mp.sqrt(mp.mpf(self.discriminant))
        beta = mp.mpf(self.beta)
        if self.regime in (self.ACROSS, self.HOMOCLINIC):
            negative = min(small, large)
            return mp.sqrt(root), -negative / (2 * root / beta), 4
        if self.regime == self.ONE_WELL:
            return mp.sqrt(beta * large / 2), small / large, 2
        return mp.sqrt(-beta * large / 2), 2 * root / (-beta * large), 4

    def _period(self, mp: Any) -> Any:
        frequency, mc, quarters = self._shape(mp)
        if self.regime in (self.HOMOCLINIC, self.HETEROCLINIC) or frequency == 0:
            return mp.inf
        return quarters * complete_first(mp, mc) / frequency

    def _turning_points(self, mp: Any) -> tuple[Any, Any]:
        if self.regime == self.REST:
            return mp.mpf(self.x0), mp.mpf(self.x0)
        if self.regime == self.HARMONIC:
            reach = mp.sqrt(mp.mpf(self.doubled_energy / self.alpha))
            return -reach, reach
        small, large = self._squares(mp)
        if self.regime in (self.ONE_WELL, self.HOMOCLINIC):
            inner, outer = mp.sqrt(small), mp.sqrt(large)
            return (inner, outer) if self.x0 > 0 else (-outer, -inner)
        reach = mp.sqrt(max(small, large) if self.beta > 0 else small)
        return -reach, reach

    @cached_property
    def _depth(self) -> float:
        """Digits to which the energy agrees with the energy of the separatrix, if there is one."""
        if self.beta == 0 or (self.beta > 0 and self.alpha >= 0):
            return 0.0
        gap = self.discriminant if self.beta < 0 else self.beta * abs(self.doubled_energy)
        return decades(self.alpha**2 / gap) if gap else 0.0

    def _cycle(self, mp: Any) -> Cycle | None:
        if not self.periodic:
            return None
        with mp.workdps(mp.dps + 20 + self._depth):
            return Cycle(self._period(mp), (mp.zero, mp.zero))

    def _guard(self, t: Fraction) -> float:
        rate = abs(self.alpha) + abs(self.beta) * self.x0**2 + self.v0**2
        lost = 30 + 2 * self._depth + decades(t * t * rate)
        if self.periodic:
            return lost
        with working(15) as mp:  # near a saddle x falls as e^(-sqrt|alpha| t), a difference of terms of size 1
            return lost + 2 * float(mp.sqrt(mp.mpf(abs(self.alpha))) * mp.mpf(abs(t)))

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        if self.regime == self.REST:
            return mp.mpf(self.x0), mp.zero
        time = mp.mpf(t)
        if self.periodic:  # P has a pole at every period: reduce t to half a period
            period = self._period(mp)
            time -= period * mp.nint(time / period)
        f: Quartic = (self.doubled_energy, Fraction(0), -self.alpha, Fraction(0), -self.beta / 2)
        return solve_quartic(mp, f, self.x0, self.v0, time)
