"""Radial oscillation of a rubber tube whose wall has any thickness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.precision import working
from gnomon.reference.numerics.well import WellMotion


@dataclass(frozen=True)
class ThickTube(WellMotion):
    """Knowles' radial oscillation of a thick incompressible tube: state (x, v), x > 0.

    M = x^2 ln(1 + gam/x^2), V = (w^2/2)(x^2 - 1) ln(x^2 (1 + gam)/(x^2 + gam)) - p (x^2 - 1)/2 under an inner pressure,
    p < w^2 ln(1 + gam).
    """

    gam: Fraction
    w: Fraction
    x0: Fraction
    v0: Fraction
    p: Fraction = Fraction(0)

    @property
    def rests(self) -> bool:
        """Whether x stays at 1; under pressure the equilibrium is at no rational stretch."""
        return self.x0 == 1 and self.v0 == 0 and self.p == 0

    @property
    def holds(self) -> bool:
        """Whether the wall bears the pressure: p < w^2 ln(1 + gam), decided with 40 digits."""
        with working(40) as mp:
            return bool(mp.mpf(self.p) < mp.mpf(self.w) ** 2 * mp.log1p(mp.mpf(self.gam)))

    def balance(self, digits: int = 15) -> Any:
        """The equilibrium stretch."""
        return self._quantity(digits, self._bottom, 30)

    def _begin(self) -> tuple[Fraction, Fraction]:
        return self.x0, self.v0

    def _bottom(self, mp: Any) -> Any:
        """The root of V'/(w^2 x), monotone in x^2: bisection in the logarithm of x^2, then Newton's method."""
        if self.p == 0:
            return mp.one
        gam, wanted = mp.mpf(self.gam), mp.mpf(self.p / self.w**2)

        def excess(square: Any) -> Any:
            less = square - 1
            return mp.log1p(gam * less / (square + gam)) + less * gam / (square * (square + gam)) - wanted

        low = high = mp.one
        while excess(low) > 0:
            low /= 4
        while excess(high) < 0:
            high *= 4
        for _ in range(60):
            middle = mp.sqrt(low * high)
            low, high = (middle, high) if excess(middle) < 0 else (low, middle)
        square = mp.sqrt(low * high)
        for _ in range(60):
            total = square * (square + gam)
            slope = gam / total + gam / total - gam * (square - 1) * (2 * square + gam) / total**2
            step = excess(square) / slope
            square -= step
            if abs(step) <= 8 * mp.eps * square:
                break
        return mp.sqrt(square)

    def _walls(self, mp: Any) -> tuple[Any, Any]:
        return mp.zero, mp.inf

    def _mass(self, mp: Any, x: Any) -> Any:
        return x**2 * mp.log1p(mp.mpf(self.gam) / x**2)

    def _potential(self, mp: Any, x: Any) -> Any:
        gam, less = mp.mpf(self.gam), x**2 - 1
        return less / 2 * (mp.mpf(self.w) ** 2 * mp.log1p(gam * less / (x**2 + gam)) - mp.mpf(self.p))

    def _slope(self, mp: Any, x: Any) -> Any:
        gam, less = mp.mpf(self.gam), x**2 - 1
        square = x**2 + gam
        wall = mp.mpf(self.w) ** 2 * (x * mp.log1p(gam * less / square) + less * gam / (x * square))
        return wall - mp.mpf(self.p) * x

    def _read(self, mp: Any, t: Fraction, x: Any, rate: Any, carried: Sequence[Any]) -> Sequence[Any]:
        return x, rate

    def _turned(self, mp: Any, carried: Sequence[Any], period: Any) -> Sequence[Any]:
        return mp.zero, mp.zero
