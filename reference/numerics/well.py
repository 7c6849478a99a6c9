"""Motions in a potential well: M(x) x'^2/2 + V(x) = E between two turning points, by quadrature and inversion.

With x = c + h cos(phi) the time is the integral of h sin(phi) sqrt(M/(2 (E - V))), an even, analytic, periodic function
of phi: a cosine series (reference/numerics/phase.py). Cyclic coordinates, mostly angles, are integrals of the same
kind, because their rates depend on x alone. All else in the state is periodic.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
import numpy as np
from gnomon.reference.numerics.balls import as_ball, precision
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.phase import FIRST, MOST, Balls, CosineSeries, cosine_series
from gnomon.reference.numerics.pointwise import Cycle
from gnomon.reference.numerics.precision import working

ROUGH = 80
"""Bits of the first, rough series, which predicts the number of terms at higher precision."""
MOST_ROUGH = 2**12
"""Most terms of the rough series; a motion that it accepts has enough terms for 600 bits."""
MOST_DOUBLINGS = 1000
"""Doublings of 1 m in the search for a turning point, which ends at about 1e300 m."""
EXTRA = 60
EXTRA_BITS = 200
"""Guard digits for cancellation: E - V next to the turning points, small swings, starts close to a turning point."""


@dataclass(frozen=True)
class _Shape:
    """Middle and half width of the swing, the phase at the start, the series of the time and the cyclic coordinates."""

    middle: Any
    reach: Any
    start: Any
    series: tuple[CosineSeries, ...]
    begun: tuple[Any, ...]
    """The integrals from phase 0 to the start."""
    table: Any


class WellMotion(Motion):
    """A subclass states M, V, V', the bottom of the well and its walls, the start, and the state as a function of x."""

    def _mass(self, mp: Any, x: Any) -> Any:
        return mp.one

    @abstractmethod
    def _potential(self, mp: Any, x: Any) -> Any: ...

    @abstractmethod
    def _slope(self, mp: Any, x: Any) -> Any:
        """V'."""

    @abstractmethod
    def _bottom(self, mp: Any) -> Any:
        """Where V is least."""

    def _walls(self, mp: Any) -> tuple[Any, Any]:
        """V reaches every energy of the domain strictly between these."""
        return -mp.inf, mp.inf

    @abstractmethod
    def _begin(self) -> tuple[Fraction, Fraction]:
        """x and x' at t = 0."""

    def _carried(self, mp: Any, x: Any) -> tuple[Any, ...]:
        """Rates of the cyclic coordinates."""
        return ()

    @abstractmethod
    def _read(self, mp: Any, t: Fraction, x: Any, rate: Any, carried: Sequence[Any]) -> Sequence[Any]:
        """The state; `carried` are the changes of the cyclic coordinates since the start."""

    @property
    @abstractmethod
    def rests(self) -> bool:
        """Whether x stays where it starts."""

    def _turned(self, mp: Any, carried: Sequence[Any], period: Any) -> Sequence[Any]:
        """The change of the state over a period in which the cyclic coordinates change by `carried`."""
        raise NotImplementedError

    def period(self, digits: int = 15) -> Any:
        """Time after which x repeats."""
        return self._quantity(digits, lambda mp: _shape(self, mp.prec).series[0].integral_over_turn(mp), 20)

    def carried_over_period(self, index: int = 0, digits: int = 15) -> Any:
        """The change of cyclic coordinate `index` over one period of x."""
        return self._quantity(digits, lambda mp: _shape(self, mp.prec).series[1 + index].integral_over_turn(mp), 20)

    def apsidal_angle(self, digits: int = 15) -> Any:
        """Half the change of the first cyclic coordinate over a period: from the least x to the largest."""
        angle = self.carried_over_period(0, digits + 5)
        return self._quantity(digits, lambda mp: mp.mpf(angle) / 2)

    def turning_points(self, digits: int = 15) -> tuple[Any, Any]:
        """The least and the largest x."""
        return (
            self._quantity(digits, lambda mp: self._edges(mp)[0], EXTRA),
            self._quantity(digits, lambda mp: self._edges(mp)[1], EXTRA),
        )

    def energy(self, digits: int = 15) -> Any:
        """M x'^2/2 + V."""
        return self._quantity(digits, self._energy, EXTRA)

    def _energy(self, mp: Any) -> Any:
        x, v = (mp.mpf(value) for value in self._begin())
        return self._mass(mp, x) * v**2 / 2 + self._potential(mp, x)

    def _edges(self, mp: Any) -> tuple[Any, Any]:
        """The turning points; a start at one of them is used exactly."""
        x0, v0 = self._begin()
        energy, bottom = self._energy(mp), self._bottom(mp)
        edges = []
        for wall, side in zip(self._walls(mp), (-1, 1), strict=True):
            start = mp.mpf(x0)
            if v0 == 0 and (start - bottom) * side > 0:
                edges.append(start)
                continue
            edges.append(self._edge(mp, energy, bottom, wall, side))
        return edges[0], edges[1]

    def _edge(self, mp: Any, energy: Any, inside: Any, wall: Any, side: int) -> Any:
        """Where V = E on one side of the bottom: bisection until Newton's method is sure to converge, then that."""
        bottom = inside
        width = mp.one if mp.isinf(wall) else abs(wall - inside) / 2
        outside = inside + side * width
        for _ in range(MOST_DOUBLINGS):
            if self._potential(mp, outside) > energy:
                break
            width = 2 * width if mp.isinf(wall) else (width + abs(wall - inside)) / 2
            outside = inside + side * width
        else:
            raise ArithmeticError(f"no turning point within {float(abs(outside - inside)):g}")
        for _ in range(mp.prec):
            middle = (inside + outside) / 2
            if self._potential(mp, middle) <= energy:
                inside = middle
            else:
                outside = middle
            step = (self._potential(mp, outside) - energy) / self._slope(mp, outside)
            # V is convex enough once a step is small against the width it starts from
            if abs(step) < abs(outside - bottom) / 10**8:
                break
        for _ in range(60):
            step = (self._potential(mp, outside) - energy) / self._slope(mp, outside)
            outside -= step
            if abs(step) <= mp.eps * (abs(outside) + abs(outside - inside)) * 8:
                break
        return outside

    def _guard(self, t: Fraction) -> float:
        if self.rests:
            return 10
        with working(20) as mp:
            period = _shape(self, ROUGH).series[0].integral_over_turn(mp)
            return 25 + 5 * round(float(mp.log10(1 + abs(mp.mpf(t)) / period)) / 5)

    def _cycle(self, mp: Any) -> Cycle | None:
        if self.rests:
            return None
        series = _shape(self, mp.prec).series
        period, *carried = (expansion.integral_over_turn(mp) for expansion in series)
        return Cycle(period, self._turned(mp, carried, period))

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        x0, _ = self._begin()
        if self.rests:
            here = mp.mpf(x0)
            carried = [rate * mp.mpf(t) for rate in self._carried(mp, here)]
            return self._read(mp, t, here, mp.zero, carried)
        shape = _shape(self, mp.prec)
        period = shape.series[0].integral_over_turn(mp)
        time = mp.mpf(t) + shape.begun[0]
        turns = mp.nint(time / period)
        time -= turns * period
        phases, times = shape.table
        phi = mp.mpf(float(np.interp(float(time), times, phases)))
        for _ in range(60):
            pace, past = shape.series[0].at(mp, phi)
            step = (past - time) / pace
            phi -= step
            if abs(step) < mp.mpf(2) ** (-mp.prec // 2 - 8):  # the next error is the square of this one
                break
        pace, past = shape.series[0].at(mp, phi)
        phi += (time - past) / pace
        cosine, sine = mp.cos_sin(phi)
        carried = []
        for expansion, begun in zip(shape.series[1:], shape.begun[1:], strict=True):
            carried.append(expansion.at(mp, phi)[1] - begun + turns * expansion.integral_over_turn(mp))
        return self._read(mp, t, shape.middle + shape.reach * cosine, -shape.reach * sine / pace, carried)


@lru_cache(maxsize=64)
def _shape(motion: WellMotion, bits: int) -> _Shape:
    with working(20) as mp:
        mp.prec = bits + 10
        wanted = mp.dps
        mp.dps = wanted + EXTRA
        low, high = motion._edges(mp)
        energy = motion._energy(mp)
        middle, reach = (low + high) / 2, (high - low) / 2
        x0, v0 = (mp.mpf(value) for value in motion._begin())
        if v0:
            cosine = max(-mp.one, min(mp.one, (x0 - middle) / reach))
            start = -mp.sign(v0) * mp.acos(cosine)
        else:
            start = mp.pi if x0 < middle else mp.zero

        centre, width, total = as_ball(middle), as_ball(reach), as_ball(energy)

        def pace(cosine: Any, sine: Any) -> Any:
            with precision(flint.ctx.prec + EXTRA_BITS):
                x = centre + width * cosine
                left = total - motion._potential(Balls, x)
                return width * sine * (motion._mass(Balls, x) / (2 * left)).sqrt()

        def carry(index: int) -> Callable[[Any, Any], Any]:
            return lambda c, s: motion._carried(Balls, centre + width * c)[index] * pace(c, s)

        mp.dps = wanted
        count = len(motion._carried(mp, middle))
        functions = [pace, *(carry(i) for i in range(count))]
        known = _shape(motion, ROUGH).series if bits > ROUGH else ()
        most = MOST if bits > ROUGH else MOST_ROUGH
        firsts = [expansion.expected(mp.prec) for expansion in known] or [FIRST] * len(functions)
        series = tuple(cosine_series(f, mp.prec, first, most) for f, first in zip(functions, firsts, strict=True))
        begun = tuple(expansion.at(mp, start)[1] for expansion in series)
        phases, times = series[0].table()
        return _Shape(+middle, +reach, +start, series, begun, (phases, times))
