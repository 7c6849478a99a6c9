"""Integrals of a function that is even, analytic and 2 pi periodic in a phase, by its cosine series.

The midpoint rule on equally spaced phases converges geometrically for such a function (Trefethen and Weideman, SIAM
Review 56, 2014), and so does its series: f = a0/2 + a1 cos(phi) + ..., integral a0 phi/2 + a1 sin(phi) + ... Terms are
added until the last quarter of them lies below the working precision. One series then gives the integral at any phase.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import flint
import numpy as np
from gnomon.reference.numerics.balls import as_ball, ball, dyadic, precision
from mpmath.libmp import from_man_exp
from numpy.typing import NDArray

FIRST = 32
ENOUGH_TO_PREDICT = 256
MOST = 2**15
"""Most terms; a function that needs more has a singularity next to the real phases."""


@dataclass(frozen=True)
class CosineSeries:
    """f(phi) and its integral from 0 to phi."""

    mean: Any
    terms: Any
    integrated: Any
    bits: int

    def expected(self, bits: int) -> int:
        """The number of terms for the same function at another precision: they decay geometrically."""
        return max(FIRST, 3 * int(self.terms.length()) * bits // (2 * self.bits) + 16)

    def at(self, mp: Any, phi: Any) -> tuple[Any, Any]:
        """(f, integral) as numbers of `mp`; any real phase."""
        with precision(self.bits):
            angle = as_ball(phi)
            z = flint.acb(angle.cos(), angle.sin())
            value = self.mean + self.terms(z).real
            integral = self.mean * angle + self.integrated(z).imag
            return to_mpf(mp, value), to_mpf(mp, integral)

    def integral_over_turn(self, mp: Any) -> Any:
        return 2 * mp.pi * to_mpf(mp, self.mean)

    def table(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Phases over [-pi, pi] and the integral there in doubles, on a grid in proportion to the number of terms."""
        weights = np.array([float(c.real.mid()) for c in self.integrated.coeffs()])
        size = 8 * (len(weights) + 8)
        phases = np.linspace(-math.pi, math.pi, size + 1)
        spectrum = np.zeros(size, dtype=complex)
        spectrum[: len(weights)] = weights
        waves = size * np.fft.ifft(spectrum).imag  # at the phases 0, 2 pi/size, ...
        rolled = np.roll(waves, size // 2)
        return phases, float(self.mean) * phases + np.append(rolled, rolled[0])


def cosine_series(
    function: Callable[[Any, Any], Any], wanted: int, first: int = FIRST, most: int = MOST
) -> CosineSeries:
    """The series of `function(cos phi, sin phi)`, over balls at phases inside (0, pi), to `wanted` bits.

    `first` is the number of terms to try first. Raises ArithmeticError where `most` terms are not enough, which is
    predicted from a few hundred of them: they decay geometrically at best.
    """
    # next to the ends of (0, pi) a quotient of small numbers loses twice the bits of the number of terms
    bits = wanted + 40
    count = _smooth(first)
    while count <= most:
        with precision(bits):
            angles = [flint.arb(2 * j + 1) / (2 * count) for j in range(count)]
            values = [function(a.cos_pi().mid(), a.sin_pi().mid()).mid() for a in angles]
            spectrum = flint.acb.dft([flint.acb(v) for v in values + values[::-1]])
            turns = [flint.arb(-k) / (2 * count) for k in range(count)]
            a = [(s * flint.acb(t.cos_pi(), t.sin_pi())).real / count for s, t in zip(spectrum, turns, strict=False)]
            a = [x.mid() for x in a]
            if _settled(a, wanted):
                last = max((k for k in range(count) if abs(a[k]) > abs(a[0]) * flint.arb(2) ** -wanted), default=0)
                cosines = a[: last + 1]
                terms = flint.acb_poly([0, *cosines[1:]])
                integrated = flint.acb_poly([0, *((x / k).mid() for k, x in enumerate(cosines[1:], start=1))])
                return CosineSeries((cosines[0] / 2).mid(), terms, integrated, bits)
            if count >= ENOUGH_TO_PREDICT and _reached(a) * most < wanted * count:
                break
        count *= 2
    raise ArithmeticError(
        f"its fastest part is too short against its period: the cosine series needs more than {most} terms"
    )


def _smooth(count: int) -> int:
    """The next number of the form 2^n or 3 2^n, for fast transforms."""
    power = 1 << (count - 1).bit_length()
    return 3 * power // 4 if 3 * power // 4 >= count else power


def _reached(a: list[Any]) -> float:
    """By how many bits the last quarter of the terms lies below the first one."""
    last = max(abs(x) for x in a[3 * len(a) // 4 :])
    return float((abs(a[0]) / last).log().mid()) / math.log(2)


def _settled(a: list[Any], bits: int) -> bool:
    small = abs(a[0]) * flint.arb(2) ** -bits
    return all(abs(x) <= small for x in a[3 * len(a) // 4 :])


def to_mpf(mp: Any, x: Any) -> Any:
    """The midpoint of a ball as a number of `mp`."""
    return mp.make_mpf(from_man_exp(*dyadic(x), mp.prec, "n"))


class Balls:
    """The functions of an mpmath context that potentials use, over balls."""

    one = flint.arb(1)

    @staticmethod
    def mpf(value: Any) -> Any:
        return flint.arb(value) if isinstance(value, int) else ball(value)

    @staticmethod
    def hypot(x: Any, y: Any) -> Any:
        return (x * x + y * y).sqrt()

    sin = staticmethod(lambda x: x.sin())
    cos = staticmethod(lambda x: x.cos())
    sqrt = staticmethod(lambda x: x.sqrt())
    exp = staticmethod(lambda x: x.exp())
    log = staticmethod(lambda x: x.log())
    log1p = staticmethod(lambda x: x.log1p())
