"""The simple pendulum: theta'' = -(g/L) sin(theta), in Jacobi's elliptic functions.

m = sin^2(theta0/2) + omega0^2/(4 w^2) and mc = 1 - m = cos^2(theta0/2) - omega0^2/(4 w^2), w^2 = g/L. The pendulum
swings for mc > 0, turns over for mc < 0 and creeps up to the top for mc = 0. For rational numbers mc = 0 means
theta0 = 0 and omega0^2 = 4 w^2, because the cosine of any other rational number is transcendental (Lindemann).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from math import ceil
from typing import Any, ClassVar

from gnomon.reference.numerics.elliptic import complete_first, incomplete_first, jacobi
from gnomon.reference.numerics.motion import Motion, decades
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.numerics.precision import working


@dataclass(frozen=True)
class Pendulum(Motion):
    """State (theta, omega), theta from the downward vertical (rad, unwrapped)."""

    g: Fraction
    length: Fraction
    theta0: Fraction
    omega0: Fraction

    LIBRATION: ClassVar[str] = "libration"
    ROTATION: ClassVar[str] = "rotation"
    SEPARATRIX: ClassVar[str] = "separatrix"
    REST: ClassVar[str] = "rest"

    @cached_property
    def regime(self) -> str:
        """libration, rotation, separatrix or rest."""
        if self.theta0 == 0 and self.omega0 == 0:
            return self.REST
        if self.theta0 == 0 and self.omega0**2 * self.length == 4 * self.g:
            return self.SEPARATRIX
        with working(15) as mp:
            return self.LIBRATION if self._moduli(mp)[1] > 0 else self.ROTATION

    def period(self, digits: int = 15) -> Any:
        """Time after which the state repeats, up to a turn of theta in rotation; infinite on the separatrix."""
        return self._quantity(digits, self._period, self._depth + 10)

    def modulus_squared(self, digits: int = 15) -> Any:
        """m = k^2, above 1 in rotation."""
        return self._quantity(digits, lambda mp: self._moduli(mp)[0])

    def complement(self, digits: int = 15) -> Any:
        """1 - m, below 0 in rotation, to `digits` significant digits."""
        return self._quantity(digits, lambda mp: self._moduli(mp)[1])

    def amplitude(self, digits: int = 15) -> Any:
        """The largest angle from the nearest downward vertical; pi where the pendulum reaches the top."""
        return self._quantity(digits, self._amplitude, self._depth + 10)

    def top_speed(self, digits: int = 15) -> Any:
        """|omega| at the bottom, 2 w k."""
        return self._quantity(digits, lambda mp: 2 * self._frequency(mp) * mp.sqrt(self._moduli(mp)[0]))

    def small_swing_period(self, digits: int = 15) -> Any:
        """2 pi sqrt(L/g)."""
        return self._quantity(digits, lambda mp: 2 * mp.pi / self._frequency(mp))

    def energy(self, digits: int = 15) -> Any:
        """Energy above the rest position, over mass and L^2: 2 w^2 m (1/s^2)."""
        return self._quantity(digits, lambda mp: 2 * mp.mpf(self.g / self.length) * self._moduli(mp)[0])

    def tension_lowest(self, digits: int = 15) -> Any:
        """Tension of the rod per unit mass at the bottom, g (1 + 4 m)."""
        return self._quantity(digits, lambda mp: mp.mpf(self.g) * (1 + 4 * self._moduli(mp)[0]))

    def tension_highest(self, digits: int = 15) -> Any:
        """Tension per unit mass at the highest point: g cos(amplitude) = g (1 - 2 m), in rotation g (4 m - 5)."""

        def formula(mp: Any) -> Any:
            m, mc = self._moduli(mp)
            return mp.mpf(self.g) * (mc - m if mc > 0 else -1 - 4 * mc)

        return self._quantity(digits, formula, 30)

    def _amplitude(self, mp: Any) -> Any:
        if self.regime in (self.ROTATION, self.SEPARATRIX):
            return +mp.pi
        m, mc = self._moduli(mp)
        return 2 * mp.atan2(mp.sqrt(m), mp.sqrt(mc))

    def _period(self, mp: Any) -> Any:
        w = self._frequency(mp)
        m, mc = self._moduli(mp)
        if self.regime == self.SEPARATRIX:
            return mp.inf
        if self.regime == self.ROTATION:
            return 2 * complete_first(mp, -mc / m) / (mp.sqrt(m) * w)
        return 4 * complete_first(mp, mc) / w

    def _cycle(self, mp: Any) -> Cycle | None:
        if self.regime in (self.SEPARATRIX, self.REST):
            return None
        turn = mp.zero if self.regime == self.LIBRATION else 2 * mp.pi * (1 if self.omega0 > 0 else -1)
        with mp.workdps(mp.dps + self._depth):
            return Cycle(self._period(mp), (turn, mp.zero))

    def _guard(self, t: Fraction) -> float:
        lost = decades(t * t * self.g / self.length + self.omega0**2 * t * t) / 2
        # In steps of 5, so that values that do not depend on t are cached at few precisions.
        return 15 + self._depth + 5 * ceil(lost / 5)

    @cached_property
    def _depth(self) -> float:
        """Digits lost to 1/sqrt(mc): in F next to the top, and in the phase that the error of F shifts."""
        if self.regime in (self.SEPARATRIX, self.REST):
            return 0.0
        with working(15) as mp:
            return max(0.0, -float(mp.log10(abs(self._moduli(mp)[1]))))

    def _frequency(self, mp: Any) -> Any:
        return mp.sqrt(mp.mpf(self.g / self.length))

    def _moduli(self, mp: Any) -> tuple[Any, Any]:
        """m and 1 - m, each to the full precision of `mp`: the precision is raised until the difference has it."""
        swing = self.omega0**2 * self.length / (4 * self.g)
        with mp.workprec(mp.prec + 20):
            half = mp.mpf(self.theta0) / 2
            m = mp.sin(half) ** 2 + mp.mpf(swing)
        wanted, extra = mp.prec, 20
        while True:
            with mp.workprec(wanted + extra):
                square = mp.cos(mp.mpf(self.theta0) / 2) ** 2
                mc = square - mp.mpf(swing)
                lost = mp.mag(square) - mp.mag(mc) if mc else (0 if self._level else wanted + extra)
                if lost + 10 <= extra:
                    break
            extra = 2 * extra
        return +m, +mc

    @property
    def _level(self) -> bool:
        """Whether it is exactly on the separatrix."""
        return self.theta0 == 0 and self.omega0**2 * self.length == 4 * self.g

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        if self.regime == self.REST:
            return mp.zero, mp.zero
        w = self._frequency(mp)
        time = mp.mpf(t)
        sign = 1 if self.omega0 > 0 else -1
        if self.regime == self.SEPARATRIX:
            # pi - theta = 4 atan(e^-x): no cancellation at the top.
            return sign * (mp.pi - 4 * mp.atan(mp.exp(-w * time))), sign * 2 * w * mp.sech(w * time)
        m, mc, turns, start = _start(self, mp, mp.prec)
        k = mp.sqrt(m)
        if self.regime == self.ROTATION:
            phi, _, _, dn = jacobi(mp, sign * k * w * time + start, -mc / m, 1 / m)
            return 2 * phi, sign * 2 * k * w * dn
        _, sn, cn, dn = jacobi(mp, w * time + start, mc, m)
        return turns + 2 * mp.atan2(k * sn, dn), 2 * k * w * cn


@lru_cache(maxsize=32)
def _start(motion: Pendulum, mp: Any, precision: int) -> tuple[Any, Any, Any, Any]:
    """m, 1 - m, the full turns in theta0 (rad; 0 in rotation) and the elliptic argument at the start."""
    m, mc = motion._moduli(mp)
    theta0, omega0 = mp.mpf(motion.theta0), mp.mpf(motion.omega0)
    if motion.regime == motion.ROTATION:
        return m, mc, mp.zero, incomplete_first(mp, theta0 / 2, -mc / m, 1 / m)
    turns = 2 * mp.pi * mp.nint(theta0 / (2 * mp.pi))
    k = mp.sqrt(m)
    phi = mp.atan2(mp.sin((theta0 - turns) / 2) / k, omega0 / (2 * motion._frequency(mp) * k))
    return m, mc, turns, incomplete_first(mp, phi, mc, m)
