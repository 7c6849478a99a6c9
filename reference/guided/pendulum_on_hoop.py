"""theta'' = -A sin(theta) + B sin(theta) cos(theta), for all A, B and starts, by Biermann's formula in balls.

A bead on a rotating hoop, a plate hinged to a rotating shaft and the gyrocompass obey this equation. With
u = tan((theta - theta0)/2), u'^2 is a quartic in u. u is infinite where theta is opposite to its start; numerator and
denominator are computed apart and stay finite. The turn of theta follows from the maxima of the potential
V = -A cos(theta) - B sin^2(theta)/2, which bound a motion that does not pass them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any, ClassVar

import flint
from gnomon.reference.numerics.balls import ball, nearest_integer, refined, sign
from gnomon.reference.numerics.biermann import FromZero
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.pointwise import Cycle


@dataclass(frozen=True)
class Hoop(BallMotion):
    """State (theta, omega), theta in rad, unwrapped."""

    pull: Fraction
    lift: Fraction
    theta0: Fraction
    omega0: Fraction

    LIBRATION: ClassVar[str] = "libration"
    ROTATION: ClassVar[str] = "rotation"
    SEPARATRIX: ClassVar[str] = "separatrix"
    REST: ClassVar[str] = "rest"

    @cached_property
    def regime(self) -> str:
        """libration, rotation, separatrix or rest.

        The cosine of a rational number other than 0 is transcendental (Lindemann): only a start at theta = 0 can be an
        equilibrium or have exactly the energy of a maximum of V.
        """
        if self.omega0 == 0 and (self.theta0 == 0 or (self.pull == 0 and self.lift == 0)):
            return self.REST
        if self.theta0 == 0:
            excess = self.omega0**2 / 2 - self.pull - self._highest
            if excess == 0 and (self.pull or self.lift):
                return self.SEPARATRIX
            return self.ROTATION if excess > 0 or not (self.pull or self.lift) else self.LIBRATION
        return self.ROTATION if sign(lambda: self._energy() - ball(self._highest)) > 0 else self.LIBRATION

    def period(self, digits: int = 15) -> Any:
        """Time after which the state repeats, up to a turn of theta in rotation; None at rest and on the separatrix."""
        if self.regime in (self.REST, self.SEPARATRIX):
            return None
        return self._derived(digits, lambda: _start(self, flint.ctx.prec)[1])

    def energy(self, digits: int = 15) -> Any:
        """omega^2/2 + V, constant; V = -A at theta = 0."""
        return self._derived(digits, self._energy)

    def tilted_equilibrium(self, digits: int = 15) -> Any | None:
        """acos(A/B), where it exists away from 0 and pi; stable for B > 0."""
        if abs(self.pull) >= abs(self.lift):
            return None
        return self._derived(digits, lambda: ball(self.pull / self.lift).acos())

    def small_frequency(self, digits: int = 15) -> Any | None:
        """Angular frequency of small swings about the minimum of V; None where the linear force vanishes."""
        a, b = abs(self.pull), self.lift
        square = b - a * a / b if b > a else a - b
        return self._derived(digits, lambda: ball(square).sqrt()) if square > 0 else None

    @property
    def _highest(self) -> Fraction:
        """The largest value of V."""
        a, b = abs(self.pull), -self.lift
        return (b + a * a / b) / 2 if b > a else a

    def _middle(self) -> Any:
        """The middle between the neighbouring maxima of V; theta stays within half a turn of it."""
        theta, turn = ball(self.theta0), 2 * flint.arb.pi()
        offset = flint.arb(0) if self.pull >= 0 else flint.arb.pi()
        if -self.lift > abs(self.pull):  # maxima at +-acos(A/B): one interval about 0, one about pi
            top = ball(self.pull / self.lift).acos()
            rest = theta - nearest_integer(theta / turn) * turn
            offset = flint.arb(0) if abs(rest) < top else flint.arb.pi()
        return offset + nearest_integer((theta - offset) / turn) * turn

    def _energy(self) -> Any:
        sine, cosine = ball(self.theta0).sin_cos()
        return ball(self.omega0**2 / 2) - ball(self.pull) * cosine - ball(self.lift / 2) * sine * sine

    def _quartic(self) -> list[Any]:
        """u'^2 as a polynomial in u."""
        s, c = ball(self.theta0).sin_cos()
        quarter, b = ball(self.omega0**2 / 4), ball(self.lift)
        force = ball(self.pull) - b * c
        return [
            quarter,
            -force * s,
            2 * quarter - force * c - b * s * s,
            -force * s - 2 * b * s * c,
            quarter - force * c - b * c * c,
        ]

    @cached_property
    def _degenerate(self) -> bool:
        """Whether two roots of the quartic coincide, which needs a start at theta = 0 (or no force)."""
        if self.pull == 0 and self.lift == 0:
            return True
        if self.theta0 != 0:
            return False
        quarter, force = self.omega0**2 / 4, self.pull - self.lift
        a0, a2, a4 = quarter, 2 * quarter - force, quarter - force - self.lift
        return a0 * a4 == 0 or a2 * a2 == 4 * a0 * a4

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if t == 0 or self.regime == self.REST:
            return [ball(self.theta0), ball(self.omega0)]
        solution, period = _start(self, flint.ctx.prec)
        time, turns = ball(t), 0
        if period is not None:
            turns = nearest_integer(time / period)
            time = time - turns * period
        top, bottom, top_rate, bottom_rate = solution(time)
        angle = 2 * flint.arb.atan2(top, bottom)
        omega = 2 * (top_rate * bottom - top * bottom_rate) / (top * top + bottom * bottom)
        turn, theta = 2 * flint.arb.pi(), ball(self.theta0)
        if self.regime == self.ROTATION:
            way = 1 if self.omega0 > 0 else -1
            if not (angle > 0 or angle < 0) or not (time > 0 or time < 0):
                return [flint.arb.nan()] * 2  # requests more precision
            forward = way if time > 0 else -way
            extra = forward if (angle > 0) != (forward > 0) else 0
            return [theta + angle + (extra + way * turns) * turn, omega]
        return [theta + angle + nearest_integer((self._middle() - theta - angle) / turn) * turn, omega]

    def _cycle(self, mp: Any) -> Cycle | None:
        if self.regime in (self.REST, self.SEPARATRIX):
            return None
        (period,) = refined(mp, lambda: [_start(self, flint.ctx.prec)[1]])
        turn = mp.zero if self.regime == self.LIBRATION else 2 * mp.pi * (1 if self.omega0 > 0 else -1)
        return Cycle(period, (turn, mp.zero))


@lru_cache(maxsize=32)
def _start(motion: Hoop, bits: int) -> tuple[FromZero, Any]:
    """The solution for u and its period (None on the separatrix), at a precision."""
    solution = FromZero(motion._quartic(), ball(motion.omega0 / 2))
    if motion.regime == motion.SEPARATRIX:
        return solution, None
    return solution, solution.elliptic.real_period(motion._degenerate)
