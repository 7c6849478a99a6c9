"""Universal functions of the Kepler problem and the root of Kepler's equation in them.

U_k = chi^k c_k(alpha chi^2) with Stumpff's functions c_k; sqrt(mu) t = r0 U1 + s0 U2 + U3. Laguerre's method on it is
Conway's (Celest. Mech. 39, 1986). `mp` is the mpmath context to work in.
"""

from __future__ import annotations

from typing import Any


def universal_functions(mp: Any, alpha: Any, chi: Any) -> tuple[Any, Any, Any, Any]:
    """U0..U3 with U_k = chi^k c_k(alpha chi^2), c_k Stumpff's functions."""
    z = alpha * chi * chi
    if abs(z) < 1:
        c2, c3 = _stumpff_series(mp, z)
        u2, u3 = chi * chi * c2, chi * chi * chi * c3
        return 1 - alpha * u2, chi - alpha * u3, u2, u3
    w = mp.sqrt(abs(alpha))
    half = w * chi / 2
    if z > 0:
        s, c = mp.sin(half), mp.cos(half)
        sign = 1
    else:
        s, c = mp.sinh(half), mp.cosh(half)
        sign = -1
    u1, u2 = 2 * s * c / w, 2 * s * s / abs(alpha)
    return 1 - sign * 2 * s * s, u1, u2, (chi - u1) / alpha


def _stumpff_series(mp: Any, z: Any) -> tuple[Any, Any]:
    """c2 and c3 for |z| < 1."""
    c2 = c3 = mp.mpf(0)
    a, b, k = mp.mpf(1) / 2, mp.mpf(1) / 6, 2
    while abs(a) > mp.eps / 4:
        c2 += a
        c3 += b
        a *= -z / ((k + 1) * (k + 2))
        b *= -z / ((k + 2) * (k + 3))
        k += 2
    return c2, c3


def laguerre_step(mp: Any, r0: Any, alpha: Any, s0: Any, target: Any, u: tuple[Any, Any, Any, Any]) -> Any:
    """Laguerre's step (n = 5) for F(chi) = r0 U1 + s0 U2 + U3 - target."""
    u0, u1, u2, u3 = u
    value, slope = r0 * u1 + s0 * u2 + u3 - target, r0 * u0 + s0 * u1 + u2
    curvature = s0 * u0 + (1 - alpha * r0) * u1
    spread = mp.sqrt(abs(16 * slope * slope - 20 * value * curvature))
    below = slope + spread
    return 5 * value / below if below else mp.mpf(0)


def rough_root(mp: Any, r0: Any, alpha: Any, s0: Any, target: Any) -> Any:
    """The root of F for a target >= 0 to about 10 digits: Laguerre's method within a shrinking bracket."""
    low, high = mp.mpf(0), _bound(mp, r0, alpha, s0, target)
    chi = min(target * alpha, high) if alpha > 0 else high
    for k in range(200):
        u = universal_functions(mp, alpha, chi)
        value = r0 * u[1] + s0 * u[2] + u[3] - target
        low, high = (chi, high) if value < 0 else (low, chi)
        new = chi - laguerre_step(mp, r0, alpha, s0, target, u)
        if not low <= new <= high or (k > 20 and k % 2):  # far out on a hyperbola each step changes w chi by 5/3 only
            new = (low + high) / 2
        converged = abs(new - chi) <= abs(new) * mp.mpf("1e-10")
        chi = new
        if converged:
            break
    return chi


def _bound(mp: Any, r0: Any, alpha: Any, s0: Any, target: Any) -> Any:
    """An upper bound of the root: a turn of an ellipse; else from U3 <= target, beyond a pericentre that is ahead."""
    if alpha > 0:
        return 2 * mp.pi / mp.sqrt(alpha)
    bound = mp.cbrt(6 * target)  # from U3 >= chi^3 / 6
    w = mp.sqrt(-alpha)
    if w:  # w^3 U3 = sinh(w chi) - w chi >= sinh(w chi) / 2 from w chi = 2.2 on
        bound = min(bound, max(mp.mpf(11) / 5, mp.asinh(2 * target * w**3)) / w)
    if s0 >= 0:
        return min(bound, target / r0)
    if not w:
        return bound - s0
    # e sinh(w chi) = -s0 w at the pericentre, where e cosh(w chi) = 1 - alpha r0; their quotient may round to 1
    eccentricity = mp.sqrt(max(mp.one, (1 - alpha * r0) ** 2 - (w * s0) ** 2))
    return bound + mp.asinh(-s0 * w / eccentricity) / w
