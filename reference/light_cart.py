"""A pendulum on a cart that is much lighter than it: the cosine series of reference/wells.py would take too many terms.

With the amplitude a and theta = a - sigma^2 the time from a turning point is the integral of 2 sqrt(L mu/(2 g sin(a -
sigma^2/2) sinc(sigma^2/2))), mu = (M + m sin^2 theta)/(M + m): adaptive where mu is nearly zero, next to the bottom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

import flint
from gnomon.reference.balls import BallMotion, ball, refined
from gnomon.reference.motion import Cycle
from gnomon.reference.passage import Track
from gnomon.reference.precision import working

LONGEST = 0.5
"""Of sqrt(L/g): the time between two places of a track."""


class Quarter(NamedTuple):
    """A quarter of a swing from its turning point, and the time of the start after the turning point at +a."""

    amplitude: Any
    track: Track
    start: Any


@dataclass(frozen=True)
class LightCart(BallMotion):
    """State (x, theta, x', theta') of a pendulum (m, L) under a cart M, as CartPendulum has it; it swings, not at rest."""

    g: Fraction
    m: Fraction
    M: Fraction
    length: Fraction
    x: Fraction
    theta: Fraction
    vx: Fraction
    omega: Fraction

    rests = False

    def period(self, digits: int = 15) -> Any:
        """Of the swing."""
        return self._derived(digits, lambda: 4 * self._quarter().track.duration)

    def turning_points(self, digits: int = 15) -> tuple[Any, Any]:
        largest = self._derived(digits, lambda: self._quarter().amplitude)
        with working(digits) as mp:
            return mp.make_mpf((-mp.mpf(largest))._mpf_), largest

    def _quarter(self) -> Quarter:
        return _quarter(self, flint.ctx.prec)

    def _inertia(self, angle: Any) -> Any:
        """L mu."""
        sine, total = angle.sin(), self.m + self.M
        return ball(self.length * self.M / total) + ball(self.length * self.m / total) * sine * sine

    def _push(self, amplitude: Any, sigma: Any) -> Any:
        """(E - V)/sigma^2."""
        half = sigma * sigma / 2
        return ball(self.g) * (amplitude - half).sin() * half.sinc()

    @property
    def _arm(self) -> Any:
        return ball(self.m * self.length / (self.M + self.m))

    def _drift(self) -> Any:
        """The speed of the centre of mass."""
        return ball(self.vx) + self._arm * ball(self.omega) * ball(self.theta).cos()

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if t == 0:
            return [ball(self.x), ball(self.theta), ball(self.vx), ball(self.omega)]
        amplitude, track, start = self._quarter()
        time, period = ball(t) + start, 4 * track.duration
        time -= round(float((time / period).mid())) * period
        past = time if time.mid() >= 0 else -time
        inward, side = (-1 if time.mid() >= 0 else 1), 1
        if (past - track.duration).mid() > 0:
            past, side = 2 * track.duration - past, -1
        sigma = track.arrival(past)
        theta = side * (amplitude - sigma * sigma)
        rate = inward * sigma * (2 * self._push(amplitude, sigma) / self._inertia(theta)).sqrt()
        drift, arm = self._drift(), self._arm
        place = ball(self.x) + arm * (ball(self.theta).sin() - theta.sin()) + drift * ball(t)
        return [place, theta, drift - arm * rate * theta.cos(), rate]

    def _cycle(self, mp: Any) -> Cycle | None:
        period, way = refined(
            mp, lambda: [4 * self._quarter().track.duration, 4 * self._quarter().track.duration * self._drift()]
        )
        return Cycle(period, (way, mp.zero, mp.zero, mp.zero))


@lru_cache(maxsize=32)
def _quarter(motion: LightCart, bits: int) -> Quarter:
    theta, omega = ball(motion.theta), ball(motion.omega)
    amplitude, gap = abs(theta), flint.arb(0)
    if motion.omega:
        half = (theta / 2).sin()
        energy = motion._inertia(theta) * omega * omega / 2 + 2 * ball(motion.g) * half * half
        amplitude = 2 * (energy / (2 * ball(motion.g))).sqrt().asin()
        gap = amplitude - abs(theta)

    # Made once: thousands of evaluations of the pace share these balls.
    total = motion.m + motion.M
    light, heavy = ball(motion.length * motion.M / total), ball(motion.length * motion.m / total)
    wide, twice_g = flint.acb(amplitude), 2 * ball(motion.g)

    def pace(sigma: Any, analytic: bool) -> Any:
        square = sigma * sigma
        sine, half = (wide - square).sin(), square / 2
        return 2 * ((light + heavy * sine * sine) / (twice_g * (wide - half).sin() * half.sinc())).sqrt(
            analytic=analytic
        )

    longest = LONGEST * float(motion.length / motion.g) ** 0.5
    track = Track(pace, amplitude.sqrt(), longest)
    begun = flint.acb.integral(pace, flint.acb(0), flint.acb(gap.sqrt())).real if motion.omega else flint.arb(0)
    # to the right and moving in: after the turning point at +a
    start = begun if motion.omega < 0 or not motion.omega else -begun
    if motion.theta < 0:
        start = 2 * track.duration + (begun if motion.omega > 0 else -begun)
    return Quarter(amplitude, track, start)
