"""A pendulum on a much lighter cart, where the cosine series of reference/numerics/well.py needs too many terms.

With the amplitude a and theta = a - sigma^2 the time from a turning point is the integral of 2 sqrt(L mu/(2 g sin(a -
sigma^2/2) sinc(sigma^2/2))), mu = (M + m sin^2 theta)/(M + m). Next to the bottom, where mu is nearly zero, the variable
is u with sin theta = sqrt(M/m) sinh u, in which mu = M/(M + m) cosh^2 u varies slowly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

import flint
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.motion import MANY, BallMotion
from gnomon.reference.numerics.passage import Track
from gnomon.reference.numerics.pointwise import Cycle, Floats, Turn
from gnomon.reference.numerics.precision import working
from gnomon.reference.pendulums.pendulum_on_cart import Cart

LONGEST = 0.5
"""In units of sqrt(L/g): the time between two places of a track."""
LOW = 0.5
"""Up to this angle, and half the amplitude, u is the variable."""


class Quarter(NamedTuple):
    """A quarter of a swing: tracks in sigma from the turning point and in u from the bottom, and its duration.

    `start` is the time from the turning point at +a to the start of the motion.
    """

    amplitude: Any
    above: Track
    below: Track
    duration: Any
    start: Any


@dataclass(frozen=True)
class LightCart(Cart, BallMotion):
    """A pendulum that swings under a cart."""

    rests = False

    def period(self, digits: int = 15) -> Any:
        """Period of the swing."""
        return self._derived(digits, lambda: 4 * self._quarter().duration)

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

    def _low(self, amplitude: Any, u: Any) -> tuple[Any, Any]:
        """theta and |theta'|; L mu theta'^2 = 2 g (cos theta - cos a)."""
        sine = ball(self.M / self.m).sqrt() * u.sinh()
        below = 2 * (amplitude / 2).sin() ** 2 - sine * sine / (1 + (1 - sine * sine).sqrt())
        light = self.length * self.M / (self.m + self.M)
        return sine.asin(), (2 * ball(self.g / light) * below).sqrt() / u.cosh()

    @property
    def _arm(self) -> Any:
        return ball(self.m * self.length / (self.M + self.m))

    def _drift(self) -> Any:
        """The speed of the centre of mass."""
        return ball(self.vx) + self._arm * ball(self.omega) * ball(self.theta).cos()

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if t == 0:
            return [ball(self.x), ball(self.theta), ball(self.vx), ball(self.omega)]
        amplitude, above, below, quarter, start = self._quarter()
        time, period = ball(t) + start, 4 * quarter
        time -= round(float((time / period).mid())) * period
        past = time if time.mid() >= 0 else -time
        inward, side = (-1 if time.mid() >= 0 else 1), 1
        if (past - quarter).mid() > 0:
            past, side = 2 * quarter - past, -1
        if (past - above.duration).mid() <= 0:
            sigma = above.arrival(past)
            theta = amplitude - sigma * sigma
            speed = sigma * (2 * self._push(amplitude, sigma) / self._inertia(theta)).sqrt()
        else:
            theta, speed = self._low(amplitude, below.arrival(quarter - past))
        theta, rate = side * theta, inward * speed
        arm = self._arm
        return [self._centre(t) - arm * theta.sin(), theta, self._drift() - arm * rate * theta.cos(), rate]

    def _centre(self, t: Fraction) -> Any:
        """Position of the centre of mass."""
        return ball(self.x) + self._arm * ball(self.theta).sin() + self._drift() * ball(t)

    def sample(self, times: Floats, span: float | None = None, breaks: Sequence[Any] = ()) -> Floats:
        if len(times) < MANY:
            return super().sample(times, span, breaks)
        return HalfSwings(self).sample(times, span, breaks)[:, :4]


@dataclass(frozen=True)
class HalfSwings(BallMotion):
    """(x, theta, x', theta', X, 1), X the centre of mass: half a period later the motion about X changes its sign."""

    motion: LightCart

    def _balls(self, t: Fraction) -> Sequence[Any]:
        return [*self.motion._balls(t), self.motion._centre(t), flint.arb(1)]

    def _cycle(self, mp: Any) -> Cycle:
        def numbers() -> list[Any]:
            half, drift = 2 * self.motion._quarter().duration, self.motion._drift()
            return [half, drift, half * drift]

        half, drift, way = refined(mp, numbers)
        turned = [
            [-1, 0, 0, 0, 2, way],
            [0, -1, 0, 0, 0, 0],
            [0, 0, -1, 0, 0, 2 * drift],
            [0, 0, 0, -1, 0, 0],
            [0, 0, 0, 0, 1, way],
            [0, 0, 0, 0, 0, 1],
        ]
        return Cycle(half, (mp.zero,) * 6, [Turn([[mp.mpf(x) for x in row] for row in turned], [range(6)])])


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

    thin = ball(motion.M / motion.m).sqrt()
    lift = flint.acb(2 * (amplitude / 2).sin() ** 2)
    scale = thin * (light / twice_g).sqrt()

    def low_pace(u: Any, analytic: bool) -> Any:
        rising = u.cosh()
        square = (thin * u.sinh()) ** 2
        cosine = (1 - square).sqrt(analytic=analytic)
        return scale * rising * rising / (cosine * (lift - square / (1 + cosine)).sqrt(analytic=analytic))

    longest = LONGEST * float(motion.length / motion.g) ** 0.5
    low = min(Fraction(LOW), Fraction(float(amplitude.mid())) / 2)
    above = Track(pace, (amplitude - ball(low)).sqrt(), longest)
    below = Track(low_pace, (ball(low).sin() / thin).asinh(), longest)
    duration = above.duration + below.duration
    begun = flint.acb.integral(pace, flint.acb(0), flint.acb(gap.sqrt())).real if motion.omega else flint.arb(0)
    # theta > 0 and falling: after the turning point at +a
    start = begun if motion.omega < 0 or not motion.omega else -begun
    if motion.theta < 0:
        start = 2 * duration + (begun if motion.omega > 0 else -begun)
    return Quarter(amplitude, above, below, duration, start)
