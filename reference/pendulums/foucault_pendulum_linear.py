"""Foucault's pendulum for small amplitudes, exactly."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.pointwise import Cycle, Turn
from gnomon.reference.numerics.precision import publish, working


@dataclass(frozen=True)
class Foucault(Motion):
    """Z = x + iy (east, north, m) with Z'' + 2 i W Z' + (g/L) Z = 0, W = Om sin(lat).

    Z = exp(-iWt) (Z0 cos st + ((V0 + iW Z0)/s) sin st), s^2 = g/L + W^2. With `larmor` the equation has the term
    -W^2 Z that makes s^2 = g/L: an isotropic oscillator seen from a frame rotating at W, which only precesses.
    """

    g: Fraction
    L: Fraction
    Om: Fraction
    lat: Fraction
    x: Fraction
    y: Fraction
    vx: Fraction
    vy: Fraction
    larmor: bool = False

    def _state(self, mp: Any, t: Fraction) -> list[Any]:
        W, s = self._rates(mp)
        z, v = mp.mpc(self.x, self.y), mp.mpc(self.vx, self.vy)
        time = mp.mpf(t)
        # In the frame that rotates with the plane of swing it is an isotropic oscillator.
        start = v + 1j * W * z
        cosine, sine = mp.cos(s * time), mp.sin(s * time)
        place, speed = z * cosine + start / s * sine, start * cosine - z * s * sine
        turn = mp.mpc(mp.cos(W * time), -mp.sin(W * time))
        here, moving = turn * place, turn * (speed - 1j * W * place)
        return [here.real, here.imag, moving.real, moving.imag]

    def _guard(self, t: Fraction) -> float:
        """Digits of the phase, and for W above sqrt(g/L) digits of terms that cancel."""
        with working(15) as mp:
            W, s = self._rates(mp)
            phase = (s + abs(W)) * abs(mp.mpf(t))
            return float(15 + mp.log10(1 + phase) + 2 * mp.log10(1 + abs(W) / s + s / mp.sqrt(mp.mpf(self.g / self.L))))

    def _cycle(self, mp: Any) -> Cycle:
        """Each swing is the previous one, rotated."""
        W, s = self._rates(mp)
        period = 2 * mp.pi / s
        sine, cosine = mp.sin(W * period), mp.cos(W * period)
        return Cycle(period, (mp.zero,) * 4, [Turn([[cosine, sine], [-sine, cosine]], [[0, 1], [2, 3]])])

    def _rates(self, mp: Any) -> tuple[Any, Any]:
        W = mp.mpf(self.Om) * mp.sin(mp.mpf(self.lat))
        square = mp.mpf(self.g / self.L)
        return W, mp.sqrt(square if self.larmor else square + W * W)

    def precession_rate(self, digits: int = 15) -> Any:
        """Angular velocity of the plane of swing (rad/s): -Om sin(lat), clockwise in the northern hemisphere."""
        return self._quantity(digits, lambda mp: -self._rates(mp)[0])

    def swing_period(self, digits: int = 15) -> Any:
        """Period of the oscillator in the rotating frame, 2 pi / s (s)."""
        return self._quantity(digits, lambda mp: 2 * mp.pi / self._rates(mp)[1])

    def closest(self, digits: int = 15) -> Any:
        """The least distance from the origin: the difference of the two circles' radii, |P^2 - Q^2|/(P + Q) (m)."""

        def distance(mp: Any) -> Any:
            W, s = self._rates(mp)
            z, v = mp.mpc(self.x, self.y), mp.mpc(self.vx, self.vy)
            start = (v + 1j * W * z) / s
            both = abs(z - 1j * start) + abs(z + 1j * start)
            # P^2 - Q^2 = Im(start conj(z)), the angular momentum over s; the two vanish together.
            return 2 * abs((start * mp.conj(z)).imag) / both if both else mp.zero

        return self._quantity(digits, distance, 30)

    def circles(self, digits: int = 15) -> tuple[Any, Any, Any, Any]:
        """Radii (m) and rates (rad/s) of the two circular motions whose sum Z is: P, Q, s - W, -(s + W)."""
        with working(digits + 15) as mp:
            W, s = self._rates(mp)
            z, v = mp.mpc(self.x, self.y), mp.mpc(self.vx, self.vy)
            start = (v + 1j * W * z) / s
            return publish((abs(z - 1j * start) / 2, abs(z + 1j * start) / 2, s - W, -(s + W)), digits)  # type: ignore[return-value]
