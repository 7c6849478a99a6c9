"""Quadrature in high precision, to verify closed forms.

Gauss-Legendre nodes come from python-flint. Next to a near-singular point the variable is replaced by delta sinh(u),
delta being the distance of the singularity: the integrand then varies on a scale of about 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any

import flint
from gnomon.reference.numerics.balls import precision


@lru_cache(maxsize=64)
def _nodes(count: int, bits: int) -> tuple[tuple[tuple[int, int], tuple[int, int]], ...]:
    with precision(bits + 20):
        pairs = [flint.arb.legendre_p_root(count, k, weight=True) for k in range(count)]
        return tuple((_dyadic(x), _dyadic(w)) for x, w in pairs)


def _dyadic(x: Any) -> tuple[int, int]:
    mantissa, exponent = x.mid().man_exp()
    return int(mantissa), int(exponent)


def gauss_legendre(mp: Any, low: Any, high: Any, count: int) -> list[tuple[Any, Any]]:
    """`count` nodes and weights on [low, high]; exact for polynomials of degree 2 count - 1."""
    middle, half = (mp.mpf(low) + high) / 2, (mp.mpf(high) - low) / 2
    return [(middle + half * mp.mpf(x), half * mp.mpf(w)) for x, w in _nodes(count, mp.prec)]


def integral(mp: Any, f: Callable[[Any], Any], edges: Sequence[Any], nodes_per_digit: float = 0.8) -> Any:
    """The integral of a function that is smooth between the edges, by one Gauss-Legendre rule on each piece.

    The error falls by a constant factor with each node, hence nodes in proportion to digits; the factor depends on how
    far around the piece the integrand is analytic. A vector-valued f gives a list.
    """
    count = math.ceil(nodes_per_digit * mp.dps)
    total: Any = None
    for low, high in pairwise(edges):
        for x, weight in gauss_legendre(mp, low, high, count):
            value = f(x)
            if isinstance(value, (list, tuple)):
                total = [weight * v + (t or 0) for v, t in zip(value, total or [0] * len(value), strict=True)]
            else:
                total = weight * value + (total or 0)
    return total


def unit_steps(low: Any, high: Any) -> list[Any]:
    """Edges from low to high, at most 1 apart."""
    pieces = max(1, math.ceil(high - low))
    return [low + (high - low) * k / pieces for k in range(pieces + 1)]


def integral_near(mp: Any, f: Callable[[Any], Any], low: Any, high: Any, centre: Any, delta: Any) -> Any:
    """The integral over [low, high] of a function with a singularity at the complex point centre +- i delta."""
    begin, end = (mp.asinh((x - centre) / delta) for x in (low, high))

    def stretched(u: Any) -> Any:
        x, jacobian = centre + delta * mp.sinh(u), delta * mp.cosh(u)
        value = f(x)
        return [v * jacobian for v in value] if isinstance(value, (list, tuple)) else value * jacobian

    return integral(mp, stretched, unit_steps(begin, end))
