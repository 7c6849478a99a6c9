"""The projectile in parabolic coordinates: x = xi eta, y = (eta^2 - xi^2)/2."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.flight.projectile_parabola import Projectile
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.motion import BallMotion


@dataclass(frozen=True)
class ParabolicProjectile(BallMotion):
    """State (xi, eta, xi', eta') under gravity g along -y; the path misses the focus, the origin of x and y.

    (eta + i xi)^2 = 2 (y + i x), and the root is continuous: x is monotone and vanishes at most once. On a path above
    the focus eta keeps its sign, on one below it xi.
    """

    g: Fraction
    xi: Fraction
    eta: Fraction
    xi_rate: Fraction
    eta_rate: Fraction

    def projectile(self) -> Projectile:
        """The same motion in x and y."""
        xi, eta, u, v = self.xi, self.eta, self.xi_rate, self.eta_rate
        return Projectile(self.g, xi * eta, (eta**2 - xi**2) / 2, u * eta + xi * v, eta * v - xi * u)

    def crossing(self) -> Fraction | None:
        """y where the path crosses x = 0; None if it stays on one side, 0 if it stays on the line x = 0."""
        flight = self.projectile()
        if flight.vx:
            return flight.rational(-flight.x / flight.vx)[1]
        return None if flight.x else Fraction(0)

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if t == 0:
            return [ball(x) for x in (self.xi, self.eta, self.xi_rate, self.eta_rate)]
        x, y, vx, vy = self.projectile().rational(t)
        r = ball(x * x + y * y).sqrt()
        if (self.crossing() or 0) >= 0:
            eta = (r + ball(y)).sqrt() * (1 if self.eta > 0 else -1)
            xi = ball(x) / eta
        else:
            xi = (r - ball(y)).sqrt() * (1 if self.xi > 0 else -1)
            eta = ball(x) / xi
        across, up = ball(vx), ball(vy)
        return [xi, eta, (across * eta - up * xi) / (2 * r), (up * eta + across * xi) / (2 * r)]
