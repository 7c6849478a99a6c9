"""A fall from a tower on a rotating planet that attracts like a point mass.

In the inertial frame it is a Kepler orbit that starts with the velocity of the top of the tower; the planet's frame
rotates. So the deflection is exact, without an expansion in Om or in the height.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import decades
from gnomon.reference.numerics.precision import working
from gnomon.reference.numerics.vectors import add, cross, dot, scale
from gnomon.reference.orbits.conic import Conic


@dataclass(frozen=True)
class TowerDrop(Conic):
    """State (x, y, z, vx, vy, vz): east, north and up from the tower's foot at latitude `lat`, R from the centre.

    g is the gravitation at the foot, Om the angular velocity of the planet. The orbit is bound and misses the centre.
    """

    g: Fraction
    R: Fraction
    Om: Fraction
    lat: Fraction
    position: tuple[Fraction, Fraction, Fraction]
    velocity: tuple[Fraction, Fraction, Fraction]

    @property
    def mu(self) -> Fraction:  # type: ignore[override]
        return self.g * self.R**2

    @property
    def conic(self) -> int:  # type: ignore[override]
        return 1

    @property
    def bound(self) -> bool:
        """Whether the speed is below the escape speed, decided with 40 digits."""
        with working(60) as mp:
            r0, alpha, _s0, _root = self._elements(mp)
            return bool(alpha * r0 > mp.mpf(10) ** -40)

    def _turning(self, mp: Any) -> tuple[Any, Any, Any]:
        lat, rate = mp.mpf(self.lat), mp.mpf(self.Om)
        return mp.zero, rate * mp.cos(lat), rate * mp.sin(lat)

    def _start(self, mp: Any) -> tuple[Any, Any]:
        """Position from the centre and velocity, in the inertial frame."""
        x, y, z = self.position
        place = tuple(mp.mpf(value) for value in (x, y, z + self.R))
        return place, add([mp.mpf(value) for value in self.velocity], cross(self._turning(mp), place))

    def _elements(self, mp: Any) -> tuple[Any, Any, Any, Any]:
        place, velocity = self._start(mp)
        mu = mp.mpf(self.mu)
        r0, root = mp.sqrt(dot(place, place)), mp.sqrt(mu)
        return r0, 2 / r0 - dot(velocity, velocity) / mu, dot(place, velocity) / root, root

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        start, first = self._start(mp)
        f, g, df, dg = self._lagrange(mp, t)
        place, velocity = add(scale(f, start), scale(g, first)), add(scale(df, start), scale(dg, first))
        turning = self._turning(mp)
        here = self._turned_back(mp, place, t)
        moving = add(self._turned_back(mp, velocity, t), scale(-1, cross(turning, here)))
        return here[0], here[1], here[2] - mp.mpf(self.R), *moving

    def _turned_back(self, mp: Any, vector: Sequence[Any], t: Fraction) -> tuple[Any, ...]:
        """A vector of the inertial frame in the frame of the planet (Rodrigues)."""
        lat, angle = mp.mpf(self.lat), mp.mpf(self.Om) * mp.mpf(t)
        axis = (mp.zero, mp.cos(lat), mp.sin(lat))
        cosine, sine = mp.cos(angle), mp.sin(angle)
        along = scale((1 - cosine) * dot(axis, vector), axis)
        return add(scale(cosine, vector), scale(-sine, cross(axis, vector)), along)

    def _guard(self, t: Fraction) -> float:
        """Metres of fall are a difference of planetary radii, and the deflection grows with the cube of the time."""
        height = max(*map(abs, self.position), *(abs(v) for v in self.velocity), Fraction(1, 10**6))
        return 60 + decades(self.R / height) + 2 * decades(abs(t) * abs(self.Om))
