"""A ball on a table with a small contact patch: coupled friction against sliding and drilling.

Per unit mass the force is -mu g s/(|s| + rho |wz|) and the torque -mu g rho^2 wz/(|s| + rho |wz|): Zhuravlev's linear
quotients (J. Appl. Math. Mech. 62, 1998) in place of Contensou's integrals, with one length rho. In the variable u,
du = mu g dt/(|s| + rho |wz|), slip and drilling rate decay as e^(-7u/2) and e^(-ku), k = 5 rho^2/(2 R^2), and

    mu g t = |s0| (1 - e^(-7u/2)) 2/7 + rho |wz0| (1 - e^(-ku))/k.

Both end together, as u goes to infinity, at a finite time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.contact.billiard_ball import Sphere
from gnomon.reference.numerics.motion import Motion


@dataclass(frozen=True)
class DrillingBall(Sphere, Motion):
    """A sphere that slides and drills with the radius of friction rho; slip, wz, mu, g and rho are not zero.

    A time at or beyond the end raises ValueError.
    """

    rho: Fraction

    def end_time(self, digits: int = 15) -> Any:
        """Time from which the ball neither slides nor drills (s)."""
        return self._quantity(digits, lambda mp: sum(size / rate for size, rate in self._fading(mp)))

    def final_velocity(self, digits: int = 15) -> tuple[Any, Any]:
        """Velocity at the end, the same as without drilling: (5/7) v0 + (2/7) R w0 x k."""
        sx, sy = self.slip
        return self._rational(digits, self.vx - 2 * sx / 7), self._rational(digits, self.vy - 2 * sy / 7)

    def _fading(self, mp: Any) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """Size over mu g and decay rate in u, for the slip and for the drilling."""
        sx, sy = self.slip
        unit = mp.mpf(self.mu * self.g)
        return (
            (mp.sqrt(mp.mpf(sx * sx + sy * sy)) / unit, mp.mpf(7) / 2),
            (mp.mpf(self.rho * abs(self.wz)) / unit, mp.mpf(5 * self.rho**2 / (2 * self.R**2))),
        )

    def _guard(self, t: Fraction) -> float:
        return 25

    def _clock(self, mp: Any, time: Any) -> Any:
        """u at a time: t(u) is concave, so that Newton's method converges from the left."""
        parts, u = self._fading(mp), mp.zero
        if time >= mp.fsum(size / rate for size, rate in parts):
            raise ValueError(f"no state at t = {float(time):g} s: the ball neither slides nor drills from end_time on")
        for _ in range(200):
            past = -mp.fsum(size * mp.expm1(-rate * u) / rate for size, rate in parts)
            pace = mp.fsum(size * mp.exp(-rate * u) for size, rate in parts)
            step = (time - past) / pace
            u += step
            if abs(step) <= 16 * mp.eps * (abs(u) + abs(time) / pace):
                return u
        raise ArithmeticError(
            f"no state found at t = {float(time):g} s, just before the ball neither slides nor drills"
        )

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        time = mp.mpf(t)
        u = self._clock(mp, time)
        (slide, fast), (drill, slow) = self._fading(mp)
        sliding = mp.expm1(-fast * u)
        further = -slide * mp.expm1(-2 * fast * u) / (2 * fast) - drill * mp.expm1(-(fast + slow) * u) / (fast + slow)
        state, rates = [], []
        for place, speed, slip in zip((self.x, self.y), (self.vx, self.vy), self.slip, strict=True):
            share = mp.mpf(2 * slip / 7)
            state.append(mp.mpf(place) + (mp.mpf(speed) - share) * time + share * further)
            rates.append(mp.mpf(speed) + share * sliding)
        turn = mp.mpf(5 / (2 * self.R))
        wx = mp.mpf(self.wx) + turn * mp.mpf(2 * self.slip[1] / 7) * sliding
        wy = mp.mpf(self.wy) - turn * mp.mpf(2 * self.slip[0] / 7) * sliding
        return [*state, *rates, wx, wy, mp.mpf(self.wz) * mp.exp(-slow * u)]
