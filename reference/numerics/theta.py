"""Jacobi's elliptic functions as quotients of theta functions, in balls; independent of the means in `elliptic`.

DLMF 20.2, 22.2. The start of a motion enters by the addition theorems (DLMF 22.8), so that no integral of the first
kind is inverted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import flint

WIDE = flint.arb(2) ** -60
"""Radius below which a ball holds rounding errors only; a wider one is a subinterval of an integral."""
MOST_EVALUATIONS = 200_000


class Values(NamedTuple):
    """sn, cn and dn of one argument."""

    sn: Any
    cn: Any
    dn: Any


class Jacobi:
    """The functions of one parameter m in [0, 1], given as balls of m and of 1 - m; `limit` where m is exactly 1."""

    def __init__(self, m: Any, mc: Any, limit: bool = False) -> None:
        self.m, self.limit = m, limit
        if limit:
            return
        one = flint.acb(1)
        self.quarter = flint.acb.elliptic_rf(flint.acb(0), flint.acb(mc), one).real
        other = flint.acb.elliptic_rf(flint.acb(0), flint.acb(m), one).real
        self.tau = flint.acb(0, other / self.quarter)
        _, second, third, fourth = flint.acb(0).modular_theta(self.tau)
        self.scales = third / second, fourth / second, fourth / third

    def at(self, u: Any) -> Values:
        """The functions of a ball u, real or complex; the results are complex balls.

        On a wide ball the mean value form is narrower than the quotients: sn' = cn dn, cn' = -sn dn, dn' = -m sn cn.
        """
        u = flint.acb(u)
        wide = self._quotients(u)
        if max(u.real.rad(), u.imag.rad()) < WIDE:
            return wide
        (s, c, d), off = self._quotients(u.mid()), u - u.mid()
        return Values(s + off * wide.cn * wide.dn, c - off * wide.sn * wide.dn, d - off * self.m * wide.sn * wide.cn)

    def _quotients(self, u: Any) -> Values:
        if self.limit:
            return Values(u.tanh(), u.sech(), u.sech())
        first, second, third, fourth = (u / (2 * self.quarter)).modular_theta(self.tau)
        a, b, c = self.scales
        return Values(a * first / fourth, b * second / fourth, c * third / fourth)

    def shifted(self, start: Values, u: Any) -> Values:
        """The functions of a + u, where `start` holds the functions of a."""
        s, c, d = start
        x, y, z = self.at(u)
        under = 1 - self.m * s * s * x * x
        return Values(
            (s * y * z + x * c * d) / under, (c * y - s * d * x * z) / under, (d * z - self.m * s * c * x * y) / under
        )

    def argument(self, values: Values) -> Any:
        """The argument between -2K and 2K that has these real values. DLMF 19.25.5."""
        s, c, d = values
        if self.limit:
            return (s / c).asinh()
        within = (s * flint.acb.elliptic_rf(flint.acb(c * c), flint.acb(d * d), flint.acb(1))).real
        return within if not c < 0 else (2 if s > 0 else -2) * self.quarter - within


def integral(rate: Callable[[Any], Any], end: Any, digits: int) -> Any:
    """The integral of a meromorphic function, real on the real axis, from 0 to a ball `end`, proved to about `digits`.

    The ball is wide, or not finite, where the current precision is not enough.
    """
    small = flint.arb(10) ** -digits
    value = flint.acb.integral(lambda s, _: rate(s), 0, end, rel_tol=small, abs_tol=small, eval_limit=MOST_EVALUATIONS)
    return value.real


def accumulated(rate: Callable[[Any], Any], time: Any, period: Any | None, digits: int) -> Any:
    """The integral of a rate from 0 to `time`; whole periods are a multiple of one."""
    if period is None:
        return integral(rate, time, digits)
    if not period.is_finite():
        return flint.arb.nan()
    whole = turns(time / period)
    rest = integral(rate, time - whole * period, digits)
    return rest + whole * integral(rate, period, digits + len(str(whole))) if whole else rest


def turns(x: Any) -> int:
    """The floor of the midpoint of a ball, 0 if it is not finite; next to an integer either neighbour serves."""
    return int(x.mid().floor().unique_fmpz()) if x.is_finite() else 0


def reals(values: Values) -> Values:
    """The real parts."""
    return Values(*(x.real for x in values))
