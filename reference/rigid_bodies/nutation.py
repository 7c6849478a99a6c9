"""The nutation of a heavy symmetric top, in balls: u = cos(theta) by Jacobi's functions, phi and psi by Carlson's.

u'^2 = f(u) = (2/I1) (E - W u) (1 - u^2) - (b - a u)^2/I1^2, with the roots u1 <= u <= u2 <= u3. Sum and
difference of precession and spin have one pole each: (phi + psi)' = a (1/I3 - 1/I1) + (b + a)/(I1 (1 + u)) and
(phi - psi)' = a (1/I1 - 1/I3) + (b - a)/(I1 (1 - u)). For b = a the top can pass through the vertical, for b = -a
through the lowest point; c = cos(theta/2) and s = sin(theta/2) have signs, so that theta is continuous there.
Whittaker, Analytical Dynamics, section 71. The caller chooses the formula, on exact numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cmp_to_key
from itertools import pairwise
from typing import Any

import flint
from gnomon.reference.numerics.balls import nearest_integer


@dataclass(frozen=True)
class Start:
    """A top in balls: I1, W > 0, the momenta a and b conjugate to spin and precession, E, u and u'.

    Decided on exact numbers: `up` b = a; `down` b = -a; `still` u' = 0 (off the poles); `pole` = u where u is exactly
    +1 or -1, else 0; `steady` a relative equilibrium; `homoclinic` b = a and E = W, the motion from or to the vertical.
    """

    moment: Any
    weight: Any
    a: Any
    b: Any
    energy: Any
    u: Any
    rate: Any
    up: bool = False
    down: bool = False
    still: bool = False
    pole: int = 0
    steady: bool = False
    homoclinic: bool = False


@dataclass(frozen=True)
class TiltState:
    """c = cos(theta/2) and s = sin(theta/2) with their signs, theta' as `rate`, and two integrals over time.

    `plus` belongs to (b + a)/(I1 (1 + u)), `minus` to (b - a)/(I1 (1 - u)).
    """

    c: Any
    s: Any
    rate: Any
    plus: Any
    minus: Any


class Steady:
    """The motion with constant theta."""

    def __init__(self, start: Start) -> None:
        self.start = start

    def at(self, t: Any) -> TiltState:
        top = self.start
        zero, one = flint.arb(0), flint.arb(1)
        c = zero if top.pole < 0 else one if top.pole > 0 else ((1 + top.u) / 2).sqrt()
        s = zero if top.pole > 0 else one if top.pole < 0 else ((1 - top.u) / 2).sqrt()
        plus = zero if top.down else (top.b + top.a) * t / (top.moment * 2 * c * c)
        minus = zero if top.up else (top.b - top.a) * t / (top.moment * 2 * s * s)
        return TiltState(c, s, zero, plus, minus)


class Homoclinic:
    """1 - u = w sech^2 x, x = x0 + k t/2: the slow sleeping top leaves the vertical and returns (b = a, E = W)."""

    def __init__(self, start: Start) -> None:
        self.start = start
        self.k = (4 * start.weight / start.moment - (start.a / start.moment) ** 2).sqrt()
        self.w = flint.arb(2) if start.down else self.k * self.k * start.moment / (2 * start.weight)
        away = 1 - start.u
        side = 1 if start.rate > 0 else -1
        level = start.still or start.pole < 0
        self.x0 = flint.arb(0) if level else side * ((self.w - away) / away).sqrt().asinh()
        self.side = side if not level else -1

    def at(self, t: Any) -> TiltState:
        x = self.x0 + self.k * t / 2
        s = (self.w / 2).sqrt() * x.sech()
        if self.start.down:
            return TiltState(self.side * x.tanh(), s, -self.side * self.k * s, flint.arb(0), flint.arb(0))
        c = (1 - s * s).sqrt()
        q = (self.w / (2 - self.w)).sqrt()
        a = self.start.a / self.start.moment
        plus = a * t + 2 * a * q / self.k * ((q * x.tanh()).atan() - (q * self.x0.tanh()).atan())
        return TiltState(c, s, -self.k * s * x.tanh() / c, plus, flint.arb(0))


class Nutating:
    """u = u1 + (u2 - u1) sn^2(tau), tau = tau0 + p t; NaN where the precision does not separate the roots."""

    def __init__(self, start: Start) -> None:
        self.start = start
        u1, u2, u3 = self.roots = _roots(start)
        self.top = start.up and bool(u2 == 1)
        self.bottom = start.down
        self.m, self.mc = (u2 - u1) / (u3 - u1), (u3 - u2) / (u3 - u1)
        self.p = (start.weight * (u3 - u1) / (2 * start.moment)).sqrt()
        self.quarter = flint.arb.pi() / (2 * flint.arb(1).agm(self.mc.sqrt()))
        self.n1 = None if start.down else -(u2 - u1) / (1 + u1)
        self.n2 = None if start.up else (u2 - u1) / (1 - u1)
        self._begin()

    def _begin(self) -> None:
        """tau0 and the integrals there; `side` is the sign of c."""
        start, (u1, u2, _) = self.start, self.roots
        self.side = 1
        if start.pole > 0 or (start.still and bool(start.u.overlaps(u2))):
            self.tau0 = -self.quarter
            first = (self._complete(self.n1), self._complete(self.n2))
            self.first = (-first[0], -first[1])
            self.side = -1
        elif start.pole < 0 or start.still:
            self.tau0, self.first, self.side = flint.arb(0), (flint.arb(0), flint.arb(0)), -1
        else:
            way = 1 if start.rate > 0 else -1
            phase = way * flint.arb.atan2((start.u - u1).sqrt(), (u2 - start.u).sqrt())
            s, c = phase.sin_cos()
            self.tau0 = s * _rf(c * c, 1 - self.m * s * s, 1)
            self.first = (self._incomplete(self.n1, s, c), self._incomplete(self.n2, s, c))
            self.side = way

    def at(self, t: Any) -> TiltState:
        start, (u1, u2, _) = self.start, self.roots
        tau = self.tau0 + self.p * t
        turns = nearest_integer(tau / (2 * self.quarter))
        phase = amplitude(tau - 2 * turns * self.quarter, self.m, self.mc)
        sn, cn = phase.sin_cos()
        plus, minus = (
            (2 * turns * self._complete(n) + self._incomplete(n, sn, cn) - first) / self.p
            for n, first in zip((self.n1, self.n2), self.first, strict=True)
        )
        dn = (cn * cn + self.mc * sn * sn).sqrt()
        if turns % 2:
            sn, cn = -sn, -cn
        s = ((1 - u1) / 2).sqrt() * cn if self.top else ((1 - u1 - (u2 - u1) * sn * sn) / 2).sqrt()
        c = self.side * ((1 + u2) / 2).sqrt() * sn if self.bottom else ((1 + u1 + (u2 - u1) * sn * sn) / 2).sqrt()
        if self.top and self.bottom:
            rate = -2 * self.side * self.p * dn
        elif self.top:
            rate = -2 * ((1 - u1) / 2).sqrt() * sn * dn * self.p / c
        elif self.bottom:
            rate = -2 * self.side * ((1 + u2) / 2).sqrt() * cn * dn * self.p / s
        else:
            rate = -(u2 - u1) * sn * cn * dn * self.p / (s * c)
        a, b, moment = start.a, start.b, start.moment
        return TiltState(
            c,
            s,
            rate,
            flint.arb(0) if start.down else (b + a) * plus / (moment * (1 + u1)),
            flint.arb(0) if start.up else (b - a) * minus / (moment * (1 - u1)),
        )

    def period(self) -> Any:
        """Period of theta and theta' (s): 2K/p, twice that where theta passes a pole."""
        return (4 if self.top or self.bottom else 2) * self.quarter / self.p

    def advance(self) -> tuple[Any, Any]:
        """The changes of the integrals `plus` and `minus` over a period."""
        start, u1 = self.start, self.roots[0]
        count = (4 if self.top or self.bottom else 2) / (self.p * start.moment)
        zero = flint.arb(0)
        return (
            zero if start.down else count * (start.b + start.a) * self._complete(self.n1) / (1 + u1),
            zero if start.up else count * (start.b - start.a) * self._complete(self.n2) / (1 - u1),
        )

    def _complete(self, n: Any) -> Any:
        """Pi(n | m); 0 where its factor is zero."""
        if n is None:
            return flint.arb(0)
        return _rf(flint.arb(0), self.mc, 1) + n / 3 * _rj(flint.arb(0), self.mc, 1, 1 - n)

    def _incomplete(self, n: Any, s: Any, c: Any) -> Any:
        """Pi(n; phase | m) for a phase within a quarter turn, by its sine and cosine. DLMF 19.25.14."""
        if n is None:
            return flint.arb(0)
        c2, s2 = c * c, s * s
        delta = c2 + self.mc * s2
        return s * _rf(c2, delta, 1) + n / 3 * s * s2 * _rj(c2, delta, 1, c2 + (1 - n) * s2)


def nutates(start: Start) -> bool:
    """Whether the tilt oscillates."""
    return not (start.steady or start.homoclinic)


def nutation(start: Start) -> Steady | Homoclinic | Nutating:
    """The motion from a start."""
    if start.steady:
        return Steady(start)
    return Homoclinic(start) if start.homoclinic else Nutating(start)


def amplitude(u: Any, m: Any, mc: Any) -> Any:
    """am(u | m) by the arithmetic-geometric mean (DLMF 22.20(ii)), with a bound of the truncation error."""
    a, b, c = flint.arb(1), mc.sqrt(), m.sqrt()
    ratios: list[Any] = []
    while c.is_finite() and c.upper() > flint.arb(2) ** (-flint.ctx.prec - 10) and len(ratios) < 200:
        a, b = (a + b) / 2, (a * b).sqrt()
        c = c * c / (4 * a)
        ratios.append(c / a)
    phase = flint.arb(2) ** len(ratios) * a * u
    for ratio in reversed(ratios):
        phase = (phase + (ratio * phase.sin()).asin()) / 2
    return phase + flint.arb(0, c.upper()) if c.is_finite() else flint.arb.nan()


def _roots(start: Start) -> tuple[Any, Any, Any]:
    """The roots of f, ascending; those that are known exactly stay exact. NaN where balls overlap."""
    i, w, a, b, e = start.moment, start.weight, start.a, start.b, start.energy
    lead = 2 * w / i
    # f over its leading coefficient, the highest power first
    rest = [
        flint.arb(1),
        -(2 * e / i + (a / i) ** 2) / lead,
        (2 * a * b / (i * i) - lead) / lead,
        (2 * e / i - (b / i) ** 2) / lead,
    ]
    known = [
        root for root, holds in ((flint.arb(1), start.up), (flint.arb(-1), start.down), (start.u, start.still)) if holds
    ]
    for root in known:
        reduced = [rest[0]]
        for coefficient in rest[1:-1]:
            reduced.append(coefficient + root * reduced[-1])
        rest = reduced
    if len(rest) == 2:
        known.append(-rest[1])
    elif len(rest) == 3:
        half = -rest[1] / 2
        spread = (half * half - rest[2]).sqrt()
        known += [half - spread, half + spread]
    elif len(rest) == 4:
        known += _three(rest)

    def before(x: Any, y: Any) -> int:
        return -1 if x.mid() < y.mid() else 1

    roots = sorted(known, key=cmp_to_key(before))
    if all(bool(x < y) for x, y in pairwise(roots)):
        return roots[0], roots[1], roots[2]
    return flint.arb.nan(), flint.arb.nan(), flint.arb.nan()


def _three(monic: list[Any]) -> list[Any]:
    """Three real roots of a monic cubic by Viete's formula."""
    mean = -monic[1] / 3
    p = (mean * mean - monic[2] / 3).sqrt()
    q = mean**3 - mean * monic[2] / 2 - monic[3] / 2
    angle = flint.arb.atan2((p**6 - q * q).sqrt(), q) / 3
    turn = 2 * flint.arb.pi() / 3
    return [mean + 2 * p * (angle + k * turn).cos() for k in range(3)]


def _rf(x: Any, y: Any, z: Any) -> Any:
    return flint.acb.elliptic_rf(flint.acb(x), flint.acb(y), flint.acb(z)).real


def _rj(x: Any, y: Any, z: Any, p: Any) -> Any:
    return flint.acb.elliptic_rj(flint.acb(x), flint.acb(y), flint.acb(z), flint.acb(p)).real
