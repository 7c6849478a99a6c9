"""Motions of one coordinate in a potential well: bead on a curve, central motion, cart with pendulum, rubber tube."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.numerics.precision import working
from gnomon.reference.numerics.well import WellMotion


@dataclass(frozen=True)
class ThickTube(WellMotion):
    """Knowles' radial oscillation of a thick incompressible tube: state (x, v), x > 0 (Beatty, Dynamics, 6.13.2).

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


@dataclass(frozen=True)
class Curve(WellMotion):
    """A bead on a smooth curve y(x) that is even and convex: state (q, q'), q = x or the arc length."""

    g: Fraction
    size: Fraction
    q0: Fraction
    v0: Fraction

    @property
    def rests(self) -> bool:
        return self.q0 == 0 and self.v0 == 0

    def _begin(self) -> tuple[Fraction, Fraction]:
        return self.q0, self.v0

    def _bottom(self, mp: Any) -> Any:
        return mp.zero

    def _read(self, mp: Any, t: Fraction, x: Any, rate: Any, carried: Sequence[Any]) -> Sequence[Any]:
        return x, rate

    def _turned(self, mp: Any, carried: Sequence[Any], period: Any) -> Sequence[Any]:
        return mp.zero, mp.zero


@dataclass(frozen=True)
class Parabola(Curve):
    """y = x^2/(4 p), p the focal length; q = x."""

    def _mass(self, mp: Any, x: Any) -> Any:
        return 1 + (x / (2 * mp.mpf(self.size))) ** 2

    def _potential(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.g) * x**2 / (4 * mp.mpf(self.size))

    def _slope(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.g) * x / (2 * mp.mpf(self.size))


@dataclass(frozen=True)
class Quartic(Curve):
    """y = x^4/a^3; q = x."""

    def _mass(self, mp: Any, x: Any) -> Any:
        return 1 + 16 * (x / mp.mpf(self.size)) ** 6

    def _potential(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.g) * x**4 / mp.mpf(self.size) ** 3

    def _slope(self, mp: Any, x: Any) -> Any:
        return 4 * mp.mpf(self.g) * x**3 / mp.mpf(self.size) ** 3


@dataclass(frozen=True)
class Catenary(Curve):
    """y = c cosh(x/c) = sqrt(c^2 + s^2); q = s, the arc length. V = g (y - c)."""

    def _potential(self, mp: Any, x: Any) -> Any:
        c = mp.mpf(self.size)
        return mp.mpf(self.g) * x**2 / (mp.hypot(c, x) + c)

    def _slope(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self.g) * x / mp.hypot(mp.mpf(self.size), x)


@dataclass(frozen=True)
class Central(WellMotion):
    """r'' = r theta'^2 - U'(r), theta'' = -2 r' theta'/r; state (r, theta, r', theta'), r > 0, theta' not zero.

    V = h^2/(2 r^2) b + U with h = r^2 theta'; a subclass states U, its slope, and b, the rotating fraction of the mass.
    """

    r: Fraction
    theta: Fraction
    vr: Fraction
    omega: Fraction

    def _turning(self) -> Fraction:
        return Fraction(1)

    def _pull(self, mp: Any, r: Any) -> Any:
        raise NotImplementedError

    def _pull_slope(self, mp: Any, r: Any) -> Any:
        raise NotImplementedError

    @cached_property
    def spin(self) -> Fraction:
        """h = r^2 theta'."""
        return self.r**2 * self.omega

    @cached_property
    def _barrier(self) -> Fraction:
        return self._turning() * self.spin**2

    def _begin(self) -> tuple[Fraction, Fraction]:
        return self.r, self.vr

    def _walls(self, mp: Any) -> tuple[Any, Any]:
        return mp.zero, mp.inf

    def _potential(self, mp: Any, x: Any) -> Any:
        return mp.mpf(self._barrier) / (2 * x**2) + self._pull(mp, x)

    def _slope(self, mp: Any, x: Any) -> Any:
        return self._pull_slope(mp, x) - mp.mpf(self._barrier) / x**3

    def _carried(self, mp: Any, x: Any) -> tuple[Any, ...]:
        return (mp.mpf(self.spin) / x**2,)

    def _read(self, mp: Any, t: Fraction, x: Any, rate: Any, carried: Sequence[Any]) -> Sequence[Any]:
        return x, mp.mpf(self.theta) + carried[0], rate, mp.mpf(self.spin) / x**2

    def _turned(self, mp: Any, carried: Sequence[Any], period: Any) -> Sequence[Any]:
        return mp.zero, carried[0], mp.zero, mp.zero


@dataclass(frozen=True)
class HangingMass(Central):
    """m1 on a smooth table, on a string through a hole to m2: (m1 + m2) r'' = m1 r theta'^2 - m2 g (Beatty 7.8)."""

    g: Fraction
    m1: Fraction
    m2: Fraction

    @cached_property
    def weight(self) -> Fraction:
        return self.m2 * self.g / (self.m1 + self.m2)

    @property
    def rests(self) -> bool:
        """Whether the motion is a circle."""
        return self.vr == 0 and self.m1 * self.r * self.omega**2 == self.m2 * self.g

    def _turning(self) -> Fraction:
        return self.m1 / (self.m1 + self.m2)

    def _bottom(self, mp: Any) -> Any:
        return mp.cbrt(mp.mpf(self._turning() * self.spin**2 / self.weight))

    def _pull(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.weight) * r

    def _pull_slope(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.weight)


@dataclass(frozen=True)
class Logarithmic(Central):
    """The attraction k/r: U = k ln(r)."""

    k: Fraction

    @property
    def rests(self) -> bool:
        return self.vr == 0 and (self.r * self.omega) ** 2 == self.k

    def _bottom(self, mp: Any) -> Any:
        return abs(mp.mpf(self.spin)) / mp.sqrt(mp.mpf(self.k))

    def _pull(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.k) * mp.log(r)

    def _pull_slope(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.k) / r


@dataclass(frozen=True)
class SpringDumbbell(Central):
    """Two masses on a spring of natural length l, relative to one: r'' = r theta'^2 - (k/mu)(r - l) (Beatty 8.6)."""

    stiffness: Fraction
    length: Fraction

    @property
    def rests(self) -> bool:
        return self.vr == 0 and self.r * self.omega**2 == self.stiffness * (self.r - self.length)

    def _bottom(self, mp: Any) -> Any:
        """r^3 (r - l) = h^2/(k/mu): Newton's method from above, where it is convex."""
        size, length = mp.mpf(self.spin**2 / self.stiffness), mp.mpf(self.length)
        r = length + mp.root(size, 4)
        for _ in range(200):
            step = (r**3 * (r - length) - size) / (4 * r**3 - 3 * length * r**2)
            r -= step
            if abs(step) <= 8 * mp.eps * r:
                break
        return r

    def _pull(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.stiffness) * (r - mp.mpf(self.length)) ** 2 / 2

    def _pull_slope(self, mp: Any, r: Any) -> Any:
        return mp.mpf(self.stiffness) * (r - mp.mpf(self.length))


@dataclass(frozen=True)
class CartPendulum(WellMotion):
    """A pendulum (m, L) under a cart (M) that is free to roll: state (x, theta, x', theta'), |theta| <= pi, swinging.

    The centre of mass moves uniformly; theta'^2 L (M + m sin^2 theta)/(M + m)/2 - g cos(theta) is constant.
    """

    g: Fraction
    m: Fraction
    M: Fraction
    length: Fraction
    x: Fraction
    theta: Fraction
    vx: Fraction
    omega: Fraction

    @property
    def rests(self) -> bool:
        return self.theta == 0 and self.omega == 0

    @property
    def swings(self) -> bool:
        """Whether the energy is below that of the upright position, decided with 40 digits; False on the separatrix."""
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
