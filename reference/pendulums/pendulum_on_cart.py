"""A pendulum under a cart that is free to roll."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.precision import working
from gnomon.reference.numerics.well import WellMotion


@dataclass(frozen=True)
class Cart:
    """A pendulum (m, L) under a cart (M) that is free to roll: state (x, theta, x', theta')."""

    g: Fraction
    m: Fraction
    M: Fraction
    length: Fraction
    x: Fraction
    theta: Fraction
    vx: Fraction
    omega: Fraction


@dataclass(frozen=True)
class CartPendulum(Cart, WellMotion):
    """A pendulum under a cart: |theta| <= pi, swinging.

    The centre of mass moves uniformly; theta'^2 L (M + m sin^2 theta)/(M + m)/2 - g cos(theta) is constant.
    """

    @property
    def rests(self) -> bool:
        return self.theta == 0 and self.omega == 0

    @property
    def swings(self) -> bool:
        """Whether the energy is below the energy of the upright position, decided with 40 digits; False on the separatrix."""
        with working(40) as mp:
            return bool(self._energy(mp) < 2 * mp.mpf(self.g) * (1 - mp.mpf(10) ** -30))

    def _begin(self) -> tuple[Fraction, Fraction]:
        return self.theta, self.omega

    def _bottom(self, mp: Any) -> Any:
        return mp.zero

    def _walls(self, mp: Any) -> tuple[Any, Any]:
        return -mp.pi, +mp.pi

    def _mass(self, mp: Any, x: Any) -> Any:
        share = mp.mpf(self.m / (self.M + self.m))
        return mp.mpf(self.length) * (mp.mpf(self.M / (self.M + self.m)) + share * mp.sin(x) ** 2)

    def _potential(self, mp: Any, x: Any) -> Any:
        return 2 * mp.mpf(self.g) * mp.sin(x / 2) ** 2

    def _slope(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.g) * mp.sin(x)

    def _read(self, mp: Any, t: Fraction, x: Any, rate: Any, carried: Sequence[Any]) -> Sequence[Any]:
        arm = mp.mpf(self.m * self.length / (self.M + self.m))
        start, turn = mp.mpf(self.theta), mp.mpf(self.omega)
        drift = mp.mpf(self.vx) + arm * turn * mp.cos(start)
        place = mp.mpf(self.x) + arm * (mp.sin(start) - mp.sin(x)) + drift * mp.mpf(t)
        return place, x, drift - arm * rate * mp.cos(x), rate

    def _turned(self, mp: Any, carried: Sequence[Any], period: Any) -> Sequence[Any]:
        arm = mp.mpf(self.m * self.length / (self.M + self.m))
        drift = mp.mpf(self.vx) + arm * mp.mpf(self.omega) * mp.cos(mp.mpf(self.theta))
        return drift * period, mp.zero, mp.zero, mp.zero
