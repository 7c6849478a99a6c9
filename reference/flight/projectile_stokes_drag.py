"""Uniform force and Stokes drag: r'' = a - nu r'.

With z = nu t: r = r0 + v0 t phi1(-z) + a t^2 phi2(-z) and r' = v0 e^-z + a t phi1(-z), phi1(-z) = (1 - e^-z)/z and
phi2(-z) = (1 - phi1(-z))/z, entire functions of nu: without drag they are 1 and 1/2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.motion import BallMotion


@dataclass(frozen=True)
class StokesDrag(BallMotion):
    """State (position..., velocity...) in any number of dimensions, `acceleration` by the uniform force."""

    nu: Fraction
    acceleration: tuple[Fraction, ...]
    position: tuple[Fraction, ...]
    velocity: tuple[Fraction, ...]

    def _balls(self, t: Fraction) -> Sequence[Any]:
        fading, first, second = self._factors(ball(t))
        time = ball(t)
        rows = list(zip(self._loads(), map(ball, self.position), map(ball, self.velocity), strict=True))
        places = [x + time * (first * v + time * second * a) for a, x, v in rows]
        return [*places, *(fading * v + time * first * a for a, _, v in rows)]

    def _loads(self) -> list[Any]:
        """The accelerations as balls; a subclass may have irrational ones."""
        return [ball(a) for a in self.acceleration]

    def _factors(self, time: Any) -> tuple[Any, Any, Any]:
        """e^-z, phi1(-z), phi2(-z)."""
        z = ball(self.nu) * time
        if z.is_zero():
            return flint.arb(1), flint.arb(1), flint.arb(1) / 2
        first = -(-z).expm1() / z
        return (-z).exp(), first, (1 - first) / z

    def flight_time(self, axis: int, digits: int = 15) -> Any | None:
        """Time at which coordinate `axis`, thrown against its acceleration, is back at its start (s); None otherwise.

        (A + W0(-A e^-A))/nu with A = 1 - nu v/a, Lambert's W on its principal branch; -2v/a without drag. Next to A = 1
        the two terms cancel, and the balls use more digits.
        """
        a, v = self.acceleration[axis], self.velocity[axis]
        if a * v >= 0:
            return None
        return self._derived(digits, lambda: self._flight_time(a, v))

    def range(self, axis: int, along: int, digits: int = 15) -> Any | None:
        """Displacement of coordinate `along` at the flight time of `axis`."""
        a, v = self.acceleration[axis], self.velocity[axis]
        if a * v >= 0:
            return None

        def distance() -> Any:
            time = self._flight_time(a, v)
            _, first, second = self._factors(time)
            return time * (first * ball(self.velocity[along]) + time * second * ball(self.acceleration[along]))

        return self._derived(digits, distance)

    def _flight_time(self, a: Fraction, v: Fraction) -> Any:
        if self.nu == 0:
            return ball(-2 * v / a)
        whole = ball(1 - self.nu * v / a)
        return (whole + (-whole * (-whole).exp()).lambertw()) / ball(self.nu)

    def terminal_speed(self, axis: int, digits: int = 15) -> Any:
        """Terminal speed |a|/nu along one axis; nu > 0."""
        return self._derived(digits, lambda: abs(self._loads()[axis]) / ball(self.nu))
