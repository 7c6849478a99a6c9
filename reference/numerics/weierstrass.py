"""x'^2 = f(x) with f of degree up to 4, from any start and in every regime, by Biermann's formula.

Biermann (1865) in Greenhill's form (Whittaker and Watson 20.6) writes x(t) with Weierstrass's P function of the two
invariants of f. The roots of f are not needed, so that separatrices and double roots are not special cases.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

from gnomon.reference.numerics.precision import Number, exact

Quartic = tuple[Fraction, Fraction, Fraction, Fraction, Fraction]
"""Coefficients of f, the constant first."""


def invariants(f: Quartic) -> tuple[Fraction, Fraction]:
    """g2 and g3 of a quartic a0 x^4 + 4 b1 x^3 + 6 b2 x^2 + 4 b3 x + a4."""
    a4, b3, b2, b1, a0 = f[0], f[1] / 4, f[2] / 6, f[3] / 4, f[4]
    g2 = a0 * a4 - 4 * b1 * b3 + 3 * b2**2
    g3 = a0 * b2 * a4 + 2 * b1 * b2 * b3 - b2**3 - a0 * b3**2 - b1**2 * a4
    return g2, g3


def weierstrass(mp: Any, z: Any, g2: Any, g3: Any) -> tuple[Any, Any]:
    """P(z; g2, g3) and P'(z), z real, not a pole: Laurent's series at z/2^n, then duplication. DLMF 23.9, 23.10.

    Each duplication loses up to 2 bits, more where P' is small; they are added to the working precision here.
    """
    scale = max(abs(g2) ** mp.mpf("0.25"), abs(g3) ** (mp.one / 6))
    halvings = max(0, int(mp.mag(abs(z) * scale)) + 2) if scale else 0
    with mp.workprec(mp.prec + 4 * halvings + 40):
        small = z / 2**halvings
        p, slope = _laurent(mp, small, g2, g3)
        for _ in range(halvings):
            curvature = 6 * p**2 - g2 / 2
            ratio = curvature / slope
            doubled = ratio**2 / 4 - 2 * p
            p, slope = doubled, -(slope + ratio * (doubled - p))
    return +p, +slope


def _laurent(mp: Any, z: Any, g2: Any, g3: Any) -> tuple[Any, Any]:
    """z^-2 + sum of c_k z^(2k-2), k >= 2, and its derivative."""
    square = z * z
    c = _coefficients(g2, g3, mp.prec)
    p, slope = 1 / square, -2 / square
    power, negligible, k = mp.one, 0, 2
    # With g2 or g3 zero only every third or second term is not zero: three in a row must be negligible.
    while negligible < 3:
        if k - 2 == len(c):
            total = mp.fsum(c[m - 2] * c[k - m - 2] for m in range(2, k - 1))
            c.append(3 * total / ((2 * k + 1) * (k - 3)))
        power *= square
        term = c[k - 2] * power
        p += term
        slope += (2 * k - 2) * term
        negligible = negligible + 1 if abs(term) < mp.eps * abs(p) else 0
        k += 1
    return p, slope / z


@lru_cache(maxsize=16)
def _coefficients(g2: Any, g3: Any, precision: int) -> list[Any]:
    """The list c_2, c_3, ... for one pair of invariants at one precision; callers extend it."""
    return [g2 / 20, g3 / 28]


def solve_quartic(mp: Any, f: Quartic, x0: Number, v0: Number, t: Any) -> tuple[Any, Any]:
    """x(t) and x'(t) of x'^2 = f(x) with x(0) = x0 and x'(0) = v0, where f(x0) = v0^2 (of either sign).

    x'' = f'(x)/2 decides the motion at a turning point. The caller supplies guard digits for the cancellation, which
    grows next to a separatrix and towards t = 0.
    """
    start = exact(x0)
    speed = mp.mpf(exact(v0))
    if t == 0:
        return mp.mpf(start), speed
    value = _derivative(f, 0, start)
    first, second, third, fourth = (mp.mpf(_derivative(f, n, start)) for n in (1, 2, 3, 4))
    g2, g3 = (mp.mpf(g) for g in invariants(f))
    p, slope = weierstrass(mp, t, g2, g3)
    shifted = p - second / 24
    top = -speed * slope + first / 2 * shifted + mp.mpf(value) * third / 24
    bottom = 2 * shifted**2 - mp.mpf(value) * fourth / 48
    top_rate = -speed * (6 * p**2 - g2 / 2) + first / 2 * slope
    bottom_rate = 4 * shifted * slope
    return mp.mpf(start) + top / bottom, (top_rate * bottom - top * bottom_rate) / bottom**2


def _derivative(f: Sequence[Fraction], n: int, x: Fraction) -> Fraction:
    total = Fraction(0)
    for power in range(len(f) - 1, n - 1, -1):
        factor = 1
        for i in range(n):
            factor *= power - i
        total = total * x + f[power] * factor
    return total
