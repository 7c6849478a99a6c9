"""A point under a uniform force and a force normal to its velocity: a charge in uniform fields, a fall on the Earth.

r'' = a + r' x W - Om x (Om x r), each vector constant.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.linear import LinearMotion, Row
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.numerics.precision import exact, publish, working
from gnomon.reference.numerics.vectors import cross, dot

Vector = tuple[Fraction, Fraction, Fraction]
ZERO: Vector = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True)
class Gyration(LinearMotion):
    """State (x, y, z, vx, vy, vz)."""

    position: Vector
    velocity: Vector

    dimension = 6

    @abstractmethod
    def _vectors(self) -> tuple[Row, Row, Row]:
        """a, W and Om."""

    def _system(self) -> tuple[Sequence[Row], Row]:
        (ax, ay, az), (wx, wy, wz), turning = self._vectors()
        pull = _centrifugal(turning)
        rows = (
            (0, 0, 0, 1, 0, 0, 0),
            (0, 0, 0, 0, 1, 0, 0),
            (0, 0, 0, 0, 0, 1, 0),
            (*pull[0], 0, wz, -wy, ax),
            (*pull[1], -wz, 0, wx, ay),
            (*pull[2], wy, -wx, 0, az),
            (0, 0, 0, 0, 0, 0, 0),
        )
        return rows, (*self.position, *self.velocity, 1)


def _centrifugal(turning: Row) -> list[list[Any]]:
    """The matrix of -Om x (Om x r): Om^2 - Om Om^T."""
    square = sum(x * x for x in turning)
    return [[(square if i == j else 0) - turning[i] * turning[j] for j in range(3)] for i in range(3)]


@dataclass(frozen=True)
class Charge(Gyration):
    """A charge in uniform fields: a = (q/m) E, W = (q/m) B."""

    q_m: Fraction
    electric: Vector
    magnetic: Vector

    def _vectors(self) -> tuple[Row, Row, Row]:
        return [self.q_m * x for x in self.electric], [self.q_m * x for x in self.magnetic], ZERO

    def _cycle(self, mp: Any) -> Cycle | None:
        """Without a force along the magnetic field each gyration is the previous one, shifted by the drift."""
        square = dot(self.magnetic, self.magnetic)
        if not square * self.q_m or dot(self.electric, self.magnetic):
            return None
        period = 2 * mp.pi / mp.sqrt(mp.mpf(self.q_m**2 * square))
        share = dot(self.velocity, self.magnetic) / square
        pace = [drift + share * field for drift, field in zip(self.drift, self.magnetic, strict=True)]
        return Cycle(period, (*(mp.mpf(x) * period for x in pace), *[mp.zero] * 3))

    def _rate(self) -> float:
        """With a force along the magnetic field no gyration repeats the previous one."""
        if not dot(self.electric, self.magnetic):
            return 0.0
        return abs(float(self.q_m)) * math.hypot(*map(float, self.magnetic))

    def gyration_rate(self, digits: int = 15) -> Any:
        """|q/m| |B| (rad/s)."""
        return self._derived(digits, lambda: ball(self.q_m**2 * dot(self.magnetic, self.magnetic)).sqrt())

    def gyration_period(self, digits: int = 15) -> Any:
        """Period of the gyration (s); needs a magnetic field."""
        square = self.q_m**2 * dot(self.magnetic, self.magnetic)
        return self._derived(digits, lambda: 2 * flint.arb.pi() / ball(square).sqrt())

    @property
    def drift(self) -> Vector:
        """The drift velocity E x B / B^2, exactly; needs a magnetic field."""
        square = dot(self.magnetic, self.magnetic)
        x, y, z = cross(self.electric, self.magnetic)
        return x / square, y / square, z / square

    def gyroradius(self, digits: int = 15) -> Any:
        """Gyroradius (m): speed normal to the field in the drifting frame, over the gyration rate."""
        square = dot(self.magnetic, self.magnetic)
        moving = tuple(v - d for v, d in zip(self.velocity, self.drift, strict=True))
        across = dot(moving, moving) - dot(moving, self.magnetic) ** 2 / square
        return self._derived(digits, lambda: ball(across / (self.q_m**2 * square)).sqrt())


@dataclass(frozen=True)
class RotatingFall(Gyration):
    """Free motion in a frame rotating at Om (0, cos lat, sin lat): x east, y north, z up.

    Gravity g along -z rotates with the frame; `centrifugal` includes Om^2 r_perp, with the origin on the axis.
    """

    g: Fraction
    Om: Fraction
    lat: Fraction
    centrifugal: bool = False

    def _vectors(self) -> tuple[Row, Row, Row]:
        sine, cosine = ball(self.lat).sin_cos()
        rate = ball(self.Om)
        turning = (flint.arb(0), rate * cosine, rate * sine)
        return (0, 0, -self.g), [2 * x for x in turning], turning if self.centrifugal else ZERO

    def first_order_deflection(self, digits: int = 15) -> Any:
        """Eastward deflection of a drop to z = 0, first order in Om: g Om cos(lat) t^3/3 with t = sqrt(2 z/g)."""

        def formula() -> Any:
            time = ball(2 * self.position[2] / self.g).sqrt()
            return ball(self.g * self.Om / 3) * ball(self.lat).cos() * time**3

        return self._derived(digits, formula)

    def strike(self, rough: float, digits: int = 15) -> tuple[Any, Any, Any]:
        """Time at which z = 0, near `rough` (s), and x and y there."""
        return strike(self, rough, digits)


def strike(motion: Motion, rough: float, digits: int) -> tuple[Any, Any, Any]:
    """Time at which a fall (x, y, z, vx, vy, vz) has z = 0, near `rough` (s), and x and y there: Newton's method."""
    time = Fraction(rough)
    for _ in range(math.ceil(math.log2(digits)) + 3):
        _x, _y, z, _vx, _vy, vz = (exact(value) for value in motion.state(time, digits + 10))
        time -= z / vz
    with working(digits + 10) as mp:
        x, y, *_ = motion.state(time, digits)
        return publish([mp.mpf(time)], digits)[0], x, y
