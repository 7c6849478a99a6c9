"""The torque-free rigid body and its attitude.

Whittaker, Analytical Dynamics, sections 69 to 71; the attitude follows from angles about the angular momentum vector.
The choice of the formula is made on exact numbers, and 1 - m is formed without cancellation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.numerics.carlson import third
from gnomon.reference.numerics.elliptic import amplitude, complete_first, incomplete_first
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.pointwise import Cycle, Turn
from gnomon.reference.numerics.precision import publish, working

Matrix = list[list[Any]]
Triple = tuple[Fraction, Fraction, Fraction]
IDENTITY = tuple(Fraction(int(k % 4 == 0)) for k in range(9))


@dataclass(frozen=True)
class EulerTop(Motion):
    """Principal moments, rates in the body (rad/s) and the attitude R(0), row by row: R(t) = R(0) Q(t), R' = R hat(w).

    R(0) need not be orthogonal. The moments may have any sequence and may be equal. State (w1, w2, w3, R11..R33).
    """

    moments: Triple
    rates: Triple
    attitude: tuple[Fraction, ...] = IDENTITY

    def __post_init__(self) -> None:
        if any(moment <= 0 for moment in self.moments):
            raise ValueError(f"a principal moment of {', '.join(map(str, self.moments))} is not positive")

    # The exact numbers that decide the kind of motion

    @cached_property
    def twice_energy(self) -> Fraction:
        return sum((i * w * w for i, w in zip(self.moments, self.rates, strict=True)), Fraction(0))

    @cached_property
    def momentum_squared(self) -> Fraction:
        return sum(((i * w) ** 2 for i, w in zip(self.moments, self.rates, strict=True)), Fraction(0))

    @cached_property
    def kind(self) -> str:
        """`steady` (about a principal axis), `symmetric`, `separatrix` or `general`."""
        if sum(w != 0 for w in self.rates) <= 1:
            return "steady"
        if len(set(self.moments)) < 3:
            return "symmetric"
        middle = sorted(self.moments)[1]
        return "separatrix" if self.momentum_squared == self.twice_energy * middle else "general"

    # The state

    def _state(self, mp: Any, t: Fraction) -> list[Any]:
        rates, turn = self.rates_and_turn(mp, mp.mpf(t))
        start = [mp.mpf(value) for value in self.attitude]
        return [*rates, *(mp.fsum(start[3 * i + k] * turn[k][j] for k in range(3)) for i in range(3) for j in range(3))]

    def rates_and_turn(self, mp: Any, t: Any) -> tuple[list[Any], Matrix]:
        """w(t) and Q(t), which do not depend on R(0)."""
        if self.kind == "steady":
            return [mp.mpf(w) for w in self.rates], rotation(mp, [mp.mpf(w) * t for w in self.rates])
        if self.kind == "symmetric":
            return self._symmetric(mp, t)
        return self._asymmetric(mp, t)

    def _guard(self, t: Fraction) -> float:
        with working(15) as mp:
            fastest = mp.sqrt(mp.mpf(self.twice_energy / min(self.moments)))
            lost = 20 + mp.log10(1 + fastest * abs(mp.mpf(t)))
            if self.kind == "general":
                top = self._ordered
                # Cancellation: a start near the middle axis (sqrt(mc)), large terms of Pi, a narrow cone.
                lost += 2 * abs(mp.log10(mp.mpf(top.mc))) + mp.log10(1 - mp.mpf(top.n)) + abs(mp.log10(mp.mpf(top.a2)))
            return 10.0 * math.ceil(float(lost) / 10)  # in coarse steps, so that values without t are cached

    def _cycle(self, mp: Any) -> Cycle | None:
        """The rates repeat themselves, and R(t + T) = R(0) Q(T) R(0)^-1 R(t)."""
        with mp.workdps(mp.dps + math.ceil(self._guard(Fraction(0)))):
            if self.kind == "separatrix" or not any(self.rates):
                return None
            if self.kind != "general":
                return self._precession_cycle(mp)
            start = mp.matrix(3, 3)
            for k, value in enumerate(self.attitude):
                start[k // 3, k % 3] = mp.mpf(value)
            if not mp.det(start):
                return None
            period = self._body_period(mp)
            gained = start * mp.matrix(self.rates_and_turn(mp, period)[1]) * mp.inverse(start)
        return Cycle(period, (mp.zero,) * 12, [Turn(gained.tolist(), [(3 + k, 6 + k, 9 + k) for k in range(3)])])

    def _precession_cycle(self, mp: Any) -> Cycle:
        """Two equal moments: after a turn about the angular momentum, rates and attitude have only been rotated."""
        k = self._axis
        if self.kind == "steady":
            return Cycle(2 * mp.pi / mp.mpf(sum(map(abs, self.rates))), (mp.zero,) * 12)
        along, across = self.moments[k], self.moments[k - 1]
        period = 2 * mp.pi * mp.mpf(across) / mp.sqrt(mp.mpf(self.momentum_squared))
        spin = mp.mpf((along - across) / across * self.rates[k]) * period
        turned = rotation(mp, [spin if i == k else mp.zero for i in range(3)])
        return Cycle(period, (mp.zero,) * 12, [Turn(turned, [range(3 * i, 3 * i + 3) for i in range(4)])])

    # Two equal moments, or three

    @cached_property
    def _axis(self) -> int:
        """The axis of symmetry."""
        i1, i2, i3 = self.moments
        return 2 if i1 == i2 else 1 if i1 == i3 else 0

    def _symmetric(self, mp: Any, t: Any) -> tuple[list[Any], Matrix]:
        """R = R(0) exp(hat(L/A) t) exp(-hat(e) Om t), Om = (C - A) w / A along the axis of symmetry e."""
        k = self._axis
        along, across = self.moments[k], self.moments[k - 1]
        spin = mp.mpf((along - across) / across * self.rates[k]) * t
        turned = rotation(mp, [spin if i == k else mp.mpf(0) for i in range(3)])
        rates = times(mp, turned, [mp.mpf(w) for w in self.rates])
        precession = rotation(mp, [mp.mpf(i * w / across) * t for i, w in zip(self.moments, self.rates, strict=True)])
        return rates, product(mp, precession, transposed(turned))

    # Three different moments

    @cached_property
    def _ordered(self) -> Ordered:
        return Ordered.of(self)

    def _asymmetric(self, mp: Any, t: Any) -> tuple[list[Any], Matrix]:
        top = self._ordered
        fixed = self._fixed.get(mp.prec)
        if fixed is None:
            fixed = self._fixed[mp.prec] = self._without_time(mp)
        (A, B, C, p), tau0, pi0, momentum, pull, before, own = fixed
        tau = tau0 + p * t
        phase = amplitude(mp, tau, mp.mpf(top.mc), mp.mpf(top.m)) if top.mc else None
        sn, cn, dn = top.jacobi(mp, phase, tau)
        phi = momentum / mp.mpf(top.moments[2]) * t + pull * (top.pi(mp, phase, tau) - pi0)
        rates = [A * cn, B * sn, C * dn]
        after = cone(mp, [mp.mpf(i) * w for i, w in zip(top.moments, rates, strict=True)])
        about = rotation(mp, [mp.mpf(0), mp.mpf(0), phi])
        turn = product(mp, before, product(mp, about, after))
        # Back to the body's own axes: w = S^T w', Q = S^T Q' S.
        return times(mp, transposed(own), rates), product(mp, transposed(own), product(mp, turn, own))

    @cached_property
    def _fixed(self) -> dict[int, tuple[Any, ...]]:
        """The values that do not depend on time, by precision."""
        return {}

    def _without_time(self, mp: Any) -> tuple[Any, ...]:
        top = self._ordered
        A, B, C, p = top.amplitudes(mp)
        tau0, phase0 = top.start(mp, A, B)
        momentum = mp.sqrt(mp.mpf(self.momentum_squared))
        excess = mp.mpf(self.twice_energy - self.momentum_squared / top.moments[2])
        pull = momentum * excess / (mp.mpf(top.moments[0] ** 2 * top.a2) * p)
        before = cone(mp, [mp.mpf(i * w) for i, w in zip(top.moments, top.rates, strict=True)])
        own = [[mp.mpf(value) for value in row] for row in top.axes]
        return (A, B, C, p), tau0, top.pi(mp, phase0, tau0), momentum, pull, transposed(before), own

    # Derived quantities

    def body_period(self, digits: int = 15) -> Any:
        """The period of w (s), 4K/p or 2 pi/|Om|; None if w is constant or never repeats."""
        with working(digits + 10) as mp:
            period = self._body_period(mp)
            return None if period is None else publish([period], digits)[0]

    def _body_period(self, mp: Any) -> Any:
        if self.kind == "general":
            top = self._ordered
            return 4 * complete_first(mp, mp.mpf(top.mc)) / top.amplitudes(mp)[3]
        if self.kind == "symmetric":
            k = self._axis
            rate = abs((self.moments[k] - self.moments[k - 1]) / self.moments[k - 1] * self.rates[k])
            return 2 * mp.pi / mp.mpf(rate) if rate else None
        return None

    def precession(self, digits: int = 15) -> Any:
        """Mean rate of rotation about the angular momentum vector (rad/s)."""

        def formula(mp: Any) -> Any:
            momentum = mp.sqrt(mp.mpf(self.momentum_squared))
            if self.kind == "steady":
                return mp.mpf(sum(abs(w) for w in self.rates))
            if self.kind == "symmetric":
                return momentum / mp.mpf(self.moments[self._axis - 1])
            top = self._ordered
            moment = mp.mpf(sorted(self.moments)[1])
            if self.kind == "separatrix":
                return momentum / moment
            A, _B, _C, _p = top.amplitudes(mp)
            per_quarter = top.pi(mp, mp.pi / 2, None) / complete_first(mp, mp.mpf(top.mc))
            excess = mp.mpf(self.twice_energy - self.momentum_squared / top.moments[2])
            return momentum * (1 / mp.mpf(top.moments[2]) + excess * per_quarter / (mp.mpf(top.moments[0]) * A) ** 2)

        return self._quantity(digits, formula, 10 + self._guard(Fraction(0)))


@dataclass(frozen=True)
class Ordered:
    """A body with three different moments, with axes relabelled by the proper rotation `axes` (w' = S w).

    The middle moment is the second, and the axis about which the motion circulates the third, so that
    w = (A cn, B sn, C dn)(tau | m). `a2`, `c2`, `p2` are the squares of A, C, p.
    """

    axes: tuple[tuple[int, int, int], ...]
    moments: Triple
    rates: Triple
    a2: Fraction
    c2: Fraction
    p2: Fraction
    m: Fraction
    mc: Fraction
    n: Fraction

    @classmethod
    def of(cls, top: EulerTop) -> Ordered:
        low, middle, high = sorted(range(3), key=lambda k: top.moments[k])
        energy, momentum = top.twice_energy, top.momentum_squared
        labels = (low, middle, high) if momentum >= energy * top.moments[middle] else (high, middle, low)
        even = labels in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        signs = (1, 1 if even else -1, 1)
        axes = tuple(tuple(s if j == k else 0 for j in range(3)) for k, s in zip(labels, signs, strict=True))
        i1, i2, i3 = (top.moments[k] for k in labels)
        rates = tuple(s * top.rates[k] for k, s in zip(labels, signs, strict=True))
        below, above = energy * i3 - momentum, momentum - energy * i1
        scale = (i3 - i2) * above
        return cls(
            axes=axes,  # type: ignore[arg-type]
            moments=(i1, i2, i3),
            rates=rates,  # type: ignore[arg-type]
            a2=below / (i1 * (i3 - i1)),
            c2=above / (i3 * (i3 - i1)),
            p2=scale / (i1 * i2 * i3),
            m=(i2 - i1) * below / scale,
            mc=(momentum - energy * i2) * (i3 - i1) / scale,
            n=-i3 * (i2 - i1) / (i1 * (i3 - i2)),
        )

    def amplitudes(self, mp: Any) -> tuple[Any, Any, Any, Any]:
        """A, B, C, p. C has the sign of w3; A is positive, or on the separatrix of the sign of w1."""
        i1, i2, i3 = self.moments
        A, C, p = (mp.sqrt(mp.mpf(square)) for square in (self.a2, self.c2, self.p2))
        A = -A if not self.mc and self.rates[0] < 0 else A
        C = -C if self.rates[2] < 0 else C
        return A, mp.mpf((i3 - i1) / i2) * A * C / p, C, p

    def start(self, mp: Any, A: Any, B: Any) -> tuple[Any, Any]:
        """tau at t = 0 and, off the separatrix, its amplitude."""
        sn, cn = mp.mpf(self.rates[1]) / B, mp.mpf(self.rates[0]) / A
        if not self.mc:
            return mp.asinh(sn / cn), None
        phase = mp.atan2(sn, cn)
        return incomplete_first(mp, phase, mp.mpf(self.mc), mp.mpf(self.m)), phase

    def jacobi(self, mp: Any, phase: Any, tau: Any) -> tuple[Any, Any, Any]:
        if phase is None:
            sech = 1 / mp.cosh(tau)
            return mp.tanh(tau), sech, sech
        s, c = mp.sin(phase), mp.cos(phase)
        return s, c, mp.sqrt(c * c + mp.mpf(self.mc) * s * s)

    def pi(self, mp: Any, phase: Any, tau: Any) -> Any:
        """Pi(n; phase | m), n < 0; elementary in tau on the separatrix."""
        n, mc = mp.mpf(self.n), mp.mpf(self.mc)
        if phase is None:
            root = mp.sqrt(-n)
            return (tau + root * mp.atan(root * mp.tanh(tau))) / (1 - n)
        return third(mp, n, phase, mc)


def rotation(mp: Any, vector: Sequence[Any]) -> Matrix:
    """exp(hat(vector)), Rodrigues' formula."""
    x, y, z = vector
    angle = mp.sqrt(x * x + y * y + z * z)
    if not angle:
        return [[mp.mpf(int(i == j)) for j in range(3)] for i in range(3)]
    s = mp.sin(angle) / angle
    half = mp.sin(angle / 2) / angle
    c = 2 * half * half  # (1 - cos) / angle^2 without cancellation
    return [
        [1 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y],
        [c * x * y + s * z, 1 - c * (x * x + z * z), c * y * z - s * x],
        [c * x * z - s * y, c * y * z + s * x, 1 - c * (x * x + y * y)],
    ]


def cone(mp: Any, momentum: Sequence[Any]) -> Matrix:
    """Rx(theta) Rz(psi): the attitude with the angular momentum (given in the body) along z, up to a turn about z."""
    m1, m2, m3 = momentum
    across = mp.sqrt(m1 * m1 + m2 * m2)
    size = mp.sqrt(across * across + m3 * m3)
    s, c = m1 / across, m2 / across
    sine, cosine = across / size, m3 / size
    return [[c, -s, mp.mpf(0)], [cosine * s, cosine * c, -sine], [sine * s, sine * c, cosine]]


def times(mp: Any, a: Matrix, v: Sequence[Any]) -> list[Any]:
    return [mp.fsum(x * y for x, y in zip(row, v, strict=True)) for row in a]


def product(mp: Any, a: Matrix, b: Matrix) -> Matrix:
    columns = transposed(b)
    return [times(mp, columns, row) for row in a]


def transposed(a: Matrix) -> Matrix:
    return [list(column) for column in zip(*a, strict=True)]
