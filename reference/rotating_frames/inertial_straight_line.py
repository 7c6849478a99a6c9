"""Uniform straight motion in a rotating frame, and the first-order Coriolis deflection."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.motion import BallMotion


@dataclass(frozen=True)
class StraightLine(BallMotion):
    """State (x, y, vx, vy) in a frame rotating at Om: z = e^(-i Om t) (z0 + (v0 + i Om z0) t), z = x + iy."""

    Om: Fraction
    x: Fraction
    y: Fraction
    vx: Fraction
    vy: Fraction

    def _balls(self, t: Fraction) -> Sequence[Any]:
        sine, cosine = ball(self.Om * t).sin_cos()
        vx, vy = self.inertial_velocity
        back = flint.acb(cosine, -sine)
        place = back * flint.acb(ball(self.x + vx * t), ball(self.y + vy * t))
        speed = back * flint.acb(ball(vx), ball(vy)) - flint.acb(0, ball(self.Om)) * place
        return place.real, place.imag, speed.real, speed.imag

    @property
    def inertial_velocity(self) -> tuple[Fraction, Fraction]:
        """Velocity in the inertial frame that coincides with the rotating one at t = 0."""
        return self.vx - self.Om * self.y, self.vy + self.Om * self.x

    def closest_distance(self, digits: int = 15) -> Any:
        """Distance of the straight line from the axis."""
        vx, vy = self.inertial_velocity
        square = vx**2 + vy**2
        if square == 0:
            return self._derived(digits, lambda: ball(self.x**2 + self.y**2).sqrt())
        return self._derived(digits, lambda: ball((self.x * vy - self.y * vx) ** 2 / square).sqrt())


@dataclass(frozen=True)
class FirstOrderFall(BallMotion):
    """r = r0 + v0 t + g t^2/2 - Om x (u t^2 + g t^3/3): the Coriolis acceleration of the velocity u + g t.

    State (x, y, z, vx, vy, vz), x east, y north, z up, Om = Om (0, cos lat, sin lat); u is `thrown`, v0 for a throw.
    """

    g: Fraction
    Om: Fraction
    lat: Fraction
    thrown: tuple[Fraction, Fraction, Fraction]
    position: tuple[Fraction, Fraction, Fraction]
    velocity: tuple[Fraction, Fraction, Fraction]

    def _balls(self, t: Fraction) -> Sequence[Any]:
        sine, cosine = ball(self.lat).sin_cos()
        oy, oz = ball(self.Om) * cosine, ball(self.Om) * sine
        ux, uy, uz = self.thrown

        def turned(a: Fraction, b: Fraction, c: Fraction) -> tuple[Any, Any, Any]:
            """(a, b, c) x Om."""
            return ball(b) * oz - ball(c) * oy, -ball(a) * oz, ball(a) * oy

        free = [x + v * t for x, v in zip(self.position, self.velocity, strict=True)]
        free[2] -= self.g * t**2 / 2
        fall = [*self.velocity[:2], self.velocity[2] - self.g * t]
        shift = turned(ux * t**2, uy * t**2, uz * t**2 - self.g * t**3 / 3)
        gain = turned(2 * ux * t, 2 * uy * t, 2 * uz * t - self.g * t**2)
        return [ball(x) + dx for x, dx in zip((*free, *fall), (*shift, *gain), strict=True)]
