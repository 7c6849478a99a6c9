"""Droplets in electric fields: a jet between charged plates, and Millikan's drop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from typing import Any

import flint
from gnomon.reference.flight.projectile_stokes_drag import StokesDrag
from gnomon.reference.numerics.balls import ball, sign
from gnomon.reference.numerics.motion import BallMotion

ZERO = Fraction(0)


@dataclass(frozen=True)
class InkJet(BallMotion):
    """State (x, y, vx, vy), vx > 0: acceleration `pull` along y up to x = plates, then free flight to x = paper.

    Stokes drag nu v acts on the whole path. The drop stays where it meets the paper.
    """

    pull: Fraction
    plates: Fraction
    paper: Fraction
    nu: Fraction
    x: Fraction
    y: Fraction
    vx: Fraction
    vy: Fraction

    @cached_property
    def _free(self) -> StokesDrag:
        return StokesDrag(self.nu, (ZERO, ZERO), (self.x, self.y), (self.vx, self.vy))

    @cached_property
    def _pulled(self) -> StokesDrag:
        return StokesDrag(self.nu, (ZERO, self.pull), (self.x, self.y), (self.vx, self.vy))

    def reaches(self, place: Fraction) -> bool:
        """Whether the drop reaches x = place, despite the drag."""
        return self.nu * (place - self.x) < self.vx

    def time_at(self, place: Fraction, digits: int = 15) -> Any:
        """Time at which it is there (s): -ln(1 - nu (place - x)/vx)/nu, or (place - x)/vx without drag."""
        return self._derived(digits, lambda: self._time(place))

    def crossing(self, place: Fraction, digits: int = 15) -> tuple[Any, ...]:
        """The state at x = plates, or at x = paper before the drop stops."""

        def state(component: int) -> Any:
            return (self._at_plates() if place == self.plates else self._at_paper())[component]

        return tuple(self._derived(digits, partial(state, component)) for component in range(4))

    def _balls(self, t: Fraction) -> Sequence[Any]:
        if self.x >= self.paper:
            return [ball(value) for value in (self.x, self.y, ZERO if t > 0 else self.vx, ZERO if t > 0 else self.vy)]
        if self._before(t, self.paper):
            if self.x < self.plates and self._before(t, self.plates):
                return self._pulled._balls(t)
            return self._flying(t)
        x, y, *_ = self._at_paper()
        return [x, y, flint.arb(0), flint.arb(0)]

    def _before(self, t: Fraction, place: Fraction) -> bool:
        """Whether x < place at t; without drag in rational numbers, with drag the time there is irrational."""
        if not self.reaches(place):
            return True
        if self.nu == 0:
            return t < (place - self.x) / self.vx
        return sign(lambda: self._time(place) - ball(t)) > 0

    def _time(self, place: Fraction) -> Any:
        way = (place - self.x) / self.vx
        return ball(way) if self.nu == 0 else -ball(-self.nu * way).log1p() / ball(self.nu)

    def _at_plates(self) -> list[Any]:
        """The state at x = plates; the loss of vx is nu times the distance."""
        if self.x >= self.plates:
            return [ball(value) for value in (self.x, self.y, self.vx, self.vy)]
        return self._place(self._pulled, self._time(self.plates), self.plates)

    def _flying(self, t: Fraction) -> list[Any]:
        """The state in free flight, at t."""
        _x, y, _vx, vy = self._at_plates()
        since = ball(t) - (self._time(self.plates) if self.x < self.plates else 0)
        x, _y, vx, _vy = self._free._balls(t)
        fading, first, _second = self._free._factors(since)
        return [x, y + since * first * vy, vx, fading * vy]

    def _at_paper(self) -> list[Any]:
        _x, y, _vx, vy = self._at_plates()
        since = self._time(self.paper) - (self._time(self.plates) if self.x < self.plates else 0)
        fading, first, _second = self._free._factors(since)
        return [ball(self.paper), y + since * first * vy, ball(self.vx - self.nu * (self.paper - self.x)), fading * vy]

    def _place(self, motion: StokesDrag, time: Any, x: Fraction) -> list[Any]:
        fading, first, second = motion._factors(time)
        y, vy, pull = ball(self.y), ball(self.vy), ball(self.pull)
        return [
            ball(x),
            y + time * (first * vy + time * second * pull),
            ball(self.vx - self.nu * (x - self.x)),
            fading * vy + time * first * pull,
        ]


@dataclass(frozen=True)
class OilDrop(StokesDrag):
    """State (y, v): m v' = -(m - m_air) g + q E - 6 pi eta a v with m = 4 pi a^3 rho/3; give nu = 9 eta/(2 a^2 rho).

    `acceleration` holds the rational part, -g (1 - rho_air/rho); `lift` is 3 q E/(4 a^3 rho), to be divided by pi.
    """

    lift: Fraction = ZERO

    def _loads(self) -> list[Any]:
        return [ball(self.acceleration[0]) + ball(self.lift) / flint.arb.pi()]

    def relaxation_time(self, digits: int = 15) -> Any:
        return self._derived(digits, lambda: ball(1 / self.nu))

    def falling_speed(self, digits: int = 15) -> Any:
        """The terminal speed without field, (2/9) (rho - rho_air) g a^2/eta."""
        return self._derived(digits, lambda: ball(-self.acceleration[0] / self.nu))

    def rising_speed(self, digits: int = 15) -> Any:
        """The upward terminal speed in the field."""
        return self._derived(digits, lambda: self._loads()[0] / ball(self.nu))

    def charge(self, radius: Fraction, viscosity: Fraction, field: Fraction, digits: int = 15) -> Any:
        """Millikan's formula, 6 pi eta a (v_up + v_down)/E."""

        def formula() -> Any:
            both = self._loads()[0] / ball(self.nu) - ball(self.acceleration[0] / self.nu)
            return 6 * flint.arb.pi() * ball(viscosity * radius / field) * both

        return self._derived(digits, formula)
