"""Carlson's symmetric elliptic integrals and Legendre's third kind by them (DLMF 19.16, 19.25.14).

Evaluated in python-flint's balls, a hundred times faster than in mpmath; a ball that is too wide is evaluated again in
higher precision. `mp` is the mpmath context to whose precision results are rounded.
"""

from __future__ import annotations

from typing import Any

import flint
from gnomon.reference.numerics.balls import as_ball, dyadic
from mpmath.libmp import from_man_exp, round_nearest


def rf(mp: Any, x: Any, y: Any, z: Any) -> Any:
    """R_F(x, y, z) for nonnegative arguments, at most one of them zero."""
    return _rounded(mp, flint.acb.elliptic_rf, (x, y, z))


def rj(mp: Any, x: Any, y: Any, z: Any, p: Any) -> Any:
    """R_J(x, y, z, p) for nonnegative x, y, z, at most one of them zero, and p > 0."""
    return _rounded(mp, flint.acb.elliptic_rj, (x, y, z, p))


def third(mp: Any, n: Any, phase: Any, mc: Any) -> Any:
    """Pi(n; phase | m) for n < 0 and any real phase, from mc = 1 - m > 0; loses the digits of 1 - n."""
    turns = mp.nint(phase / mp.pi)
    rest = phase - turns * mp.pi
    total = mp.mpf(0)
    if turns:
        total = 2 * turns * (rf(mp, 0, mc, 1) + n / 3 * rj(mp, 0, mc, 1, 1 - n))
    if not rest:
        return total
    s, c = mp.sin(rest), mp.cos(rest)
    s2, c2 = s * s, c * c
    delta = c2 + mc * s2  # 1 - m s^2
    return total + s * rf(mp, c2, delta, 1) + n / 3 * s * s2 * rj(mp, c2, delta, 1, c2 + (1 - n) * s2)


def _rounded(mp: Any, function: Any, arguments: tuple[Any, ...]) -> Any:
    extra = 30
    while True:
        with flint.ctx.workprec(mp.prec + extra):
            ball = function(*(flint.acb(as_ball(mp.mpf(argument))) for argument in arguments)).real
            if ball.is_finite() and ball.rel_accuracy_bits() > mp.prec + 2:
                return mp.make_mpf(from_man_exp(*dyadic(ball), mp.prec, round_nearest))
        extra *= 2
        if extra > 100_000:
            raise ArithmeticError(f"{function.__name__} does not settle at {', '.join(map(str, arguments))}")
