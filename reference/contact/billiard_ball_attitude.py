"""The attitude of a billiard ball: R' = hat(w) R with w in the inertial frame.

While the ball slides, w = w0 + alpha t; the power series of the quaternion in t converges for all t, with terms below
the terms of exp(|w0| t/2 + |alpha| t^2/4). While it rolls, w is constant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.contact.billiard_ball import BilliardBall
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.precision import publish, working
from gnomon.reference.rigid_bodies.lagrange_top_attitude import Quaternion, matrix, product

ZERO = (flint.arb(0),) * 3
PIECE = 16
"""Largest bound of half the angle (rad) for one series, whose loss of digits is proportional to the bound."""
MOST_PIECES = 256
MOST_TURN = 2 * MOST_PIECES * PIECE
"""Largest bound of the whole angle (rad)."""


@dataclass(frozen=True)
class BilliardAttitude(BallMotion):
    """State (x, y, vx, vy, wx, wy, wz, R11..R33)."""

    centre: BilliardBall
    attitude: tuple[Fraction, ...]

    def rolling_state(self, digits: int = 15) -> tuple[Any, ...]:
        """The state when sliding ends; mu > 0."""
        with working(digits + 2) as mp:
            return publish(refined(mp, lambda: self._after(self.centre._rolling_time(), flint.arb(0))), digits)

    def _after(self, until: Any, rest: Any) -> list[Any]:
        """The state at `rest` after sliding ends at `until`."""
        here = list(self.centre._rolled(rest))
        start = [ball(w) for w in (self.centre.wx, self.centre.wy, self.centre.wz)]
        slid = turned(start, self.centre.spin_up(), until)
        return [*here, *self._rows(product(turned(here[4:7], ZERO, rest), slid))]

    def _rows(self, turn: Quaternion) -> list[Any]:
        rotation, rows = matrix(turn), [[ball(x) for x in self.attitude[3 * i : 3 * i + 3]] for i in range(3)]
        return [sum(rotation[i][k] * rows[k][j] for k in range(3)) for i in range(3) for j in range(3)]

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if self.centre.slides and self.centre.rolls_at(t):
            until = self.centre._rolling_time()
            return self._after(until, ball(t) - until)
        start = [ball(w) for w in (self.centre.wx, self.centre.wy, self.centre.wz)]
        growth = self.centre.spin_up() if self.centre.slides else ZERO
        return [*self.centre._balls(t), *self._rows(turned(start, growth, ball(t)))]


def turned(rate: Sequence[Any], growth: Sequence[Any], time: Any) -> Quaternion:
    """The rotation after `time` at the rate `rate` + `growth` t (inertial frame); long times are halved."""
    zero = flint.arb(0)
    square = sum(w * w for w in rate)
    if growth is ZERO and square > 0:
        half = square.sqrt() * time / 2
        sine = half.sinc() * time / 2
        return (half.cos(), *(w * sine for w in rate))  # type: ignore[return-value]
    first: Quaternion = (zero, *(w * time / 2 for w in rate))  # type: ignore[assignment]
    second: Quaternion = (zero, *(a * time * time / 2 for a in growth))  # type: ignore[assignment]
    size = sum(x * x for x in first).sqrt() + 2 * sum(x * x for x in second).sqrt()
    if size > MOST_PIECES * PIECE:
        raise ArithmeticError(
            f"the ball turns by up to {float(2 * size):.3g} rad as it slides; give at most {MOST_TURN}"
        )
    if size > PIECE:
        middle = [w + a * time / 2 for w, a in zip(rate, growth, strict=True)]
        return product(turned(middle, growth, time / 2), turned(rate, growth, time / 2))
    # The remainder of exp(a + b) after n terms, a and b the sizes, is below e^(2a + 4b) 2^(1 - n) (Cauchy, |z| = 2).
    count = flint.ctx.prec + int(float(size.mid()) * 6) + 16
    before: Quaternion = (zero, zero, zero, zero)
    term: Quaternion = (flint.arb(1), zero, zero, zero)
    total = term
    for n in range(1, count + 1):
        steady, growing = product(first, term), product(second, before)
        before, term = term, tuple((a + b) / n for a, b in zip(steady, growing, strict=True))  # type: ignore[assignment]
        total = tuple(a + b for a, b in zip(total, term, strict=True))  # type: ignore[assignment]
    rest = (2 * size).exp() * flint.arb(2) ** (1 - count)
    left = flint.arb(0, 1) * rest
    return tuple(x + left for x in total)  # type: ignore[return-value]
