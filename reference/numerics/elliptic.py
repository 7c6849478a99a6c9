"""Jacobi's elliptic functions and Legendre's integrals by the arithmetic-geometric mean.

Every function takes the complementary parameter mc = 1 - m (m = k^2, 0 < mc), formed by the caller without
cancellation: m itself loses the digits that matter next to a separatrix. The amplitude is continuous in u: it is not
reduced to one period. `mp` is an mpmath context; results have its precision less the digits of 2**N u and 1/sqrt(mc).
DLMF 22.20(ii), 19.8(i), 19.22.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any


def means(mp: Any, mc: Any, m: Any) -> tuple[list[Any], list[Any], list[Any]]:
    """The arithmetic-geometric mean from (1, sqrt(mc), sqrt(m)) until c is negligible at the working precision."""
    return _means(mp, mc, m, mp.prec)


@lru_cache(maxsize=32)
def _means(mp: Any, mc: Any, m: Any, precision: int) -> tuple[list[Any], list[Any], list[Any]]:
    """Cached, because a motion needs the same means at every time."""
    a, b, c = [mp.one], [mp.sqrt(mc)], [mp.sqrt(m)]
    while abs(c[-1]) > abs(a[-1]) * mp.eps:
        x, y = a[-1], b[-1]
        a.append((x + y) / 2)
        b.append(mp.sqrt(x * y))
        # c_{n+1} = (a_n - b_n)/2 = c_n^2 / (4 a_{n+1}): the second form does not cancel.
        c.append(c[-1] ** 2 / (4 * a[-1]))
    return a, b, c


def complete_first(mp: Any, mc: Any) -> Any:
    """K = pi / (2 agm(1, sqrt(mc)))."""
    return mp.pi / (2 * mp.agm(1, mp.sqrt(mc)))


def incomplete_first(mp: Any, phi: Any, mc: Any, m: Any) -> Any:
    """F(phi | m) for any real phi, by Landen's transformation; loses log10(1/sqrt(mc)) digits near pi/2."""
    a, b, _ = means(mp, mc, m)
    for x, y in zip(a[:-1], b[:-1], strict=True):
        sine, cosine = mp.sin(phi), mp.cos(phi)
        # tan(next - phi) = (b/a) tan(phi), written as a difference of angles so that no branch is chosen.
        phi = 2 * phi - mp.atan((x - y) * sine * cosine / (x * cosine**2 + y * sine**2))
    return phi / (2 ** (len(a) - 1) * a[-1])


def amplitude(mp: Any, u: Any, mc: Any, m: Any) -> Any:
    """am(u | m), continuous in u."""
    a, _, c = means(mp, mc, m)
    phi = 2 ** (len(a) - 1) * a[-1] * u
    for x, z in zip(reversed(a[1:]), reversed(c[1:]), strict=True):
        phi = (phi + mp.asin(z / x * mp.sin(phi))) / 2
    return phi


def jacobi(mp: Any, u: Any, mc: Any, m: Any) -> tuple[Any, Any, Any, Any]:
    """am, sn, cn, dn of u; dn without cancellation where m is near 1."""
    phi = amplitude(mp, u, mc, m)
    sine, cosine = mp.sin(phi), mp.cos(phi)
    return phi, sine, cosine, mp.sqrt(cosine**2 + mc * sine**2)
