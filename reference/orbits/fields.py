"""Gravitation of simple bodies, in balls (Beatty, Dynamics, 5.6-5.10).

mu = G M; fields point towards the body along the named axes, potentials vanish at infinity.
"""

from __future__ import annotations

from typing import Any

import flint
from gnomon.reference.numerics.vectors import square


def rod_midplane(mu: Any, length: Any, d: Any) -> Any:
    """Attraction of a rod at distance d from its middle, perpendicular to it."""
    return mu / (d * (d * d + length * length / 4).sqrt())


def _ring_elliptic(a: Any, rho: Any, z: Any) -> tuple[Any, Any, Any, Any]:
    """K(m), E(m), the largest and the smallest distance squared, for a ring of radius a."""
    far = square(a + rho) + z * z
    near = square(a - rho) + z * z
    m = 4 * a * rho / far
    # K by the arithmetic-geometric mean of 1 and sqrt(1 - m), which has no cancellation here.
    K = flint.arb.pi() / 2 / flint.arb(1).agm((near / far).sqrt())
    E = flint.acb(m).elliptic_e().real
    return K, E, far, near


def ring_potential(mu: Any, a: Any, rho: Any, z: Any) -> Any:
    """Potential at (rho, z): -(2 mu/pi) K(m)/sqrt((a+rho)^2 + z^2), m = 4 a rho/((a+rho)^2 + z^2)."""
    K, _E, far, _near = _ring_elliptic(a, rho, z)
    return -2 * mu * K / (flint.arb.pi() * far.sqrt())


def ring_field(mu: Any, a: Any, rho: Any, z: Any) -> tuple[Any, Any]:
    """Acceleration at (rho, z): outward from the axis, and along z."""
    K, E, far, near = _ring_elliptic(a, rho, z)
    factor = mu / (flint.arb.pi() * far.sqrt())
    along = -2 * factor * z * E / near
    if rho.is_zero():
        return rho, along
    return -factor * (K - (a * a - rho * rho + z * z) / near * E) / rho, along


def disc_axis(mu: Any, a: Any, z: Any) -> Any:
    """Attraction of a disc at height z > 0 on its axis."""
    return 2 * mu / (a * a) * (1 - z / (a * a + z * z).sqrt())


def shell(mu: Any, a: Any, r: Any, outside: bool) -> tuple[Any, Any]:
    """Attraction and potential of a thin spherical shell at distance r from its centre."""
    return (mu / (r * r), -mu / r) if outside else (r * 0, -mu / a)


def sphere(mu: Any, a: Any, r: Any, outside: bool) -> tuple[Any, Any]:
    """Attraction and potential of a uniform solid sphere."""
    if outside:
        return mu / (r * r), -mu / r
    return mu * r / a**3, -mu * (3 * a * a - r * r) / (2 * a**3)
