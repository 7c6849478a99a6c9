"""Motions without a closed form, by Taylor series in high precision, dense in time.

Each step's series is kept, so that any time within it costs one evaluation of a polynomial. How far errors grow is
measured by a second integration with fewer digits, and the working precision compensates for it: the requested digits
are those in which two precisions agree.

An integration that would take too long is refused before it starts, by a `Scout`. The step of a Taylor method is a share
of the radius of convergence, whatever the order. So an integration of order 7, about 8 times cheaper than the cheapest one
of full order, takes nearly as many steps (0.7 to 3.8 times as many, over all variants of all cases).
"""

from __future__ import annotations

import bisect
import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
from gnomon.reference.numerics.balls import ball, precision
from gnomon.reference.numerics.motion import MANY, Motion
from gnomon.reference.numerics.pointwise import Floats
from gnomon.reference.numerics.precision import working
from gnomon.reference.numerics.taylor import MAX_STEPS, Field, _Flow, _fraction, _step, _value
from gnomon.reference.storage.diskcache import Entry, cached
from gnomon.reference.storage.import_closure import closure, modules_of

COARSE = 24
"""Digits of the integration that measures growth."""
LEVELS = (40, 56, 78, 150, 240)
"""Working digits: few levels, so that integrations are reused."""
MARGIN = 4
GUARD = 6
MOST_WORK = 25_000
"""Most steps times nodes that a scout may take unless a motion allows more, about 0.4 s: some 10 s of integrations."""
NODES_OF_A_STEP = 4
"""The cost of a step besides the cost of the equations, in nodes."""
OVERRUN = 1.6
"""The most work of an integration over the work of its scout."""
SCOUTED = Fraction(99, 100)
"""A scout that reaches this part of the span refuses nothing: a collision just after the span comes earlier to it."""
SCOUT_ORDER, SCOUT_BITS = 7, 64
COMPARED = 16


class Path:
    """One integration from t = 0 forward (or backward), each step's truncation below 10**-digits of the state."""

    def __init__(
        self, flow: Field, start: Sequence[Fraction], digits: int, backward: bool, most_work: float = math.inf
    ) -> None:
        self.digits, self.most_work = digits, most_work
        self.bits = math.ceil((digits + 10) * math.log2(10))
        self.order = math.ceil(digits * math.log(10) / 2) + 2
        self.sign = -1 if backward else 1
        with precision(self.bits):
            self.flow = _Flow(flow, len(start))
            self.here = [ball(x) for x in start]
        self.ends = [Fraction(0)]
        """Distances from t = 0 at which steps end."""
        self.series: list[list[list[Any]]] = []

    def value(self, t: Fraction) -> list[Fraction]:
        """The state at t; raises ArithmeticError where the integration does not reach it."""
        distance = abs(t)
        with precision(self.bits):
            while not self.series or self.ends[-1] < distance:
                self._advance()
            index = max(bisect.bisect_left(self.ends, distance) - 1, 0)
            offset = self.sign * (distance - self.ends[index])
            return [_fraction(_value(coefficients, offset)) for coefficients in self.series[index]]

    def _advance(self) -> None:
        now = self.sign * self.ends[-1]
        series = [list(coefficients) for coefficients in self.flow.series(now, self.here, self.order)]
        step = _step(series, self.order)
        self.here = [_value(coefficients, self.sign * step) for coefficients in series]
        self.series.append(series)
        self.ends.append(self.ends[-1] + step)
        if _work(self.flow, len(self.series)) > OVERRUN * self.most_work:
            raise ArithmeticError(_too_many(len(self.series), now))
        if len(self.series) > MAX_STEPS:
            raise ArithmeticError(f"more than {MAX_STEPS} Taylor steps, at t = {float(now):g}")


def _work(flow: _Flow, steps: int) -> int:
    return steps * (len(flow.tape.nodes) + NODES_OF_A_STEP)


def _too_many(steps: int, now: Fraction) -> str:
    return f"{steps} Taylor steps, the most that are taken, reach t = {float(now):g} s; give a span below that"


class Scout:
    """An integration of low order that keeps nothing: it counts the steps that the others will take."""

    def __init__(self, flow: Field, start: Sequence[Fraction], backward: bool, most_work: float = MOST_WORK) -> None:
        self.most_work = most_work
        self.sign = -1 if backward else 1
        with precision(SCOUT_BITS):
            self.flow = _Flow(flow, len(start))
            self.here = [ball(x) for x in start]
        self.distance = Fraction(0)
        self.steps = 0

    def reach(self, t: Fraction) -> None:
        """Go on to t. Raises ArithmeticError where the steps until then are too many."""
        with precision(SCOUT_BITS):
            while self.distance < abs(t):
                if _work(self.flow, self.steps) > self.most_work:
                    if self.distance > SCOUTED * abs(t):
                        return
                    raise ArithmeticError(_too_many(self.steps, self.sign * self.distance))
                series = self.flow.series(self.sign * self.distance, self.here, SCOUT_ORDER)
                step = _step(series, SCOUT_ORDER)
                self.here = [_value(coefficients, self.sign * step) for coefficients in series]
                self.distance += step
                self.steps += 1


@dataclass(frozen=True)
class CertifiedMotion(Motion):
    """y' = rates(t, y) from `start` at t = 0, up to about `horizon` (s).

    `label` identifies these rates and their parameters among all others. `most_work`: the most steps times nodes of the
    equations that its scout may take; more is refused.
    """

    label: str
    start: tuple[Fraction, ...]
    horizon: Fraction
    rates: Field = field(repr=False, compare=False)
    most_work: int = field(default=MOST_WORK, repr=False, compare=False)

    def _guard(self, t: Fraction) -> float:
        return 2

    def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
        wanted = mp.dps + MARGIN + self.growth(t)
        level = next((level for level in LEVELS if level >= wanted), math.ceil(wanted))
        return [mp.mpf(x) for x in _path(self, level, t < 0).value(t)]

    def rough_state(self, t: Fraction) -> tuple[Any, ...]:
        """The state at t from the coarse integration alone, to COARSE digits less those by which errors grow.

        Enough for the difference of two motions that start half an ulp apart: it grows as the errors do, so that it keeps
        six digits, at a tenth of the cost.
        """
        with working(COARSE + GUARD) as mp:
            return tuple(map(mp.mpf, _path(self, COARSE, t < 0).value(t)))

    def growth(self, t: Fraction) -> float:
        """Digits by which errors grow until t (at least until the horizon for t >= 0), relative to the motion's size.

        Raises ArithmeticError where all digits of the coarse integration are lost: the motion is too long.
        """
        return _growth(self, max(t, self.horizon) if t >= 0 else t)

    def sample(self, times: Floats, span: float | None = None, breaks: Sequence[Any] = ()) -> Floats:
        """States at few times are kept on disk too, because the integration is expensive."""
        if len(times) >= MANY:
            return Motion.sample(self, times, span, breaks)
        digest = hashlib.sha256(np.ascontiguousarray(times).tobytes()).hexdigest()
        sources = closure(*modules_of(self))
        if sources is None:
            return self.sample_each(times)
        key = f"certified {sources} {self!r} {digest}"
        return np.asarray(cached(key, lambda: Entry({"states": self.sample_each(times)})).arrays["states"])


@lru_cache(maxsize=24)
def _path(motion: CertifiedMotion, digits: int, backward: bool) -> Path:
    return Path(motion.rates, motion.start, digits, backward, motion.most_work)


@lru_cache(maxsize=24)
def _scout(motion: CertifiedMotion, backward: bool) -> Scout:
    return Scout(motion.rates, motion.start, backward, motion.most_work)


@lru_cache(maxsize=64)
def _growth(motion: CertifiedMotion, t: Fraction) -> float:
    _scout(motion, t < 0).reach(t)
    coarse, fine = (_path(motion, digits, t < 0) for digits in (COARSE, LEVELS[0]))
    places = [t * k / COMPARED for k in range(1, COMPARED + 1)]
    pairs = [(coarse.value(s), fine.value(s)) for s in places]
    sizes = [max(map(abs, column)) for column in zip(motion.start, *(b for _, b in pairs), strict=True)]
    largest = max(sizes) or Fraction(1)
    # A component that stays at zero, or at round-off, has no digits of its own.
    sizes = [size if size * 10**COMPARED > largest else largest for size in sizes]
    worst = max(abs(x - y) / size for a, b in pairs for x, y, size in zip(a, b, sizes, strict=True))
    lost = COARSE + math.log10(worst) if worst * 10**COARSE > 1 else 0.0
    if lost > COARSE - 3:
        raise ArithmeticError(f"errors grow by 1e{lost:.0f} until t = {float(t):g}; shorten the span")
    return lost
