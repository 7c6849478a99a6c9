"""x'^2 = f(x) with f of degree up to 4, by Biermann's formula, in balls: for irrational coefficients.

This is the formula of `weierstrass`, but with the start shifted to x = 0 and numerator and denominator kept apart,
so that a solution can pass through infinity (the tangent of half an angle does).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import flint

Quartic = Sequence[Any]
"""Five balls, the coefficient of x^0 first."""


class Weierstrass:
    """P(z; g2, g3) and its derivative, z real: Laurent's series at z/2^n, then duplication. DLMF 23.9, 23.10."""

    def __init__(self, g2: Any, g3: Any) -> None:
        self.g2, self.g3 = g2, g3
        size = max(_upper(g2) ** 0.25, _upper(g3) ** (1 / 6))
        self.scale = size * (1 + 2.0**-40)
        self.c: list[Any] = [g2 / 20, g3 / 28]

    def __call__(self, z: Any) -> tuple[Any, Any]:
        width = _upper(z) * self.scale
        halvings = max(0, math.ceil(math.log2(width)) + 2) if width else 0
        p, slope = self._laurent(z * flint.arb(2) ** -halvings, width / 2.0**halvings)
        for _ in range(halvings):
            curvature = 6 * p * p - self.g2 / 2
            ratio = curvature / slope
            doubled = ratio * ratio / 4 - 2 * p
            p, slope = doubled, -(slope + ratio * (doubled - p))
        return p, slope

    def _laurent(self, z: Any, width: float) -> tuple[Any, Any]:
        """z^-2 + sum of c_k z^(2k-2), k >= 2, and its derivative, with bounds of their tails.

        |c_k| <= s^2k/20 with s = `scale`, by induction over the recurrence; |z| s = `width` <= 1/4.
        """
        count = 3 if width == 0 else 3 + math.ceil(flint.ctx.prec / (-2 * math.log2(width)))
        while len(self.c) < count:
            k = len(self.c) + 2
            total = sum((self.c[m - 2] * self.c[k - m - 2] for m in range(2, k - 1)), flint.arb(0))
            self.c.append(3 * total / ((2 * k + 1) * (k - 3)))
        square = z * z
        p, slope = flint.arb(0), flint.arb(0)
        for k in range(count + 1, 1, -1):
            p = p * square + self.c[k - 2]
            slope = slope * square + (2 * k - 2) * self.c[k - 2]
        s, last = flint.arb(self.scale), count + 2
        tail = s**2 * flint.arb(width) ** (2 * last - 2) / 10
        tail_slope = s**3 * flint.arb(width) ** (2 * last - 3) * last / 4
        return (
            1 / square + p * square + flint.arb(0, tail.upper()),
            -2 / (square * z) + slope * z + flint.arb(0, tail_slope.upper()),
        )

    def real_period(self, degenerate: bool = False) -> Any:
        """The smallest real period; infinite (not finite) where there is none.

        `degenerate`: two roots of 4x^3 - g2 x - g3 are known to coincide away from the motion.
        """
        g2, g3 = self.g2, self.g3
        if degenerate:
            return flint.arb.pi() / (g2 * 3 / 4).sqrt().sqrt()  # e1 - e2 = 3 sqrt(g2/12)
        discriminant = g2**3 - 27 * g3**2
        if discriminant > 0:
            third = (g2 / 3).sqrt()
            angle = flint.arb.atan2((discriminant / 27).sqrt(), g3) / 3
            turn = 2 * flint.arb.pi() / 3
            e1, e2, e3 = (third * (angle + k * turn).cos() for k in (0, 2, 1))
            return flint.arb.pi() / (e1 - e3).sqrt().agm((e1 - e2).sqrt())
        if discriminant < 0:
            side = 1 if g3.mid() >= 0 else -1
            cube = abs(g3) / 8 + (-discriminant / 1728).sqrt()
            root = cube.root(3)
            e = side * (root + g2 / (12 * root))
            product = (3 * e * e - g2 / 4).sqrt()
            return flint.arb.pi() / ((3 * e + 2 * product).sqrt() / 2).agm(product.sqrt())
        return flint.arb.nan()


class FromZero:
    """x = top/bottom with x(0) = 0 and x'(0) = speed, speed^2 = f(0); x'' = f'(x)/2."""

    def __init__(self, f: Quartic, speed: Any) -> None:
        self.f, self.speed = f, speed
        b1, b2, b3 = f[3] / 4, f[2] / 6, f[1] / 4
        g2 = f[4] * f[0] - 4 * b1 * b3 + 3 * b2 * b2
        g3 = f[4] * b2 * f[0] + 2 * b1 * b2 * b3 - b2**3 - f[4] * b3 * b3 - b1 * b1 * f[0]
        self.elliptic = Weierstrass(g2, g3)

    def __call__(self, t: Any) -> tuple[Any, Any, Any, Any]:
        """top, bottom and their derivatives, all over P^2, at t != 0."""
        p, slope = self.elliptic(t)
        shifted = p - self.f[2] / 12
        top = -self.speed * slope + self.f[1] / 2 * shifted + self.f[0] * self.f[3] / 4
        bottom = 2 * shifted * shifted - self.f[0] * self.f[4] / 2
        top_rate = -self.speed * (6 * p * p - self.elliptic.g2 / 2) + self.f[1] / 2 * slope
        bottom_rate = 4 * shifted * slope
        return top, bottom, top_rate, bottom_rate


def _upper(x: Any) -> float:
    bound = float(abs(x).upper())
    return bound if math.isfinite(bound) else 1.0
