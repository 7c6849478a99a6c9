"""Three bodies at the corners of an equilateral triangle that keeps its shape: Lagrange's motion.

If the initial velocities too belong to one similarity (translation, growth and rotation in the plane of the
triangle), each side is a Kepler motion with mu = G (m1 + m2 + m3), the same for all three: with Lagrange's f and g of
one side every position about the centre of mass is f r0 + g v0. In space such a triangle can have rational corners, in
a plane it cannot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.numerics.precision import working
from gnomon.reference.numerics.vectors import cross, dot, subtract
from gnomon.reference.orbits.conic import Conic

Vector = tuple[Fraction, Fraction, Fraction]


@dataclass(frozen=True)
class Homographic(Conic):
    """State (r1, r2, r3, v1, v2, v3), three components each; `masses` are G m of each body.

    Raises ValueError if the start is not an equilateral triangle, does not move as one similarity, or does not rotate.
    """

    masses: Vector
    places: tuple[Vector, Vector, Vector]
    velocities: tuple[Vector, Vector, Vector]

    def __post_init__(self) -> None:
        if not keeps_its_shape(self.places, self.velocities):
            raise ValueError("the start is not an equilateral triangle whose velocities keep it one")

    @cached_property
    def mu(self) -> Fraction:  # type: ignore[override]
        """G times the total mass."""
        return sum(self.masses, Fraction(0))

    @cached_property
    def _side(self) -> tuple[Vector, Vector]:
        """Position and velocity of body 2 relative to body 1."""
        return subtract(self.places[1], self.places[0]), subtract(self.velocities[1], self.velocities[0])

    @cached_property
    def _rr(self) -> Fraction:
        return Fraction(dot(self._side[0], self._side[0]))

    @cached_property
    def _vv(self) -> Fraction:
        return Fraction(dot(self._side[1], self._side[1]))

    @cached_property
    def _rv(self) -> Fraction:
        return Fraction(dot(*self._side))

    @cached_property
    def _hh(self) -> Fraction:
        """The square of the angular momentum of a side."""
        return self._rr * self._vv - self._rv**2

    def centre(self, vectors: Sequence[Vector]) -> list[Fraction]:
        """The mean, weighted by the masses."""
        return [
            sum((m * v[i] for m, v in zip(self.masses, vectors, strict=True)), Fraction(0)) / self.mu for i in range(3)
        ]

    def eccentricity(self, digits: int = 15) -> Any:
        """Eccentricity of the conic on which each body moves."""
        return self._quantity(digits, self._eccentricity, 30)

    def sides(self, digits: int = 15) -> tuple[Any, Any | None]:
        """The shortest and the longest side of the triangle; None for the longest if it is not bound."""
        pericentre = self._quantity(digits, self._pericentre, 30)
        if self.conic <= 0:
            return pericentre, None
        return pericentre, self._quantity(digits, lambda mp: 2 / self._elements(mp)[1] - self._pericentre(mp), 30)

    def _eccentricity(self, mp: Any) -> Any:
        alpha = self._elements(mp)[1]
        return mp.sqrt(max(mp.zero, 1 - alpha * mp.mpf(self._hh / self.mu)))

    def _pericentre(self, mp: Any) -> Any:
        return mp.mpf(self._hh / self.mu) / (1 + self._eccentricity(mp))

    def _guard(self, t: Fraction) -> float:
        with working(30) as mp:
            r0, alpha, _s0, _root = self._elements(mp)
            size = r0 + (1 / abs(alpha) if self.conic else 0)
            turns = abs(mp.mpf(t)) / self._period(mp) if self.conic > 0 else mp.zero
            return float(20 + mp.log10(1 + turns) + 2 * mp.log10(1 + size / self._pericentre(mp)))

    def _cycle(self, mp: Any) -> Cycle | None:
        if self.conic <= 0:
            return None
        period = self._period(mp)
        drift = [mp.mpf(v) * period for v in self.centre(self.velocities)]
        return Cycle(period, (*drift, *drift, *drift, *[mp.zero] * 9))

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        f, g, df, dg = self._lagrange(mp, t)
        centre, drift = self.centre(self.places), self.centre(self.velocities)
        places, velocities = [], []
        for place, velocity in zip(self.places, self.velocities, strict=True):
            for r, v, middle, speed in zip(place, velocity, centre, drift, strict=True):
                about, pace = mp.mpf(r - middle), mp.mpf(v - speed)
                places.append(mp.mpf(middle + speed * t) + f * about + g * pace)
                velocities.append(mp.mpf(speed) + df * about + dg * pace)
        return places + velocities


def keeps_its_shape(places: Sequence[Sequence[Fraction]], velocities: Sequence[Sequence[Fraction]]) -> bool:
    """Whether three bodies form an equilateral triangle and move as one similarity that rotates, decided exactly."""
    first, second = (subtract(places[i], places[0]) for i in (1, 2))
    pace, other = (subtract(velocities[i], velocities[0]) for i in (1, 2))
    square = dot(first, first)
    if not square or not square == dot(second, second) == 2 * dot(first, second):
        return False
    normal = cross(first, second)
    growth = dot(pace, first) / square
    turn = dot(pace, cross(normal, first)) / (square * dot(normal, normal))
    if not turn:
        return False
    for side, rate in ((first, pace), (second, other)):
        across = cross(normal, side)
        if any(v != growth * r + turn * n for v, r, n in zip(rate, side, across, strict=True)):
            return False
    return True
