"""A rigid body whose angular momentum decays at the rate nu in a Stokes medium.

With s = (1 - e^(-nu t))/nu the motion is the motion of the torque-free body (W, Q) at the time s: w(t) = e^(-nu t) W(s) and
R(t) = Q(s). The attitude converges to the attitude of the free body at the time 1/nu.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.rigid_bodies.euler_top import IDENTITY, EulerTop, Triple


@dataclass(frozen=True)
class StokesBody(Motion):
    """State (w1, w2, w3, R11..R33): I w' + w x I w = -nu I w, R' = R hat(w); nu >= 0."""

    nu: Fraction
    moments: Triple
    rates: Triple
    attitude: tuple[Fraction, ...] = IDENTITY

    @cached_property
    def free(self) -> EulerTop:
        """The body without the medium."""
        return EulerTop(self.moments, self.rates, self.attitude)

    def slowed(self, mp: Any, t: Fraction) -> Any:
        """s at t: the time of the free body."""
        return -mp.expm1(-mp.mpf(self.nu * t)) / mp.mpf(self.nu) if self.nu else mp.mpf(t)

    def _guard(self, t: Fraction) -> float:
        reached = t if self.nu == 0 else min(abs(t), 1 / self.nu) if t > 0 else 2 * t
        return self.free._guard(reached)

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        rates, turn = self.free.rates_and_turn(mp, self.slowed(mp, t))
        fading = mp.exp(-mp.mpf(self.nu * t))
        start = [mp.mpf(value) for value in self.attitude]
        rows = (mp.fsum(start[3 * i + k] * turn[k][j] for k in range(3)) for i in range(3) for j in range(3))
        return [*(fading * w for w in rates), *rows]

    def final_turn(self, digits: int = 15) -> Any | None:
        """The limit of s, 1/nu; None without a medium."""
        return self._quantity(digits, lambda mp: 1 / mp.mpf(self.nu)) if self.nu else None
